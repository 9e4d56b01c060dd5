"""
How much do equal surfaces scatter?
===================================

Eight surfaces with one spectrum. What differs from one to the next is what a single scan cannot
tell you.
"""

import matplotlib.pyplot as plt
import numpy as np

import asperity
import surfaces

polymer = asperity.HalfSpace(3e9, 0.4)
pressures = np.geomspace(1e5, 1e7, 7)
found = {"area [%]": [], "separation [µm]": []}
for seed in range(8):
    hm = surfaces.self_affine(
        (192, 192), (5e-4, 5e-4), hurst=0.8, rms_slope=0.1, rolloff=2.5e-4, cutoff=2e-5, seed=seed
    )
    curve = asperity.contact_curve(hm, polymer, pressures=pressures)
    found["area [%]"].append(100 * curve.area_fraction)
    found["separation [µm]"].append(1e6 * curve.separation)

# %%
# A light load rests on the few highest hills, and there the surfaces differ most.

for name, values in found.items():
    scatter = 100 * np.std(values, axis=0, ddof=1) / np.mean(values, axis=0)
    light, heavy = scatter[[0, -1]]
    print(f"{name}: standard deviation {light:.1f} % at 0.1 MPa, {heavy:.1f} % at 10 MPa")

figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for ax, (name, values) in zip(axes, found.items(), strict=True):
    mean, deviation = np.mean(values, axis=0), np.std(values, axis=0, ddof=1)
    ax.plot(pressures / 1e6, np.transpose(values), color="0.8", lw=0.8)
    ax.errorbar(pressures / 1e6, mean, deviation, fmt="o-", capsize=3)
    ax.set(xlabel="mean pressure [MPa]", ylabel=name, xscale="log")
axes[0].set_yscale("log")
plt.show()
