"""Result of a comparison of both models: errors, run times, verdict, report."""

from __future__ import annotations

import os
from dataclasses import dataclass

from .record import ComparisonRecord

__all__ = ["Comparison"]


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(ComparisonRecord):
    """Both models on the same surface at the same loads, and what each cost.

    Attributes
    ----------
    model
        Curve of the microcontact model.
    reference
        Curve of the boundary-element solution on the full grid.
    table
        One row per load point: mean_pressure [Pa], area fractions and separations [m] of both
        models, load_error (load at equal separation, relative), area_error (area at equal load,
        relative), separation_error (at equal load, in rms heights), contacts of both, and mean
        contact pressures [Pa] of both. NaN where the model in question did not converge.
    pareto
        One row per run: model, ny, nx, tolerance, seconds, and its rms errors over the load points.
    overlap
        Intersection over union of the two contact maps.
    maps
        "bem" and "asperity": contact maps (ny, nx) at the load point `map_point`; "pressure_bem"
        and "pressure_asperity" [Pa] there, and "heights" [m] about their mean, in single precision;
        files of earlier versions have the first two.
    map_point
        Index of the load point of the maps.
    microcontacts
        Table of the microcontacts at that load point.
    plan
        What the model run needed and left out.
    about
        Facts about the input.
    elastic
        Curve of the microcontact model at these loads without the hardness; None where the body has
        none.
    resolution
        Error that the pixels of the map leave in the reference itself, at the lightest and at the
        heaviest load: mean_pressure [Pa], load_error and area_error (relative, against a grid twice
        as fine), its ny and nx; None if it is not known.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> both = asperity.compare(hm, steel, pressures=[1e9], tolerance=1e-4)
    >>> both.verdict().split(",")[0]
    'At a mean pressure of 1 GPa'
    """

    def to_html(self, path: str | os.PathLike[str]) -> None:
        """Write the self-contained report."""
        from .report.build import write_report
        from .report.sample import Sample

        write_report(path, [Sample.of_comparison(self)])
