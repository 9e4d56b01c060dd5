"""Compiled loops of the contact shifts and of the conjugate gradients.

`shift_contacts` evaluates the equations of `contact_shifts` (docs/development/interaction.md,
"Contact shift"). `aim` and `advance` are preconditioned conjugate gradients (Hestenes & Stiefel
1952) for A x = b, and for A x + c = b where the sum of x is held. The preconditioner is the
inverse D^-1 + D^-1 P E P' D^-1 of `TwoLevelPreconditioner`.
"""

from __future__ import annotations

from surfaces.numerics.compiled import compiled

SMALLEST_APPROACH = 1e-200
"""Approach [m] below which a contact stays where it is."""

LONGEST_STEP = 5.0
"""Largest step over the preconditioned residual. A longer one means that the matrix is hardly
positive along it. Steps are 0.4 to 0.9 where the matrix is positive definite, 1.8 at most on random
maps, 3 to 5 where a lattice of equal summits is about to fill."""


@compiled()
def shift_contacts(
    force, stiffness, approach, tilt, radii, modulus, power, limit, gain, shift, moment
):
    """Fill `gain`, `shift` and `moment`: height gained, shift, and force times shift (n, 2).

    With R = a^2 / (p d), a the punch radius (k = 2 E* a^p / p), the free shift of a contact is
    -R g and its gain R g^2 / 2. Both are multiplied by b / (b + R g^2 / 2), b = `limit`^2 p d / 2,
    which bounds the shift by `limit` a.
    """
    for i in range(force.size):
        y, x, rise = 0.0, 0.0, 0.0
        if force[i] > 0.0 and approach[i] > SMALLEST_APPROACH:
            along_y, along_x = tilt[i, 0], tilt[i, 1]
            radius = power * stiffness[i] / (2.0 * modulus)
            square = radius * radius if power == 1.0 else radius ** (2.0 / power)
            bend = square / (power * approach[i])
            y = -bend * (radii[i, 0] * along_y + radii[i, 2] * along_x)
            x = -bend * (radii[i, 2] * along_y + radii[i, 1] * along_x)
            free = -0.5 * (along_y * y + along_x * x)
            bound = 0.5 * limit * limit * power * approach[i]
            share = bound / (bound + free)
            y, x, rise = share * y, share * x, share * free
        gain[i] = rise
        shift[i, 0], shift[i, 1] = y, x
        moment[i, 0], moment[i, 1] = force[i] * y, force[i] * x


@compiled()
def aim(last, direction, residual, stiffness, cell, inverse, total, held, scratch):
    """Next conjugate direction, in place: p <- z + (r.z / `last`) p.

    z is the preconditioned residual, z_i = k_i (r_i + (E P' D^-1 r)_c) with the cell c of contact
    i; with `held` its sum is zero. `last` is r.z of the step before. `inverse` and `total` are E
    and K of `TwoLevelPreconditioner`; `scratch` has shape (3, cells).

    Returns the sum of k (r - c)^2, the number c, which is the mean of r weighted by k if `held` and
    else zero, and r.z.
    """
    count = total.size
    square = 0.0
    first = 0.0
    whole = 0.0
    for c in range(count):
        scratch[1, c] = 0.0
    for i in range(residual.size):
        moment = stiffness[i] * residual[i]
        scratch[1, cell[i]] += moment
        square += moment * residual[i]
    product = square
    response = 0.0
    answer = 0.0
    for c in range(count):
        first += scratch[1, c]
        whole += total[c]
        here = 0.0
        even = 1.0
        for e in range(count):
            here += inverse[c, e] * scratch[1, e]
            even += inverse[c, e] * total[e]
        product += scratch[1, c] * here
        response += scratch[1, c] + total[c] * here
        answer += total[c] * even
        scratch[0, c] = here
        scratch[2, c] = even
    mean = 0.0
    if held:
        shift = response / answer
        for c in range(count):
            scratch[0, c] -= shift * scratch[2, c]
        mean = first / whole
        square = max(square - mean * first, 0.0)
        product = max(product - shift * response, 0.0)
    ratio = product / last
    for i in range(direction.size):
        direction[i] = stiffness[i] * (residual[i] + scratch[0, cell[i]]) + ratio * direction[i]
    return square, mean, product


@compiled()
def advance(
    product, direction, image, solution, residual, stiffness, cell, inverse, total, held, scratch
):
    """One step of conjugate gradients along `direction`, whose product with the matrix is `image`,
    and the next direction.

    Returns whether the step was taken, and what `aim` returns. A step along a direction of negative
    or hardly any curvature (`LONGEST_STEP`) is not taken.
    """
    curvature = 0.0
    for i in range(direction.size):
        curvature += direction[i] * image[i]
    if LONGEST_STEP * curvature <= product:
        return False, (0.0, 0.0, 0.0)
    length = product / curvature
    for i in range(solution.size):
        solution[i] += length * direction[i]
        residual[i] -= length * image[i]
    after = aim(product, direction, residual, stiffness, cell, inverse, total, held, scratch)
    return True, after
