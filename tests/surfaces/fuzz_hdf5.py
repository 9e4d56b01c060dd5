"""Mutate HDF5 height maps: each must read correctly or raise one sentence.

Run as ``python tests/surfaces/fuzz_hdf5.py --count 5000 --seed 1``. A hang ends the process by
SIGPROF (SIGALRM if it only waits), a memory blow-up by the address-space limit, a crash by itself;
with ``--verbose`` the last line printed names the case.
"""

from __future__ import annotations

import argparse
import collections
import resource
import signal
import tempfile
from pathlib import Path

import h5py
import numpy as np

import surfaces

CPU_SECONDS_PER_CASE = 10
SECONDS_PER_CASE = 300
MEMORY = 4 << 30
VALUES = (
    "um", "", "parsec", "\x00", 0.0, -1.0, np.nan, np.inf, 1e300, 1e-300, 2**62, True,
    [1e-6, 1e-6], [], [[1.0, 2.0]], np.zeros(1000), b"\xff\xfe", "x" * 100_000, 1j, None,
)  # fmt: skip


def write_seeds(folder: Path) -> dict[str, Path]:
    """Files to mutate: ours, and foreign ones in old layouts without checksums."""
    heights = np.random.default_rng(0).normal(0.0, 1e-7, (300, 52))
    heights[3, 4] = np.nan
    seeds = {name: folder / f"{name}.h5" for name in ("ours", "packed", "plain")}
    history = ({"step": "read", "file": "a.sur", "unit": "um"},)
    ours = surfaces.HeightMap(heights, (1e-6, 2e-6), periodic=True, name="m", history=history)
    surfaces.write(ours, seeds["ours"])
    for name, layout in (("packed", {"chunks": (16, 16), "compression": "gzip"}), ("plain", {})):
        with h5py.File(seeds[name], "w", libver="earliest") as file:
            file["group/other"] = np.arange(50.0)
            data = file.create_dataset("heights", data=heights.astype("f4"), **layout)
            data.attrs["spacing"] = (1e-6, 2e-6)
            data.attrs["unit"] = "m"
            data.attrs["periodic"] = False
            data.attrs["description"] = "old layout"
    return seeds


def mutate_bytes(content: bytes, rng: np.random.Generator) -> bytes:
    """Flip, overwrite, cut, repeat or drop bytes; more often near the front, where metadata lie."""
    data = bytearray(content)
    front = 3000 if rng.random() < 0.6 else len(data)
    kind = rng.integers(7)
    at = int(rng.integers(min(front, len(data))))
    if kind <= 2:
        for _ in range(int(rng.integers(1, 12))):
            data[int(rng.integers(min(front, len(data))))] = int(rng.integers(256))
    elif kind == 3:
        data[at] ^= 1 << int(rng.integers(8))
    elif kind == 4:
        return bytes(data[:at])
    elif kind == 5:
        length = int(rng.integers(1, 64))
        data[at : at + length] = rng.choice([b"\x00", b"\xff"]) * len(data[at : at + length])
    else:
        start = int(rng.integers(len(data)))
        data[at:at] = data[start : start + int(rng.integers(1, 64))]
    return bytes(data)


def mutate_content(path: Path, rng: np.random.Generator) -> None:
    """Give the heights another attribute, type or shape by means of the library itself."""
    with h5py.File(path, "r+") as file:
        if rng.random() < 0.2:
            del file["heights"]
            shape = tuple(int(n) for n in rng.integers(0, 7, size=int(rng.integers(0, 4))))
            kind = rng.choice(["f2", "f4", "f8", "i1", "u8", "c16", "S5", "?"])
            file["heights"] = np.ones(shape, dtype=kind)
        names = ["spacing", "unit", "periodic", "schema", "name", "history", "extra"]
        for name in rng.choice(names, size=int(rng.integers(1, 4)), replace=False):
            file["heights"].attrs.pop(name, None)
            value = VALUES[int(rng.integers(len(VALUES)))]
            if (value is not None and not isinstance(value, str)) or value:
                try:
                    file["heights"].attrs[name] = value
                except (OSError, ValueError, RuntimeError):
                    continue


def outcome(path: Path, original: surfaces.HeightMap | None) -> str:
    """What reading gave: ``same``, ``other`` (read, with other content) or the error's kind."""
    try:
        hm = surfaces.read(path)
    except (surfaces.FileFormatError, surfaces.SurfaceError) as error:
        text = str(error)
        if not text.startswith(str(path)) or "\n" in text or len(text) > 2000:
            raise AssertionError(f"not one sentence that names the file: {text!r}") from error
        return type(error).__name__
    surfaces.validate(path)
    if original is None:
        return "other"
    return "same" if hm.digest == original.digest else "other"


def run(count: int, seed: int, verbose: bool) -> collections.Counter[str]:
    """Mutate and read `count` files; returns how often each outcome came."""
    results: collections.Counter[str] = collections.Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        seeds = write_seeds(folder)
        originals = {name: surfaces.read(path) for name, path in seeds.items()}
        contents = {name: path.read_bytes() for name, path in seeds.items()}
        path = folder / "case.h5"
        for case in range(count):
            rng = np.random.default_rng([seed, case])
            kind = ("ours", "packed", "plain")[case % 3]
            by_bytes = case % 7 != 0
            if verbose:
                print(f"case {case} of seed {seed}", flush=True)
            if by_bytes:
                path.write_bytes(mutate_bytes(contents[kind], rng))
            else:
                path.write_bytes(contents[kind])
                mutate_content(path, rng)
            signal.alarm(SECONDS_PER_CASE)
            signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS_PER_CASE)
            found = outcome(path, originals[kind] if by_bytes else None)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.alarm(0)
            if found == "other" and by_bytes and kind == "ours":
                raise AssertionError(f"case {case}: a damaged file of ours was read as another map")
            results[f"{kind} {'bytes' if by_bytes else 'content'}: {found}"] += 1
    return results


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--verbose", action="store_true")
    args = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for name, times in sorted(run(args.count, args.seed, args.verbose).items()):
        print(f"{times:6d}  {name}")


if __name__ == "__main__":
    main()
