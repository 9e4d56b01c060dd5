"""
Beyond the curve
================

What one run holds: contacts, pressure, sizes, conductance, partial slip.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection

import asperity
import surfaces

hm = surfaces.self_affine(
    (180, 240), (0.9e-3, 1.2e-3), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=3.2e-5, seed=7
)
steel = asperity.HalfSpace(210e9, 0.3)
run = asperity.solve_contacts(hm, steel, pressures=[1e6, 1e7, 3e7, 1e8, 3e8])
curve, last = run.curve, run.curve.load[-1]

table = run.microcontacts()  # of the last load point; run.microcontacts(0) of the first
print(f"{len(table)} contacts carry {table['force'].sum() / last:.6f} of the load")
strongest = table[table["force"].argmax()]
print(f"the strongest is at x = {strongest['x']:.3g} m, y = {strongest['y']:.3g} m")

pressure = run.pressure_map()  # (ny, nx) [Pa]
print(f"the pressure field carries {pressure.mean() / curve.mean_pressure[-1]:.6f} of the load")
asperity.write_vti("contact.vti", {"pressure": pressure, "contact": run.contact_map()}, hm.spacing)

spots = run.spots()  # contacts that meet are one spot
sizes = asperity.size_distribution(spots["area"], bins=8)
print(f"{len(spots)} spots, per bin of area: {sizes['contacts'].tolist()}")

print(f"stiffness {curve.stiffness[-1]:.4g} Pa/m")
conductance = asperity.constriction_conductance(curve, resistivity=(1e-7, 1e-7))
print(f"constriction conductance {conductance[-1]:.4g} S/m^2")

ratio = steel.modulus / asperity.tangential_modulus(steel)
slip = asperity.friction_curve(curve, 3e8, friction=0.3, modulus_ratio=ratio)
half = abs(slip.shear - 0.5 * slip.slip_shear).argmin()
stuck = slip.stick_area_fraction[half] / slip.stick_area_fraction[0]
print(f"pushed by half its friction it moves {slip.displacement[half]:.3g} m, {stuck:.2f} sticks")

# %%
# The contacts on the surface: every circle has the area of its contact.

axes = hm.plot(cmap="gray")
place, size = np.column_stack([table["x"], table["y"]]), 2 * table["radius"]
circles = EllipseCollection(size, size, 0 * size, units="xy", offsets=place)
circles.set_offset_transform(axes.transData)
axes.add_collection(circles)
plt.show()
