"""Value and derivatives of the quintic B-spline, as explicit vector instructions.

Written out as vectors because the automatic vectorizer does not find them in a loop of six taps:
the six weights of an axis are one polynomial in vector coefficients, and each of the six rows of
coefficients is one load and one multiply-add for every derivative over y that is asked for. The
lanes that fill the vector have the weight zero.

Values are found at eight points together, which shares the sums over the lanes, and takes the
weights over y from memory, where spreading one over all lanes costs nothing.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from ._vectors import (
    constant,
    data_of,
    everywhere,
    instruction,
    load,
    multiply_add,
    shuffled,
    store,
    sum_lanes,
    sums_of_each,
)

__all__ = ["LANES", "TAPS", "ray_places", "spline_expansion", "spline_values"]

LANES = 8
TAPS = 6
_EXPANSION = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)


def _weights() -> NDArray[np.float64]:
    """Coefficients (derivative, power of t, lane) of the weights of the taps -2 to 3.

    The quintic B-spline is sum_k (-1)^k binomial(6, k) (x + 3 - k)_+^5 / 120, at x = t - tap.
    """
    out = np.zeros((3, TAPS, LANES))
    for lane in range(TAPS):
        terms = [
            (-1) ** k * math.comb(6, k) * polynomial.polypow([5 - lane - k, 1.0], 5) / 120.0
            for k in range(6 - lane)
        ]
        weight = np.sum(terms, axis=0)
        for order in range(3):
            values = polynomial.polyder(weight, order)
            out[order, : values.size, lane] = values
    return out


_WEIGHTS = _weights()


def _entry(builder: Any, data: Any, place: Any) -> Any:
    return builder.load(builder.gep(data, [place]))


def _horner(builder: Any, powers: list[Any], t: Any) -> Any:
    total = powers[-1]
    for power in reversed(powers[:-1]):
        total = multiply_add(builder, total, t, power)
    return total


def _taps(builder: Any, t: Any, order: int = 0) -> Any:
    """Weights of all taps at a fraction that stands in all lanes."""
    rows = _WEIGHTS[order, : TAPS - order]
    return _horner(builder, [ir.Constant(_VECTOR, row.tolist()) for row in rows], t)


@intrinsic
def ray_places(
    typing: Any, y: Any, x: Any, way_y: Any, way_x: Any, scale: Any, most: Any, radii: Any,
    first: Any, cell: Any, corners: Any, rest: Any, weights: Any, pixels: Any, at: Any, into: Any,
) -> Any:  # fmt: skip
    """Eight places on a ray, and what `spline_values` needs there.

    They lie at ``(y, x) + r (way_y, way_x)`` with ``r = min(scale radii[first:], most)``, kept
    inside the cell or no further out than its margin. Written are `corners` of the coefficients and
    fractions of a pixel over x in `rest`, from `at` on; eight `weights` over y for each tap, from
    ``TAPS * at`` on; and the nearest `pixels` (-1 beyond the border), from `into` on. `cell` holds
    height and width of the map, their inverses (zero if it is not periodic), the margin, the
    width of the coefficients and the corner of the first pixel.
    """

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        y, x, way_y, way_x, scale, most = (everywhere(builder, a, LANES) for a in arguments[:6])
        first, at, into = (arguments[k] for k in (7, 13, 14))
        radii, cell, corners, rest, weights, pixels = (
            data_of(context, builder, signature.args[k], arguments[k])
            for k in (6, 8, 9, 10, 11, 12)
        )
        ny, nx, inverse_y, inverse_x, margin, width, shift = (
            everywhere(builder, _entry(builder, cell, ir.Constant(first.type, k)), LANES)
            for k in range(7)
        )
        half = constant(_VECTOR, 0.5)

        def least(a: Any, b: Any) -> Any:
            return builder.select(builder.fcmp_ordered("<", a, b), a, b)

        def whole(value: Any) -> Any:
            return instruction(builder, "floor", value)

        def inside(value: Any, center: Any, n: Any, inverse: Any) -> Any:
            return builder.fsub(value, builder.fmul(n, whole(builder.fmul(center, inverse))))

        def place(start: Any, way: Any, n: Any, inverse: Any) -> tuple[Any, Any]:
            value = least(multiply_add(builder, r, way, start), builder.fadd(n, margin))
            value = builder.fneg(least(builder.fneg(value), margin))
            value = inside(value, value, n, inverse)
            pixel = whole(builder.fadd(value, half))
            return value, inside(pixel, builder.fadd(pixel, half), n, inverse)

        integers = ir.VectorType(first.type, LANES)
        r = least(builder.fmul(scale, load(builder, radii, first, _VECTOR)), most)
        (y, pixel_y), (x, pixel_x) = place(y, way_y, ny, inverse_y), place(x, way_x, nx, inverse_x)
        there = None
        for pixel, n in ((pixel_y, ny), (pixel_x, nx)):
            for test in (
                builder.fcmp_ordered(">=", pixel, constant(_VECTOR, 0.0)),
                builder.fcmp_ordered("<", pixel, n),
            ):
                there = test if there is None else builder.and_(there, test)
        pixel = builder.fptosi(multiply_add(builder, pixel_y, nx, pixel_x), integers)
        nowhere = constant(integers, -1)
        store(builder, builder.select(there, pixel, nowhere), pixels, into)
        row, col = whole(y), whole(x)
        corner = builder.fadd(multiply_add(builder, row, width, col), shift)
        store(builder, builder.fptosi(corner, integers), corners, at)
        store(builder, builder.fsub(x, col), rest, at)
        t = builder.fsub(y, row)
        offset = builder.mul(at, ir.Constant(at.type, TAPS))
        for tap in range(TAPS):
            rows = [constant(_VECTOR, value) for value in _WEIGHTS[0, :, tap].tolist()]
            store(builder, _horner(builder, rows, t), weights, offset)
            offset = builder.add(offset, ir.Constant(offset.type, LANES))
        return context.get_dummy_value()

    real, place = types.float64, types.intp
    kinds = (real, real, real, real, real, real, radii, place, cell, corners, rest, weights, pixels)
    return types.void(*kinds, place, place), codegen


@intrinsic
def spline_values(
    typing: Any, flat: Any, width: Any, corners: Any, first: Any, weights: Any, t: Any, out: Any,
    into: Any,
) -> Any:  # fmt: skip
    """Spline at the eight points from `first` on, into `out` from `into` on.

    The coefficients of a point are 6 x 6 from its corner on in `flat`, which holds them row by
    row, `width` in a row; two more than six are read in each row. `weights` are those over y,
    `t` the fractions of a pixel over x.
    """

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = signature.args
        _, width, _, first, _, _, _, into = arguments
        data, corners, weights, t, out = (
            data_of(context, builder, kinds[k], arguments[k]) for k in (0, 2, 4, 5, 6)
        )
        shares = builder.mul(first, ir.Constant(first.type, TAPS))
        products = []
        for lane in range(LANES):
            point = builder.add(first, ir.Constant(first.type, lane))
            corner = _entry(builder, corners, point)
            total = None
            for row in range(TAPS):
                at = builder.add(shares, ir.Constant(first.type, row * LANES + lane))
                share = everywhere(builder, _entry(builder, weights, at), LANES)
                values = load(builder, data, corner, _VECTOR)
                if total is None:
                    total = builder.fmul(share, values)
                else:
                    total = multiply_add(builder, share, values, total)
                corner = builder.add(corner, width)
            across = _taps(builder, everywhere(builder, _entry(builder, t, point), LANES))
            products.append(builder.fmul(total, across))
        store(builder, sums_of_each(builder, products), out, into)
        return context.get_dummy_value()

    place = types.intp
    return types.void(flat, place, corners, place, weights, t, out, place), codegen


@intrinsic
def spline_expansion(typing: Any, flat: Any, corner: Any, width: Any, t_y: Any, t_x: Any) -> Any:
    """Value and derivatives per pixel (h, h_y, h_x, h_yy, h_xy, h_xx) at one point.

    The coefficients are the 6 x 6 from `corner` on, t_y and t_x the fractions of a pixel.
    """

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data, place, width, t_y, t_x = arguments
        data = data_of(context, builder, signature.args[0], data)
        down, across = (
            [_taps(builder, t, order) for order in range(3)]
            for t in (everywhere(builder, t, LANES) for t in (t_y, t_x))
        )
        sums: list[Any] = []
        for row in range(TAPS):
            values = load(builder, data, place, _VECTOR)
            shares = [shuffled(builder, weight, weight, [row] * LANES) for weight in down]
            sums = [
                multiply_add(builder, share, values, sums[k])
                if row
                else builder.fmul(share, values)
                for k, share in enumerate(shares)
            ]
            place = builder.add(place, width)
        results = [sum_lanes(builder, builder.fmul(sums[a], across[b])) for a, b in _EXPANSION]
        return cgutils.pack_array(builder, results)

    arguments = (flat, types.intp, types.intp, types.float64, types.float64)
    return types.UniTuple(types.float64, len(_EXPANSION))(*arguments), codegen
