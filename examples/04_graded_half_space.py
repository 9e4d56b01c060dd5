"""
A graded half-space
===================

E(z) = E0 z^m: stiffer (m > 0) or softer (m < 0) with depth. All bodies here have 2 GPa at 20 µm
below the surface. Both models, one rough surface.
"""

import matplotlib.pyplot as plt
import numpy as np

import asperity
import surfaces

hm = surfaces.self_affine(
    (192, 192), (1e-3, 1e-3), hurst=0.8, rms_slope=0.1, rolloff=2.5e-4, cutoff=4e-5, seed=4
)
axes = None
for m in (-0.3, 0.0, 0.3):
    body = asperity.HalfSpace(2e9 * (2e-5) ** -m, 0.3, m=m)
    separations = [1.5 * hm.rms_height, hm.rms_height]
    model = asperity.contact_curve(hm, body, separations=separations)
    reference = asperity.bem_curve(hm, body, separations=separations)
    for i in range(2):
        print(
            f"m = {m:+.1f}: mean pressure {model.mean_pressure[i]:.3e} Pa, "
            f"boundary elements {reference.mean_pressure[i]:.3e} Pa"
        )
    many = asperity.contact_curve(hm, body, separations=np.linspace(1.7, 0.8, 10) * hm.rms_height)
    axes = many.plot("separation", "mean_pressure", axes, marker="", label=f"m = {m:+.1f}")
    color = axes.lines[-1].get_color()
    reference.plot("separation", "mean_pressure", axes, ls="", color=color, label="_bem")

axes.legend(title="dots: boundary elements")
plt.show()
