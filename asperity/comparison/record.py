"""What a comparison of both models holds: errors, run times, verdict; read and written."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from asperity.errors import FileFormatError, InputError
from asperity.results.curve import ContactCurve, read_results
from asperity.results.storage import ResultFile, write_results
from surfaces.drawing import with_unit
from surfaces.heightmap import HeightMap

from .other_grids import ERRORS

__all__ = ["PARETO_TYPE", "ComparisonRecord"]

PARETO_TYPE = np.dtype(
    [
        ("model", "U16"),
        ("ny", np.int64),
        ("nx", np.int64),
        *((name, np.float64) for name in ("tolerance", "seconds", *ERRORS)),
    ]
)

TABLE_COLUMNS = (
    "mean_pressure",
    "area_bem",
    "area_model",
    "separation_bem",
    "separation_model",
    *ERRORS,
    "contacts_bem",
    "contacts_model",
)

CONTACTS = "bem", "asperity"
"""Maps that every comparison has."""


@dataclass(frozen=True, eq=False)
class ComparisonRecord:
    """The fields of a `Comparison`, its verdict and its file."""

    model: ContactCurve
    reference: ContactCurve
    table: NDArray[np.void]
    pareto: NDArray[np.void]
    overlap: float
    maps: dict[str, NDArray[Any]]
    map_point: int
    microcontacts: NDArray[np.void]
    plan: tuple[str, ...]
    about: dict[str, Any]
    elastic: ContactCurve | None = None
    resolution: NDArray[np.void] | None = None

    @property
    def surface(self) -> HeightMap | None:
        """The map, its heights about their mean to single precision; None of an earlier version."""
        if "heights" not in self.maps:
            return None
        facts = {name: self.about[name] for name in ("periodic", "name", "history")}
        return HeightMap(self.maps["heights"], self.about["spacing"], **facts)

    @property
    def converged(self) -> bool:
        """Whether every point of both models converged."""
        return bool(self.model.converged.all() and self.reference.converged.all())

    @property
    def rival(self) -> NDArray[np.void] | None:
        """The fastest boundary-element run at least as accurate as the model, if there is one."""
        ours = self.pareto[self.pareto["model"] == "asperity"][0]
        others = self.pareto[self.pareto["model"] == "bem"]
        as_good = (others["load_error"] <= ours["load_error"]) & (
            others["area_error"] <= ours["area_error"]
        )
        if not as_good.any():
            return None
        fastest: NDArray[np.void] = others[as_good][np.argmin(others[as_good]["seconds"])]
        return fastest

    def verdict(self) -> str:
        """What a reader wants to know first, in three sentences."""
        row, ours = self.table[self.map_point], self.pareto[0]
        text = f"At a mean pressure of {with_unit(row['mean_pressure'], 'Pa')}, "
        for name, of in (("boundary elements", "bem"), ("microcontact model", "model")):
            if math.isfinite(row[f"area_{of}"]):
                text += (
                    f"{100 * row[f'area_{of}']:.3g} % of the nominal area touches at a separation "
                    f"of {with_unit(row[f'separation_{of}'], 'm')} ({name}). "
                )
                break
        else:
            text += "neither boundary elements nor the microcontact model converged. "
        if self.elastic is not None and self.elastic.converged[self.map_point]:
            share = 100 * self.elastic.area_fraction[self.map_point]
            text += (
                f"Without the hardness of {with_unit(self.about['hardness'], 'Pa')} it would be "
                f"{share:.3g} % (microcontact model). "
            )
        judged = int(np.count_nonzero(np.isfinite(self.table["area_error"])))
        if not judged:
            return text + "No load point of the microcontact model can be judged."
        where = "Over the whole curve"
        if judged < len(self.table):
            where = f"At {judged} of {len(self.table)} load points, the others not being judged,"
        what = {"load_error": "load at equal separation", "area_error": "area at equal load"}
        errors = " and ".join(
            f"{100 * ours[name]:.2g} % rms in {text}"
            for name, text in what.items()
            if math.isfinite(ours[name])
        )
        text += f"{where} the microcontact model is off by {errors}, in {ours['seconds']:.2g} s. "
        rival = self.rival
        if rival is None:
            return text + "No loose boundary-element run was as accurate."
        ratio = float(rival["seconds"] / ours["seconds"])
        speed = (
            f"{ratio:.2g} times faster than" if ratio >= 1 else f"{1 / ratio:.2g} times slower than"
        )
        if 0.95 < ratio < 1.05:
            speed = "as fast as"
        return text + (
            f"The model is {speed} the fastest boundary-element run at least as accurate "
            f"({rival['ny']} x {rival['nx']} points, tolerance {rival['tolerance']:.0e}, "
            f"{rival['seconds']:.2g} s)."
        )

    def to_results(self) -> ResultFile[ContactCurve]:
        """Everything as the content of a results file."""
        about = {
            **self.about,
            "plan": list(self.plan),
            "overlap": self.overlap,
            "map_point": self.map_point,
        }
        curves = {"asperity": self.model, "bem": self.reference}
        if self.elastic is not None:
            curves["elastic"] = self.elastic
        tables = {
            "comparison": self.table,
            "pareto": self.pareto,
            "microcontacts": self.microcontacts,
        }
        if self.resolution is not None:
            tables["resolution"] = self.resolution
        return ResultFile(curves, tables, dict(self.maps), about)

    def to_hdf5(self, path: str | os.PathLike[str]) -> None:
        """Write the curves, the tables and the maps to a results file."""
        write_results(path, self.to_results())

    @classmethod
    def from_hdf5(cls, path: str | os.PathLike[str]) -> Self:
        """Read a comparison back from a results file.

        Raises
        ------
        FileFormatError, InputError
            If the file is unreadable or holds no comparison.
        """
        return cls.from_results(read_results(path), path)

    @classmethod
    def from_results(cls, held: ResultFile[ContactCurve], path: str | os.PathLike[str]) -> Self:
        """The comparison that the content of a results file holds; `path` is for messages."""
        if "comparison" not in held.tables:
            raise InputError(f"{path} holds no comparison; make one with asperity compare")
        about = dict(held.about)
        if not (
            _has_numbers(held.tables["comparison"], TABLE_COLUMNS)
            and _has_numbers(held.tables.get("pareto"), (PARETO_TYPE.names or ())[1:])
        ):
            raise FileFormatError(
                f"{path}: a column of the comparison is missing or holds no numbers; make it again"
            )
        try:
            found = cls(
                model=held.curves["asperity"],
                reference=held.curves["bem"],
                table=held.tables["comparison"],
                pareto=held.tables["pareto"],
                plan=tuple(about.pop("plan")),
                overlap=float(about.pop("overlap")),
                map_point=int(about.pop("map_point")),
                maps=held.maps | {name: held.maps[name].astype(bool) for name in CONTACTS},
                microcontacts=held.tables["microcontacts"],
                about=about,
                elastic=held.curves.get("elastic"),
                resolution=held.tables.get("resolution"),
            )
            whole = set(CONTACTS) <= set(found.maps) and all(
                one.shape == tuple(about["shape"]) for one in found.maps.values()
            )
        except (KeyError, TypeError, ValueError):
            whole = False
        if not whole:
            raise FileFormatError(f"{path}: part of the comparison is missing; make it again")
        return found

    def __str__(self) -> str:
        lines = ["  pressure [Pa]   area BEM   area model   load error   area error   ds/rms"]
        columns = {
            "mean_pressure": (1, "{:14.4g}"),
            "area_bem": (1, "{:11.4f}"),
            "area_model": (1, "{:13.4f}"),
            "load_error": (100, "{:+11.2f} %"),
            "area_error": (100, "{:+11.2f} %"),
            "separation_error": (1, "   {:+.4f}"),
        }
        for row in self.table:
            shown = (_shown(times * row[name], form) for name, (times, form) in columns.items())
            lines.append("".join(shown))
        lines += [f"  contact-map overlap {_shown(self.overlap, '{:.2f}')}", self.verdict()]
        return "\n".join(lines)

    __repr__ = __str__


def _shown(value: float, form: str) -> str:
    """A number in a form, or as many places with "-" where nothing touches or no answer is."""
    text = form.format(value)
    return "-".rjust(len(text)) if math.isnan(value) else text


def _has_numbers(table: NDArray[Any] | None, names: tuple[str, ...]) -> bool:
    """Whether a table has these columns, all of them of real numbers."""
    if table is None or not set(names) <= set(table.dtype.names or ()):
        return False
    return all(table.dtype[name].kind in "biuf" for name in names)
