"""What was done to a map, in words, with a warning where that may decide the answer."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from surfaces.drawing import with_unit

__all__ = ["in_words", "preparation_warnings"]

MUCH_TAPERED = 0.1
"""Share of the map in faded strips from which on tapering is warned of."""

Step = Mapping[str, Any]


def in_words(history: Iterable[Step]) -> list[str]:
    """A sentence for each step of a map's history; a step that is not known is listed.

    Examples
    --------
    >>> from surfaces.history import in_words
    >>> in_words([{"step": "level", "form": "plane"}, {"step": "sanded", "grit": 80}])
    ['Levelled: plane taken off.', 'sanded: grit 80']
    """
    found = []
    for step in history:
        try:
            found.append(_SENTENCES[str(step.get("step"))](step))
        except (KeyError, TypeError, ValueError, IndexError):
            details = ", ".join(
                f"{k} {_short(v)}" for k, v in step.items() if k != "step" and v is not None
            )
            name = str(step.get("step", "step"))
            found.append(f"{name}: {details}" if details else name)
    return found


def preparation_warnings(history: Iterable[Step]) -> list[str]:
    """One sentence for each preparation that changes more than a reader would expect.

    Examples
    --------
    >>> from surfaces.history import preparation_warnings
    >>> taper = {"step": "periodic", "how": "taper", "area_changed": 0.36}
    >>> preparation_warnings([taper])[0][:52]
    'Tapering altered 36 % of the map: heights fade to th'
    """
    return [
        f"Tapering altered {100 * step['area_changed']:.3g} % of the map: heights fade to their "
        "mean towards the border, and contact there is not that of the surface. Make the strip "
        "narrower, use --periodic smooth, or press the map as it is, not periodic."
        for step in history
        if step.get("how") == "taper" and _number(step.get("area_changed")) > MUCH_TAPERED
    ]


def _read(step: Step) -> str:
    part = step.get("dataset") or step.get("channel")
    unit = f", heights in {step['unit']}" if step.get("unit") else ""
    return f"Read from {step['file']}{f', {part}' if part else ''}{unit}."


def _leveled(step: Step) -> str:
    taken = {"plane": "plane taken off", "mean": "mean taken off"}
    form = str(step["form"])
    left = step.get("left_out") or 0
    apart = f", {left} points left out of the fit" if left else ""
    return f"Levelled: {taken.get(form, f'{form} form taken off')}{apart}."


def _spikes(step: Step) -> str:
    return f"{step['count']} spikes beyond {with_unit(step['limit'], 'm')} removed."


def _filled(step: Step) -> str:
    if not step["count"]:
        return "No point was missing."
    share = 100 * step["fraction"]
    return (
        f"{step['count']} missing points ({share:.2g} %) filled smoothly, at most "
        f"{step['largest_gap']} in one gap."
    )


def _filtered(step: Step) -> str:
    short, long = step.get("shortest"), step.get("longest")
    ends = [
        f"{word} {with_unit(float(end), 'm')}"
        for word, end in (("from", short), ("to", long))
        if end
    ]
    kept = " ".join(ends)
    heights = f"{with_unit(step['rms_before'], 'm')} to {with_unit(step['rms_after'], 'm')}"
    return f"Wavelengths kept {kept}; the rms height went from {heights}."


def _cropped(step: Step) -> str:
    (top, bottom), (left, right) = step["rows"], step["columns"]
    return f"Rows {top} to {bottom} and columns {left} to {right} cut out."


def _resampled(step: Step) -> str:
    before, after = (f"{ny} × {nx}" for ny, nx in (step["from"], step["to"]))
    return f"Resampled from {before} to {after} points."


def _made_periodic(step: Step) -> str:
    how = {
        "mirror": "mirrored at its sides: no height changed, four times the area",
        "taper": f"heights fade to their mean within {with_unit(_number(step.get('width')), 'm')} "
        f"of the border, {100 * step['area_changed']:.3g} % of the map",
        "smooth": "a smooth surface that carries the steps across the seam taken off",
        "wrap": "repeated as it is",
    }[step["how"]]
    return (
        f"Made periodic: {how}. The step across the seam is {with_unit(step['seam_step'], 'm')} "
        f"rms, that between neighbors inside {with_unit(step['inner_step'], 'm')}."
    )


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")


def _short(value: object) -> str:
    """A value of the history, its numbers to four digits."""
    if isinstance(value, list | tuple):
        return " × ".join(map(_short, value))
    return f"{value:.4g}" if isinstance(value, float) else str(value)


_SENTENCES: dict[str, Callable[[Step], str]] = {
    "read": _read,
    "level": _leveled,
    "outliers": _spikes,
    "fill": _filled,
    "bandpass": _filtered,
    "crop": _cropped,
    "resample": _resampled,
    "periodic": _made_periodic,
}
