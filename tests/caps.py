"""Maps with known peaks: the truth goes in, and must come out.

A peak is a `Cap`: a summit at a known place and the gap f(r, phi) below it. `draw` takes the
highest of all caps at each point, so that caps may touch, cross the seam of a periodic map or be
cut by the border.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surfaces.errors import InputError
from surfaces.heightmap import HeightMap

__all__ = [
    "Cap", "cone", "draw", "ellipsoid", "paraboloid", "pyramid", "random_caps", "sphere",
    "sphere_array", "star",
]  # fmt: skip

Array = NDArray[np.float64]
Gap = Callable[[ArrayLike, ArrayLike], Any]


@dataclass(frozen=True)
class Cap:
    """One peak of known shape.

    Parameters
    ----------
    x, y
        Summit [m].
    height
        Height of the summit [m].
    gap
        Function f(r, phi) [m] of the distance r [m] from the summit and the direction phi [rad],
        zero at r = 0; vectorized. NaN or infinity: the cap does not reach so far.
    angle
        Turn of the cap, counter-clockwise from +x [rad].
    """

    x: float
    y: float
    height: float
    gap: Gap
    angle: float = 0.0


def draw(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    caps: Sequence[Cap],
    *,
    base: float | None = None,
    periodic: bool = False,
) -> HeightMap:
    """Map of the highest of all caps at each point.

    Parameters
    ----------
    shape
        Number of points (ny, nx).
    spacing
        Pixel size (dy, dx) [m].
    caps
        Peaks of the map.
    base
        Height [m] of the plane between the caps; None: there is none, and every point must be
        reached by a cap.
    periodic
        Whether the caps continue across the border. Each cap then counts with its nearest image.

    Returns
    -------
    HeightMap
        The map.

    Raises
    ------
    SurfaceError
        If a point is reached by no cap and there is no base.
    """
    ny, nx = shape
    dy, dx = spacing
    heights = np.full(shape, -np.inf if base is None else base)
    for cap in caps:
        away_y = (np.arange(ny)[:, None] + 0.5) * dy - cap.y
        away_x = (np.arange(nx)[None, :] + 0.5) * dx - cap.x
        if periodic:
            away_y -= ny * dy * np.round(away_y / (ny * dy))
            away_x -= nx * dx * np.round(away_x / (nx * dx))
        gap = np.asarray(cap.gap(np.hypot(away_y, away_x), np.arctan2(away_y, away_x) - cap.angle))
        heights = np.fmax(heights, np.where(np.isnan(gap), -np.inf, cap.height - gap))
    return HeightMap(heights, spacing, periodic=periodic, history=({"step": "draw"},))


def paraboloid(k1: float, k2: float | None = None) -> Gap:
    """Gap ``(k2 X^2 + k1 Y^2)/2`` with curvatures k1 >= k2 [1/m]; X points along the angle."""
    return _elliptic(lambda s: 0.5 * s, k1, k2)


def ellipsoid(k1: float, k2: float | None = None, *, depth: float) -> Gap:
    """Upper half of an ellipsoid with summit curvatures k1 >= k2 [1/m] and semi-axis `depth` [m].

    f = depth (1 - sqrt(1 - (k2 X^2 + k1 Y^2)/depth)), NaN outside.
    """

    def section(s: Array) -> Array:
        inside = 1.0 - s / depth
        return np.where(inside >= 0.0, depth - depth * np.sqrt(np.maximum(inside, 0.0)), np.nan)

    return _elliptic(section, k1, k2)


def sphere(radius: float) -> Gap:
    """Upper half of a sphere of the given radius [m], NaN outside."""
    return ellipsoid(1.0 / radius, depth=radius)


def cone(slope: float) -> Gap:
    """Gap ``slope r``."""
    return lambda r, phi: slope * np.asarray(r, float) + 0.0 * np.asarray(phi, float)


def pyramid(slope: float, sides: int = 4) -> Gap:
    """Regular pyramid whose faces fall with `slope`; the first face looks along the angle."""
    if sides < 3:
        raise InputError(f"a pyramid has at least 3 sides, not {sides}")
    width = 2.0 * np.pi / sides

    def gap(r: ArrayLike, phi: ArrayLike) -> Array:
        turn = np.mod(np.asarray(phi, float) + 0.5 * width, width) - 0.5 * width
        return np.asarray(slope * np.asarray(r, float) * np.cos(turn))

    return gap


def star(k: float, amplitude: float, *, points: int = 5, wave: float = 0.2) -> Gap:
    """Gap ``amplitude r^k (1 + wave cos(points phi))`` with 0 <= wave < 1."""
    if not 0.0 <= wave < 1.0:
        raise InputError(f"wave is {wave}; it must lie in [0, 1)")

    def gap(r: ArrayLike, phi: ArrayLike) -> Array:
        ripple = 1.0 + wave * np.cos(points * np.asarray(phi, float))
        return np.asarray(amplitude * np.asarray(r, float) ** k * ripple)

    return gap


def random_caps(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    count: int,
    *,
    distance: float,
    curvature: tuple[float, float],
    ratio: float = 4.0,
    kind: Callable[..., Gap] = paraboloid,
    height: float = 0.0,
    seed: int = 0,
    **options: float,
) -> list[Cap]:
    """Elliptic caps at random places, of random curvatures, directions and heights.

    Parameters
    ----------
    shape, spacing
        Grid of the map: points (ny, nx) and pixel (dy, dx) [m].
    count
        Number of caps; fewer are returned when no more find room.
    distance
        Least distance between two summits, seam included [m].
    curvature
        Range of the geometric mean curvature [1/m].
    ratio
        Largest ratio of the principal curvatures; its logarithm is uniform.
    kind
        `paraboloid` or `ellipsoid`, called as ``kind(k1, k2, **options)``.
    height
        Summit heights are uniform in [0, height] [m].
    seed
        Seed of the random numbers.

    Returns
    -------
    list of Cap
        The caps; ``cap.angle`` is the direction of their long axis.
    """
    rng = np.random.default_rng(seed)
    size = np.array(shape) * np.array(spacing)
    places: list[Array] = []
    for _ in range(50 * count):
        place = rng.uniform(0.0, size)
        away = np.array([other - place for other in places]).reshape(-1, 2)
        away -= size * np.round(away / size)
        if len(places) < count and np.all(np.hypot(*away.T) >= distance):
            places.append(place)
    caps = []
    for y, x in places:
        mean = np.exp(rng.uniform(*np.log(curvature)))
        skew = np.exp(0.5 * rng.uniform(0.0, np.log(ratio))) if ratio > 1.0 else 1.0
        gap = kind(mean * skew, mean / skew, **options)
        angle, top = rng.uniform(-0.5 * np.pi, 0.5 * np.pi), rng.uniform(0.0, height)
        caps.append(Cap(float(x), float(y), float(top), gap, float(angle)))
    return caps


def sphere_array(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    *,
    rows: int,
    columns: int,
    radius: float,
    height_step: float = 0.0,
) -> HeightMap:
    """Periodic array of sphere caps on a flat base one radius below the highest summit.

    The summits stand in the middle of `rows` x `columns` equal cells; in reading order each is
    `height_step` [m] lower than the one before.
    """
    ly, lx = shape[0] * spacing[0], shape[1] * spacing[1]
    caps = [
        Cap((j + 0.5) * lx / columns, (i + 0.5) * ly / rows, -(i * columns + j) * height_step,
            sphere(radius))
        for i in range(rows)
        for j in range(columns)
    ]  # fmt: skip
    return draw(shape, spacing, caps, base=-radius, periodic=True)


def _elliptic(section: Callable[[Array], Array], k1: float, k2: float | None) -> Gap:
    """Gap ``section(k2 X^2 + k1 Y^2)``."""
    low = k1 if k2 is None else k2
    if not 0.0 < low <= k1:
        raise InputError(f"curvatures are {k1} and {k2}; give k1 >= k2 > 0 in 1/m")

    def gap(r: ArrayLike, phi: ArrayLike) -> Array:
        radius, turn = np.asarray(r, float), np.asarray(phi, float)
        return section(radius**2 * (low * np.cos(turn) ** 2 + k1 * np.sin(turn) ** 2))

    return gap
