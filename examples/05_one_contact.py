"""
One contact
===========

A square pyramid is pressed into steel: two contact laws, boundary elements, friction, and a viscous
body.
"""

import matplotlib.pyplot as plt
import numpy as np

from asperity import (
    HalfSpace,
    Relaxation,
    indent,
    indent_bem,
    partial_slip,
    tangential_modulus,
    viscoelastic_indent,
)
from surfaces import shapes

steel = HalfSpace(210e9, 0.3)
tip = shapes.polygon(4, k=1, scale=0.1)  # a square pyramid of slope 0.1
depth = 1e-7  # m

reference = indent_bem(tip, steel, depth, grid=128)
for law in ("paper", "harmonic"):
    one = indent(tip, steel, depth, law=law)
    error = 100 * (one.force / reference.force - 1)
    expected = 100 * one.error_estimate
    print(f"{law:>9}: {one.force * 1e3:.4f} mN, {error:+.2f} % of force, expected {expected:.2f} %")
print(f"contact reaches {one.contour(0.0) * 1e6:.3f} um to a face, "
      f"{one.contour(np.pi / 4) * 1e6:.3f} um to an edge")  # fmt: skip

ratio = steel.modulus / tangential_modulus(steel)
push = partial_slip(tip, steel, depth, friction=0.3, modulus_ratio=ratio,
                    tangential_force=0.15 * float(one.force))  # fmt: skip
print(f"pushed by half its friction it sticks on {100 * push.stick_area / one.contact_area:.1f} %"
      f" of its area and moves {push.displacement * 1e9:.2f} nm")  # fmt: skip

polymer = Relaxation(equilibrium=1e9, strengths=[3e9], times=[2.0])
time = np.linspace(0, 20, 41)
held = viscoelastic_indent(tip, polymer, time, np.full(time.size, depth))
print(f"held on a polymer its force falls from {held.force[0] * 1e6:.1f} to "
      f"{held.force[-1] * 1e6:.1f} uN")  # fmt: skip

# %%
# The contour of the law over the contact of the boundary elements.

turn = np.linspace(0, 2 * np.pi, 361)
for outline in reference.solutions[-1].outlines():
    x, y = 1e6 * (outline - reference.summit[-1]).T
    plt.fill(x, y, color="0.8", label="boundary elements")
edge = 1e6 * one.contour(turn)
plt.plot(edge * np.cos(turn), edge * np.sin(turn), label=one.law)
plt.axis("equal")
plt.xlabel("x [µm]")
plt.ylabel("y [µm]")
plt.legend()
plt.show()
