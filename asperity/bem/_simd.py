"""Four dot products of a 15 x 16 stencil with a padded grid, as explicit vector instructions.

Written out as vectors because the automatic vectorizer does not find 16 lanes in a loop of 15
taps; one load of the weights serves four points.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["LANES", "RADIUS", "stencil_dot4"]

RADIUS = 7
LANES = 16
_POINTS = 4


@intrinsic
def stencil_dot4(
    typing_context: Any, grid: Any, a: Any, b: Any, c: Any, d: Any, stride: Any, weights: Any
) -> Any:
    """Stencil sums with the corner of the stencil at flat offsets a, b, c and d of the grid.

    grid and weights are flat float32 arrays; weights hold 15 rows of 16 lanes.
    """
    place = types.intp
    signature = types.UniTuple(types.float32, _POINTS)(  # type: ignore[no-untyped-call]
        grid, place, place, place, place, place, weights
    )

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data, *offsets, stride, table = arguments
        data = context.make_array(signature.args[0])(context, builder, data).data
        table = context.make_array(signature.args[-1])(context, builder, table).data
        scalar = ir.FloatType()
        vector = ir.VectorType(scalar, LANES)
        fma = cgutils.get_or_insert_function(  # type: ignore[no-untyped-call]
            builder.module,
            ir.FunctionType(vector, [vector, vector, vector]),
            f"llvm.fma.v{LANES}f32",
        )

        def load(base: Any, offset: Any) -> Any:
            pointer = builder.bitcast(builder.gep(base, [offset]), ir.PointerType(vector))
            return builder.load(pointer, align=4, typ=vector)

        sums = [ir.Constant(vector, [0.0] * LANES) for _ in range(_POINTS)]
        for row in range(2 * RADIUS + 1):
            tap = load(table, ir.Constant(offsets[0].type, row * LANES))
            shift = builder.mul(stride, ir.Constant(stride.type, row))
            for i, offset in enumerate(offsets):
                values = load(data, builder.add(offset, shift))
                sums[i] = builder.call(fma, [values, tap, sums[i]])
        result = [_sum_lanes(builder, total) for total in sums]
        return cgutils.pack_array(builder, result)  # type: ignore[no-untyped-call]

    return signature, codegen


def _sum_lanes(builder: Any, vector: Any) -> Any:
    """Sum of the lanes of one vector, pairwise."""
    lanes = vector.type.count
    index = ir.IntType(32)
    while lanes > 1:
        lanes //= 2
        nothing = ir.Constant(vector.type, ir.Undefined)
        low, high = (
            ir.Constant(ir.VectorType(index, lanes), list(range(start, start + lanes)))
            for start in (0, lanes)
        )
        vector = builder.fadd(
            builder.shuffle_vector(vector, nothing, low),
            builder.shuffle_vector(vector, nothing, high),
        )
    return builder.extract_element(vector, ir.Constant(index, 0))
