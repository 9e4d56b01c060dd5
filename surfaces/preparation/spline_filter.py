"""Areal spline filter: the smoothing spline through a map, free at its border."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from surfaces.errors import SurfaceError
from surfaces.heightmap import HeightMap

__all__ = ["free_spline", "spline_share"]

Array = NDArray[np.float64]


def spline_share(
    hm: HeightMap, cutoff: float, frequencies: tuple[Array, Array]
) -> Callable[[slice], Array]:
    """Share of each wave that passes the filter of a map without a border, of those in the columns
    of its spectrum asked for; half of the wavelength `cutoff` [m].

    The `frequencies` [1/m] along y and x are those of its Fourier spectrum, or cosine spectrum if
    it is not periodic.

    Raises
    ------
    SurfaceError
        If the cut-off is below two pixels.

    Notes
    -----
    The filtered map w minimizes sum (z - w)^2 + sum (a_y^2 w_yy)^2 + 2 (a_y a_x w_yx)^2 +
    (a_x^2 w_xx)^2 over second differences w_yy, w_yx, w_xx of the grid, with a = 1 / (2 sin(pi d /
    cutoff)) for the pixel size d of each axis. A wave along an axis passes with 1 / (1 + (sin(pi d
    / wavelength) / sin(pi d / cutoff))^4), as through the profile filter; one in another direction
    to the order of the grid.

    References
    ----------
    ISO 16610-62 (areal spline filters), ISO 16610-22, 4.2 (alpha of the profile filter).
    Krystek 2005, Spline filters for surface texture analysis, Key Eng. Mater. 295-296, 441-446.
    """
    if cutoff < 2.0 * max(hm.spacing):
        raise SurfaceError(
            f"a spline filter of {cutoff:g} m is shorter than two pixels; take "
            f"{2.0 * max(hm.spacing):g} m or more, or None"
        )
    (bend_y, bend_x) = (
        np.square(np.sin(math.pi * d * frequency) / math.sin(math.pi * d / cutoff))
        for d, frequency in zip(hm.spacing, frequencies, strict=True)
    )

    def share(columns: slice) -> Array:
        return np.asarray(1.0 / (1.0 + np.square(bend_y[:, None] + bend_x[columns])))

    return share


def free_spline(hm: HeightMap, cutoff: float, passed: Array) -> Array:
    """Long waves of a map that is not periodic and has no missing points, heights [m] (ny, nx).

    Its ends are free (natural conditions), which keep planes: conjugate gradients, preconditioned
    by the filter of the map mirrored at its border, of which the shares `passed` are those of
    `spline_share` for this `cutoff` [m].
    """
    y, x = (0.25 / math.sin(math.pi * d / cutoff) ** 2 for d in hm.spacing)
    (slope_y, bend_y), (slope_x, bend_x) = (_differences(count) for count in hm.shape)

    def normal(flat: Array) -> Array:
        w = flat.reshape(hm.shape)
        bends = y * y * (bend_y @ w) + 2.0 * x * y * (slope_y @ w @ slope_x) + x * x * (w @ bend_x)
        return np.asarray(w + bends).ravel()

    def mirrored(flat: Array) -> Array:
        return np.asarray(fft.idctn(fft.dctn(flat.reshape(hm.shape)) * passed)).ravel()

    operator, guess = (
        LinearOperator((hm.heights.size,) * 2, matvec=f, dtype=np.float64)
        for f in (normal, mirrored)
    )
    mean = float(hm.heights.mean())
    z = (hm.heights - mean).ravel()
    w, status = cg(operator, z, x0=guess @ z, rtol=1e-9, maxiter=3000, M=guess)
    if status != 0:
        raise SurfaceError(
            f"the spline filter of {cutoff:g} m did not converge; take a shorter cut-off or "
            'filter="gaussian" (--filter gaussian)'
        )
    return np.asarray(w.reshape(hm.shape) + mean)


def _differences(count: int) -> tuple[csr_array, csr_array]:
    """Squares of the first and of the second differences of a line of points, as matrices."""
    first = diags_array([-1.0, 1.0], offsets=[0, 1], shape=(count - 1, count))
    second = diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(count - 2, count))
    return csr_array(first.T @ first), csr_array(second.T @ second)
