"""The mean curve of an ensemble, its bands, and how they narrow with the members."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asperity.errors import InputError
from asperity.results.storage import (
    ResultFile,
    columns,
    structured,
    write_csv,
    write_results,
)
from asperity.results.table import axis
from surfaces.arrays import Array

from .index import Sweep

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

__all__ = ["DECIDES", "QUANTITIES", "Ensemble", "mean_and_scatter", "relative_half_width"]


QUANTITIES = ("separation", "area_fraction", "stiffness", "contacts")
"""Columns of the members that are averaged."""

DECIDES = "area_fraction"
"""The one whose mean must be known well enough."""

LEVEL = 0.95
"""Probability of the confidence interval of a mean."""

TENTHS = 0.1, 0.9
"""Quantiles of the members that are told."""


def mean_and_scatter(curves: Array) -> tuple[Array, Array, Array]:
    """Mean of curves, shape (n, p), at each of their points, shape (p,); the standard deviation of
    the curves; and the half width of the confidence interval of the mean. NaN is left out.

    Notes
    -----
    The half width is t s / sqrt(n), with the quantile t of Student's distribution of n - 1 degrees
    of freedom and the standard deviation s. It is NaN of fewer than two curves, as s is.
    """
    from scipy.special import stdtrit

    count = np.isfinite(curves).sum(axis=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # NaN where too few curves have a value
        mean, deviation = np.nanmean(curves, axis=0), np.nanstd(curves, axis=0, ddof=1)
    quantile = stdtrit(np.maximum(count - 1, 1), 0.5 + 0.5 * LEVEL)
    return mean, deviation, np.asarray(quantile * deviation / np.sqrt(np.maximum(count, 1)))


def relative_half_width(curves: Array) -> float:
    """Largest half width over the mean, of curves as in `mean_and_scatter`; infinite where a mean
    is not known."""
    mean, _, half_width = mean_and_scatter(curves)
    known = np.isfinite(half_width) & (mean != 0.0)
    share = np.full(mean.shape, np.inf)
    share[known] = half_width[known] / np.abs(mean[known])
    return float(share.max())


@dataclass(frozen=True, eq=False, repr=False)
class Ensemble:
    """Mean curve of an ensemble; made by `asperity.ensemble`.

    Attributes
    ----------
    sweep
        Index of the members that were taken, in their order; some may have failed.
    pressures
        Mean pressures [Pa] at which they are compared, shape (p,).
    values
        By name of the column, those of each member that has a curve, shape (n, p).
    convergence
        Half width of the 95 % confidence interval of the mean contact area over that mean, at the
        worst pressure, after each of them, shape (n,); infinite after the first.
    until
        What it was to come down to; None if nothing was asked for.

    Examples
    --------
    >>> import tempfile
    >>> from functools import partial
    >>> import asperity, surfaces
    >>> make = partial(
    ...     surfaces.self_affine, (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = asperity.ensemble(
    ...         make, steel, {"pressures": [1e8, 1e9]}, folder=folder, seeds=12, until=0.5
    ...     )
    >>> found.met, len(found.to_dataframe())
    (True, 2)
    """

    sweep: Sweep
    pressures: Array
    values: Mapping[str, Array]
    convergence: Array
    until: float | None = None

    def __len__(self) -> int:
        return len(self.convergence)

    @property
    def met(self) -> bool:
        """Whether the mean is known as well as was asked for."""
        return self.until is None or bool(self.convergence[-1] <= self.until)

    @property
    def table(self) -> NDArray[np.void]:
        """A row per pressure, shape (p,): ``mean_pressure``, number of ``members``; of each column
        its mean by its name, ``_std`` the standard deviation of the members, ``_p10`` and ``_p90``
        quantiles of them, ``_half_width`` that of the 95 % confidence interval of the mean."""
        found: dict[str, Any] = {"mean_pressure": self.pressures}
        for name, curves in self.values.items():
            mean, deviation, half_width = mean_and_scatter(curves)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)  # NaN where no member has a value
                low, high = np.nanquantile(curves, TENTHS, axis=0)
            found |= {
                "members": np.isfinite(curves).sum(axis=0),
                name: mean,
                f"{name}_std": deviation,
                f"{name}_p10": low,
                f"{name}_p90": high,
                f"{name}_half_width": half_width,
            }
        return structured(found)

    def to_dataframe(self) -> pandas.DataFrame:
        """The table as a pandas frame."""
        import pandas

        return pandas.DataFrame(columns(self.table))

    def write(self) -> None:
        """Write ``ensemble.csv``, ``convergence.csv`` and both, with the members, as
        ``ensemble.h5`` into the folder of the sweep."""
        folder = self.sweep.folder
        narrowing = {
            "members": np.arange(1, len(self) + 1),
            "relative_half_width": self.convergence,
        }
        write_csv(folder / "ensemble.csv", columns(self.table))
        write_csv(folder / "convergence.csv", narrowing)
        tables = {"ensemble": self.table, "convergence": structured(narrowing)}
        about = {"until": self.until}
        write_results(folder / "ensemble.h5", ResultFile({}, tables, dict(self.values), about))

    def plot(self, y: str = "area_fraction", ax: Axes | None = None, **style: Any) -> Axes:
        """Draw a mean over the pressure: its confidence dark, the middle 80 % of members light.

        Parameters
        ----------
        y
            Name of the column.
        ax
            Axes to draw on; new ones if None.
        style
            Further arguments of `matplotlib.axes.Axes.plot`.

        Raises
        ------
        InputError
            If there is no such column.
        """
        if y not in self.values:
            raise InputError(f"there is no column {y!r}; there are {', '.join(self.values)}")
        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.subplots(layout="constrained")[1]
        table, (across, pressure), (up, unit) = self.table, axis("mean_pressure"), axis(y)
        x = self.pressures / pressure
        mean, half, low, high = (
            table[f"{y}{part}"] / unit for part in ("", "_half_width", "_p10", "_p90")
        )
        look: dict[str, Any] = {"label": f"mean of {len(self)}"} | style
        (line,) = ax.plot(x, mean, **look)
        shade: dict[str, Any] = {"color": line.get_color(), "linewidth": 0}
        ax.fill_between(x, low, high, alpha=0.15, **shade)
        ax.fill_between(x, mean - half, mean + half, alpha=0.35, **shade)
        ax.set(xlabel=across, ylabel=up, xscale="log")
        return ax

    def __str__(self) -> str:
        table, width = self.table, self.convergence[-1]
        first, last = (f"{p:.3g}" for p in (self.pressures.min(), self.pressures.max()))
        scatter = table["area_fraction_std"] / table["area_fraction"]
        known = scatter[np.isfinite(scatter)]
        told = (
            f"{100 * known.max():.2g} % of the mean contact area, at most"
            if known.size
            else "unknown"
        )
        asked = ""
        if self.until is not None:
            asked = f"; {self.until:.2g} asked for: {'met' if self.met else 'NOT MET'}"
        failed = [self.sweep.table[row] for row in self.sweep.failed[:10]]
        return "\n".join(
            [
                f"ensemble        {len(self)} members, {len(self.sweep.failed)} failed",
                f"mean pressure   {first} .. {last} Pa, {len(self.pressures)} points",
                f"scatter         {told}",
                f"mean known to   {100 * width:.2g} % of the contact area ({LEVEL:.0%}){asked}",
                f"table           {self.sweep.folder / 'ensemble.csv'}",
                *(f"failed          {row['surface']}: {row['reason']}" for row in failed),
            ]
        )

    __repr__ = __str__
