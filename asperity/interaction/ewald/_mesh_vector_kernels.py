"""The 4 by 4 mesh nodes about a point, a mesh line at once (cubic B-splines,
docs/development/half_space.md).

Four nodes of a mesh line lie side by side. `lines` are the places of the first node of each of the
four lines in a flat mesh, `at` the shares (y, x) of a step by which the point lies behind the
second nodes.
"""

from __future__ import annotations

import numpy as np
from numba import types

from surfaces.numerics.compiled import SUMS, inner
from surfaces.numerics.vectors import adder, lane, loader, multiply_add, store, total

__all__ = ["add_moved", "add_spread", "add_stored", "read", "read_stored", "set_stored"]

NODES = 4
_CUBIC = np.array(
    [
        [-1.0, 3.0, -3.0, 1.0],
        [3.0, -6.0, 3.0, 0.0],
        [-3.0, 0.0, 3.0, 0.0],
        [1.0, 4.0, 1.0, 0.0],
    ]
)
"""Six times the cubic B-spline at the four nodes, by falling powers of the share of a step."""

_FALLING = np.array([3.0, 2.0, 1.0, 0.0])[:, None]
_VALUE = _CUBIC / 6
_SLOPE = _FALLING[:3] * _VALUE[:3]
_BEND = (_FALLING[:2] - 1) * _SLOPE[:2]

_load, _add = loader(NODES), adder()
_load_double = loader(NODES, element=types.float64)


@inner(fastmath=SUMS, forceinline=True)
def _weights(table, t):
    """Polynomials at t, of which the rows of the table are the coefficients."""
    found = _load(table, 0)
    for k in range(1, len(table)):
        found = multiply_add(found, t, _load(table, NODES * k))
    return found


@inner(fastmath=SUMS, forceinline=True)
def _outer(a, b, c, d, line):
    """Line of the sum of the outer products a b and c d."""
    return multiply_add(b, lane(a, line), lane(c, line) * d)


@inner(fastmath=SUMS, forceinline=True)
def _spread(at, half):
    """Weights of a unit force with `half` its variance by y and x [steps^2]: factors of `_outer`.

    With w the B-spline they are (w + half_y w'') w along y and x, and w half_x w''.
    """
    along, across = _weights(_VALUE, at[0]), _weights(_VALUE, at[1])
    first = multiply_add(_weights(_BEND, at[0]), half[0], along)
    return first, across, half[1] * along, _weights(_BEND, at[1])


@inner(fastmath=SUMS, forceinline=True)
def add_spread(mesh, lines, at, half, force):
    """Add a force that is spread with `half` its variance by y and x [steps^2]."""
    a, b, c, d = _spread(at, half)
    _add(mesh, lines[0], force * _outer(a, b, c, d, 0))
    _add(mesh, lines[1], force * _outer(a, b, c, d, 1))
    _add(mesh, lines[2], force * _outer(a, b, c, d, 2))
    _add(mesh, lines[3], force * _outer(a, b, c, d, 3))


@inner(fastmath=SUMS, forceinline=True)
def add_moved(mesh, lines, at, moment):
    """Add a force times its shift (y, x) [steps]."""
    a, c = moment[0] * _weights(_SLOPE, at[0]), moment[1] * _weights(_VALUE, at[0])
    b, d = _weights(_VALUE, at[1]), _weights(_SLOPE, at[1])
    _add(mesh, lines[0], _outer(a, b, c, d, 0))
    _add(mesh, lines[1], _outer(a, b, c, d, 1))
    _add(mesh, lines[2], _outer(a, b, c, d, 2))
    _add(mesh, lines[3], _outer(a, b, c, d, 3))


@inner(fastmath=SUMS, forceinline=True)
def _sum_of_lines(a, b, c, d, weights):
    """Sum of four mesh lines with the weights of the nodes along y."""
    found = multiply_add(b, lane(weights, 1), lane(weights, 0) * a)
    return multiply_add(d, lane(weights, 3), multiply_add(c, lane(weights, 2), found))


@inner(fastmath=SUMS, forceinline=True)
def read(mesh, lines, at):
    """Value of the spline at the point, its slopes by y and x, and its second slopes [1/steps]."""
    a, b = _load_double(mesh, lines[0]), _load_double(mesh, lines[1])
    c, d = _load_double(mesh, lines[2]), _load_double(mesh, lines[3])
    level = _sum_of_lines(a, b, c, d, _weights(_VALUE, at[0]))
    slope = _sum_of_lines(a, b, c, d, _weights(_SLOPE, at[0]))
    bend = _sum_of_lines(a, b, c, d, _weights(_BEND, at[0]))
    across = _weights(_VALUE, at[1])
    return (
        total(level * across),
        total(slope * across),
        total(level * _weights(_SLOPE, at[1])),
        total(bend * across),
        total(level * _weights(_BEND, at[1])),
    )


@inner(fastmath=SUMS, forceinline=True)
def set_stored(weight, place, at, half):
    """Write the 16 weights of a force that is spread with `half` its variance by y and x [steps^2]
    from element `place` of `weight` on, flat."""
    a, b, c, d = _spread(at, half)
    store(weight, place, _outer(a, b, c, d, 0))
    store(weight, place + np.uint64(4), _outer(a, b, c, d, 1))
    store(weight, place + np.uint64(8), _outer(a, b, c, d, 2))
    store(weight, place + np.uint64(12), _outer(a, b, c, d, 3))


@inner(fastmath=SUMS, forceinline=True)
def add_stored(mesh, lines, weight, place, force):
    """Add a force by the 16 weights from element `place` on."""
    _add(mesh, lines[0], force * _load(weight, place))
    _add(mesh, lines[1], force * _load(weight, place + np.uint64(4)))
    _add(mesh, lines[2], force * _load(weight, place + np.uint64(8)))
    _add(mesh, lines[3], force * _load(weight, place + np.uint64(12)))


@inner(fastmath=SUMS, forceinline=True)
def read_stored(mesh, lines, weight, place):
    """Sum of the nodes by the 16 weights from element `place` on."""
    found = _load(weight, place) * _load(mesh, lines[0])
    found = multiply_add(_load(weight, place + np.uint64(4)), _load(mesh, lines[1]), found)
    found = multiply_add(_load(weight, place + np.uint64(8)), _load(mesh, lines[2]), found)
    return total(multiply_add(_load(weight, place + np.uint64(12)), _load(mesh, lines[3]), found))
