"""Kernels of the filter that turns points into coefficients of the quintic B-spline.

Lines are filtered several at a time, one per lane, in a buffer that holds them side by side: row i
of it is point i of every line. The two causal and the two anticausal poles go together, as one
recursion over the last two points each.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .compiled import compiled, inner
from .vectors import constant, data_of, load, multiply_add, store, transposed

__all__ = ["LINES", "PAD", "filter_columns", "filter_rows"]

PAD = 25
"""Points before and after a line."""

LINES = 16
"""Lines filtered at a time."""

_POLES = -0.43057534709997379, -0.043096288203264654
_SUM, _PRODUCT = _POLES[0] + _POLES[1], _POLES[0] * _POLES[1]
_GAIN = 120.0
_REST = 1.0 / ((1.0 - _POLES[0]) * (1.0 - _POLES[1]))
_ROW = ir.VectorType(ir.DoubleType(), LINES)
_SIDE = 8
_BLOCK = ir.VectorType(ir.DoubleType(), _SIDE)


def _step(gain: float) -> Any:
    """Function that filters a row of the buffer, given the places of the row and the last two."""

    @intrinsic
    def function(typing: Any, line: Any, at: Any, last: Any, before: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            data = data_of(context, builder, signature.args[0], arguments[0])
            value, near, far = (load(builder, data, place, _ROW) for place in arguments[1:])
            total = builder.fmul(constant(_ROW, gain), value)
            total = multiply_add(builder, constant(_ROW, -_PRODUCT), far, total)
            total = multiply_add(builder, constant(_ROW, _SUM), near, total)
            store(builder, total, data, arguments[1])
            return context.get_dummy_value()

        return types.void(line, types.intp, types.intp, types.intp), code

    return function


_forwards, _backwards = _step(_GAIN), _step(_PRODUCT)


@intrinsic
def _copy(typing: Any, source: Any, start: Any, target: Any, to: Any) -> Any:
    """Copy one row from a place of the source on to a place of the target."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, start, target, to = arguments
        kinds = signature.args
        row = load(builder, data_of(context, builder, kinds[0], source), start, _ROW)
        store(builder, row, data_of(context, builder, kinds[2], target), to)
        return context.get_dummy_value()

    return types.void(source, types.intp, target, types.intp), code


@intrinsic
def _turn(typing: Any, source: Any, start: Any, step: Any, target: Any, to: Any, along: Any) -> Any:
    """Copy a transposed square of `_SIDE` rows, a `step` apart there and `along` here."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, start, step, target, to, along = arguments
        kinds = signature.args
        source = data_of(context, builder, kinds[0], source)
        target = data_of(context, builder, kinds[3], target)
        rows = []
        for _ in range(_SIDE):
            rows.append(load(builder, source, start, _BLOCK))
            start = builder.add(start, step)
        for column in transposed(builder, rows):
            store(builder, column, target, to)
            to = builder.add(to, along)
        return context.get_dummy_value()

    place = types.intp
    return types.void(source, place, place, target, place, place), code


@inner()
def _filter(line, m, periodic):
    """Fill the padding of the m points of the lines and filter them in place."""
    n = m + 2 * PAD
    for ghost in range(1, PAD + 1):
        low, high = (PAD - ghost) * LINES, (PAD + m - 1 + ghost) * LINES
        if periodic:
            _copy(line, (PAD + (-ghost) % m) * LINES, line, low)
            _copy(line, (PAD + (m - 1 + ghost) % m) * LINES, line, high)
            continue
        bend = 0.5 * ghost * (ghost + 1)
        for edge, way, place in ((PAD, LINES, low), (PAD + m - 1, -LINES, high)):
            at = edge * LINES
            for k in range(LINES):
                a, b, c = line[at + k], line[at + way + k], line[at + 2 * way + k]
                line[place + k] = a + ghost * (a - b) + bend * (a - 2.0 * b + c)
    for k in range(LINES):
        line[k] *= _GAIN * _REST
    _forwards(line, LINES, 0, 0)
    for i in range(2, n):
        _forwards(line, i * LINES, (i - 1) * LINES, (i - 2) * LINES)
    last = (n - 1) * LINES
    for k in range(LINES):
        line[last + k] *= _PRODUCT * _REST
    _backwards(line, last - LINES, last, last)
    for i in range(n - 3, -1, -1):
        _backwards(line, i * LINES, (i + 1) * LINES, (i + 2) * LINES)


@compiled()
def filter_columns(heights, periodic, flat, line, start, stop):
    """Filter the columns [start, stop) of the map into the padded array `flat`."""
    ny, nx = heights.shape
    width = nx + 2 * PAD
    source = heights.ravel()
    for left in range(start, stop, LINES):
        lanes = min(LINES, stop - left)
        for i in range(ny):
            if lanes == LINES:
                _copy(source, i * nx + left, line, (PAD + i) * LINES)
                continue
            for k in range(lanes):
                line[(PAD + i) * LINES + k] = source[i * nx + left + k]
        _filter(line, ny, periodic)
        for i in range(ny + 2 * PAD):
            place = i * width + PAD + left
            if lanes == LINES:
                _copy(line, i * LINES, flat, place)
                continue
            for k in range(lanes):
                flat[place + k] = line[i * LINES + k]


@compiled()
def filter_rows(flat, nx, periodic, line, start, stop):
    """Filter the rows [start, stop) of the padded array in place."""
    width = nx + 2 * PAD
    for top in range(start, stop, LINES):
        lanes = min(LINES, stop - top)
        for k in range(0, lanes, _SIDE):
            row, whole = (top + k) * width, lanes >= k + _SIDE
            tail = PAD + nx - nx % _SIDE if whole else PAD
            for j in range(PAD, tail, _SIDE):
                _turn(flat, row + j, width, line, j * LINES + k, LINES)
            for lane in range(k, min(k + _SIDE, lanes)):
                for j in range(tail, PAD + nx):
                    line[j * LINES + lane] = flat[(top + lane) * width + j]
        _filter(line, nx, periodic)
        for k in range(0, lanes, _SIDE):
            row, whole = (top + k) * width, lanes >= k + _SIDE
            tail = width - width % _SIDE if whole else 0
            for j in range(0, tail, _SIDE):
                _turn(line, j * LINES + k, LINES, flat, row + j, width)
            for lane in range(k, min(k + _SIDE, lanes)):
                for j in range(tail, width):
                    flat[(top + lane) * width + j] = line[j * LINES + lane]
