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

from ._lanes import sum_lanes

__all__ = ["LANES", "TAPS", "ray_places", "spline_expansion", "spline_values"]

LANES = 8
TAPS = 6
_FUSED = ("contract",)
_EXPANSION = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))

_SCALAR, _INDEX = ir.DoubleType(), ir.IntType(32)
_VECTOR = ir.VectorType(_SCALAR, LANES)


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


def _data(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    return context.make_array(kind)(context, builder, array).data


def _at(builder: Any, data: Any, place: Any) -> Any:
    """Pointer to the eight numbers that start at a place."""
    return builder.bitcast(builder.gep(data, [place]), ir.PointerType(_VECTOR))


def _load(builder: Any, data: Any, place: Any) -> Any:
    return builder.load(_at(builder, data, place), align=8, typ=_VECTOR)


def _fused(builder: Any, a: Any, b: Any, c: Any) -> Any:
    return builder.fadd(builder.fmul(a, b, flags=_FUSED), c, flags=_FUSED)


def _spread(builder: Any, values: Any, lane: int) -> Any:
    """One lane of a vector in all of them."""
    lanes = ir.Constant(ir.VectorType(_INDEX, LANES), [lane] * LANES)
    return builder.shuffle_vector(values, ir.Constant(values.type, ir.Undefined), lanes)


def _everywhere(builder: Any, scalar: Any) -> Any:
    """A scalar in all lanes of a vector."""
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    return _spread(builder, builder.insert_element(nothing, scalar, ir.Constant(_INDEX, 0)), 0)


def _horner(builder: Any, powers: list[Any], t: Any) -> Any:
    total = powers[-1]
    for power in reversed(powers[:-1]):
        total = _fused(builder, total, t, power)
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
        y, x, way_y, way_x, scale, most = (_everywhere(builder, a) for a in arguments[:6])
        first, at, into = (arguments[k] for k in (7, 13, 14))
        radii, cell, corners, rest, weights, pixels = (
            _data(context, builder, signature.args[k], arguments[k]) for k in (6, 8, 9, 10, 11, 12)
        )
        ny, nx, inverse_y, inverse_x, margin, width, shift = (
            _everywhere(builder, builder.load(builder.gep(cell, [ir.Constant(first.type, k)])))
            for k in range(7)
        )
        half = ir.Constant(_VECTOR, [0.5] * LANES)
        floor = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(_VECTOR, [_VECTOR]), f"llvm.floor.v{LANES}f64"
        )

        def least(a: Any, b: Any) -> Any:
            return builder.select(builder.fcmp_ordered("<", a, b), a, b)

        def whole(value: Any) -> Any:
            return builder.call(floor, [value])

        def inside(value: Any, center: Any, n: Any, inverse: Any) -> Any:
            return builder.fsub(value, builder.fmul(n, whole(builder.fmul(center, inverse))))

        def place(start: Any, way: Any, n: Any, inverse: Any) -> tuple[Any, Any]:
            value = least(_fused(builder, r, way, start), builder.fadd(n, margin))
            value = builder.fneg(least(builder.fneg(value), margin))
            value = inside(value, value, n, inverse)
            pixel = whole(builder.fadd(value, half))
            return value, inside(pixel, builder.fadd(pixel, half), n, inverse)

        def store(value: Any, data: Any, offset: Any) -> None:
            pointer = builder.bitcast(builder.gep(data, [offset]), ir.PointerType(value.type))
            builder.store(value, pointer, align=8)

        integers = ir.VectorType(first.type, LANES)
        r = least(builder.fmul(scale, _load(builder, radii, first)), most)
        (y, pixel_y), (x, pixel_x) = place(y, way_y, ny, inverse_y), place(x, way_x, nx, inverse_x)
        there = None
        for pixel, n in ((pixel_y, ny), (pixel_x, nx)):
            for test in (
                builder.fcmp_ordered(">=", pixel, ir.Constant(_VECTOR, [0.0] * LANES)),
                builder.fcmp_ordered("<", pixel, n),
            ):
                there = test if there is None else builder.and_(there, test)
        pixel = builder.fptosi(_fused(builder, pixel_y, nx, pixel_x), integers)
        nowhere = ir.Constant(integers, [-1] * LANES)
        store(builder.select(there, pixel, nowhere), pixels, into)
        row, col = whole(y), whole(x)
        corner = builder.fadd(_fused(builder, row, width, col), shift)
        store(builder.fptosi(corner, integers), corners, at)
        store(builder.fsub(x, col), rest, at)
        t = builder.fsub(y, row)
        offset = builder.mul(at, ir.Constant(at.type, TAPS))
        for tap in range(TAPS):
            rows = [ir.Constant(_VECTOR, [value] * LANES) for value in _WEIGHTS[0, :, tap].tolist()]
            store(_horner(builder, rows, t), weights, offset)
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
            _data(context, builder, kinds[k], arguments[k]) for k in (0, 2, 4, 5, 6)
        )
        shares = builder.mul(first, ir.Constant(first.type, TAPS))
        products = []
        for lane in range(LANES):
            point = builder.add(first, ir.Constant(first.type, lane))
            corner = builder.load(builder.gep(corners, [point]))
            total = None
            for row in range(TAPS):
                at = builder.add(shares, ir.Constant(first.type, row * LANES + lane))
                share = _everywhere(builder, builder.load(builder.gep(weights, [at])))
                values = _load(builder, data, corner)
                if total is None:
                    total = builder.fmul(share, values, flags=_FUSED)
                else:
                    total = _fused(builder, share, values, total)
                corner = builder.add(corner, width)
            across = _taps(builder, _everywhere(builder, builder.load(builder.gep(t, [point]))))
            products.append(builder.fmul(total, across))
        builder.store(_lane_sums(builder, products), _at(builder, out, into), align=8)
        return context.get_dummy_value()

    place = types.intp
    return types.void(flat, place, corners, place, weights, t, out, place), codegen


def _lane_sums(builder: Any, vectors: list[Any]) -> Any:
    """Vector of the sums over the lanes of as many vectors as there are lanes, pairwise."""
    index = ir.VectorType(_INDEX, LANES)
    step = LANES // 2
    while len(vectors) > 1:
        # a lane whose bit `step` is clear comes from the first of two vectors, else from the second
        low = [lane if not lane & step else LANES + (lane ^ step) for lane in range(LANES)]
        high = [lane ^ step if not lane & step else LANES + lane for lane in range(LANES)]
        half = len(vectors) // 2
        vectors = [
            builder.fadd(
                builder.shuffle_vector(a, b, ir.Constant(index, low)),
                builder.shuffle_vector(a, b, ir.Constant(index, high)),
            )
            for a, b in zip(vectors[:half], vectors[half:], strict=True)
        ]
        step //= 2
    return vectors[0]


@intrinsic
def spline_expansion(typing: Any, flat: Any, corner: Any, width: Any, t_y: Any, t_x: Any) -> Any:
    """Value and derivatives per pixel (h, h_y, h_x, h_yy, h_xy, h_xx) at one point.

    The coefficients are the 6 x 6 from `corner` on, t_y and t_x the fractions of a pixel.
    """

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data, place, width, t_y, t_x = arguments
        data = _data(context, builder, signature.args[0], data)
        down, across = (
            [_taps(builder, t, order) for order in range(3)]
            for t in (_everywhere(builder, t_y), _everywhere(builder, t_x))
        )
        sums: list[Any] = []
        for row in range(TAPS):
            values = _load(builder, data, place)
            shares = [_spread(builder, weight, row) for weight in down]
            sums = [
                _fused(builder, share, values, sums[k])
                if row
                else builder.fmul(share, values, flags=_FUSED)
                for k, share in enumerate(shares)
            ]
            place = builder.add(place, width)
        results = [sum_lanes(builder, builder.fmul(sums[a], across[b])) for a, b in _EXPANSION]
        return cgutils.pack_array(builder, results)

    arguments = (flat, types.intp, types.intp, types.float64, types.float64)
    return types.UniTuple(types.float64, len(_EXPANSION))(*arguments), codegen
