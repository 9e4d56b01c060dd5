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

from .vectors import (
    data_of,
    everywhere,
    load,
    multiply_add,
    shuffled,
    store,
    sum_lanes,
    sums_of_each,
)

__all__ = [
    "LANES",
    "TAPS",
    "VECTOR",
    "WEIGHTS",
    "entry",
    "horner",
    "spline_expansion",
    "spline_values",
]

LANES = 8
TAPS = 6
_EXPANSION = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))

VECTOR = ir.VectorType(ir.DoubleType(), LANES)


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


WEIGHTS = _weights()


def entry(builder: Any, data: Any, place: Any) -> Any:
    return builder.load(builder.gep(data, [place]))


def horner(builder: Any, powers: list[Any], t: Any) -> Any:
    total = powers[-1]
    for power in reversed(powers[:-1]):
        total = multiply_add(builder, total, t, power)
    return total


def _taps(builder: Any, t: Any, order: int = 0) -> Any:
    """Weights of all taps at a fraction that stands in all lanes."""
    rows = WEIGHTS[order, : TAPS - order]
    return horner(builder, [ir.Constant(VECTOR, row.tolist()) for row in rows], t)


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
            corner = entry(builder, corners, point)
            total = None
            for row in range(TAPS):
                at = builder.add(shares, ir.Constant(first.type, row * LANES + lane))
                share = everywhere(builder, entry(builder, weights, at), LANES)
                values = load(builder, data, corner, VECTOR)
                if total is None:
                    total = builder.fmul(share, values)
                else:
                    total = multiply_add(builder, share, values, total)
                corner = builder.add(corner, width)
            across = _taps(builder, everywhere(builder, entry(builder, t, point), LANES))
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
            values = load(builder, data, place, VECTOR)
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
