"""
Curves and contacts in one picture
==================================

Both curves, the elastic one beside them, and where the surface touches.
"""

import matplotlib.pyplot as plt

import asperity
import surfaces

hm = surfaces.self_affine(
    (256, 256), (1e-3, 1e-3), hurst=0.8, rms_slope=0.1, rolloff=1.25e-4, cutoff=3.2e-5, seed=1
)
result = asperity.compare(hm, asperity.HalfSpace(210e9, 0.3, hardness=2e9))
model, bem, elastic = result.model, result.reference, result.elastic

figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
left.semilogy(1e6 * bem.separation, bem.mean_pressure / 1e6, "o-", label="boundary elements")
left.semilogy(1e6 * model.separation, model.mean_pressure / 1e6, "D--", label="microcontacts")
left.semilogy(1e6 * elastic.separation, elastic.mean_pressure / 1e6, "k:", label="elastic")
left.set(xlabel="separation [µm]", ylabel="mean pressure [MPa]")
left.legend(frameon=False)
middle.loglog(bem.mean_pressure / 1e6, 100 * bem.area_fraction, "o-")
middle.loglog(model.mean_pressure / 1e6, 100 * model.area_fraction, "D--")
middle.loglog(elastic.mean_pressure / 1e6, 100 * elastic.area_fraction, "k:")
middle.set(xlabel="mean pressure [MPa]", ylabel="real contact area [%]")
extent = (0, 1e3 * hm.size[1], 1e3 * hm.size[0], 0)
right.imshow(1e6 * hm.heights, cmap="gray", extent=extent)
shown = dict(levels=[0.5], extent=extent, origin="upper", linewidths=1)
right.contour(result.maps["bem"], colors="C0", **shown)
right.contour(result.maps["asperity"], colors="C1", **shown)
pressure = result.table["mean_pressure"][result.map_point]
right.set(xlabel="x [mm]", ylabel="y [mm]", title=f"contacts at {pressure / 1e6:.0f} MPa")
figure.savefig("contact.png", dpi=110)
print(result.verdict())
plt.show()
