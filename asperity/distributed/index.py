"""The index of a sweep: a row for each job, in memory and in files."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asperity.errors import FileFormatError, InputError
from asperity.results.curve import ContactCurve, read_results
from asperity.results.storage import (
    ResultFile,
    columns,
    structured,
    write_csv,
    write_results,
)

if TYPE_CHECKING:
    import pandas

__all__ = ["Sweep", "require_own"]

TABLE = "index"


@dataclass(frozen=True, eq=False, repr=False)
class Sweep:
    """What a sweep found, a row for each job; the curves stay in their files.

    Attributes
    ----------
    folder
        Folder of the sweep: ``index.csv``, ``index.h5``, and a results file for each job in
        ``results/``.
    table
        Structured array, shape (n,): surface, body and settings of each job; its ``state`` (done,
        not converged, failed, waiting) and ``reason``; values at the heaviest load point that
        converged, ``seconds`` of the job, ``digest`` and results ``file``. Numbers of a failed job
        are NaN.

    Examples
    --------
    >>> import tempfile
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = asperity.sweep(hm, steel, {"pressures": [1e8, 1e9]}, folder=folder, workers=1)
    ...     list(run.to_dataframe().state), run.curve(0).model
    (['done'], 'asperity')
    """

    folder: Path
    table: NDArray[np.void]

    def __len__(self) -> int:
        return len(self.table)

    @property
    def failed(self) -> NDArray[np.intp]:
        """Rows of the jobs that failed."""
        return np.flatnonzero(self.table["state"] == "failed")

    @property
    def converged(self) -> bool:
        """Whether every load point of every job converged."""
        return bool((self.table["state"] == "done").all())

    def curve(self, row: int) -> ContactCurve:
        """The curve of a job, read from its file.

        Raises
        ------
        InputError
            If the job has no result, or there is no such job.
        """
        if row not in range(-len(self), len(self)):
            raise InputError(f"row is {row!r}; the jobs are numbered 0 to {len(self) - 1}")
        found = self.table[int(row)]
        if not found["file"]:
            raise InputError(f"job {row} ({found['surface']}) has no curve: {found['reason']}")
        return ContactCurve.from_hdf5(self.folder / str(found["file"]))

    def to_dataframe(self) -> pandas.DataFrame:
        """The index as a pandas frame."""
        import pandas

        return pandas.DataFrame(columns(self.table))

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the index with a header line; NaN is left empty."""
        write_csv(path, columns(self.table))

    def write(self) -> None:
        """Write ``index.h5`` and ``index.csv`` into the folder, each replaced at once."""
        write_results(self.folder / "index.h5", ResultFile(tables={TABLE: self.table}))
        self.to_csv(self.folder / "index.csv")

    @classmethod
    def read(cls, folder: str | os.PathLike[str]) -> Sweep:
        """The sweep in a folder, as far as it has come.

        Raises
        ------
        FileFormatError
            If the folder holds no index, or a damaged one.
        """
        tables = read_results(Path(folder) / "index.h5").tables
        if TABLE not in tables:
            raise FileFormatError(f"{folder}/index.h5 is no index of a sweep")
        return cls(Path(folder), tables[TABLE])

    @classmethod
    def of_rows(cls, folder: Path, rows: Sequence[Mapping[str, str | float]]) -> Sweep:
        """The sweep of rows by name of the column; what a row lacks is NaN, or no text."""
        names = list(dict.fromkeys(name for row in rows for name in row))
        return cls(folder, structured({name: _column(name, rows) for name in names}))

    def __str__(self) -> str:
        states, counts = np.unique(self.table["state"], return_counts=True)
        told = ", ".join(f"{n} {s}" for s, n in zip(states, counts, strict=True))
        work = np.nansum(self.table["seconds"]) if "seconds" in columns(self.table) else 0.0
        first = [self.table[row] for row in self.failed[:10]]
        left = len(self.failed) - len(first)
        lines = [
            f"sweep           {len(self)} jobs: {told}",
            f"work            {work:.3g} s",
            f"index           {self.folder / 'index.csv'}",
            *(f"failed          {row['surface']}: {row['reason']}" for row in first),
            *([f"failed          and {left} more, see the index"] if left else []),
        ]
        return "\n".join(lines)

    __repr__ = __str__


def require_own(folder: Path, *names: str) -> None:
    """Refuse a folder with files of these names, or of an index, that are of no sweep: those of a
    sweep would replace them."""
    there = [name for name in ("index.csv", "index.h5", *names) if (folder / name).exists()]
    try:
        if there:
            Sweep.read(folder)
    except FileFormatError:
        raise InputError(
            f"{folder / there[0]} is there already, and not of a sweep; give another folder, or "
            "force it to be replaced (--force)"
        ) from None


def _column(name: str, rows: Sequence[Mapping[str, str | float]]) -> NDArray[Any]:
    """Cells of one name: texts, or numbers."""
    text = any(isinstance(row.get(name), str) for row in rows)
    if text:
        return np.array([str(row.get(name, "")) for row in rows])
    return np.array([row.get(name, math.nan) for row in rows], float)
