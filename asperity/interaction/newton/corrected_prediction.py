"""A forecast of the contacts, put right between them before its field is taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.ewald.tangent import Tangent

from . import _state_kernels
from .conjugate_gradients import conjugate_gradients
from .problem import Problem

__all__ = ["corrected_prediction"]

FORCING = 0.05
"""Relative accuracy of the linear solve at best: of many contacts a rougher one left a third of the
points to a Newton step, which costs twice as much as the rest."""

Array = NDArray[np.float64]


def corrected_prediction(
    problem: Problem, wanted: Array, force: Array, *, tolerance: float
) -> tuple[Array, int]:
    """Approaches that agree with the forces of a forecast, and the products spent.

    Parameters
    ----------
    problem
        Contacts.
    wanted
        Forecast of z - s - u [m], shape (n,).
    force
        Forecast of the forces [N] with the same weights of the same points, shape (n,).
    tolerance
        Residual to which the point will be solved.

    Notes
    -----
    Displacements are linear in the forces but for the growth of the footprints: the forecast of u
    is right for the forecast of the forces, whether the points before were solved well or not. It
    is the laws that bend. With F(d) the laws, the approaches that fit are the solution of
    d = wanted - G (F(d) - force), G the interaction of the contacts: one Newton step of it.
    """
    law = problem.laws(wanted)
    closed = law.force > 0
    tangent = Tangent(problem.plan, closed, law.stiffness, None, problem.form)
    rows = tangent.index
    right, exponent, share = np.empty((3, len(rows)))
    known = law.force, law.stiffness, wanted, force
    # the residual, sum |r| k, is at most the root of sum k r^2 times sum k
    load, most = _state_kernels.mismatch(rows, *known, right, exponent, share)
    enough = tolerance * load / most if most > 0 else 1.0
    solved = conjugate_gradients(tangent, right, tolerance=min(max(FORCING, enough), 1.0))
    share += solved.solution / law.force.take(rows)
    approach = np.maximum(wanted, 0.0)
    approach[rows] *= np.maximum(share, 0.0) ** exponent
    return approach, solved.products
