"""The contact curve: what every model returns, how it prints and how it is read off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import __version__
from .errors import InputError

__all__ = ["POINT_FIELDS", "ContactCurve"]

POINT_FIELDS = (
    "separation",
    "mean_pressure",
    "load",
    "area_fraction",
    "contact_area",
    "contacts",
    "stiffness",
    "converged",
    "residual",
    "error_estimate",
)


@dataclass(frozen=True, eq=False)
class ContactCurve:
    """Load, separation and real contact area over a sequence of load points.

    Attributes
    ----------
    separation
        Distance of the rigid flat from the mean plane [m], shape (n,).
    mean_pressure
        Load over nominal area [Pa], shape (n,), compression positive.
    load
        Normal load [N], shape (n,).
    area_fraction
        Real contact area over nominal area [-], shape (n,).
    contact_area
        Real contact area [m^2], shape (n,).
    contacts
        Number of separate contact spots [-], shape (n,).
    stiffness
        Minus the slope of mean pressure over separation [Pa/m], shape (n,).
    converged
        Whether the point reached its tolerance, shape (n,).
    residual
        Relative residual of the solver at the point [-], shape (n,).
    error_estimate
        Expected relative error of the load at equal separation [-], shape (n,); NaN if unknown.
    model
        Name of the model.
    seconds
        Run time by stage [s].
    settings
        Everything needed to repeat the run.
    extra
        Further arrays over the load points, by name.
    reasons
        One sentence for each load point that did not converge or was refused, else "".
    version
        Version of the package that made the curve.
    """

    separation: NDArray[np.float64]
    mean_pressure: NDArray[np.float64]
    load: NDArray[np.float64]
    area_fraction: NDArray[np.float64]
    contact_area: NDArray[np.float64]
    contacts: NDArray[np.int64]
    stiffness: NDArray[np.float64]
    converged: NDArray[np.bool_]
    residual: NDArray[np.float64]
    error_estimate: NDArray[np.float64]
    model: str
    seconds: Mapping[str, float] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    extra: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    reasons: tuple[str, ...] = ()
    version: str = __version__

    def __post_init__(self) -> None:
        n = np.size(self.separation)
        for name in POINT_FIELDS:
            array = np.atleast_1d(np.asarray(getattr(self, name)))
            if array.shape != (n,):
                raise InputError(f"{name} has shape {array.shape}; expected ({n},)")
            object.__setattr__(self, name, array)
        if not self.reasons:
            object.__setattr__(self, "reasons", ("",) * n)

    def __len__(self) -> int:
        return len(self.separation)
