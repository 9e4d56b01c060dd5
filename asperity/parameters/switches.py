"""Switches of the corrections of the microcontact model."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Corrections"]


@dataclass(frozen=True)
class Corrections:
    """Switches of what is added to independent laws and their interaction
    (``benchmarks/ablation.py`` has a row for each).

    Attributes
    ----------
    contact_shift
        Contacts move aside on the slope of their neighbors' field.
    elongation
        Footprints of contacts on long summits are long.
    pressed_basins
        Basins that carry much of the load are pressed alone.
    joined_pairs
        Two contacts that join while they carry much of the load are pressed as one.
    tilted_basins
        Contacts on basins that the field of the others tilts get the area of the tilted basin.
    sharp_tips
        Contacts little beyond a tip that their rays do not resolve are no longer trusted.
    wave_split
        The finest waves of a broad spectrum act as a law of the contacts.
    finer_grid
        Maps whose waves reach the pixel are solved on smaller pixels.
    coarser_grid
        Smooth maps are solved on larger pixels.
    """

    contact_shift: bool = True
    elongation: bool = True
    pressed_basins: bool = True
    joined_pairs: bool = True
    tilted_basins: bool = True
    sharp_tips: bool = True
    wave_split: bool = True
    finer_grid: bool = True
    coarser_grid: bool = True
