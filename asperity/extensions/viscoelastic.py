"""Viscoelastic contact while it does not shrink (Lee-Radok correspondence)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError, ModelRangeError
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.single.indent import indent
from asperity.microcontact.single.indentation import Indentation
from surfaces.arrays import Array
from surfaces.errors import as_number, as_sizes
from surfaces.polar import PolarProfile, PowerSumProfile

__all__ = ["Relaxation", "ViscoelasticContact", "viscoelastic_force", "viscoelastic_indent"]


@dataclass(frozen=True)
class Relaxation:
    """Relaxation function of E* [Pa] as a Prony series, constant Poisson ratio.

    ``E*_rel(t) = equilibrium + sum_i strength_i exp(-t/time_i)``.

    Parameters
    ----------
    equilibrium
        Long-time modulus [Pa], not negative; 0 is a Maxwell body.
    strengths
        Moduli [Pa] of the arms, positive.
    times
        Relaxation times [s] of the arms, positive.

    Examples
    --------
    >>> import asperity
    >>> polymer = asperity.Relaxation(equilibrium=1e9, strengths=[3e9], times=[2.0])
    >>> polymer.equilibrium + sum(polymer.strengths)
    4000000000.0
    """

    equilibrium: float
    strengths: Sequence[float]
    times: Sequence[float]

    def __post_init__(self) -> None:
        strengths, times = as_sizes("strengths", self.strengths), as_sizes("times", self.times)
        equilibrium = as_number("equilibrium", self.equilibrium)
        as_sizes("equilibrium", equilibrium)
        if strengths.ndim != 1 or strengths.shape != times.shape:
            raise InputError("give one relaxation time per strength")
        if equilibrium < 0 or np.any(strengths <= 0) or np.any(times <= 0):
            raise InputError("strengths and times must be positive, equilibrium not negative")
        if equilibrium == 0 and len(strengths) == 0:
            raise InputError("a body without any modulus carries nothing")
        object.__setattr__(self, "equilibrium", equilibrium)
        object.__setattr__(self, "strengths", tuple(strengths.tolist()))
        object.__setattr__(self, "times", tuple(times.tolist()))

    def __call__(self, t: ArrayLike) -> Array:
        """E*_rel [Pa] at the times `t` [s] after a step; refused before it."""
        time = as_sizes("t", t)
        if np.any(time < 0):
            raise InputError(f"t is {time.min():.4g} s; give times after the step, not negative")
        arms = (g * np.exp(-time / tau) for g, tau in zip(self.strengths, self.times, strict=True))
        return np.asarray(sum(arms, np.full(time.shape, self.equilibrium)))


@dataclass(frozen=True, eq=False)
class ViscoelasticContact:
    """History of one viscoelastic contact.

    Attributes
    ----------
    time
        [s], shape (n,).
    approach
        [m], shape (n,), never falling.
    force
        Normal force [N], shape (n,).
    elastic
        The elastic solution at the same approaches for unit modulus: it has the contour, area and
        flags, which are those of the viscoelastic contact.
    """

    time: Array
    approach: Array
    force: Array
    elastic: Indentation

    @property
    def contact_area(self) -> Array:
        """Contact area [m^2], shape (n,)."""
        return self.elastic.contact_area


def viscoelastic_indent(
    profile: PowerSumProfile | PolarProfile,
    relaxation: Relaxation,
    time: ArrayLike,
    approach: ArrayLike | None = None,
    *,
    load: ArrayLike | None = None,
    m: float = 0.0,
    law: str = "harmonic",
) -> ViscoelasticContact:
    """Contact history of a rigid profile on a viscoelastic half-space.

    Parameters
    ----------
    profile
        Gap at first touch.
    relaxation
        Relaxation function of E* (of E_m* for a graded body whose grading does not relax).
    time
        Rising times [s], shape (n,); the body is at rest before the first.
    approach, load
        Approach d(t) [m] or normal force F(t) [N] at these times, shape (n,), one of them. Steps
        are taken at the first time; in between the elastic force is linear in time.
    m
        Exponent of the grading.
    law
        Law of the elastic contact.

    Raises
    ------
    ModelRangeError
        If the contact would shrink: the correspondence does not hold then (Ting).

    Notes
    -----
    ``F(t) = int_0^t E*_rel(t - t') d/dt' [F_el(d(t')) / E*] dt'`` with the geometry of the elastic
    body at the same approach; by exact recursion over the arms for F_el linear between the times.
    Under load control the same recursion is solved for F_el, time by time.

    Examples
    --------
    >>> import asperity, surfaces
    >>> import numpy as np
    >>> polymer = asperity.Relaxation(equilibrium=1e9, strengths=[3e9], times=[2.0])
    >>> time = np.linspace(0.0, 20.0, 21)
    >>> ball = surfaces.PowerLawProfile(2.0, 50.0)
    >>> held = asperity.viscoelastic_indent(ball, polymer, time, np.full(21, 1e-6))
    >>> f"{held.force[0] / held.force[-1]:.2f}"
    '4.00'
    """
    if not isinstance(relaxation, Relaxation):
        raise InputError(f"an asperity.Relaxation is needed, not {type(relaxation).__name__}")
    instants = as_sizes("time", time)
    if instants.ndim != 1 or instants.size < 2 or np.any(np.diff(instants) <= 0):
        raise InputError("time must hold at least two rising instants")
    if (approach is None) == (load is None):
        raise InputError("give either approach or load")
    name, chosen = ("approach", approach) if load is None else ("load", load)
    given = as_sizes(name, chosen)
    if given.shape != instants.shape or np.any(given < 0):
        raise InputError(f"{name} must be not negative and as long as time")
    unit = HalfSpace.from_modulus(1.0, m)
    if load is None:
        _growing(given)
        elastic = indent(profile, unit, given, law=law)
        return ViscoelasticContact(
            instants, given, viscoelastic_force(relaxation, instants, elastic.force), elastic
        )
    response = viscoelastic_force(relaxation, instants, given, inverse=True)
    as_sizes("load over modulus", response)
    _growing(response)
    depth = np.zeros(given.shape)
    touching = response > 0
    if np.any(touching):
        depth[touching] = indent(profile, unit, load=response[touching], law=law).approach
    return ViscoelasticContact(instants, depth, given, indent(profile, unit, depth, law=law))


def viscoelastic_force(
    relaxation: Relaxation, time: Array, given: Array, *, inverse: bool = False
) -> Array:
    """Force [N] from the elastic force per modulus [m^2] at the times [s], linear in between; or,
    `inverse`, the latter from the former."""
    strength, tau = np.asarray(relaxation.strengths), np.asarray(relaxation.times)
    arms, last = np.zeros(strength.shape), 0.0
    decay, share = np.zeros(strength.shape), np.ones(strength.shape)  # a step at the first time
    found = np.empty(time.shape)
    for i, value in enumerate(given.tolist()):
        if i > 0:
            x = (time[i] - time[i - 1]) / tau
            decay, share = np.exp(-x), -np.expm1(-x) / x
        response = value
        if inverse:
            gain = relaxation.equilibrium + float(np.sum(strength * share))
            kept = float(np.sum(arms * decay - strength * share * last))
            response = (value - kept) / gain
        arms = arms * decay + strength * share * (response - last)
        force = relaxation.equilibrium * response + float(np.sum(arms))
        found[i] = response if inverse else force
        last = response
    return found


def _growing(values: Array) -> None:
    if np.any(np.diff(values) < -1e-12 * np.max(np.abs(values))):
        raise ModelRangeError(
            "the contact would shrink, where the correspondence principle does not hold; "
            "cut the history at the largest approach"
        )
