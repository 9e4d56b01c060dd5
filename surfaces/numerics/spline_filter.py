"""Kernels of the filter that turns points into coefficients of the quintic B-spline.

Lines are filtered several at a time, one per lane, in a buffer that holds them side by side: row i
of it is point i of every line. The two causal and the two anticausal poles go together, as one
recursion over the last two points each.
"""

from __future__ import annotations

from .compiled import compiled, inner
from .vectors import loader, multiply_add, store, transposer

__all__ = ["LINES", "PAD", "filter_columns", "filter_rows"]

PAD = 25
"""Points before and after a line."""

LINES = 16
"""Lines filtered at a time."""

_POLES = -0.43057534709997379, -0.043096288203264654
_SUM, _PRODUCT = _POLES[0] + _POLES[1], _POLES[0] * _POLES[1]
_GAIN = 120.0
_REST = 1.0 / ((1.0 - _POLES[0]) * (1.0 - _POLES[1]))
_SIDE = 8
"""Rows and columns that are transposed at a time."""

load, turn = loader(LINES), transposer(_SIDE)


@inner(forceinline=True)
def _step(line, at, last, before, gain):
    """Filter the row of the buffer at a place, given the places of the last two and the gain."""
    value = multiply_add(load(line, before), -_PRODUCT, gain * load(line, at))
    store(line, at, multiply_add(load(line, last), _SUM, value))


@inner()
def _filter(line, m, periodic):
    """Fill the padding of the m points of the lines and filter them in place."""
    n = m + 2 * PAD
    for ghost in range(1, PAD + 1):
        low, high = (PAD - ghost) * LINES, (PAD + m - 1 + ghost) * LINES
        if periodic:
            store(line, low, load(line, (PAD + (-ghost) % m) * LINES))
            store(line, high, load(line, (PAD + (m - 1 + ghost) % m) * LINES))
            continue
        bend = 0.5 * ghost * (ghost + 1)
        for edge, way, place in ((PAD, LINES, low), (PAD + m - 1, -LINES, high)):
            at = edge * LINES
            for k in range(LINES):
                a, b, c = line[at + k], line[at + way + k], line[at + 2 * way + k]
                line[place + k] = a + ghost * (a - b) + bend * (a - 2.0 * b + c)
    for k in range(LINES):
        line[k] *= _GAIN * _REST
    _step(line, LINES, 0, 0, _GAIN)
    for i in range(2, n):
        _step(line, i * LINES, (i - 1) * LINES, (i - 2) * LINES, _GAIN)
    last = (n - 1) * LINES
    for k in range(LINES):
        line[last + k] *= _PRODUCT * _REST
    _step(line, last - LINES, last, last, _PRODUCT)
    for i in range(n - 3, -1, -1):
        _step(line, i * LINES, (i + 1) * LINES, (i + 2) * LINES, _PRODUCT)


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
                store(line, (PAD + i) * LINES, load(source, i * nx + left))
                continue
            for k in range(lanes):
                line[(PAD + i) * LINES + k] = source[i * nx + left + k]
        _filter(line, ny, periodic)
        for i in range(ny + 2 * PAD):
            place = i * width + PAD + left
            if lanes == LINES:
                store(flat, place, load(line, i * LINES))
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
                turn(flat, row + j, width, line, j * LINES + k, LINES)
            for lane in range(k, min(k + _SIDE, lanes)):
                for j in range(tail, PAD + nx):
                    line[j * LINES + lane] = flat[(top + lane) * width + j]
        _filter(line, nx, periodic)
        for k in range(0, lanes, _SIDE):
            row, whole = (top + k) * width, lanes >= k + _SIDE
            tail = width - width % _SIDE if whole else 0
            for j in range(0, tail, _SIDE):
                turn(line, j * LINES + k, LINES, flat, row + j, width)
            for lane in range(k, min(k + _SIDE, lanes)):
                for j in range(tail, width):
                    flat[(top + lane) * width + j] = line[j * LINES + lane]
