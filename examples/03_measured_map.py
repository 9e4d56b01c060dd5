"""From a surface file to a curve: read, prepare, load. Here the file is made first."""

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

hm = surfaces.prepare(surfaces.read("scan.h5"), level="plane", fill="harmonic", periodic="taper")
for step in hm.history:
    print(step)
curve = asperity.contact_curve(hm, asperity.HalfSpace(70e9, 0.17))
print(curve)
curve.to_hdf5("curve.h5")
print(asperity.ContactCurve.from_hdf5("curve.h5").area_fraction)
