"""Arguments of the wrong type are refused in one sentence, by every public function."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
import surfaces

HM = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6, seed=1)
STEEL = asperity.HalfSpace(210e9, 0.3)
BALL = surfaces.PowerLawProfile(2.0, 50.0)


def drawn(**changed):
    given = {"hurst": 0.8, "rms_slope": 0.1, **changed}
    return surfaces.self_affine((32, 48), (1.0, 1.5), **given)


@pytest.mark.parametrize(
    "call",
    [
        *(
            lambda name=name: drawn(**{name: "much"})
            for name in ("hurst", "rms_slope", "rolloff", "cutoff", "anisotropy", "angle", "seed")
        ),
        lambda: drawn(seed=True),
        lambda: surfaces.HeightMap(np.eye(4), np.True_),
        lambda: asperity.contact_curve(HM, STEEL, pressures=[True]),
        lambda: asperity.indent_bem(BALL, STEEL, True),
        lambda: surfaces.HeightMap(np.eye(4), 1.0, history=3),
        lambda: surfaces.HeightMap(np.eye(4), 1.0, history=(3,)),
        lambda: surfaces.read(3),
        lambda: surfaces.open(None),
        lambda: surfaces.write(HM, 3.5),
        lambda: surfaces.validate(None),
        lambda: surfaces.prepare(HM, outliers="many"),
        lambda: surfaces.prepare(HM, fill_limit="few"),
        lambda: surfaces.prepare(HM, bandpass=("a", None)),
        lambda: surfaces.fill_missing(HM, limit="few"),
        lambda: surfaces.bandpass(HM, "short"),
        lambda: surfaces.make_periodic(HM, "taper", width="wide"),
        lambda: surfaces.segment(HM, above="high"),
        lambda: surfaces.segment(HM, min_prominence="high"),
        lambda: surfaces.fit_profiles(HM, 3),
        lambda: surfaces.fit_profiles(HM, surfaces.segment(HM), rays="many"),
        lambda: asperity.set_threads("many"),
        lambda: asperity.set_threads([2]),
        lambda: asperity.bem_curve(HM, STEEL, pressures=[1e8], accuracy="high"),
        lambda: asperity.indent_bem(BALL, STEEL, 1e-6, grid="fine"),
        lambda: asperity.compare(HM, STEEL, pressures=[1e8], tolerance="tight"),
        lambda: asperity.make_plan(HM, STEEL, law="best"),
        lambda: asperity.bem_curve(HM, STEEL, pressures=np.array(["2020"], "datetime64[Y]")),
        lambda: asperity.read_results(3),
        lambda: asperity.ContactCurve.from_hdf5(None, "bem"),
        lambda: asperity.InterfaceLaw.read(b"law.inp"),
        lambda: asperity.write_vti(None, {"height": HM.heights}, HM.spacing),
        lambda: HM.crop(x=1e-6),
        lambda: HM.crop(x=(1e-6, 2e-6, 9e-6)),
        lambda: surfaces.redistribute(HM.heights, np.sqrt),
        lambda: surfaces.redistribute(HM, 3.0),
        lambda: surfaces.fit_spectrum(HM),
        *(
            lambda name=name, value=value: surfaces.ground(
                (32, 48), (1.0, 1.5), **{"rms_slope": 0.1, "cutoff": 0.1, name: value}
            )
            for name in ("rms_slope", "cutoff", "rolloff", "hurst", "length", "fine", "seed")
            for value in ("5 um", True, [0.1])
        ),
        lambda: surfaces.ground((32, 48), (1.0, 1.5), rms_slope=None, cutoff=0.1),
        lambda: surfaces.PolynomialProfile({"a": 1.0}),
        lambda: surfaces.PolynomialProfile({("a", "b"): 1.0}),
        lambda: surfaces.PolynomialProfile({(0.0, 0.0): 1.0}),
        lambda: surfaces.PolynomialProfile(None),
        lambda: surfaces.PowerSumProfile([1.0], 3),
        lambda: surfaces.plot_map(HM, 3),
        lambda: surfaces.crop(HM, [[1], [1, 2]], (0, 16)),
        lambda: surfaces.crop(HM, None, (0, 16)),
        lambda: surfaces.crop(HM, (0, 8.5), (0, 16)),
    ],
)
def test_a_wrong_type_is_one_sentence(call):
    with pytest.raises(asperity.InputError, match=r"^[^\n]+$"):
        call()


NAMES = [
    ("law", lambda x: asperity.contact_curve(HM, STEEL, law=x)),
    ("law", lambda x: asperity.indent(BALL, STEEL, 1e-6, law=x)),
    ("scales", lambda x: asperity.make_plan(HM, STEEL, scales=x)),
    ("boundary", lambda x: asperity.bem_curve(HM, STEEL, boundary="none" if x is None else x)),
    ("engine", lambda x: asperity.solve(HM, STEEL, engine=x)),
    ("method", lambda x: asperity.sweep(HM, STEEL, {"method": x}, folder="unused")),
    ("format", lambda x: asperity.InterfaceLaw.of(CURVE).write("unused", x)),
    ("level", lambda x: surfaces.level(HM, x)),
    ("fill", lambda x: surfaces.prepare(HM, fill="no" if x is None else x)),
    ("filter", lambda x: surfaces.prepare(HM, filter=x)),
    ("filter", lambda x: surfaces.bandpass(HM, 1e-5, filter=x)),
    ("periodic", lambda x: surfaces.make_periodic(HM, x)),
    ("dtype", lambda x: surfaces.write(HM, "unused.h5", dtype=x)),
    ("x", lambda x: CURVE.plot(x)),
]


@pytest.mark.parametrize(("name", "call"), NAMES, ids=[name for name, _ in NAMES])
@pytest.mark.parametrize("wrong", [np.array(["a", "b"]), ["auto"], {}, None, 3, "auto "], ids=repr)
def test_one_of_a_few_names(name, call, wrong, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(asperity.InputError, match=rf"^{name} is [^\n]+; choose one of [^\n]+$"):
        call(wrong)
    assert not [*tmp_path.iterdir()]


def test_progress_is_a_switch_or_a_function():
    with pytest.raises(asperity.InputError, match=r"progress is array.*; give a function"):
        asperity.contact_curve(HM, STEEL, pressures=[1e7], progress=np.ones(2))


def test_a_hardness_alone_is_one():
    (one,) = asperity.hardness_sweep(HM, STEEL, np.array(1e9), pressures=[1e7])
    (same,) = asperity.hardness_sweep(HM, STEEL, [1e9], pressures=[1e7])
    assert one.load == same.load


def test_a_map_with_gaps_says_what_fills_it():
    heights = HM.heights.copy()
    heights[3, 4] = np.nan
    with pytest.raises(asperity.InputError, match=r"surfaces.fill_missing, surface prepare"):
        surfaces.power_spectrum(HM.replace(heights=heights))


CURVE = asperity.contact_curve(HM, STEEL, pressures=[1e7, 1e8])
RUBBER = asperity.Relaxation(1e6, [1e7], [1.0])
PUSH = {"friction": 0.3, "modulus_ratio": 1.2}
NO_NUMBER = [None, "much", 1j, {}, object(), [1.0, "b"], 10**400, float("nan"), -1.0, True]


@pytest.mark.parametrize("wrong", NO_NUMBER, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize(
    "call",
    [
        lambda x: asperity.HalfSpace(x, 0.3),
        lambda x: asperity.HalfSpace(1e9, 0.3, hardness=-1.0 if x is None else x),
        lambda x: asperity.HalfSpace.from_modulus(x),
        lambda x: asperity.Relaxation(x, [1e7], [1.0]),
        lambda x: asperity.Relaxation(1e6, x, [1.0]),
        lambda x: asperity.Relaxation(1e6, [1e7], x),
        lambda x: asperity.viscoelastic_indent(BALL, x, [0.0, 1.0], [0.0, 1e-6]),
        lambda x: asperity.viscoelastic_indent(BALL, RUBBER, x, [0.0, 1e-6]),
        lambda x: asperity.viscoelastic_indent(BALL, RUBBER, [0.0, 1.0], x),
        lambda x: asperity.viscoelastic_indent(BALL, RUBBER, [0.0, 1.0], load=x),
        lambda x: asperity.partial_slip(BALL, x, 1e-6, **PUSH, displacement=1e-9),
        lambda x: asperity.partial_slip(BALL, STEEL, x, **PUSH, displacement=1e-9),
        lambda x: asperity.partial_slip(BALL, STEEL, 1e-6, **PUSH, displacement=x),
        lambda x: asperity.partial_slip(BALL, STEEL, 1e-6, **PUSH, tangential_force=x),
        lambda x: asperity.tangential_modulus(x),
        lambda x: asperity.friction_curve(CURVE, x, **PUSH),
        lambda x: asperity.friction_curve(CURVE, 1e8, **PUSH, points=x),
        lambda x: asperity.constriction_conductance(CURVE, resistivity=x),
        lambda x: asperity.constriction_conductance(CURVE, resistivity=(1.0, x)),
        lambda x: asperity.hardness_sweep(HM, STEEL, x, pressures=[1e7]),
        lambda x: asperity.hardness_sweep(HM, x, [1e9], pressures=[1e7]),
        lambda x: asperity.flat_punch(x, STEEL),
        lambda x: asperity.flat_punch(1e-3, x),
        lambda x: asperity.size_distribution(x),
        lambda x: asperity.size_distribution([1.0], bins=x),
        lambda x: asperity.indent(BALL, STEEL, x if x != -1.0 else 1e300),
        lambda x: asperity.indent(BALL, STEEL, 1e-6, law=x),
        lambda x: asperity.indent_bem(BALL, STEEL, x),
        lambda x: asperity.bem_curve(HM, STEEL, pressures=-1.0 if x is None else x),
        lambda x: asperity.set_threads(-1 if x is None else x),
        lambda x: CURVE.at(pressure=x),
        lambda x: CURVE.to_interface_law(conductance=[x]),
        lambda x: surfaces.self_affine((x, 8), (1.0, 1.0), hurst=0.8, rms_slope=0.1),
        lambda x: surfaces.self_affine((8, 8), (1.0, x), hurst=0.8, rms_slope=0.1),
        lambda x: surfaces.HeightMap(np.eye(4), x),
        lambda x: surfaces.PowerLawProfile(x, 1.0),
        lambda x: surfaces.PolarProfile(x, np.arange(8), np.ones((8, 8))),
    ],
)
def test_what_is_no_number_is_one_sentence(call, wrong):
    with pytest.raises(asperity.InputError, match=r"^[^\n]+$"):
        call(wrong)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 2.5, 1e300])
def test_a_count_is_a_whole_number(bad):
    with pytest.raises(asperity.InputError, match="whole number, at least 4"):
        surfaces.fit_profiles(HM, surfaces.segment(HM), rays=bad)
    with pytest.raises(asperity.InputError, match="whole number, at least 1"):
        asperity.set_threads(bad)


def test_a_sum_of_powers_is_read_at_single_numbers():
    assert float(surfaces.PowerSumProfile([2.0, 4.0], [1.0, 0.5])(1.0, 0.0)) == 1.5


@pytest.mark.parametrize(
    ("stated", "expected"), [("False", False), ("no", False), (0, False), ("true", True), (1, True)]
)
def test_a_word_says_whether_a_map_is_periodic(tmp_path, stated, expected):
    path = tmp_path / "a.npz"
    np.savez(path, heights=np.eye(5), unit="m", spacing=(1.0, 1.0), periodic=stated)
    assert surfaces.read(path).periodic is expected


@pytest.mark.parametrize("stated", ["perhaps", 2, (0, 1)])
def test_what_is_no_truth_is_refused(tmp_path, stated):
    path = tmp_path / "a.npz"
    np.savez(path, heights=np.eye(5), unit="m", spacing=(1.0, 1.0), periodic=stated)
    with pytest.raises(surfaces.FileFormatError, match="it must be true or false"):
        surfaces.read(path)
