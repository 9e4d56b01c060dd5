"""
From a file to a curve
======================

Read, prepare, load. Here the file is made first, with the faults of a measured map: tilt and
missing points.
"""

import matplotlib.pyplot as plt
import numpy as np

import asperity
import surfaces

scan = surfaces.self_affine(
    (180, 240), (18e-6, 24e-6), hurst=0.7, rms_slope=0.15, rolloff=6e-6, cutoff=8e-7, seed=3
)
tilt = 0.01 * scan.x[None, :] + 0.02 * scan.y[:, None]
heights = scan.heights + tilt
heights[50:53, 100:102] = np.nan
surfaces.write(surfaces.HeightMap(heights, scan.spacing, name="scan"), "scan.h5")

# %%
# Every step of the preparation is recorded.

hm = surfaces.prepare(surfaces.read("scan.h5"), level="plane", fill="harmonic", periodic="taper")
for step in hm.history:
    print(step)
curve = asperity.contact_curve(hm, asperity.HalfSpace(70e9, 0.17, hardness=9e9))
print(curve)
curve.to_hdf5("curve.h5")
print(asperity.ContactCurve.from_hdf5("curve.h5").area_fraction)

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.4), layout="constrained")
surfaces.read("scan.h5").plot(left).set_title("as measured")
hm.plot(right).set_title("as solved")
plt.show()
