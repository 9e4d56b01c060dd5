"""One solver in a process of its own: reads cases as JSON lines, times them, answers in JSON.

Run by `benchmarks/bem.py`, by the project's interpreter for "ours" and by the peers' interpreter
for the others; it imports nothing that the chosen solver does not need.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np


def ours(case, heights):
    """Single load or curve by this project; pressures, and what the solver says of its cost."""
    import asperity
    from surfaces import HeightMap

    n = heights.shape[0]
    body = asperity.HalfSpace.from_modulus(1.0)
    boundary = "free" if case["free"] else "periodic"
    hm = HeightMap(heights, 1.0 / n)

    def run():
        options = {"tolerance": case["target"], "boundary": boundary}
        if len(case["loads"]) > 1:
            curve = asperity.bem_curve(hm, body, pressures=case["loads"], **options)
            cost = {
                "pairs": int(curve.extra["fft_pairs"].sum()),
                "setup": curve.seconds["setup"],
                "certificate": float(curve.residual.max()),
            }
            return None, cost
        found = asperity.bem_solve(hm, body, pressure=case["loads"][0], **options)
        return found.pressure, {"pairs": found.fft_pairs, "setup": found.seconds["setup"]}

    return run


def aspher(case, heights, **options):
    """ASPHER's nested solver; its tolerance is relative to the larger of height range and load."""
    import aspher

    n = heights.shape[0]
    gap = np.ascontiguousarray(-heights).ravel()
    options.setdefault("backend", "fft" if case["free"] else "periodic")

    def run():
        pressures, pairs = [], 0
        for load in case["loads"]:
            tolerance = case["target"] * case["factor"] * heights.std()
            tolerance /= max(float(np.ptp(heights)), load)
            more = dict(options)
            if more.get("precision") == "float":
                more["float_floor"] = tolerance
            found = aspher.solve_nested(
                n, gap, load, tol=tolerance, max_iter=5000, light_result=True, coarsest=64, **more
            )
            pressures.append(np.asarray(found.pressure).reshape(n, n))
            pairs += found.matvec_count + found.precond_count
        return pressures[-1], {"pairs": pairs}

    return run


def tamaas(case, heights):
    """Tamaas' Polonsky-Keer solver, cold."""
    import tamaas as tm

    n = heights.shape[0]

    def run():
        model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], [n, n])
        model.E, model.nu = 1.0, 0.0
        solver = tm.PolonskyKeerRey(model, heights, case["target"] * case["factor"])
        solver.max_iter = 20000
        for load in case["loads"]:
            model.traction[:] = 0.0
            solver.solve(load)
        return np.array(model.traction), {"pairs": 0}

    return run


SOLVERS = {
    "ours": ours,
    "aspher-d": lambda c, h: aspher(c, h, precision="double"),
    "aspher-ftd": lambda c, h: aspher(c, h, precision="float_then_double"),
    "aspher-h2": lambda c, h: aspher(c, h, precision="double", backend="h2"),
    "tamaas": tamaas,
}


def memory(key):
    """A line of /proc/self/status [bytes]."""
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith(key + ":"))


def reset_peak():
    """Let the peak of the resident memory start anew."""
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")


def main():
    """Answer one line for each line."""
    name = sys.argv[1]
    answers = sys.stdout
    sys.stdout = sys.stderr
    for line in sys.stdin:
        case = json.loads(line)
        heights = np.load(case["map"])
        run = SOLVERS[name](case, heights)
        before = memory("VmRSS")
        reset_peak()
        wall, cpu = time.perf_counter(), time.process_time()
        pressure, cost = run()
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        peak = (memory("VmHWM") - before) / heights.size
        if case.get("out") and pressure is not None:
            np.save(case["out"], pressure)
        answers.write(json.dumps({"wall": wall, "cpu": cpu, "bytes": peak, **cost}) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
