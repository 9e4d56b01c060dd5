"""Rays on the interpolated map, eight samples at once."""

from __future__ import annotations

from surfaces.numerics.compiled import BORROWING, inner
from surfaces.numerics.spline_expansion import LANES, TAPS, WEIGHTS
from surfaces.numerics.vectors import loader, multiply_add, splatter, store, where, whole

__all__ = ["ray_places", "ray_signs", "rising_nodes"]

_load, _splat = loader(LANES), splatter(LANES)


@inner(forceinline=True, **BORROWING)
def _least(a, b):
    return where(a < b, a, b)


@inner(forceinline=True, **BORROWING)
def _inside(value, center, n, inverse):
    """A place moved by whole sides n so that `center` lies in the map; `inverse` is 1/n or 0."""
    return value - n * whole(center * inverse)


@inner(forceinline=True, **BORROWING)
def _along(start, way, r, n, inverse, margin):
    """Places along an axis, kept in the map or its margin, and their nearest pixels."""
    value = _least(multiply_add(r, way, _splat(start)), _splat(n + margin))
    value = -_least(-value, _splat(margin))
    value = _inside(value, value, n, inverse)
    pixel = whole(value + 0.5)
    return value, _inside(pixel, pixel + 0.5, n, inverse)


@inner(**BORROWING)
def ray_places(
    y, x, way_y, way_x, scale, most, radii, first, cell, corners, rest, weights, pixels, at, into
):
    """Eight places on a ray, and what `spline_values` needs there.

    They lie at ``(y, x) + r (way_y, way_x)`` with ``r = min(scale radii[first:], most)``, kept
    inside the cell or no further out than its margin. Written are `corners` of the coefficients and
    fractions of a pixel over x in `rest`, from `at` on; eight `weights` over y for each tap, from
    ``TAPS * at`` on; and the nearest `pixels` (-1 beyond the border), from `into` on, unless that
    is negative. `cell` holds height and width of the map, their inverses (zero if it is not
    periodic), the margin, the width of the coefficients and the corner of the first pixel.
    """
    ny, nx, margin, width = cell[0], cell[1], cell[4], cell[5]
    r = _least(scale * _load(radii, first), _splat(most))
    high, row = _along(y, way_y, r, ny, cell[2], margin)
    wide, col = _along(x, way_x, r, nx, cell[3], margin)
    if into >= 0:
        there = (row >= 0.0) & (row < ny) & (col >= 0.0) & (col < nx)
        store(pixels, into, where(there, multiply_add(row, nx, col), -1.0))
    row, col = whole(high), whole(wide)
    store(corners, at, multiply_add(row, width, col) + cell[6])
    store(rest, at, wide - col)
    t = high - row
    for tap in range(TAPS):
        share = _splat(WEIGHTS[0, TAPS - 1, tap])
        for power in range(TAPS - 2, -1, -1):
            share = multiply_add(share, t, WEIGHTS[0, power, tap])
        store(weights, TAPS * at + tap * LANES, share)


@inner(**BORROWING)
def ray_signs(zs, at, z, high, dip, pixels, labels, owner, peak, radii, first, end):
    """What holds at the eight samples of a ray from `at` on: five bytes of a number.

    f, which is z minus the height, rises above `high` and all samples before; has fallen `dip`
    below; the pixel lies in a basin whose owner is another than `peak`; it lies beyond the border;
    and the radius, from `first` on, exceeds `end`.
    """
    rises, fallen, foreign, gone, past = 0, 0, 0, 0, 0
    for k in range(LANES):
        f = z - zs[at + k]
        fallen |= (f <= high - dip) << k
        rises |= (f > high) << k
        high = f if f > high else high
        pixel = pixels[at + k]
        label = labels[max(pixel, 0)]
        gone |= (pixel < 0) << k
        foreign |= ((label >= 0) & (owner[max(label, 0)] != peak)) << k
        past |= (radii[first + k] > end) << k
    signs = past
    for part in (gone, foreign, fallen, rises):
        signs = signs << LANES | part
    return signs


@inner(**BORROWING)
def rising_nodes(zs, at, z, least, high, scale, squares, inverses, first):
    """Turn the eight heights from `at` on into f/r^2 at the nodes of a ray, from `first` on.

    f is z minus the height, at least `least` times the square of the node, and never falls: `high`
    is its value at the node before; that at the last node is returned. `scale` is one over the
    squared length of the ray.
    """
    for k in range(LANES):
        high = max(high, max(z - zs[at + k], least * squares[first + k]))
        zs[at + k] = high * (scale * inverses[first + k])
    return high
