"""
The cut-off decides the area
============================

The finer you look, the less touches. One surface, four shortest wavelengths, one pressure.
"""

import matplotlib.pyplot as plt
import numpy as np

import asperity
import surfaces

hm = surfaces.self_affine(
    (512, 384), (1e-3, 0.75e-3), hurst=0.8, rms_slope=0.2, rolloff=2e-4, cutoff=8e-6, seed=5
)
polymer = asperity.HalfSpace(3e9, 0.4)

# %%
# Waves shorter than a length are taken out, as a coarser instrument or a wear-in would.

cut_offs = [8e-6, 1.6e-5, 3.2e-5, 6.4e-5]
maps = [surfaces.bandpass(hm, shortest=length) for length in cut_offs]
curves = [asperity.solve(map_, polymer, pressures=[5e6]) for map_ in maps]
slopes = np.array([map_.roughness.rms_slope for map_ in maps])
areas = np.array([100 * curve.area_fraction[0] for curve in curves])
for length, slope, area in zip(cut_offs, slopes, areas, strict=True):
    print(f"cut-off {1e6 * length:4.0f} um: rms slope {slope:.3f}, {area:.1f} % touches")

# %%
# The slope decides: in light contact of random surfaces the area fraction is a little more than
# 2 p / (E* h'), with the rms slope h'. Quote no area without its cut-off.

estimate = 100 * 2 * 5e6 / (polymer.modulus * slopes)
plt.loglog(1e6 * np.array(cut_offs), areas, "o-", label="solve")
plt.loglog(1e6 * np.array(cut_offs), estimate, "k:", label="2 p / (E* h')")
plt.xlabel("shortest wavelength [µm]")
plt.ylabel("real contact area [%]")
plt.legend()
plt.show()
