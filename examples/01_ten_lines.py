"""
Ten lines
=========

How much of a rough steel surface touches: the code of the README.
"""

import asperity
import surfaces

hm = surfaces.self_affine(
    (256, 256), (1e-3, 1e-3), hurst=0.8, rms_slope=0.1, rolloff=1.25e-4, cutoff=3.2e-5, seed=1
)
steel = asperity.HalfSpace(210e9, 0.3, hardness=2e9)
curve = asperity.solve(hm, steel, pressures=[1e7, 3e7, 1e8, 3e8], accuracy=0.05)
print(curve)
point = curve.at(pressure=5e7)
print(f"{100 * point.area_fraction:.2f} % touches at separation {point.separation:.3g} m")

# %%
# The surface, and the part of it that touches.

import matplotlib.pyplot as plt  # noqa: E402

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
hm.plot(left)
curve.plot(ax=right, marker="o")
plt.show()
