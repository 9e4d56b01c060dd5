"""Arguments of the wrong type are refused in one sentence, at every public door."""

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
    ],
)
def test_a_wrong_type_is_one_sentence(call):
    with pytest.raises(asperity.InputError, match=r"^[^\n]+$"):
        call()


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
