"""Two surfaces as one: the convention, the grids, the history, and the curve of a pair."""

import numpy as np
import pytest

import asperity
import surfaces
from asperity.cli.main import main

BODIES = asperity.HalfSpace(210e9, 0.3), asperity.HalfSpace(70e9, 0.33, hardness=9e9)


def rough(seed, shape=(32, 48), spacing=1e-6):
    size = (shape[0] * spacing, shape[1] * spacing)
    return surfaces.self_affine(shape, size, hurst=0.8, rms_slope=0.1, cutoff=8e-6, seed=seed)


def test_b_is_turned_over_about_y():
    a, b = rough(1), rough(2)
    both = surfaces.composite(a, b)
    assert (both.heights == a.heights + b.heights[:, ::-1]).all()
    assert both.periodic
    step = both.history[-1]
    assert step["step"] == "composite" and step["history"] == [dict(s) for s in b.history]
    # seen from the other body it is the same contact, mirrored
    assert (surfaces.composite(b, a).heights == both.heights[:, ::-1]).all()


def test_a_flat_leaves_the_other_alone():
    a = rough(1)
    flat = surfaces.HeightMap(np.zeros((64, 96)), 0.5e-6, periodic=True)
    finer = surfaces.resample(a, 0.5e-6)
    assert surfaces.composite(a, flat).heights == pytest.approx(finer.heights, abs=1e-20)


def test_other_sizes_are_cropped_to_the_overlap():
    both = surfaces.composite(rough(1), rough(2, (40, 40)))
    assert both.shape == (32, 40) and not both.periodic


def test_a_map_with_a_border_has_it_in_the_composite_too():
    a, b = rough(1), rough(2).replace(periodic=False)
    assert not surfaces.composite(a, b).periodic and not surfaces.composite(b, a).periodic


def test_a_coarser_map_moves_to_the_finer_pixels():
    both = surfaces.composite(rough(1), rough(2, (16, 24), 2e-6))
    assert both.shape == (32, 48) and both.periodic


def test_bad_input_is_told():
    a = rough(1)
    with pytest.raises(surfaces.SurfaceError, match="unit"):
        surfaces.composite(a, surfaces.HeightMap(np.eye(5), 1e-2))
    holes = a.heights.copy()
    holes[3, 4] = np.nan
    with pytest.raises(surfaces.SurfaceError, match="missing"):
        surfaces.composite(a, a.replace(heights=holes))
    with pytest.raises(surfaces.SurfaceError, match="HeightMap"):
        surfaces.composite(a, a.heights)


@pytest.mark.parametrize("solve", [asperity.contact_curve, asperity.bem_curve])
def test_the_curve_of_a_pair_is_that_of_the_summed_map(solve):
    a, b = rough(1), rough(2)
    summed = surfaces.HeightMap(a.heights + b.heights[:, ::-1], 1e-6, periodic=True)
    moduli = [210e9 / (1 - 0.3**2), 70e9 / (1 - 0.33**2)]
    one = asperity.HalfSpace.from_modulus(1 / sum(1 / m for m in moduli), hardness=9e9)
    pair = solve(surfaces.composite(a, b), asperity.HalfSpace.pair(*BODIES), pressures=[1e8, 5e8])
    curve = solve(summed, one, pressures=[1e8, 5e8])
    assert pair.separation == pytest.approx(curve.separation, rel=1e-9)
    assert pair.contact_area == pytest.approx(curve.contact_area, rel=1e-9)


def test_the_command_presses_two_files(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, seed in (("a.h5", 1), ("b.h5", 2)):
        surfaces.write(rough(seed), name)
    loads = ["--pressure", "1e8,5e8", "--E", "210e9"]
    more = ["--against", "b.h5", "--E2", "70e9", "--nu2", "0.33", "--hardness2", "9e9"]
    assert main(["curve", "a.h5", *loads, *more]) == 0
    pair = asperity.HalfSpace.pair(*BODIES)
    hm = surfaces.composite(rough(1), rough(2))
    curve = asperity.contact_curve(hm, pair, pressures=[1e8, 5e8])
    found = asperity.ContactCurve.from_hdf5("results.h5")
    assert found.separation == pytest.approx(curve.separation, rel=1e-9)
    # one material for both without --E2
    assert main(["curve", "a.h5", *loads, "--against", "b.h5", "--force"]) == 0
    found = asperity.ContactCurve.from_hdf5("results.h5")
    assert found.settings["modulus"] == pytest.approx(BODIES[0].modulus / 2)
    assert main(["curve", "a.h5", *loads, "--nu2", "0.3"]) == 2
    assert "--E2" in capsys.readouterr().err


def test_the_pixels_of_a_composite_are_the_finer_ones_in_either_order():
    """Where the finer pixels do not divide the coarser map, one order had its rounded ones."""
    a, b = (
        surfaces.self_affine((n, n), (n * d, n * d), hurst=0.8, rms_slope=0.1)
        for n, d in ((48, 1e-6), (47, 1.5e-6))
    )
    assert surfaces.composite(a, b).spacing == surfaces.composite(b, a).spacing == a.spacing
