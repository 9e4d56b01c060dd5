"""Place of a direction among the rays of a summit, without an arctangent."""

from __future__ import annotations

from surfaces.numerics.compiled import QUOTIENTS, inner
from surfaces.numerics.lanes import most, splat
from surfaces.numerics.vectors import absolute, where


@inner(fastmath=QUOTIENTS)
def place(x, y, rays):
    """Angle of (x, y) in steps between `rays` equispaced rays, right to 5e-5 of a quarter."""
    ax, ay = absolute(x), absolute(y)
    z = ay / most(ax + ay, splat(1e-300)) - 0.5
    q = z * z
    turn = 1.27223736 + q * (-1.6356908 + q * (2.97934497 - q * 3.17613357))
    turn = (0.25 * rays) * (0.5 + z * turn)
    turn = where(x < 0.0, 0.5 * rays - turn, turn)
    return where(y < 0.0, rays - turn, turn)
