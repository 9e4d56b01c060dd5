"""Search for the mean pressure of a prescribed separation, during the solution."""

from __future__ import annotations

import math

__all__ = ["LoadSearch"]

_LARGEST_RATIO = 8.0
"""Largest ratio of two loads tried in turn."""


class LoadSearch:
    """Secant search for the load at which the contact lies at a prescribed level.

    Parameters
    ----------
    offset
        Level u - h of the contact to reach [m].
    mean
        First mean pressure p~ to try [m], positive.
    stiffness
        Slope of mean pressure over level, if known.
    largest
        Largest mean pressure p~ [m].

    Notes
    -----
    Load grows about exponentially with the level, so steps are taken in its logarithm. The level
    rises with the load, so every solved load bounds the answer from one side; a step never leaves
    the bounds nor changes the load more than eightfold. A level that is not known better than its
    distance from the aim changes nothing: the contact is solved further at the same load first.
    """

    def __init__(
        self,
        offset: float,
        mean: float,
        stiffness: float | None = None,
        *,
        largest: float = math.inf,
    ) -> None:
        self.offset = offset
        self.mean = mean
        self.largest = largest
        self.stiffness = stiffness
        self._below, self._above = 0.0, math.inf
        self._last: tuple[float, float] | None = None

    def update(self, level: float, uncertainty: float) -> float:
        """Next mean pressure to try, given the level reached by the present one.

        Parameters
        ----------
        level
            Level of the contact at the present load [m].
        uncertainty
            How far the level may be off, because the contact is not solved exactly [m].
        """
        miss = self.offset - level
        if abs(miss) < uncertainty:
            return self.mean
        if miss > 0.0:
            self._below = max(self._below, self.mean)
        else:
            self._above = min(self._above, self.mean)
        if self._last is not None:
            rise, step = level - self._last[1], self.mean - self._last[0]
            if abs(rise) > 3.0 * uncertainty and rise * step > 0.0:
                self.stiffness = step / rise
        self._last = (self.mean, level)
        self.mean = self._bounded(self._proposal(miss))
        return self.mean

    def _proposal(self, miss: float) -> float:
        """Step of the secant in the logarithm of the load, at most eightfold."""
        longest = math.log(_LARGEST_RATIO)
        exponent = math.copysign(longest, miss)
        if self.stiffness is not None:
            exponent = min(max(self.stiffness * miss / self.mean, -longest), longest)
        return self.mean * math.exp(exponent)

    def _bounded(self, proposal: float) -> float:
        """The proposal, or the middle of the bounds if it leaves them."""
        if self._above - self._below <= 1e-12 * self._above:
            self._below, self._above = 0.0, math.inf
        proposal = min(proposal, self.largest)
        if self._below < proposal < self._above:
            return proposal
        upper = self._above if math.isfinite(self._above) else min(4.0 * self.mean, self.largest)
        return 0.5 * (self._below + upper)

    def rescale(self, ratio: float) -> None:
        """Carry the search to a grid with another unit of pressure; its bounds are forgotten."""
        self.mean *= ratio
        self.largest *= ratio
        if self.stiffness is not None:
            self.stiffness *= ratio
        self._below, self._above, self._last = 0.0, math.inf, None
