"""What decides the answers of one run of the microcontact model: constants and switches."""

from __future__ import annotations

from dataclasses import dataclass, field

from .constants import (
    ErrorEstimate,
    Limits,
    PixelWaves,
    PressedBasins,
    Segmentation,
    SharpTips,
    Spots,
    SubContact,
    TiltedBasins,
    WaveSplit,
)

__all__ = ["DEFAULTS", "Corrections", "Parameters"]


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


@dataclass(frozen=True)
class Parameters:
    """All constants of one run, by what they belong to."""

    segmentation: Segmentation = field(default_factory=Segmentation)
    pixel_waves: PixelWaves = field(default_factory=PixelWaves)
    wave_split: WaveSplit = field(default_factory=WaveSplit)
    sub_contact: SubContact = field(default_factory=SubContact)
    pressed_basins: PressedBasins = field(default_factory=PressedBasins)
    tilted_basins: TiltedBasins = field(default_factory=TiltedBasins)
    sharp_tips: SharpTips = field(default_factory=SharpTips)
    spots: Spots = field(default_factory=Spots)
    error_estimate: ErrorEstimate = field(default_factory=ErrorEstimate)
    limits: Limits = field(default_factory=Limits)
    corrections: Corrections = field(default_factory=Corrections)


DEFAULTS = Parameters()
"""The constants that results are judged with."""
