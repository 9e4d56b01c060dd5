"""Names, units and meanings of the roughness parameters."""

from __future__ import annotations

__all__ = ["PARAMETERS"]

PARAMETERS = {
    "Sq": ("m", "rms height"),
    "Ssk": ("-", "skewness"),
    "Sku": ("-", "kurtosis"),
    "Sp": ("m", "highest peak"),
    "Sv": ("m", "deepest dale"),
    "Sz": ("m", "peak to dale"),
    "Sa": ("m", "mean absolute height"),
    "Sal": ("m", "autocorrelation length"),
    "Str": ("-", "texture aspect ratio"),
    "Std": ("deg", "texture direction, across the lay"),
    "lay": ("deg", "direction of the lay, by the correlation"),
    "Sdq": ("-", "rms slope, finite differences"),
    "Sdr": ("-", "additional area"),
    "curvature": ("1/m", "rms mean curvature, finite differences"),
    "Sk": ("m", "core height"),
    "Spk": ("m", "reduced peak height"),
    "Svk": ("m", "reduced dale height"),
    "Smr1": ("-", "ratio of the peaks"),
    "Smr2": ("-", "ratio above the dales"),
    "Smr": ("-", "material ratio at the mean plane"),
    "Smc": ("m", "height of the material ratio 10 %"),
    "Sxp": ("m", "peak extreme height, 2.5 to 50 %"),
    "Vm": ("m", "material volume above 10 %"),
    "Vv": ("m", "void volume below 10 %"),
    "Vmp": ("m", "peak material volume"),
    "Vmc": ("m", "core material volume"),
    "Vvc": ("m", "core void volume"),
    "Vvv": ("m", "dale void volume"),
    "Spd": ("1/m^2", "density of peaks"),
    "Svd": ("1/m^2", "density of pits"),
    "Spc": ("1/m", "mean curvature of peaks"),
    "Svc": ("1/m", "mean curvature of pits"),
    "S5p": ("m", "five highest peaks"),
    "S5v": ("m", "five deepest pits"),
    "S10z": ("m", "ten-point height"),
    "Sha": ("m^2", "closed hill area"),
    "Sda": ("m^2", "closed dale area"),
    "Shv": ("m^3", "closed hill volume"),
    "Sdv": ("m^3", "closed dale volume"),
}
"""Unit and meaning of each parameter, in the order of tables; volumes Vm to Vvv are per area."""
