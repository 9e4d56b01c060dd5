"""Quantities of the command line: plain numbers in SI, or with a unit such as 210GPa."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np

from asperity.errors import InputError
from asperity.halfspace.scene import MOST_LOADS
from surfaces import units
from surfaces.arrays import Array


def of(kind: str) -> Callable[[str], float]:
    """Type of an option that takes a quantity of one kind, a key of `units.QUANTITIES`."""

    def parse(text: str) -> float:
        try:
            return units.quantity(text, kind)
        except InputError as error:
            raise argparse.ArgumentTypeError(f"{text[:30]}: {error}") from None

    return parse


def several(kind: str, nargs: int | str) -> dict[str, Any]:
    """Keywords of an option that takes several quantities of a kind, of which all have a unit or
    none."""

    class Several(argparse.Action):
        def __call__(
            self,
            parser: argparse.ArgumentParser,
            namespace: argparse.Namespace,
            values: Any,
            option: str | None = None,
        ) -> None:
            try:
                found = units.quantities(values, kind)
            except InputError as error:
                text = " ".join(values)[:30]
                raise argparse.ArgumentError(self, f"{text}: {error}") from None
            setattr(namespace, self.dest, found)

    return {"nargs": nargs, "action": Several}


def whole(things: str = "") -> Callable[[str], int]:
    """Type of an option that takes a whole number, of `things`."""

    def parse(text: str) -> int:
        try:
            return int(text)
        except ValueError:
            number = f"whole number of {things}" if things else "whole number"
            raise argparse.ArgumentTypeError(f"{text[:30]}: give a {number}") from None

    return parse


def spread(text: str, option: str, kind: str, *, geometric: bool) -> Array:
    """Quantities written as LO:HI:N or as a comma-separated list."""
    ends = text.count(":") == 2
    words = text.split(":")[:2] if ends else text.split(",")
    count = text.split(":")[2] if ends else "1"
    if ":" in text and not (ends and count.isdecimal() and float(count) > 0):
        raise InputError(f"{option} {text}: write LO:HI:N or numbers separated by commas")
    if (asked := float(count) if ends else len(words)) > MOST_LOADS:
        raise InputError(f"{option} {text[:60]}: {asked:g} load points; give at most {MOST_LOADS}")
    try:
        values = np.array(units.quantities(words, kind))
    except InputError as error:
        form = "" if ends else ", or LO:HI:N"
        raise InputError(f"{option} {text}: {error}{form}") from None
    if not (np.abs(values) < 1e40).all():
        raise InputError(f"{option} {text}: every number must be finite and below 1e40")
    if not ends:
        return values
    if geometric and values.min() <= 0:
        raise InputError(f"{option} {text}: both ends must be positive")
    return (np.geomspace if geometric else np.linspace)(values[0], values[1], int(count))
