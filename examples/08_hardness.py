"""
Metals yield
============

How much more of a metal touches than elasticity says, from soft to hard.
"""

import matplotlib.pyplot as plt

import asperity
import surfaces

hm = surfaces.self_affine(
    (256, 256), (1e-3, 1e-3), hurst=0.8, rms_slope=0.1, rolloff=2.5e-4, cutoff=3.2e-5, seed=3
)
steel = asperity.HalfSpace(210e9, 0.3)
hardnesses = [1e9, 3e9, 1e10, float("inf")]
for hardness, curve in zip(
    hardnesses, asperity.hardness_sweep(hm, steel, hardnesses, pressures=[5e7]), strict=True
):
    index = steel.modulus * hm.roughness.rms_slope / hardness
    plastic = curve.extra["plastic_share"][0] if hardness < float("inf") else 0.0
    print(
        f"plasticity index {index:5.1f}: {100 * curve.area_fraction[0]:.2f} % touches, "
        f"{100 * plastic:.0f} % of that at the hardness, "
        f"{1e6 * curve.separation[0]:.2f} um from the mean plane"
    )

# %%
# What is left after unloading is flattened, and carries the same pressure elastically.

body = asperity.HalfSpace(210e9, 0.3, hardness=1e9)
pressed = asperity.bem_solve(hm, body, pressure=5e7)
left = pressed.unloaded()
print(
    f"boundary elements: {100 * pressed.area_fraction:.2f} %, sunk by up to "
    f"{1e6 * pressed.plastic_depth.max():.2f} um"
)
again = asperity.bem_solve(left, body.elastic, pressure=5e7)
print(f"pressed once more, elastically: {100 * again.area_fraction:.2f} %")

row = pressed.plastic_depth.max(axis=1).argmax()
plt.plot(1e3 * hm.x, 1e6 * hm.heights[row], label="before")
plt.plot(1e3 * hm.x, 1e6 * left.heights[row], label="after")
plt.xlabel("x [mm]")
plt.ylabel("height [µm]")
plt.legend()
plt.show()
