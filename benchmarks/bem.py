"""Boundary elements: this project and its peers, alternately in one run, certified alike.

    python benchmarks/bem.py --peers /path/to/peers/bin/python --size 512 1024 --repeats 5
    python benchmarks/bem.py --peers /path/to/peers/bin/python --repeats 1 --factor 0.3 \\
        --solvers aspher-ftd --only "4096 N/8 p=0.02"

The second form is for the long cases: `--only` takes whole names of cases, one repeat times a peer
by the run that reached the certificate, and `--factor` is the share of the tolerance to begin with,
printed by an earlier run on a smaller grid.

Every pressure is certified anew here, in numpy; a peer's tolerance is tightened until it reaches
the same certificate. Without --peers only this project is timed. Times are medians in seconds with
set-up; "quiet" the shortest run; bytes are the peak above the loaded process per grid point.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

import numpy as np

TARGET = 1e-7
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))


def rough(n, cutoff):
    """The self-affine map of the problems: H = 0.8, plateau below 8 waves, slope 1, seed 1."""
    import surfaces

    return surfaces.self_affine(
        (n, n), (1.0, 1.0), hurst=0.8, rms_slope=1.0, rolloff=1 / 8, cutoff=1 / cutoff, seed=1
    ).heights


def cap(n, pyramid):
    """A paraboloid of radius 1 or a pyramid of slope 0.3, in the middle of the unit square."""
    x = (np.arange(n) + 0.5) / n - 0.5
    x, y = np.meshgrid(x, x)
    return -0.3 * np.maximum(abs(x), abs(y)) if pyramid else -0.5 * (x**2 + y**2)


def cases(sizes, suites):
    """Name, map maker, loads, free boundary."""
    for n in sizes:
        if "single" in suites:
            for divisor, load in ((8, 0.005), (8, 0.02), (8, 0.1), (2, 0.02), (2, 0.1)):
                if n > 2048 and (divisor == 2 or load == 0.1):
                    continue
                yield f"{n} N/{divisor} p={load}", (rough, n, n // divisor), [load], False
        if "curve" in suites:
            loads = np.geomspace(0.002, 0.1, 24).tolist()
            yield f"{n} N/8 curve of 24", (rough, n, n // 8), loads, False
        if "free" in suites:
            yield f"{n} free sphere", (cap, n, False), [4 / 3 * 0.25**3], True
            yield f"{n} free pyramid", (cap, n, True), [0.03], True
            yield f"{n} free rough", (rough, n, n // 8), [0.02], True


def chosen(args):
    """The cases asked for, by size and suite or by name."""
    if not args.only:
        yield from cases(args.size, args.suite)
        return
    sizes = {int(name.split()[0]) for name in args.only}
    found = {case[0]: case for case in cases(sorted(sizes), ["single", "curve", "free"])}
    for name in args.only:
        if name not in found:
            raise SystemExit(f'no case is named "{name}"; there are: {", ".join(found)}')
        yield found[name]


def certificate(pressure, heights, load, free):
    """Duality gap over rms height and load error, from the pressure alone (E* = 1, unit square)."""
    from scipy import fft

    n = heights.shape[0]
    if free:
        i = np.abs(np.fft.fftfreq(2 * n, 0.5 / n)) / n
        edge = np.stack([i - 0.5 / n, i + 0.5 / n])
        kernel = 0.0
        for a, x in enumerate(edge):
            for b, y in enumerate(edge):
                s, t = np.meshgrid(x, y, indexing="ij")
                corner = s * np.arcsinh(t / np.abs(s)) + t * np.arcsinh(s / np.abs(t))
                kernel = kernel + (1 if a == b else -1) * corner / np.pi
        wide = fft.rfft2(pressure, s=(2 * n, 2 * n)) * fft.rfft2(kernel)
        u = fft.irfft2(wide, s=(2 * n, 2 * n))[:n, :n]
    else:
        q = 2 * np.pi * np.hypot(np.fft.fftfreq(n, 1 / n)[:, None], np.arange(n // 2 + 1))
        q[0, 0] = np.inf
        u = fft.irfft2(fft.rfft2(pressure) * (2.0 / q), s=(n, n))
    gap = u - heights
    work = float((pressure * (gap - gap.min())).sum() / pressure.sum() / heights.std())
    return work, abs(pressure.mean() / load - 1.0)


class Worker:
    """One solver in a process of its own."""

    def __init__(self, name, python, threads, factor):
        self.name, self.factor = name, factor if name != "ours" else 1.0
        environment = {**os.environ, "OMP_NUM_THREADS": str(threads)}
        environment["ASPERITY_THREADS"] = environment["OPENBLAS_NUM_THREADS"] = str(threads)
        if name == "ours":
            root = str(HERE.parent)
            environment["PYTHONPATH"] = root + os.pathsep + environment.get("PYTHONPATH", "")
        else:
            environment.pop("PYTHONPATH", None)
        self.process = subprocess.Popen(
            [python, str(HERE / "bem_worker.py"), name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            text=True,
        )

    def run(self, case):
        """Answer of one run, or None if the solver failed."""
        self.process.stdin.write(json.dumps({**case, "factor": self.factor}) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        return json.loads(line) if line else None

    def calibrate(self, case, heights, folder):
        """Tighten the tolerance until the certificate holds; returns it and the last answer."""
        out = str(Path(folder) / "pressure.npy")
        for _ in range(4):
            answer = self.run({**case, "out": out})
            if answer is None:
                return float("nan"), None
            if "certificate" in answer:
                return answer["certificate"], answer
            reached, load = certificate(np.load(out), heights, case["loads"][-1], case["free"])
            if max(reached, load) <= TARGET:
                break
            self.factor *= min(0.5, 0.5 * TARGET / max(reached, load))
        print(f"{self.name}: tolerance times {self.factor:.2g}", file=sys.stderr, flush=True)
        return max(reached, load), answer

    def close(self):
        """End the process."""
        self.process.stdin.close()
        self.process.wait()


def measure(case, workers, repeats, folder):
    """Alternate the solvers; returns certificate and answers of each."""
    heights = np.load(case["map"])
    reached, answers = {}, {w.name: [] for w in workers}
    for w in workers:
        reached[w.name], answer = w.calibrate(case, heights, folder)
        if repeats == 1 and w.name != "ours" and answer is not None:
            answers[w.name].append(answer)
    for _ in range(repeats):
        for w in workers:
            if np.isfinite(reached[w.name]) and len(answers[w.name]) < repeats:
                answers[w.name].append(w.run(case))
    return reached, answers


def main():
    """Print one table row for each case and solver."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--size", type=int, nargs="+", default=[512, 1024])
    parser.add_argument("--suite", nargs="+", default=["single"], help="single, curve, free")
    parser.add_argument("--only", nargs="+", help="whole names of cases, of any size and suite")
    parser.add_argument("--factor", type=float, default=1.0, help="of a peer's tolerance, at first")
    parser.add_argument("--peers", help="Python interpreter that has aspher and tamaas")
    parser.add_argument("--solvers", nargs="+", default=["aspher-d", "aspher-ftd"])
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--repeats", type=int, default=5)
    args = parser.parse_args()
    print(f"{date.today()}, {platform.processor() or platform.machine()}, {args.threads} threads")
    print(
        "| case | solver | median s | quiet s | without set-up | CPU s | certificate | pairs "
        "| bytes/point | ratio |"
    )
    print("|" + "---|" * 10)
    with tempfile.TemporaryDirectory() as folder:
        for name, (make, *sizes), loads, free in chosen(args):
            path = str(Path(folder) / "map.npy")
            np.save(path, make(*sizes))
            case = {"map": path, "loads": loads, "free": free, "target": TARGET}
            names = ["ours", *(args.solvers if args.peers else [])]
            workers = [
                Worker(n, sys.executable if n == "ours" else args.peers, args.threads, args.factor)
                for n in names
            ]
            reached, answers = measure(case, workers, args.repeats, folder)
            for worker in workers:
                worker.close()
            own = statistics.median(a["wall"] for a in answers["ours"])
            for solver, runs in answers.items():
                if not runs:
                    print(f"| {name} | {solver} | failed |" + " |" * 7)
                    continue
                walls = [a["wall"] for a in runs]
                middle = statistics.median(walls)
                solved = statistics.median(a["wall"] - a.get("setup", 0.0) for a in runs)
                missed = "" if reached[solver] <= TARGET else " MISSED"
                print(
                    f"| {name} | {solver} | {middle:.4g} | {min(walls):.4g} | {solved:.4g} "
                    f"| {statistics.median(a['cpu'] for a in runs):.4g} "
                    f"| {reached[solver]:.1e}{missed} | {runs[0]['pairs']} "
                    f"| {max(a['bytes'] for a in runs):.0f} | {middle / own:.2f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
