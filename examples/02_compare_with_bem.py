"""
Two models, one surface
=======================

The sum of microcontacts against the full boundary elements: errors, and what each cost.
"""

import matplotlib.pyplot as plt
from matplotlib.colors import ListedColormap

import asperity
import surfaces

hm = surfaces.self_affine(
    (192, 256), (0.75e-3, 1e-3), hurst=0.8, rms_slope=0.1, rolloff=2e-4, cutoff=3.2e-5, seed=2
)
result = asperity.compare(hm, asperity.HalfSpace(3e9, 0.4), pressures=[5e5, 1.5e6, 5e6, 1e7])
print(result)
result.to_hdf5("results.h5")
result.to_html("report.html")

# %%
# The report holds the curves, the maps and the errors. Here is where both find contact.

model, reference = result.maps["asperity"] > 0, result.maps["bem"] > 0
colors = ListedColormap(["white", "C1", "C0", "0.3"])
plt.imshow(model + 2 * reference, cmap=colors, vmin=0, vmax=3, interpolation="nearest")
plt.title("gray: both, orange: model alone, blue: boundary elements alone")
plt.axis("off")
plt.show()
