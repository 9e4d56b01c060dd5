"""How much of a rough surface touches, at what load and separation, and how far to trust it."""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .bem.curve import bem_curve as bem_curve
    from .bem.single import BemIndentation as BemIndentation
    from .bem.solution import BemSolution as BemSolution
    from .bem.solve import bem_solve as bem_solve
    from .comparison.result import Comparison as Comparison
    from .comparison.run import compare as compare
    from .contacts.sizes import size_distribution as size_distribution
    from .curve import ContactRun as ContactRun
    from .curve import contact_curve as contact_curve
    from .curve import solve_contacts as solve_contacts
    from .derived.conductance import constriction_conductance as constriction_conductance
    from .derived.friction import FrictionCurve as FrictionCurve
    from .derived.friction import friction_curve as friction_curve
    from .errors import AsperityError as AsperityError
    from .errors import ConvergenceError as ConvergenceError
    from .errors import InputError as InputError
    from .errors import ModelRangeError as ModelRangeError
    from .indentation import Indentation as Indentation
    from .indentation import indent as indent
    from .indentation_bem import indent_bem as indent_bem
    from .material import HalfSpace as HalfSpace
    from .microcontact.friction import PartialSlip as PartialSlip
    from .microcontact.friction import partial_slip as partial_slip
    from .microcontact.friction import tangential_modulus as tangential_modulus
    from .microcontact.punch import FlatPunch as FlatPunch
    from .microcontact.punch import flat_punch as flat_punch
    from .microcontact.viscoelastic import Relaxation as Relaxation
    from .microcontact.viscoelastic import viscoelastic_indent as viscoelastic_indent
    from .plan import Plan as Plan
    from .plan import make_plan as make_plan
    from .population.population import Population as Population
    from .population.state import PopulationState as PopulationState
    from .results.curve import ContactCurve as ContactCurve
    from .results.paraview import write_vti as write_vti
    from .threads import set_threads as set_threads

__version__ = "0.1.0"

# A waiting OpenMP thread must sleep soon: on a busy machine a barrier that spins for long costs
# more than the loop that it ends.  10 000 spins (below 0.5 ms) bridge the gap between two loops,
# so that schedulers that pack tasks do not put both threads on one processor.  The runtime reads
# this once, when the first parallel kernel loads it.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("GOMP_SPINCOUNT", "10000")

_HOME = {
    "AsperityError": "errors",
    "BemIndentation": "bem.single",
    "BemSolution": "bem.solution",
    "Comparison": "comparison.result",
    "ContactCurve": "results.curve",
    "ContactRun": "curve",
    "ConvergenceError": "errors",
    "FrictionCurve": "derived.friction",
    "FlatPunch": "microcontact.punch",
    "HalfSpace": "material",
    "Indentation": "indentation",
    "InputError": "errors",
    "ModelRangeError": "errors",
    "PartialSlip": "microcontact.friction",
    "Plan": "plan",
    "Population": "population.population",
    "PopulationState": "population.state",
    "Relaxation": "microcontact.viscoelastic",
    "bem_curve": "bem.curve",
    "bem_solve": "bem.solve",
    "compare": "comparison.run",
    "constriction_conductance": "derived.conductance",
    "contact_curve": "curve",
    "flat_punch": "microcontact.punch",
    "friction_curve": "derived.friction",
    "indent": "indentation",
    "indent_bem": "indentation_bem",
    "make_plan": "plan",
    "partial_slip": "microcontact.friction",
    "set_threads": "threads",
    "size_distribution": "contacts.sizes",
    "solve_contacts": "curve",
    "tangential_modulus": "microcontact.friction",
    "viscoelastic_indent": "microcontact.viscoelastic",
    "write_vti": "results.paraview",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
