"""Compiled passes over the contacts of a trial point."""

from __future__ import annotations

import math

from surfaces._compiled import compiled


@compiled()
def deflect(force, stiffness, approach, tilt, lean, modulus, power, limit, gain, aside):
    """Height gained and shift (n, 2) of each contact; `deflection` has the formulas."""
    for i in range(force.size):
        bound = 0.5 * limit * limit * power * approach[i]
        if force[i] <= 0.0 or bound < 1e-200:
            gain[i] = 0.0
            aside[i, 0] = 0.0
            aside[i, 1] = 0.0
            continue
        radius = power * stiffness[i] / (2.0 * modulus)
        square = radius * radius if power == 1.0 else radius ** (2.0 / power)
        bend = square / (power * approach[i])
        along_y = lean[i, 0] * tilt[i, 0] + lean[i, 2] * tilt[i, 1]
        along_x = lean[i, 2] * tilt[i, 0] + lean[i, 1] * tilt[i, 1]
        free = 0.5 * bend * (tilt[i, 0] * along_y + tilt[i, 1] * along_x)
        share = bound / (bound + free)
        gain[i] = free * share
        aside[i, 0] = -bend * share * along_y
        aside[i, 1] = -bend * share * along_x


@compiled()
def lag(force, stiffness, tilt, aside, fresh, moved, gain):
    """Share of the load that the difference between `aside` and `fresh` can make."""
    whole = 0.0
    change = 0.0
    afar = 0.0
    own = 0.0
    load = 0.0
    for i in range(force.size):
        f = force[i]
        if f == 0.0:
            continue
        load += f
        pull = f * math.sqrt(tilt[i, 0] ** 2 + tilt[i, 1] ** 2)
        whole += pull * math.sqrt(fresh[i, 0] ** 2 + fresh[i, 1] ** 2)
        dy, dx = fresh[i, 0] - aside[i, 0], fresh[i, 1] - aside[i, 1]
        change += pull * math.sqrt(dy * dy + dx * dx)
        afar += stiffness[i] * abs(moved[i])
        own += 2.0 * stiffness[i] * gain[i]
    return change / whole * max(afar, own) / load if whole > 0.0 else 0.0


@compiled()
def balance(stiffness, error):
    """Mean of the errors, weighted by stiffness."""
    total = 0.0
    moment = 0.0
    for i in range(error.size):
        total += stiffness[i]
        moment += stiffness[i] * error[i]
    return moment / total if total > 0.0 else 0.0


@compiled()
def imbalance(gap, value, growth, slope, approach, force, stiffness, wanted, error):
    """Fill z - s - u and what it exceeds the approach by; sum of stiffness times size of that, and
    the load."""
    total = 0.0
    load = 0.0
    for i in range(gap.size):
        wanted[i] = gap[i] - value[i] - growth[i] * slope[i]
        error[i] = wanted[i] - approach[i]
        total += stiffness[i] * abs(error[i])
        load += force[i]
    return total, load


@compiled()
def fall(gap, error, force, approach, value, work, force1, approach1, value1, work1):
    """Change of energy from one point to another (1) at one gap, minus the work of the errors along
    it, and the size of the energies."""
    change = 0.0
    slope = 0.0
    scale = 0.0
    for i in range(gap.size):
        before = force[i] * (approach[i] + 0.5 * value[i] - gap[i]) - work[i]
        after = force1[i] * (approach1[i] + 0.5 * value1[i] - gap[i]) - work1[i]
        change += after - before
        scale += abs(before)
        slope -= error[i] * (force1[i] - force[i])
    return change, slope, scale
