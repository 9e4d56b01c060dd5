"""The best ellipse of one profile at one approach, and the expansion about that of the contour."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from asperity.microcontact.ellipse.ellipse_operator import LOG_RATIO
from asperity.microcontact.hertz import ASPECT_EXPONENT
from surfaces.arrays import Array
from surfaces.polar import PolarProfile, PowerSumProfile

from .ellipse_expansion import ANGLES, Edge, Gap, edge_of, fit_points, fitted
from .ellipse_series import Expansion, expand

__all__ = ["SHARP_TIP", "Ellipse", "Search", "Solved"]


SHARP_TIP = 0.005
"""Misfit of the polynomial over the approach above which a tip is sharp: its ellipse stays about
the summit, since powers of the distance from there describe what the polynomial leaves."""

_MAX_NEWTON_STEPS = 30
"""Newton steps towards the best ellipse."""

_SMALL_STEP = 1e-8
"""Newton step at which it has been found."""

_TEACHING_STEP = 0.05
"""Newton step below which the steps teach the inverse of what is left out in them."""

_APPROACH_STEP = 1e-3
"""Logarithmic step of the approach for the stiffness."""

_LARGEST_STEP, _LEAST_SQUARE, _KEPT_ELLIPSES = 0.3, 0.1, 4
"""Largest step over a mode; least square of a contour; ellipses on which f is kept."""


class Ellipse(NamedTuple):
    """Semi-axes [m], turn [rad] and centre [m]."""

    a: float
    b: float
    turn: float
    x: float
    y: float

    def places(self, xi: Array, eta: Array) -> tuple[Array, Array]:
        """Places (r, phi) of scaled coordinates."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        x = self.x + c * self.a * xi - s * self.b * eta
        y = self.y + s * self.a * xi + c * self.b * eta
        return np.hypot(x, y), np.arctan2(y, x)

    def coordinates(self, r: Array, phi: Array) -> tuple[Array, Array]:
        """Scaled coordinates (xi, eta) of places, the inverse of `places`."""
        x, y = r * np.cos(phi) - self.x, r * np.sin(phi) - self.y
        c, s = np.cos(self.turn), np.sin(self.turn)
        return (c * x + s * y) / self.a, (c * y - s * x) / self.b

    def moved(self, step: Array) -> Ellipse:
        """Ellipse whose boundary is displaced by `step` over the first modes of `_MODES`."""
        step = np.append(step, [0.0] * (5 - len(step)))
        shear = 2 * step[2] / (self.a / self.b + self.b / self.a)
        strain = np.array([[1 + step[0], shear], [shear, 1 + step[1]]])
        c, s = np.cos(self.turn), np.sin(self.turn)
        axes, size, _ = np.linalg.svd(np.array([[c, -s], [s, c]]) @ strain * [self.a, self.b])
        x, y = step[3] * self.a, step[4] * self.b
        turn = np.arctan2(axes[1, 0], axes[0, 0])
        return Ellipse(
            float(size[0]),
            float(size[1]),
            float(turn),
            self.x + c * x - s * y,
            self.y + s * x + c * y,
        )


_T = 2 * np.pi * np.arange(ANGLES) / ANGLES
_MODES = np.stack([np.cos(_T) ** 2, np.sin(_T) ** 2, np.sin(2 * _T), np.cos(_T), np.sin(_T)])


class Solved(NamedTuple):
    """The expansion about one ellipse, and what it was made of."""

    ellipse: Ellipse
    gap: Gap
    expansion: Expansion
    widest: float


class Search:
    """The ellipses of one profile: f is fitted again on each.

    Newton steps of the exact force of the elliptic punch find the best one. What they leave out of
    its second variation is learned from them (Broyden), for this approach and the next.
    """

    def __init__(
        self, profile: PowerSumProfile | PolarProfile, m: float, approach: float, radius: float
    ) -> None:
        self._profile, self._m = profile, m
        self._gap = lru_cache(maxsize=_KEPT_ELLIPSES)(self._fitted)
        self.first, free = self._first(radius, approach)
        self._modes = _MODES if free else _MODES[:3]
        self._inverse = np.eye(len(self._modes))

    def optimum(self, start: Ellipse, approach: float) -> Ellipse | None:
        """Ellipse of the largest force of the elliptic punch.

        None if it was not found, or is more slender than the tables reach.
        """
        best, step = start, self._newton(start, approach)
        for _ in range(_MAX_NEWTON_STEPS):
            if step is None:
                return None
            if np.abs(step).max() < _SMALL_STEP:
                break
            move = np.clip(self._inverse @ step, -_LARGEST_STEP, _LARGEST_STEP)
            best = best.moved(move)
            following = self._newton(best, approach)
            if following is not None and np.abs(step).max() < _TEACHING_STEP:
                along = self._inverse @ (step - following)
                share = move @ along
                if share > 0.1 * (move @ move):
                    self._inverse += np.outer(move - along, move @ self._inverse) / share
                else:  # steps away from the best have taught a wrong one
                    self._inverse = np.eye(len(self._modes))
            step = following
        found = step is not None and np.abs(step).max() < 1e-2
        return best if found and np.log(best.b / best.a) >= LOG_RATIO[0] else None

    def solved(self, best: Ellipse, approach: float) -> Solved:
        """Expansion about the ellipse of the contour that the one about `best` gives."""
        first = self._edge(best, approach)
        radius = np.sqrt(np.maximum(expand(first).squared, _LEAST_SQUARE))
        moved = best.moved(
            np.clip(self._over_modes(first, radius - 1), -_LARGEST_STEP, _LARGEST_STEP)
        )
        edge = self._edge(moved, approach)
        widest = float(np.abs(first.shift).max())
        return Solved(moved, self._gap(moved), expand(edge), widest)

    def power(self, best: Ellipse, approach: float) -> float:
        """d ln F / d ln d, by difference."""
        forces = []
        for h in (-_APPROACH_STEP, _APPROACH_STEP):
            near = self.optimum(best, approach * np.exp(h))
            forces.append(
                np.nan if near is None else self.solved(near, approach * np.exp(h)).expansion.force
            )
        with np.errstate(invalid="ignore", divide="ignore"):
            return float(np.log(forces[1] / forces[0]) / (2 * _APPROACH_STEP))

    def _newton(self, ellipse: Ellipse, approach: float) -> Array | None:
        """Step over the modes; None where the ellipse bears nothing."""
        edge = self._edge(ellipse, approach)
        if not (np.isfinite(edge.lower) and edge.level > 0):
            return None
        return self._over_modes(edge, edge.shift)

    def _over_modes(self, edge: Edge, values: Array) -> Array:
        weighted = self._modes * edge.weight
        return np.asarray(np.linalg.solve(weighted @ self._modes.T, weighted @ values))

    def _edge(self, ellipse: Ellipse, approach: float) -> Edge:
        return edge_of(self._gap(ellipse), approach, ellipse.a, ellipse.b, self._m)

    def _fitted(self, ellipse: Ellipse) -> Gap:
        """f on the ellipse."""
        xi, eta, _, _ = fit_points()
        return fitted(np.asarray(self._profile(*ellipse.places(xi, eta))))

    def _first(self, radius: float, approach: float) -> tuple[Ellipse, bool]:
        """Ellipse of the Hertzian aspect about the summit, a circle about a sharp one, and whether
        its centre is free."""
        circle = Ellipse(radius, radius, 0.0, 0.0, 0.0)
        gap = self._gap(circle)
        c = gap.polynomial
        values, axes = np.linalg.eigh([[c[3], 0.5 * c[4]], [0.5 * c[4], c[5]]])
        if gap.misfit > SHARP_TIP * approach or not values[1] > 0:
            return circle, gap.misfit <= SHARP_TIP * approach
        root = float(np.clip(values[0] / values[1], 1e-3, 1.0)) ** (ASPECT_EXPONENT / 2)
        turn = float(np.arctan2(axes[1, 0], axes[0, 0]))
        return Ellipse(radius / root, radius * root, turn, 0.0, 0.0), True
