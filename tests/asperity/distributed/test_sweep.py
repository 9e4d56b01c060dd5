"""A sweep: one result per job, whatever the workers; what is finished is not run again."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import asperity
import surfaces
from asperity.distributed import pool
from asperity.distributed.pool import Workers, opened

from .conftest import LOADS, MAKE, STEEL, same_but_seconds

ALUMINIUM = asperity.HalfSpace(70e9, 0.33, hardness=1e9)


def deadly(marker: str, seed: int) -> surfaces.HeightMap:
    """A map, but for the seed 2: that ends its worker, once if there is a marker to leave."""
    if seed == 2 and not (marker and Path(marker).exists()):
        if marker:
            Path(marker).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return MAKE(seed=seed)


def faulty(seed: int) -> surfaces.HeightMap:
    """A map, but for the seed 1: an error that nobody foresaw."""
    if seed == 1:
        raise ZeroDivisionError("one over none")
    return MAKE(seed=seed)


@pytest.fixture(params=["dask", "processes"])
def engine(request: pytest.FixtureRequest) -> str:
    """Each engine in turn."""
    if request.param == "dask":
        pytest.importorskip("distributed", reason="dask.distributed is not installed")
    else:
        request.getfixturevalue("without_dask")
    return str(request.param)


def test_results_are_those_of_a_loop_to_the_last_bit(engine, maps, tmp_path, capfd):
    files, bodies = maps(3), [STEEL, ALUMINIUM]
    found = asperity.sweep(files, bodies, LOADS, folder=tmp_path, workers=2)
    asperity.set_threads(1)
    try:
        for row in range(6):
            hm, body = surfaces.read(files[row // 2]), bodies[row % 2]
            alone = asperity.contact_curve(hm, body, **LOADS).columns()
            for name, column in found.curve(row).columns().items():
                np.testing.assert_array_equal(column, alone[name], name)
    finally:
        asperity.set_threads(None)
    told = capfd.readouterr().err
    if engine == "dask":
        assert re.search(r"dashboard http://127\.0\.0\.1:\d+/status", told)
    else:
        assert "dask.distributed is not installed: a pool of 2 processes; pip install" in told


def test_what_is_finished_is_not_run_again_and_what_changed_is(here, maps, tmp_path):
    files, folder = maps(3), tmp_path / "out"
    first = asperity.sweep(files, STEEL, LOADS, folder=folder, workers=1)
    surfaces.write(MAKE(seed=9), files[1])
    told: list[dict[str, object]] = []
    second = asperity.sweep(
        str(tmp_path / "maps" / "*.h5"),
        STEEL,
        LOADS,
        folder=folder,
        workers=1,
        progress=told.append,
    )
    assert len(told) == 3
    same = first.table["digest"] == second.table["digest"]
    assert same.tolist() == [True, False, True]
    assert (first.table["seconds"] == second.table["seconds"]).tolist() == same.tolist()
    assert second.table["area_fraction"][1] != first.table["area_fraction"][1]
    both = [LOADS, {**LOADS, "law": "hertz"}]
    third = asperity.sweep(files, STEEL, both, folder=folder, workers=1)
    assert third.table["law"].tolist() == ["", "hertz"] * 3
    assert third.table["seconds"][::2].tolist() == second.table["seconds"].tolist()
    again = asperity.sweep(files, STEEL, LOADS, folder=folder, workers=1, force=True)
    assert not (again.table["seconds"] == second.table["seconds"]).any()
    assert same_but_seconds(again, second)


def test_a_zarr_that_changed_is_run_again(here, tmp_path):
    """Its folder cannot be opened as a file: the curve of the map before was told."""
    zarr = pytest.importorskip("zarr", reason="the extra for Zarr is not installed")
    told = []
    for seed in (1, 1, 2):
        hm = MAKE(seed=seed)
        facts = {"unit": "m", "spacing": hm.spacing, "periodic": True}
        zarr.create_array(tmp_path / "a.zarr", data=hm.heights, attributes=facts, overwrite=True)
        found = asperity.sweep(tmp_path / "a.zarr", STEEL, LOADS, folder=tmp_path / "out")
        told.append((found.table["digest"][0], found.table["area_fraction"][0]))
    assert told[0] == told[1]
    assert told[1][0] != told[2][0] and told[1][1] != told[2][1]


def test_nothing_is_started_where_all_is_finished(here, maps, tmp_path, monkeypatch):
    files = maps(2)
    first = asperity.sweep(files, STEEL, LOADS, folder=tmp_path, workers=1)
    monkeypatch.setattr("asperity.distributed.sweep.opened", None)
    second = asperity.sweep(files, STEEL, LOADS, folder=tmp_path)
    assert (
        second.table.tobytes()
        == first.table.tobytes()
        == asperity.Sweep.read(tmp_path).table.tobytes()
    )
    for change, told in (({"workers": 0}, "workers is 0"), ({"threads": 1.5}, "threads is 1.5")):
        with pytest.raises(asperity.InputError, match=told):
            asperity.sweep(files, STEEL, LOADS, folder=tmp_path, **change)
    for row in (2, -3, "first", slice(1)):
        with pytest.raises(asperity.InputError, match="numbered 0 to 1"):
            second.curve(row)


def test_a_damaged_result_is_made_again(here, maps, tmp_path):
    first = asperity.sweep(maps(2), STEEL, LOADS, folder=tmp_path, workers=1)
    (tmp_path / str(first.table["file"][0])).write_bytes(b"half a fi")
    second = asperity.sweep(tmp_path / "maps/*.h5", STEEL, LOADS, folder=tmp_path, workers=1)
    assert second.converged and same_but_seconds(first, second)


def test_a_job_that_fails_is_named_and_the_others_go_on(without_dask, maps, tmp_path):
    (good,) = maps(1)
    bad = tmp_path / "bad.h5"
    bad.write_text("no map")
    given = [bad, tmp_path / "none.h5", *(partial(faulty, seed=seed) for seed in range(3)), good]
    given.append("zero\0byte.h5")
    found = asperity.sweep(given, STEEL, LOADS, folder=tmp_path / "out", workers=2)
    assert found.failed.tolist() == [0, 1, 3, 6]
    reasons = found.table["reason"]
    assert "HDF5" in reasons[0] and "no such file" in reasons[1]
    assert reasons[3] == "ZeroDivisionError: one over none" and "zero byte" in reasons[6]
    assert "faulty seed 1: ZeroDivisionError" in str(found)
    with pytest.raises(asperity.InputError, match=r"has no curve: .*no such file"):
        found.curve(1)


def test_a_lost_worker_costs_nothing_that_is_finished(engine, tmp_path):
    marker = str(tmp_path / "marker")
    given = [partial(deadly, marker, seed) for seed in range(6)]
    found = asperity.sweep(given, STEEL, LOADS, folder=tmp_path / "out", workers=2)
    assert Path(marker).exists() and found.converged


def test_a_job_that_ends_every_worker_fails_alone(engine, tmp_path):
    given = [partial(deadly, "", seed) for seed in range(5)]
    found = asperity.sweep(given, STEEL, LOADS, folder=tmp_path / "out", workers=2)
    assert found.failed.tolist() == [2]
    assert found.table["reason"][2] == "its worker ended each time, perhaps for want of memory"


def test_a_killed_run_goes_on_to_the_same_table(engine, here, maps, tmp_path):
    files = maps(8)
    script = tmp_path / "run.py"
    hide = "sys.modules['distributed'] = None" if engine == "processes" else "pass"
    script.write_text(
        "import sys, asperity\n"
        'if __name__ == "__main__":\n'
        f"    {hide}\n"
        f"    asperity.sweep({[str(f) for f in files]}, asperity.HalfSpace(210e9, 0.3),\n"
        f"        {LOADS}, folder={str(tmp_path / 'out')!r}, workers=1)\n"
    )
    place = {**os.environ, "PYTHONPATH": str(Path(asperity.__file__).parents[1])}
    run = subprocess.Popen([sys.executable, script], env=place, stderr=subprocess.DEVNULL)
    results = tmp_path / "out" / "results"
    while not (results.is_dir() and any(results.glob("*.h5"))):
        assert run.poll() is None
        time.sleep(0.01)
    run.kill()
    run.wait()
    finished = {file.name: file.stat().st_mtime_ns for file in results.glob("m*.h5")}
    assert 0 < len(finished) < 8
    found = asperity.sweep(files, STEEL, LOADS, folder=tmp_path / "out")
    for name, changed in finished.items():
        assert (results / name).stat().st_mtime_ns == changed
    whole = asperity.sweep(files, STEEL, LOADS, folder=tmp_path / "whole")
    assert same_but_seconds(found, whole)


def test_a_scheduler_that_runs_already(maps, tmp_path):
    distributed = pytest.importorskip("distributed")
    files = maps(3)
    here = asperity.sweep(files, STEEL, LOADS, folder=tmp_path / "here", workers=1)
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=":0") as it:
        there = asperity.sweep(
            files, STEEL, LOADS, folder=tmp_path / "there", scheduler=it.scheduler_address
        )
    assert same_but_seconds(here, there)


def test_a_scheduler_whose_workers_stay_away_is_not_waited_for(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(pool, "SECONDS_BETWEEN_LOOKS", 0.1)
    monkeypatch.setattr(pool, "SECONDS_WITHOUT_WORKERS", 0.5)
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=":0") as empty,
        pytest.raises(asperity.AsperityError, match="has had no workers for"),
    ):
        at = empty.scheduler_address
        asperity.sweep(partial(MAKE, seed=1), STEEL, LOADS, folder=tmp_path, scheduler=at)


def test_a_scheduler_that_is_not_there_or_not_possible(tmp_path, monkeypatch):
    dask = pytest.importorskip("dask")
    pytest.importorskip("distributed")
    go = partial(asperity.sweep, partial(MAKE, seed=1), STEEL, LOADS, folder=tmp_path)
    with dask.config.set({"distributed.comm.timeouts.connect": "300ms"}):
        with pytest.raises(asperity.InputError, match="no Dask scheduler answers at tcp"):
            go(scheduler="tcp://127.0.0.1:9")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(asperity.InputError, match=r"pip install 'asperity\[distributed\]'"):
        go(scheduler="tcp://127.0.0.1:9")


def test_a_table_has_a_row_for_each_job(here, maps, tmp_path):
    pandas = pytest.importorskip("pandas")
    files = maps(2)
    rows = [
        {"surface": str(files[0]), "E": 210e9, "nu": 0.3},
        {"surface": str(files[1]), "modulus": 1e11, "hardness": 2e9, "law": "hertz"},
    ]
    frame = pandas.DataFrame(rows)
    found = asperity.sweep(frame, settings=LOADS, folder=tmp_path, workers=1).to_dataframe()
    assert found.modulus.tolist() == [STEEL.modulus, 1e11]
    assert found.hardness.tolist() == [np.inf, 2e9]
    assert found.law.tolist() == ["", "hertz"]


def test_maps_in_memory_loads_and_preparation(here, tmp_path):
    hm = MAKE(seed=4).replace(name="mine")
    settings = {"loads": np.array([0.1, 1.0]), "prepare": {"level": "mean"}}
    found = asperity.sweep(hm, STEEL, settings, folder=tmp_path, workers=1)
    assert found.table["surface"].tolist() == ["mine"]
    np.testing.assert_allclose(found.curve(0).load, [0.1, 1.0], rtol=1e-2)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"materials": {"E": 1e9, "G": 1.0}}, "a material is E and nu"),
        ({"materials": 3.0}, "HalfSpace or its keywords, not float"),
        ({"materials": None}, "needs materials, or a table"),
        ({"materials": None, "surfaces": []}, "a table with a row for each job"),
        ({"surfaces": []}, "at least one surface"),
        ({"surfaces": 7}, "a path, a glob, a HeightMap or a function that makes one, not int"),
        ({"surfaces": lambda: None}, "cannot be told from another"),
        ({"surfaces": MAKE(seed=1).crop}, "HeightMap .* cannot be told from another"),
        ({"settings": {"speed": 1.0}}, "speed is no setting of the method curve; it takes"),
        ({"settings": 3.0}, "settings are keywords of a method, not float"),
        ({"settings": {"method": ["bem"]}}, "choose one of curve, bem, solve"),
        ({"settings": {"pressures": [1e6], "loads": [1.0]}}, "give one of loads, pressures"),
        ({"settings": {"prepare": 3}}, "the keywords of surfaces.prepare"),
        ({"folder": None}, "the path of a file"),
        ({"folder": __file__, "surfaces": MAKE(seed=1)}, "cannot be made"),
        ({"force": "no"}, "force is 'no'; it must be True or False"),
        ({"workers": 2.5}, "whole number"),
        ({"settings": {"method": "magic"}}, "method is 'magic'; choose one of curve, bem, solve"),
        ({"workers": 0}, "the number of workers is 0"),
        ({"threads": 0}, "the number of threads is 0"),
    ],
)
def test_bad_arguments_are_refused_in_one_sentence(change, match, tmp_path):
    given = {"surfaces": partial(MAKE, seed=1), "materials": STEEL, "settings": LOADS}
    given |= {"folder": tmp_path / "out"} | change
    with pytest.raises(asperity.InputError, match=match):
        asperity.sweep(given.pop("surfaces"), **given)


def late(begun, ended):
    """A job during which the run is interrupted."""
    begun.touch()
    time.sleep(2.0)
    ended.touch()


def test_an_interrupt_waits_for_no_job(engine, tmp_path):
    begun, ended = tmp_path / "begun", tmp_path / "ended"
    with pytest.raises(KeyboardInterrupt), opened(Workers(1), 1) as pool:
        pool.submit(late, begun, ended)
        while not begun.exists():
            time.sleep(0.02)
        raise KeyboardInterrupt
    time.sleep(2.0)
    assert not ended.exists()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="workers are forked on Linux only")
def test_an_interrupt_while_workers_start_ends_the_run(monkeypatch):
    """It was lost, and the run went on to its end."""
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    made = distributed.LocalCluster

    def interrupted(**how):
        signal.raise_signal(signal.SIGINT)
        return made(**how)

    monkeypatch.setattr(distributed, "LocalCluster", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), opened(Workers(1), 1):
            pass
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="workers are forked on Linux only")
@pytest.mark.parametrize("dask", [True, False])
def test_workers_are_forked_from_a_process_without_threads(dask, monkeypatch):
    """Threads would not be there after the fork, and what they hold would stay locked."""
    if not dask:
        monkeypatch.setitem(sys.modules, "distributed", None)
    with opened(Workers(1), 1) as opened_pool:
        server = opened_pool.submit(os.getppid).result()
        assert opened_pool.submit(os.getenv, "OMP_NUM_THREADS").result() == "1"
        assert server != os.getpid()
        assert len(os.listdir(f"/proc/{server}/task")) == 1


def test_a_sweep_of_which_all_failed_took_no_time(here, tmp_path):
    found = asperity.sweep("absent.h5", STEEL, LOADS, folder=tmp_path)
    assert "work            0 s" in str(found)
