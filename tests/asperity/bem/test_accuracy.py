"""Curves on the coarsest sufficient grid, and the memory estimate."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import rough

from asperity import HalfSpace, bem_curve, errors
from asperity.bem import accuracy, memory

BODY = HalfSpace.from_modulus(1.0)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_coarse_curve_holds_its_accuracy(boundary):
    """A smooth map is solved on a coarser grid, within the accuracy asked for."""
    hm = rough((300, 360), size=(1.0, 1.2), cutoff=24.0, seed=6)
    loads = [0.01, 0.03, 0.09]
    exact = bem_curve(hm, BODY, pressures=loads, boundary=boundary)
    loose = bem_curve(hm, BODY, pressures=loads, boundary=boundary, accuracy=0.06, check=True)
    assert loose.settings["shape"][0] < 200
    assert loose.settings["accuracy"] == 0.06
    assert "points" in loose.settings["accuracy_reason"]
    np.testing.assert_allclose(loose.area_fraction, exact.area_fraction, rtol=0.06)
    stiffness = np.gradient(np.log(exact.mean_pressure), exact.separation)
    assert np.abs(stiffness * (loose.separation - exact.separation)).max() < 0.06
    assert (loose.error_estimate < 0.1).all()


def test_long_curve_is_interpolated_between_few_solved_loads():
    """Thirty loads and zero: ten or so are solved, the others as good, and it is stated."""
    hm = rough((128, 150), cutoff=6.0, seed=9)
    loads = np.append(np.geomspace(0.2, 0.006, 30), 0.0)
    exact = bem_curve(hm, BODY, pressures=loads)
    found = bem_curve(hm, BODY, pressures=loads, accuracy=0.03)
    known = found.extra["interpolated"] == 0.0
    assert 10 <= known.sum() <= 12 and known[[0, 29, 30]].all()
    assert found.settings["solved_loads"] == known.sum()
    assert not found.extra["fft_pairs"][~known].any() and found.converged.all()
    np.testing.assert_allclose(found.mean_pressure, loads, rtol=1e-9)
    np.testing.assert_allclose(found.area_fraction[:30], exact.area_fraction[:30], rtol=0.03)
    shift = np.abs(found.separation - exact.separation)[:30] * exact.stiffness[:30]
    assert (shift / loads[:30]).max() < 0.03


def test_few_or_repeated_loads_are_all_solved():
    """Ten distinct loads are not interpolated, however often they are asked for."""
    loads = np.geomspace(0.01, 0.1, 10)
    assert accuracy.loads_to_solve(np.repeat(loads, 3)) is None
    chosen = accuracy.loads_to_solve(np.linspace(0.0, 1.0, 100))
    assert chosen is not None and chosen[0] == 0.0 and 10 <= len(chosen) <= 12
    assert chosen[1] == 0.01 * 100 / 99 and chosen[-1] == 1.0


def test_choice_follows_the_spectrum_and_the_load():
    """Rougher maps, lighter loads and higher accuracy ask for more points."""
    smooth, sharp = (rough((256, 320), cutoff=c, seed=7) for c in (32.0, 2.0))
    sizes = [
        accuracy.choose_grid(hm, wanted, light, "periodic")[0][0]
        for hm, wanted, light in (
            (smooth, 0.1, 0.05),
            (smooth, 0.05, 0.05),
            (smooth, 0.1, 0.003),
            (sharp, 0.1, 0.05),
        )
    ]
    assert sizes[0] < min(sizes[1:])
    assert sizes[3] > 160
    assert accuracy.choose_grid(smooth, 0.035, 0.05, "periodic")[0] == smooth.shape
    with pytest.raises(errors.InputError, match=r"accuracy is 2\.0"):
        bem_curve(smooth, BODY, pressures=[0.1], accuracy=2.0)
    with pytest.raises(errors.InputError, match="give accuracy as well"):
        bem_curve(smooth, BODY, pressures=[0.1], check=True)


def test_coarsened_keeps_mean_size_and_waves():
    """Truncation keeps every wave that the coarse grid holds, and the mean."""
    hm = rough((90, 120), cutoff=12.0, seed=8)
    hm = hm.replace(heights=hm.heights + 3.0)
    half = accuracy.coarsened(hm, (45, 60), "periodic")
    assert half.size == pytest.approx(hm.size)
    np.testing.assert_allclose(half.heights, hm.heights[::2, ::2], atol=1e-9)
    averaged = accuracy.coarsened(hm, (45, 60), "free")
    expected = hm.heights.reshape(45, 2, 60, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(averaged.heights, expected, rtol=1e-13)


def test_memory_is_estimated_and_refused(monkeypatch):
    """A grid that will not fit is refused with its size; one that fits is not."""
    memory.require_memory((100, 100), "periodic")
    monkeypatch.setattr(memory, "available_bytes", lambda: 10_000)
    with pytest.raises(errors.InputError, match=r"needs about .* GiB are available"):
        bem_curve(rough((20, 24)), BODY, pressures=[0.1])
    assert memory.estimated_bytes((10, 10), "free") > memory.estimated_bytes((10, 10), "periodic")
    assert not memory.fits((20, 24), "free", 1)
