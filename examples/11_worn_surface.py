"""
A surface that has worn
=======================

Running-in planes the tops down to plateaus. The worn surface touches in many more spots, which
share the load: more area, a lower contact pressure, and the bodies sit closer.
"""

import matplotlib.pyplot as plt

import asperity
import surfaces

new = surfaces.self_affine(
    (256, 320), (0.8e-3, 1e-3), hurst=0.8, rms_height=1e-6, rolloff=2e-4, cutoff=2e-5, seed=6
)
steel = asperity.HalfSpace(210e9, 0.3, hardness=3e9)
pressures = [1e7, 3e7, 1e8]

# %%
# Wear takes off what stands above a height, and leaves a finer roughness on the plateaus.

fine = surfaces.self_affine(
    new.shape, new.size, hurst=0.8, rms_height=3e-8, rolloff=8e-5, cutoff=2e-5, seed=7
)
worn = new.replace(heights=new.heights.clip(max=0.8e-6) + fine.heights)

# %%
# The functional parameters of ISO 25178-2 and the curves of both.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for name, hm in (("new", new), ("worn", worn)):
    core = surfaces.bearing_curve(hm).core()
    curve = asperity.solve(hm, steel, pressures=pressures)
    print(f"{name:5}: Sk {1e6 * core['Sk']:.2f} um, Svk {1e6 * core['Svk']:.2f} um")
    for point in range(len(pressures)):
        print(
            f"  {curve.mean_pressure[point] / 1e6:4.0f} MPa: "
            f"{100 * curve.area_fraction[point]:.2f} % in {curve.contacts[point]:.0f} spots, "
            f"{1e6 * curve.separation[point]:.2f} um from the mean plane"
        )
    left.plot(1e3 * hm.x, 1e6 * hm.heights[128], label=name)
    curve.plot("mean_pressure", "separation", right, marker="o", label=name)
left.set(xlabel="x [mm]", ylabel="height [µm]")
right.legend()
plt.show()
