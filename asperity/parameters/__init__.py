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
from .switches import Corrections

__all__ = ["DEFAULTS", "Corrections", "Parameters"]


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
