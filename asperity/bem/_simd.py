"""Symmetric stencils on a padded grid, as explicit vector instructions.

Written out as vectors because the automatic vectorizer does not find them. A tile is 16 neighbors
of a row: rows at equal distance above and below are added first, then weighted, and the weighted
sums are shifted last, so that a tile costs as much as four to five points on their own. Four such
points share one load of the weights.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from surfaces.numerics.vectors import (
    constant,
    data_of,
    everywhere,
    load,
    multiply_add,
    shuffled,
    store,
    sum_lanes,
)

__all__ = [
    "LANES",
    "RADIUS",
    "SHORT_RADIUS",
    "points",
    "points_short",
    "tile",
    "tile_short",
]

RADIUS = 7
SHORT_RADIUS = 4
LANES = 16
_HALF = LANES // 2
_POINTS = 4
_VECTOR = ir.VectorType(ir.FloatType(), LANES)


def _tile(radius: int) -> Any:
    """Stencil of a radius for a tile, as an intrinsic."""

    @intrinsic
    def sums_of_tile(
        typing_context: Any, grid: Any, place: Any, stride: Any, weights: Any, sums: Any
    ) -> Any:
        """Stencil sums of the 16 points from a flat offset of the grid on, into `sums`.

        grid, weights and sums are flat float32 arrays; weights hold the quadrant of the stencil,
        (radius + 1)**2 values from its center on.
        """
        index = types.intp
        signature = types.void(grid, index, index, weights, sums)

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            grid, place, stride, weights, sums = arguments
            data = data_of(context, builder, signature.args[0], grid)
            table = data_of(context, builder, signature.args[3], weights)
            folded = _folded_rows(builder, data, place, stride, radius)
            total = None
            for distance in range(radius + 1):
                left = right = None
                for row in range(radius + 1):
                    place_of = ir.Constant(place.type, row * (radius + 1) + distance)
                    weight = builder.load(builder.gep(table, [place_of]))
                    weight = everywhere(builder, weight, LANES)
                    if left is None:
                        left, right = (builder.fmul(half, weight) for half in folded[row])
                    else:
                        left = multiply_add(builder, folded[row][0], weight, left)
                        right = multiply_add(builder, folded[row][1], weight, right)
                for shift in sorted({-distance, distance}):
                    part = _shifted(builder, left, right, shift)
                    total = part if total is None else builder.fadd(total, part)
            out = data_of(context, builder, signature.args[4], sums)
            store(builder, total, out, ir.Constant(place.type, 0))
            return context.get_dummy_value()

        return signature, codegen

    return sums_of_tile


def _folded_rows(builder: Any, data: Any, place: Any, stride: Any, radius: int) -> list[Any]:
    """Sums of the rows at each distance from the tile, in two vectors from 8 points before it."""
    begin = builder.sub(place, ir.Constant(place.type, _HALF))
    halves = (begin, builder.add(begin, ir.Constant(place.type, LANES)))
    folded = [tuple(load(builder, data, half, _VECTOR) for half in halves)]
    for row in range(1, radius + 1):
        shift = builder.mul(stride, ir.Constant(stride.type, row))
        folded.append(
            tuple(
                builder.fadd(
                    load(builder, data, builder.add(half, shift), _VECTOR),
                    load(builder, data, builder.sub(half, shift), _VECTOR),
                )
                for half in halves
            )
        )
    return folded


def _shifted(builder: Any, left: Any, right: Any, shift: int) -> Any:
    """The 16 lanes of a pair of vectors that start `shift` from its middle."""
    first = _HALF + shift
    return shuffled(builder, left, right, range(first, first + LANES))


def _points(radius: int) -> Any:
    """Stencil of a radius for four points anywhere, as an intrinsic."""

    @intrinsic
    def sums_of_points(
        typing_context: Any, grid: Any, a: Any, b: Any, c: Any, d: Any, stride: Any, weights: Any
    ) -> Any:
        """Stencil sums at the flat offsets a, b, c and d of the grid.

        grid and weights are flat float32 arrays; weights hold a row of 16 lanes for each row of
        the stencil, from 7 points before its center on.
        """
        place = types.intp
        signature = types.UniTuple(types.float32, _POINTS)(
            grid, place, place, place, place, place, weights
        )

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            grid, *offsets, stride, weights = arguments
            data = data_of(context, builder, signature.args[0], grid)
            table = data_of(context, builder, signature.args[-1], weights)
            sums = [constant(_VECTOR, 0.0)] * _POINTS
            for row in range(2 * radius + 1):
                taps = load(builder, table, ir.Constant(stride.type, row * LANES), _VECTOR)
                shift = builder.mul(stride, ir.Constant(stride.type, row - radius))
                shift = builder.sub(shift, ir.Constant(stride.type, RADIUS))
                for i, offset in enumerate(offsets):
                    values = load(builder, data, builder.add(offset, shift), _VECTOR)
                    sums[i] = multiply_add(builder, values, taps, sums[i])
            result = [sum_lanes(builder, total) for total in sums]
            return cgutils.pack_array(builder, result)

        return signature, codegen

    return sums_of_points


tile = _tile(RADIUS)
tile_short = _tile(SHORT_RADIUS)
points = _points(RADIUS)
points_short = _points(SHORT_RADIUS)
