"""The elastic half-space: homogeneous, or graded as a power of depth."""

from __future__ import annotations

import math
from dataclasses import dataclass

from asperity.errors import InputError
from surfaces.errors import as_number

__all__ = ["HalfSpace", "require_half_space"]

_LEAST_MODULUS, _LARGEST_MODULUS = 1e-40, 1e40
"""Moduli [Pa] whose products with lengths and each other floating-point numbers hold."""


@dataclass(frozen=True, init=False)
class HalfSpace:
    """Half-space with Young's modulus E(z) = E z^m, constant Poisson ratio and, maybe, a hardness.

    Parameters
    ----------
    E
        Young's modulus [Pa] of the homogeneous body (m = 0), or the factor of z^m [Pa m^-m];
        positive.
    nu
        Poisson ratio, -1 < nu <= 1/2.
    m
        Exponent of the grading, -1 < m < 1; 0 is the homogeneous body.
    hardness
        Largest pressure [Pa] that a contact bears, positive; with None nothing limits it, and the
        attribute is infinite.

    Raises
    ------
    InputError
        If a value is outside its range.

    Notes
    -----
    The contact partner is rigid; `HalfSpace.pair` combines two deformable bodies. `modulus` is
    E* = E / (1 - nu^2) for m = 0 and the effective graded modulus E_m* [Pa m^-m] otherwise: the
    flat round punch of radius a has the stiffness 2 E_m* a^(1+m) / (1+m) (Popov, Li and Willert
    2023, equations 9, 11, 13). With a hardness H the contact pressure of first loading is bounded,
    0 <= p <= H: where it reaches H the surface yields and stays in contact (elastic, perfectly
    plastic cap; Almqvist, Sahlin, Larsson and Glavatskih 2007).

    Examples
    --------
    >>> HalfSpace(210e9, 0.3).modulus == 210e9 / (1 - 0.3**2)
    True
    """

    E: float | None
    nu: float | None
    m: float
    hardness: float
    modulus: float

    def __init__(
        self, E: float, nu: float, m: float = 0.0, *, hardness: float | None = None
    ) -> None:
        if E is None or nu is None:
            raise InputError("HalfSpace needs E and nu; use HalfSpace.from_modulus without them")
        young, ratio, exponent = _number(E, "E"), _number(nu, "nu"), _exponent(m)
        _require_modulus(young, "E")
        if not -1 < ratio <= 0.5:
            raise InputError(f"nu must lie in -1 < nu <= 0.5, got {ratio:g}")
        modulus = young / (1 - ratio * ratio) * _grading_factor(exponent, ratio)
        self._fill(young, ratio, exponent, modulus, _hardness(hardness))

    @classmethod
    def from_modulus(
        cls, modulus: float, m: float = 0.0, *, hardness: float | None = None
    ) -> HalfSpace:
        """Half-space given by its effective modulus E* (or E_m*, [Pa m^-m]) and hardness alone.

        Raises
        ------
        InputError
            If the modulus or the hardness is not positive, or m outside (-1, 1).
        """
        value = _number(modulus, "modulus")
        _require_modulus(value, "modulus")
        body = object.__new__(cls)
        body._fill(None, None, _exponent(m), value, _hardness(hardness))
        return body

    @classmethod
    def pair(cls, first: HalfSpace, second: HalfSpace) -> HalfSpace:
        """Composite of two deformable bodies, 1/E* = 1/E1* + 1/E2*; the gradings must agree.

        The softer of two hardnesses bounds the pressure of both.

        Raises
        ------
        InputError
            If the bodies are not two `HalfSpace`, or their gradings differ.
        """
        for body in (first, second):
            if not isinstance(body, cls):
                raise InputError(f"a composite is of two HalfSpace, not {type(body).__name__}")
        if first.m != second.m:
            raise InputError(
                f"bodies graded with m = {first.m:g} and m = {second.m:g} have no composite "
                "modulus; both need the same m"
            )
        product = first.modulus / (first.modulus + second.modulus) * second.modulus
        softer = min(first.hardness, second.hardness)
        return cls.from_modulus(product, first.m, hardness=softer)

    @property
    def elastic(self) -> HalfSpace:
        """This half-space without a hardness."""
        if self.hardness == math.inf:
            return self
        body = object.__new__(type(self))
        body._fill(self.E, self.nu, self.m, self.modulus, math.inf)
        return body

    @property
    def facts(self) -> dict[str, float]:
        """What a result depends on: modulus, exponent and, where there is one, the hardness."""
        known = {"modulus": self.modulus, "m": self.m}
        return known | ({"hardness": self.hardness} if self.hardness < math.inf else {})

    def _fill(
        self, young: float | None, nu: float | None, m: float, modulus: float, hardness: float
    ) -> None:
        values = {"E": young, "nu": nu, "m": m, "modulus": modulus, "hardness": hardness}
        for name, value in values.items():
            object.__setattr__(self, name, value)


def _grading_factor(m: float, nu: float) -> float:
    """h(m, nu) of E_m* = E h / (1 - nu^2); 1 at m = 0 (Popov, Li & Willert 2023, equation 13)."""
    if m == 0:
        return 1.0
    beta = math.sqrt((1 + m) * (1 - m * nu / (1 - nu)))
    log_c = (
        (1 + m) * math.log(2)
        + math.lgamma((3 + m + beta) / 2)
        + math.lgamma((3 + m - beta) / 2)
        - math.log(math.pi)
        - math.lgamma(2 + m)
    )
    log_ratio = math.lgamma(1 + m / 2) - math.lgamma((1 + m) / 2) - log_c
    cosine = math.sin((1 - abs(m)) * math.pi / 2)
    below = math.sqrt(math.pi) * beta * math.sin(beta * math.pi / 2)
    return 2 * (1 + m) * cosine * math.exp(log_ratio) / below


def _number(value: float, name: str) -> float:
    number = as_number(name, value)
    if not math.isfinite(number):
        rigid = number == math.inf and name in ("E", "modulus")
        hint = "; of a rigid and an elastic body take the elastic one alone" if rigid else ""
        raise InputError(f"{name} must be finite, got {number}{hint}")
    return number


def _require_modulus(value: float, name: str) -> None:
    if value <= 0:
        raise InputError(f"{name} must be positive, got {value:g} Pa")
    if not _LEAST_MODULUS <= value <= _LARGEST_MODULUS:
        raise InputError(
            f"{name} is {value:g} Pa, beyond {_LEAST_MODULUS:g} to {_LARGEST_MODULUS:g} Pa; check "
            "its unit"
        )


def _hardness(value: float | None) -> float:
    """Infinite where none is given."""
    hardness = math.inf if value is None else as_number("hardness", value)
    if hardness != math.inf:
        _require_modulus(hardness, "hardness")
    return hardness


def _exponent(value: float) -> float:
    m = _number(value, "m")
    if not -1 < m < 1:
        raise InputError(f"m must lie in -1 < m < 1, got {m:g}")
    return m


def require_half_space(material: object) -> None:
    """Refuse an argument that is not a `HalfSpace`, such as a bare modulus."""
    if not isinstance(material, HalfSpace):
        raise InputError(
            f"an asperity.HalfSpace is needed, not {type(material).__name__}: "
            "asperity.HalfSpace(E, nu) or asperity.HalfSpace.from_modulus(modulus)"
        )
