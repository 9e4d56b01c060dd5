"""``asperity solve``: accuracy in, verified curve out, kept and continued."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from asperity import ContactCurve
from asperity.cli.main import main

ASKED = ["solve", "rough.h5", "--E", "210e9", "--pressure", "1e8:1e9:8"]


@pytest.fixture(autouse=True)
def folder(folder):
    """A folder with one periodic map."""
    hm = surfaces.self_affine(
        (96, 96), (9.6e-4, 9.6e-4), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=6e-5, seed=1
    )
    surfaces.write(hm, folder / "rough.h5")
    return folder


def test_accuracy_in_per_cent_or_as_a_number(capsys):
    for text in ("3%", "0.03"):
        assert main([*ASKED, "--accuracy", text, "--force"]) == 0
        curve = ContactCurve.from_hdf5("results.h5", "bem")
        assert curve.verification["accuracy"] == [0.03, 0.06] and curve.verification["met"]
        assert "accuracy        0.03 in load, 0.06 in area: met" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main([*ASKED, "--accuracy", "good"])
    assert "--accuracy: good: 'good' is no share; write one such as 5%" in capsys.readouterr().err
    assert main([*ASKED, "--accuracy", "90%", "--force"]) == 2
    assert "accuracy is 0.9" in capsys.readouterr().err


def test_anchored_run_keeps_its_anchors_and_goes_on(monkeypatch):
    anchored = [*ASKED, "--engine", "anchored", "--accuracy", "10%"]
    assert main(anchored) == 0
    first = ContactCurve.from_hdf5("results.h5", "anchored")
    anchors = ContactCurve.from_hdf5("results.h5", "bem")
    at = first.verification["anchors"]
    np.testing.assert_array_equal(np.sort(anchors.separation), np.sort(first.separation[at]))
    solved = []
    from asperity.bem import curve as bem

    original = bem.LoadPath.solve
    monkeypatch.setattr(
        bem.LoadPath, "solve", lambda self, *load: (solved.append(load), original(self, *load))[1]
    )
    assert main([*anchored, "--resume"]) == 0
    again = ContactCurve.from_hdf5("results.h5", "anchored")
    np.testing.assert_array_equal(again.separation, first.separation)
    np.testing.assert_array_equal(again.error_estimate, first.error_estimate)
    # the lightest and the middle one once more, and on a finer grid, for what the pixels leave open
    assert len(solved) <= 4


def test_what_boundary_elements_solved_stays_in_the_file():
    """Fewer than five loads are solved by them alone; of more some are anchors."""
    call = [*ASKED[:-1], "2e8,3e8", "--engine", "anchored", "--accuracy", "10%"]
    assert main(call) == 0
    first = ContactCurve.from_hdf5("results.h5", "bem")
    call[call.index("2e8,3e8")] = "1e8:1e9:8"
    assert main([*call, "--resume"]) == 0
    held = ContactCurve.from_hdf5("results.h5", "bem")
    assert len(held) < len(ContactCurve.from_hdf5("results.h5", "anchored"))
    assert np.isin(first.separation, held.separation).all()


def test_separations_and_a_free_map(capsys):
    assert main([*ASKED[:4], "--separation", "1.5e-5:8e-6:3", "--boundary", "free"]) == 0
    assert "free" in capsys.readouterr().out


def test_points_that_the_file_holds_stay_there(capsys):
    """A run that goes on with other loads lost them."""
    for loads in (["1e6", "2e6"], ["3e6"]):
        assert main([*ASKED[:4], "--pressure", ",".join(loads), "--resume"]) == 0
        assert f", {len(loads)} points," in capsys.readouterr().out
    assert ContactCurve.from_hdf5("results.h5").extra["asked_pressure"].tolist() == [3e6, 1e6, 2e6]


def test_a_run_whose_every_load_is_an_anchor_goes_on():
    """Its curve, by boundary elements alone, was taken for one of a contact law."""
    run = [*ASKED[:4], "--engine", "anchored", "--accuracy", "3%", "--resume"]
    for loads in ("1e8:1e9:5", "1e8:3e9:6"):
        assert main([*run, "--pressure", loads]) == 0
    held = ContactCurve.from_hdf5("results.h5", "bem")
    assert held.settings["engine"] == "bem" and len(held) == 10  # the lightest is one of both


@pytest.mark.parametrize("engine", ["bem", "anchored"])
def test_what_pixels_leave_open_stays_known(engine):
    """A run that goes on solves no load, and took that for nothing that touches."""
    run = [*ASKED, "--engine", engine, "--accuracy", "10%"]
    told = []
    for more in ([], ["--resume"], ["--resume"]):
        assert main([*run, *more]) == 0
        told.append(ContactCurve.from_hdf5("results.h5", engine).verification)
    assert told[0]["resolution_uncertainty"] != [0.0, 0.0]
    for again in told[1:]:
        np.testing.assert_allclose(
            again["resolution_uncertainty"], told[0]["resolution_uncertainty"], rtol=0.2
        )
