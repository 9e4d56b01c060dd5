"""Rays on the interpolated map, eight samples at once, as explicit vector instructions."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from surfaces.numerics.spline_expansion import LANES, TAPS, VECTOR, WEIGHTS, entry, horner
from surfaces.numerics.vectors import (
    constant,
    data_of,
    everywhere,
    gathered,
    instruction,
    load,
    multiply_add,
    shuffled,
    store,
)

__all__ = ["ray_places", "ray_signs", "rising_nodes"]

_BYTE, _INTEGER = ir.IntType(8), ir.IntType(32)
_LONGS = ir.VectorType(ir.IntType(64), LANES)


def _most(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


def _highest(builder: Any, values: Any, before: Any) -> Any:
    """In each lane the highest of `before`, which stands in all lanes, and the values up to it."""
    step = 1
    while step < LANES:
        order = [lane - step if lane >= step else LANES for lane in range(LANES)]
        values = _most(builder, values, shuffled(builder, values, before, order))
        step *= 2
    return _most(builder, values, before)


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
            everywhere(builder, entry(builder, cell, ir.Constant(first.type, k)), LANES)
            for k in range(7)
        )
        half = constant(VECTOR, 0.5)

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
        r = least(builder.fmul(scale, load(builder, radii, first, VECTOR)), most)
        (y, pixel_y), (x, pixel_x) = place(y, way_y, ny, inverse_y), place(x, way_x, nx, inverse_x)
        with builder.if_then(builder.icmp_signed(">=", into, ir.Constant(into.type, 0))):
            there = None
            for pixel, n in ((pixel_y, ny), (pixel_x, nx)):
                for test in (
                    builder.fcmp_ordered(">=", pixel, constant(VECTOR, 0.0)),
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
            rows = [constant(VECTOR, value) for value in WEIGHTS[0, :, tap].tolist()]
            store(builder, horner(builder, rows, t), weights, offset)
            offset = builder.add(offset, ir.Constant(offset.type, LANES))
        return context.get_dummy_value()

    real, place = types.float64, types.intp
    kinds = (real, real, real, real, real, real, radii, place, cell, corners, rest, weights, pixels)
    return types.void(*kinds, place, place), codegen


@intrinsic
def ray_signs(
    typing: Any, zs: Any, at: Any, z: Any, high: Any, dip: Any, pixels: Any, labels: Any,
    owner: Any, peak: Any, radii: Any, first: Any, end: Any,
) -> Any:  # fmt: skip
    """What holds at the eight samples of a ray from `at` on: five bytes of a number.

    f, which is z minus the height, rises above `high` and all samples before; has fallen `dip`
    below; the pixel lies in a basin whose owner is another than `peak`; it lies beyond the border;
    and the radius, from `first` on, exceeds `end`.
    """

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        _, at, z, high, dip, _, _, _, peak, _, first, end = arguments
        zs, pixels, labels, owner, radii = (
            data_of(context, builder, signature.args[k], arguments[k]) for k in (0, 5, 6, 7, 9)
        )
        z, high, dip, end = (everywhere(builder, a, LANES) for a in (z, high, dip, end))
        nothing = constant(_LONGS, 0)

        def floor(value: Any) -> Any:
            return builder.select(builder.icmp_signed(">", value, nothing), value, nothing)

        f = builder.fsub(z, load(builder, zs, at, VECTOR))
        tops = _highest(builder, f, high)
        order = [LANES, *range(LANES - 1)]
        before = shuffled(builder, tops, high, order)
        rises = builder.fcmp_ordered(">", f, before)
        low = builder.fcmp_ordered("<=", f, builder.fsub(before, dip))
        pixel = load(builder, pixels, at, _LONGS)
        singles = ir.VectorType(ir.FloatType(), LANES)
        label = gathered(builder, labels, floor(pixel), singles)
        label = builder.sext(builder.bitcast(label, ir.VectorType(_INTEGER, LANES)), _LONGS)
        own = builder.bitcast(gathered(builder, owner, floor(label), VECTOR), _LONGS)
        other = builder.icmp_signed("!=", own, everywhere(builder, peak, LANES))
        signs = (
            rises,
            builder.and_(low, builder.not_(rises)),
            builder.and_(other, builder.icmp_signed(">=", label, nothing)),
            builder.icmp_signed("<", pixel, nothing),
            builder.fcmp_ordered(">", load(builder, radii, first, VECTOR), end),
        )
        bits = ir.Constant(at.type, 0)
        for sign in reversed(signs):
            byte = builder.zext(builder.bitcast(sign, _BYTE), at.type)
            bits = builder.or_(builder.shl(bits, ir.Constant(at.type, LANES)), byte)
        return bits

    real, place = types.float64, types.intp
    kinds = (zs, place, real, real, real, pixels, labels, owner, place, radii, place, real)
    return place(*kinds), codegen


@intrinsic
def rising_nodes(
    typing: Any, zs: Any, at: Any, z: Any, least: Any, high: Any, scale: Any, squares: Any,
    inverses: Any, first: Any,
) -> Any:  # fmt: skip
    """Turn the eight heights from `at` on into f/r^2 at the nodes of a ray, from `first` on.

    f is z minus the height, at least `least` times the square of the node, and never falls: `high`
    is its value at the node before; that at the last node is returned. `scale` is one over the
    squared length of the ray.
    """

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        _, at, z, least, high, scale, _, _, first = arguments
        zs, squares, inverses = (
            data_of(context, builder, signature.args[k], arguments[k]) for k in (0, 6, 7)
        )
        z, least, high, scale = (everywhere(builder, a, LANES) for a in (z, least, high, scale))

        floor = builder.fmul(least, load(builder, squares, first, VECTOR))
        f = _most(builder, builder.fsub(z, load(builder, zs, at, VECTOR)), floor)
        f = _highest(builder, f, high)
        unit = builder.fmul(scale, load(builder, inverses, first, VECTOR))
        store(builder, builder.fmul(f, unit), zs, at)
        return builder.extract_element(f, ir.Constant(ir.IntType(32), LANES - 1))

    real, place = types.float64, types.intp
    kinds = (zs, place, real, real, real, real, squares, inverses, place)
    return types.float64(*kinds), codegen
