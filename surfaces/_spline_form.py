"""Value and derivatives of the quintic B-spline at a point, as explicit vector instructions.

Written out as vectors because the automatic vectorizer does not find them in a loop of six taps:
the six weights of an axis are one polynomial in vector coefficients, and each of the six rows of
coefficients is one load and one multiply-add for every derivative over y that is asked for. The
lanes that fill the vector have the weight zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.polynomial import polynomial
from numpy.typing import NDArray

__all__ = ["spline_expansion", "spline_value"]

_LANES = 8
_TAPS = 6
_FUSED = ("contract",)
_VALUE = ((0, 0),)
_EXPANSION = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def _weights() -> NDArray[np.float64]:
    """Coefficients (derivative, power of t, lane) of the weights of the taps -2 to 3.

    The quintic B-spline is sum_k (-1)^k binomial(6, k) (x + 3 - k)_+^5 / 120, at x = t - tap.
    """
    out = np.zeros((3, _TAPS, _LANES))
    for lane in range(_TAPS):
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


def _form(orders: tuple[tuple[int, int], ...]) -> Callable[..., Any]:
    """Code for the derivatives of the given orders (over y, over x)."""
    scalar, index = ir.DoubleType(), ir.IntType(32)
    vector = ir.VectorType(scalar, _LANES)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data, place, width, t_y, t_x = arguments
        data = context.make_array(signature.args[0])(context, builder, data).data
        nothing = ir.Constant(vector, ir.Undefined)

        def fused(a: Any, b: Any, c: Any) -> Any:
            return builder.fadd(builder.fmul(a, b, flags=_FUSED), c, flags=_FUSED)

        def spread(values: Any, lane: int) -> Any:
            lanes = ir.Constant(ir.VectorType(index, _LANES), [lane] * _LANES)
            return builder.shuffle_vector(values, nothing, lanes)

        def weights(t: Any, order: int) -> Any:
            powers = [ir.Constant(vector, row.tolist()) for row in _WEIGHTS[order, : _TAPS - order]]
            total = powers.pop()
            while powers:
                total = fused(total, t, powers.pop())
            return total

        def along(t: Any, needed: set[int]) -> dict[int, Any]:
            first = builder.insert_element(nothing, t, ir.Constant(index, 0))
            return {order: weights(spread(first, 0), order) for order in needed}

        down, across = along(t_y, {a for a, _ in orders}), along(t_x, {b for _, b in orders})
        sums: dict[int, Any] = {}
        for row in range(_TAPS):
            pointer = builder.bitcast(builder.gep(data, [place]), ir.PointerType(vector))
            values = builder.load(pointer, align=8, typ=vector)
            for order, weight in down.items():
                share = spread(weight, row)
                if row == 0:
                    sums[order] = builder.fmul(share, values, flags=_FUSED)
                else:
                    sums[order] = fused(share, values, sums[order])
            place = builder.add(place, width)
        results = [_total(builder, builder.fmul(sums[a], across[b])) for a, b in orders]
        return results[0] if len(results) == 1 else cgutils.pack_array(builder, results)  # type: ignore[no-untyped-call]

    return codegen


def _total(builder: Any, values: Any) -> Any:
    """Sum of the lanes of one vector, pairwise."""
    index = ir.IntType(32)
    lanes = _LANES
    while lanes > 1:
        lanes //= 2
        nothing = ir.Constant(values.type, ir.Undefined)
        low, high = (
            ir.Constant(ir.VectorType(index, lanes), list(range(start, start + lanes)))
            for start in (0, lanes)
        )
        values = builder.fadd(
            builder.shuffle_vector(values, nothing, low),
            builder.shuffle_vector(values, nothing, high),
        )
    return builder.extract_element(values, ir.Constant(index, 0))


@intrinsic
def spline_value(typing: Any, flat: Any, corner: Any, width: Any, t_y: Any, t_x: Any) -> Any:
    """Spline of the 6 x 6 coefficients from `corner` on, at the fractions t_y and t_x of a pixel.

    `flat` holds the coefficients row by row, `width` in a row; two more than six are read in
    each row.
    """
    arguments = (flat, types.intp, types.intp, types.float64, types.float64)
    return types.float64(*arguments), _form(_VALUE)


@intrinsic
def spline_expansion(typing: Any, flat: Any, corner: Any, width: Any, t_y: Any, t_x: Any) -> Any:
    """The same with its derivatives per pixel: (h, h_y, h_x, h_yy, h_xy, h_xx)."""
    arguments = (flat, types.intp, types.intp, types.float64, types.float64)
    return types.UniTuple(types.float64, len(_EXPANSION))(*arguments), _form(_EXPANSION)  # type: ignore[no-untyped-call]
