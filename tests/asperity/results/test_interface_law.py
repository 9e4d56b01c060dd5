"""Interface laws: monotone, of the curve's work, read back, and run in CalculiX."""

import dataclasses
import functools
import re
import shutil
import subprocess
import warnings

import numpy as np
import pytest
from scipy.integrate import trapezoid

import asperity
import surfaces
from asperity.cli.main import main
from asperity.errors import FileFormatError
from asperity.results.interface_law import FORMATS, UNITS
from asperity.results.storage import ResultFile, write_results

STEEL = asperity.HalfSpace(210e9, 0.3)


@functools.cache
def made(material=STEEL):
    hm = surfaces.self_affine((64, 64), (64e-6, 64e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    return asperity.contact_curve(hm, material, pressures=np.geomspace(1e5, 1e9, 17))


@pytest.fixture(scope="module")
def curve():
    return made()


def work(curve):
    """Work per area between the ends of a curve, on a grid of its own."""
    pressure = np.geomspace(*curve.mean_pressure[[0, -1]], 20001)
    return -trapezoid(pressure, curve.at(pressure=pressure).separation)


@pytest.mark.parametrize("hardness", [np.inf, 4e9])
@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("form", FORMATS)
def test_the_law_read_back_has_the_work_of_the_curve(tmp_path, curve, hardness, units, form):
    if hardness < np.inf:
        curve = made(asperity.HalfSpace(210e9, 0.3, hardness=hardness))
    heat = asperity.constriction_conductance(curve, resistivity=(0.02, 0.02))
    law = curve.to_interface_law(conductance=heat)
    law.write(tmp_path / "law", form, units=units)
    back = asperity.InterfaceLaw.read(tmp_path / "law")
    run_in = 0.5 * law.pressure[1] * law.overclosure[1]
    assert back.work - run_in == pytest.approx(work(curve), rel=1e-3)
    assert back.pressure[0] == back.overclosure[0] == 0.0
    assert (np.diff(back.pressure) > 0).all() and (np.diff(back.overclosure) > 0).all()
    assert back.reference - back.overclosure[-1] == pytest.approx(curve.separation[-1], rel=1e-6)
    assert back.conductance[-1] == pytest.approx(heat[-1], rel=1e-6)
    assert back.hardness == hardness


@pytest.mark.parametrize(
    "error", [None, 0.0, 1e-12, 0.3, 1.5, "one exact", "at once loose", "level far above"]
)
@pytest.mark.parametrize("hardness", [np.inf, 4e9])
def test_the_band_holds_the_law_and_rises_with_it(tmp_path, curve, error, hardness):
    """Also of a curve known exactly, of one of which nothing is, and of one that turns loose."""
    n, loads = len(curve), curve.mean_pressure
    stated = {
        None: curve.error_estimate,
        "one exact": np.where(np.arange(n) == 3, 0.0, 0.1),
        "at once loose": np.where(np.arange(n) < 9, 1e-3, 0.999),
        "level far above": 15.0 * loads.max() / loads - 1.0,
    }.get(error, np.full(n, error))
    facts = curve.settings | ({"hardness": hardness} if hardness < np.inf else {})
    law = dataclasses.replace(curve, error_estimate=stated, settings=facts).to_interface_law()
    assert (law.lower <= law.pressure).all() and (law.pressure <= law.upper).all()
    assert (law.upper <= hardness).all()
    for band in ("lower", "upper"):
        law.write(tmp_path / "law", band=band)
        assert (np.diff(asperity.InterfaceLaw.read(tmp_path / "law").pressure) > 0).all()


def test_a_law_ends_where_no_gap_is_left():
    """Of several loads in full contact of a periodic cell the lightest one is its last row."""
    hm = surfaces.self_affine((48, 48), (1.0, 1.0), hurst=0.8, rms_slope=0.1, cutoff=0.1)
    loads = np.array([1e-3, 1e-2, 0.05, 0.2, 1.0, 10.0])
    full = asperity.bem_curve(hm, asperity.HalfSpace.from_modulus(1.0), pressures=loads)
    assert (full.area_fraction[3:] == 1.0).all()
    heat = asperity.constriction_conductance(full, resistivity=(0.02, 0.02))
    law = full.to_interface_law(conductance=heat)
    assert law.pressure[-1] == pytest.approx(0.2) and (np.diff(law.overclosure) > 0).all()
    known = np.isfinite(law.conductance)
    assert known.any() and law.pressure[known].max() < 0.2 and np.isinf(heat[3:]).all()


@pytest.mark.parametrize("unknown", [np.inf, np.nan])
def test_a_light_point_without_an_error_leaves_the_band_of_the_others(tmp_path, curve, unknown):
    error = np.full(len(curve), 0.1)
    error[0] = unknown
    law = dataclasses.replace(curve, error_estimate=error).to_interface_law()
    whole = dataclasses.replace(curve, error_estimate=np.full(len(curve), 0.1)).to_interface_law()
    light = law.pressure < curve.mean_pressure[1]
    for band in ("lower", "upper"):
        law.write(tmp_path / "law", band=band)
        np.testing.assert_allclose(
            getattr(law, band)[~light], getattr(whole, band)[~light], rtol=1e-3
        )
    assert (law.lower <= whole.lower).all() and (law.upper >= whole.upper).all()


@pytest.mark.parametrize("unknown", [np.inf, np.nan])
def test_a_heavy_point_without_an_error_opens_the_band_there(curve, unknown):
    """The errors beside it were told in its place."""
    error = np.full(len(curve), 0.05)
    error[2] = unknown
    law = dataclasses.replace(curve, error_estimate=error).to_interface_law()
    at, (light, here, heavy) = law.pressure.searchsorted(curve.mean_pressure[2]), (1, 2, 3)
    assert law.lower[at] < 1.06 * curve.mean_pressure[light] < curve.mean_pressure[here]
    assert law.upper[at] > 0.94 * curve.mean_pressure[heavy] > curve.mean_pressure[here]


@pytest.mark.parametrize("value", [-1.0, 0.0])
def test_a_conductance_under_load_is_positive(curve, value):
    heat = np.full(len(curve), 2.0)
    heat[1] = value
    with pytest.raises(asperity.InputError, match="not positive"):
        curve.to_interface_law(conductance=heat)


def test_hardness_bounds_the_band_and_is_told(tmp_path):
    hard = 1.05e9
    law = made(asperity.HalfSpace(210e9, 0.3, hardness=hard)).to_interface_law()
    assert law.upper.max() <= hard and (np.diff(law.upper) > 0).all()
    law.write(tmp_path / "law.inp")
    assert "first loading" in (tmp_path / "law.inp").read_text()


@pytest.mark.parametrize(
    ("choice", "told"),
    [({"format": "ansys"}, "abaqus"), ({"units": "feet"}, "SI"), ({"band": "middle"}, "upper")],
)
def test_unknown_choices_are_told(tmp_path, curve, choice, told):
    with pytest.raises(asperity.InputError, match=told):
        curve.to_interface_law().write(tmp_path / "law.inp", **choice)


def test_a_law_is_of_a_curve():
    with pytest.raises(asperity.InputError, match="a contact curve is needed, not float"):
        asperity.InterfaceLaw.of(1e9)


def test_what_is_no_law_is_refused(tmp_path):
    (tmp_path / "law.inp").write_text("*NODE\n1, 0, 0, 0\n")
    with pytest.raises(surfaces.FileFormatError, match="no interface law"):
        asperity.InterfaceLaw.read(tmp_path / "law.inp")


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(surfaces.FileFormatError, match="cannot be read"):
        asperity.InterfaceLaw.read(tmp_path / "law.inp")


def test_the_command_writes_the_law(tmp_path, curve, capsys):
    curve.to_hdf5(tmp_path / "results.h5")
    target = tmp_path / "law.inp"
    assert main(["interface", str(tmp_path / "results.h5"), "--output", str(target)]) == 0
    assert "mean plane" in capsys.readouterr().out
    assert asperity.InterfaceLaw.read(target).pressure[-1] == pytest.approx(1e9, rel=1e-2)


def test_a_file_of_no_curve_or_of_several_is_told(tmp_path, curve, capsys):
    path = tmp_path / "results.h5"
    write_results(path, ResultFile())
    assert main(["interface", str(path), "--output", str(tmp_path / "law.inp")]) == 2
    assert capsys.readouterr().err.endswith("results.h5 holds no curve\n")
    write_results(path, ResultFile(curves={"a": curve, "b": curve}))
    with pytest.raises(surfaces.FileFormatError, match=r"holds a, b; name one \(model=\)"):
        asperity.ContactCurve.from_hdf5(path)
    assert main(["interface", str(path), "--curve", "c"]) == 2
    assert "holds a, b, and no curve 'c'" in capsys.readouterr().err


PATCH = """*NODE, NSET=ALL
{nodes}
*ELEMENT, TYPE=C3D8, ELSET=BLOCKS
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 9, 10, 11, 12, 13, 14, 15, 16
*ELSET, ELSET=LOWER
1
*ELSET, ELSET=UPPER
2
*SURFACE, NAME=MASTER
LOWER, S2
*SURFACE, NAME=SLAVE
UPPER, S1
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.
*SOLID SECTION, ELSET=BLOCKS, MATERIAL=STEEL
*SURFACE INTERACTION, NAME=ROUGH
*INCLUDE, INPUT=law.inp
*CONTACT PAIR, INTERACTION=ROUGH, TYPE=NODE TO SURFACE
SLAVE, MASTER
*BOUNDARY
1, 1, 3
2, 1, 3
3, 1, 3
4, 1, 3
5, 1, 2
6, 1, 2
7, 1, 2
8, 1, 2
9, 1, 2
10, 1, 2
11, 1, 2
12, 1, 2
13, 1, 2
14, 1, 2
15, 1, 2
16, 1, 2
{steps}
"""

STEP = """*STEP, NLGEOM, INC=1000
*STATIC
0.2, 1.
*BOUNDARY
13, 3, 3, {u:.8g}
14, 3, 3, {u:.8g}
15, 3, 3, {u:.8g}
16, 3, 3, {u:.8g}
*CONTACT PRINT, FREQUENCY=1000
CDIS, CSTR
*END STEP"""


def printed(folder):
    return (folder / "patch.dat").read_text()


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (calculix-ccx) not installed")
def test_calculix_presses_two_blocks_by_the_law(tmp_path, curve):
    law = curve.to_interface_law()
    law.write(tmp_path / "law.inp", "calculix", units="mm-N-MPa")
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    nodes = [(x, y, z) for z in (0, 1, 1, 2) for x, y in square]
    overclosure = 1e3 * law.overclosure[-1] * np.array([0.3, 0.6, 0.9])
    asked = np.interp(overclosure, 1e3 * law.overclosure, 1e-6 * law.pressure)
    text = PATCH.format(
        nodes="\n".join(f"{i}, {x}., {y}., {z}." for i, (x, y, z) in enumerate(nodes, 1)),
        # both blocks give way by p L / E
        steps="\n".join(STEP.format(u=-u) for u in overclosure + 2 * asked / 210000),
    )
    (tmp_path / "patch.inp").write_text(text)
    run = subprocess.run(
        ["ccx", "patch"], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
    )
    assert run.returncode == 0, run.stdout[-2000:]
    number = r"([-+]?\d\.\d+E[-+]\d+)"
    rows = re.findall(rf"^ +\d+ +{number} +{number} +{number}$", printed(tmp_path), re.M)
    # steps, displacement before stress, points, normal before tangents
    found = np.array(rows, dtype=float).reshape(3, 2, -1, 3)[..., 0]
    table = asperity.InterfaceLaw.read(tmp_path / "law.inp")
    expected = np.interp(-found[:, 0], 1e3 * table.overclosure, 1e-6 * table.pressure)
    assert abs(found[:, 1]) == pytest.approx(expected, rel=1e-3)
    assert abs(found[:, 1]) == pytest.approx(asked[:, None] + 0 * expected, rel=1e-2)


def test_a_conductance_that_is_not_known_is_not_zero_either(curve):
    assert np.isnan(curve.to_interface_law().conductance).all()


@pytest.mark.parametrize("form", FORMATS)
def test_a_law_that_is_cut_off_or_damaged_is_refused(tmp_path, curve, form):
    """Cut inside the last number, the work was 3e7 times as large."""
    path = tmp_path / "law"
    curve.to_interface_law().write(path, form)
    text = path.read_text()
    lines = text.splitlines(keepends=True)
    wrong = text[:-4], "".join(lines[:-3]), "".join([*lines[:-1], lines[-2]]), text + lines[-1]
    for damaged in (*wrong, text.replace(lines[-5], "nan, nan\n")):
        path.write_text(damaged)
        with pytest.raises(FileFormatError, match="no interface law"):
            asperity.InterfaceLaw.read(path)


def test_a_conductance_that_is_known_in_part_is_written_in_part(tmp_path, curve):
    heat = asperity.constriction_conductance(curve, resistivity=(0.02, 0.02))
    law = curve.to_interface_law(conductance=np.where(np.arange(len(heat)) > 0, heat, np.nan))
    law.write(tmp_path / "law.inp", "abaqus")
    back = asperity.InterfaceLaw.read(tmp_path / "law.inp")
    known = np.isfinite(law.conductance)
    assert 2 < known.sum() < known.size
    np.testing.assert_allclose(back.conductance, law.conductance, rtol=1e-8)


def test_the_sinking_of_the_half_space_under_a_free_map_is_told():
    """Pressed flat, a free map is a flat punch: all of its law is that of the body below."""
    hm = surfaces.self_affine((48, 64), (48e-6, 64e-6), hurst=0.8, rms_slope=1e-3, cutoff=8e-6)
    loads = [1e7, 4e8]
    for boundary, share in (("free", "100%"), ("periodic", None)):
        flat = asperity.bem_curve(hm, STEEL, pressures=loads, boundary=boundary)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", asperity.ContactWarning)
            flat.to_interface_law()
            asperity.constriction_conductance(flat, resistivity=(1e-7, 1e-7))
        assert len(told) == (2 if share else 0)
        assert all(share in str(one.message) for one in told)
