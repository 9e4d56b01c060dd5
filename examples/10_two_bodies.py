"""
Two bodies
==========

Rough steel on rough aluminum. Without adhesion only the sum of both roughnesses and the composite
modulus count: the pair is one rough map on one half-space.
"""

import matplotlib.pyplot as plt

import asperity
import surfaces

size = (0.8e-3, 1e-3)
ground = surfaces.ground((256, 320), size, rms_slope=0.1, cutoff=2e-5, length=8, seed=1)
blasted = surfaces.self_affine(
    (256, 320), size, hurst=0.8, rms_height=1e-6, rolloff=1e-4, cutoff=2e-5, seed=2
)
steel = asperity.HalfSpace(210e9, 0.3, hardness=2.5e9)
aluminum = asperity.HalfSpace(70e9, 0.33, hardness=1e9)
pair = asperity.HalfSpace.pair(steel, aluminum)  # the softer of both yields
print(f"E* = {pair.modulus / 1e9:.1f} GPa, hardness {pair.hardness / 1e9:.1f} GPa")

# %%
# Each body on a smooth one, and both on each other.

axes = None
both = surfaces.composite(ground, blasted)
for name, hm in (("ground", ground), ("blasted", blasted), ("both", both)):
    curve = asperity.solve(hm, pair, pressures=[3e6, 1e7, 3e7])
    middle = curve.at(pressure=1e7)
    print(f"{name:8}: rms height {1e6 * hm.rms_height:.2f} um, at 10 MPa "
          f"{1e6 * middle.separation:.2f} um apart")  # fmt: skip
    axes = curve.plot("mean_pressure", "separation", axes, marker="o", label=name)
axes.legend()
plt.show()
