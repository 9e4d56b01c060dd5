"""Power spectral density of a height map: in two dimensions, around rings, and along the axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft

from surfaces.arrays import Array, Index, Mask
from surfaces.heightmap import HeightMap, require_map
from surfaces.numerics.parallel import over_rows

from .density import TIED, Density, density_of, wave_numbers

__all__ = [
    "SpectralMoments",
    "Spectrum",
    "power_spectrum",
    "power_spectrum_2d",
    "spectrum_of",
]


_RING = 1.12  # outer over inner wave number of a ring
_FLOOR = 1e-14  # density over the largest, or the mean, below which a ring holds rounding alone
_HANN_MODES = (18.0 / 35.0) ** 2  # mean square of the window squared, over its mean fourth power


@dataclass(frozen=True)
class SpectralMoments:
    """Moments m_ab of the spectrum, the mean of qx^a qy^b over the power.

    Attributes
    ----------
    m00
        Variance of the heights [m^2].
    m20, m11, m02
        Variances and covariance of the slopes along x and y [-].
    m40, m22, m04
        Variances and covariance of the second derivatives along x and y [1/m^2].

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> x = np.arange(48) + 0.5
    >>> hm = surfaces.HeightMap(
    ...     np.tile(np.cos(2 * np.pi * x / 24), (32, 1)), 1.0, periodic=True
    ... )
    >>> moments = surfaces.power_spectrum(hm).moments
    >>> f"{moments.m20 / moments.m00:.4f}, {(2 * np.pi / 24) ** 2:.4f}"
    '0.0685, 0.0685'
    """

    m00: float
    m20: float
    m11: float
    m02: float
    m40: float
    m22: float
    m04: float

    @property
    def rms_height(self) -> float:
        """Root-mean-square height [m]."""
        return float(np.sqrt(self.m00))

    @property
    def rms_slope(self) -> float:
        """Root-mean-square gradient [-]."""
        return float(np.sqrt(self.m20 + self.m02))

    @property
    def rms_curvature(self) -> float:
        """Root-mean-square mean curvature (h_xx + h_yy) / 2 [1/m]."""
        return 0.5 * float(np.sqrt(self.m40 + 2.0 * self.m22 + self.m04))

    @property
    def m2(self) -> float:
        """Slope variance of a profile, averaged over directions [-]."""
        return 0.5 * (self.m20 + self.m02)

    @property
    def m4(self) -> float:
        """Curvature variance of a profile, averaged over directions [1/m^2]."""
        return 0.375 * (self.m40 + 2.0 * self.m22 + self.m04)

    @property
    def nayak(self) -> float:
        """Bandwidth parameter of Nayak m0 m4 / m2^2, at least 1.5 for an isotropic surface [-]."""
        return self.m00 * self.m4 / self.m2**2 if self.m2 else float("nan")

    @property
    def slope_ratio(self) -> float:
        """Largest over smallest rms slope of all directions [-]; 1 for an isotropic surface."""
        low, high = np.linalg.eigvalsh([[self.m20, self.m11], [self.m11, self.m02]])
        return float(np.sqrt(high / low)) if low > 0.0 else float("inf")

    @property
    def lay(self) -> float:
        """Direction of the smallest slopes, the lay [rad], ccw from +x to +y, in 0 to pi."""
        half = 0.5 * np.arctan2(2.0 * self.m11, self.m20 - self.m02)
        return float((half + 0.5 * np.pi) % np.pi % np.pi)  # once: pi, of -1e-17


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Power spectral density of a map.

    Attributes
    ----------
    q
        Wave number 2 pi over wavelength of the rings [rad/m], shape (n,); full rings only.
    density
        Mean density of the modes of each ring [m^4], shape (n,).
    modes
        Independent modes in each ring, shape (n,); a Hann window leaves 1 / 3.78 of them.
    qx, density_x
        Wave numbers [rad/m] and density [m^3] of the profiles along x, averaged over y.
    qy, density_y
        The same along y.
    moments
        Moments of the two-dimensional density.
    edge
        Wave number at which the spectrum ends in a cliff [rad/m], or `nyquist` if it does not.
    nyquist
        Largest wave number of a full ring [rad/m].
    window
        ``none`` for a periodic map, else ``hann``.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> x = np.arange(48) + 0.5
    >>> hm = surfaces.HeightMap(
    ...     np.tile(np.cos(2 * np.pi * x / 24), (32, 1)), 1.0, periodic=True
    ... )
    >>> spectrum = surfaces.power_spectrum(hm)
    >>> peak = spectrum.qx[spectrum.density_x.argmax()]
    >>> f"{2 * np.pi / peak:.0f}"
    '24'
    """

    q: Array
    density: Array
    modes: Array
    qx: Array
    density_x: Array
    qy: Array
    density_y: Array
    moments: SpectralMoments
    edge: float
    nyquist: float
    window: str

    @property
    def seen(self) -> Mask:
        """Rings that hold more than rounding, shape (n,)."""
        white = self.moments.m00 * (np.pi / self.nyquist) ** 2  # were all waves equal
        return np.asarray(self.density > _FLOOR * self.density.max(initial=white))


def power_spectrum(hm: HeightMap) -> Spectrum:
    """Power spectral density around rings and along the axes, and its moments.

    Parameters
    ----------
    hm
        The map, without missing points; of one on disk (`surfaces.SurfaceFile.on_disk`) the waves
        take up to 16 bytes per point in temporary files.

    Notes
    -----
    `C(q) = |dx dy sum h exp(-i q.x)|^2 / A` [m^4], so that the integral of C over d^2q / (4 pi^2)
    is the variance of the heights; for profiles `C(q) = |dx sum h exp(-i q x)|^2 / L` [m^3] with
    both signs of q averaged (Jacobs, Junge, Pastewka 2017). A map that is not periodic has its
    least-squares plane taken out and is weighted by a Hann window of mean square one.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> x = np.arange(48) + 0.5
    >>> hm = surfaces.HeightMap(
    ...     np.tile(np.cos(2 * np.pi * x / 24), (32, 1)), 1.0, periodic=True
    ... )
    >>> spectrum = surfaces.power_spectrum(hm)
    >>> f"{spectrum.moments.m00:.3f}"
    '0.500'
    """
    return spectrum_of(density_of(hm))


def spectrum_of(waves: Density) -> Spectrum:
    """As `power_spectrum`, of a density."""
    (ny, nx), (dy, dx) = waves.source.shape, waves.source.spacing
    size = ny * dy, nx * dx
    nyquist = np.pi / max(dy, dx)
    edges = _ring_edges(2.0 * np.pi / max(size), nyquist)
    rings = np.zeros((3, len(edges) + 1))
    table, rows, columns = np.zeros((4, 4)), np.zeros(ny), np.zeros(nx // 2 + 1)
    weight = waves.weight
    signed = 2 * np.arange(ny) != ny  # a wave of two pixels runs both ways

    def ring_sums(part: slice, density: Array) -> tuple[Array, Array, slice, Array, Array]:
        qy, qx = wave_numbers(waves, part)
        q = np.hypot(qy[:, None], qx[None, :])
        ring = np.digitize(q, edges).ravel()
        half = np.broadcast_to(0.5 * weight, q.shape).ravel()
        logs = np.log(np.maximum(q, 0.5 * edges[0])).ravel()
        values = half, half * density.ravel(), half * logs
        rings = np.array([np.bincount(ring, v, len(edges) + 1) for v in values], np.float64)
        table = _moment_table(qy, qx, density * weight / (size[0] * size[1]), signed[part])
        return rings, table, part, np.asarray(density @ weight), density.sum(axis=0)

    for more, moments, part, along_y, along_x in over_rows(ring_sums, waves.values):
        rings += more
        table += moments
        rows[part] = along_y
        columns += along_x
    count, power, place = rings[:, 1:-1]
    full = count > 0
    if waves.hann:
        density_y, density_x = waves.along(0), waves.along(1)
    else:
        opposite = rows[-np.arange(ny)]
        density_y, density_x = 0.5 * (rows + opposite) / size[1], columns / size[0]
    return Spectrum(
        q=np.exp(place[full] / count[full]),
        density=power[full] / count[full],
        modes=count[full] * (_HANN_MODES if waves.hann else 1.0),
        qx=2.0 * np.pi * fft.rfftfreq(nx, dx)[1:],
        density_x=density_x[1:],
        qy=2.0 * np.pi * fft.rfftfreq(ny, dy)[1:],
        density_y=density_y[1 : ny // 2 + 1],
        moments=SpectralMoments(
            m00=float(table[0, 0]),
            m20=float(table[0, 2]),
            m11=float(table[1, 1]),
            m02=float(table[2, 0]),
            m40=float(table[0, 3]),
            m22=float(table[2, 2]),
            m04=float(table[3, 0]),
        ),
        edge=_edge(waves, 2.0 * np.pi / min(size), nyquist),
        nyquist=float(nyquist),
        window="hann" if waves.hann else "none",
    )


def power_spectrum_2d(hm: HeightMap) -> tuple[Array, Array, Array]:
    """Wave numbers qy (ny,), qx (nx//2 + 1,) [rad/m] and density [m^4], shape (ny, nx//2 + 1).

    The half of the spectrum with qx >= 0, in the order of the discrete Fourier transform; see
    `power_spectrum` for the definition.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> x = np.arange(48) + 0.5
    >>> hm = surfaces.HeightMap(
    ...     np.tile(np.cos(2 * np.pi * x / 24), (32, 1)), 1.0, periodic=True
    ... )
    >>> qy, qx, density = surfaces.power_spectrum_2d(hm)
    >>> density.shape
    (32, 25)
    """
    require_map(hm)
    waves = density_of(hm.replace(heights=hm.heights))
    return *wave_numbers(waves, slice(None)), np.array(waves.values[:])


def _edge(waves: Density, width: float, nyquist: float) -> float:
    """Where the density falls by a thousand within six rings of `width` and stays there."""
    count = max(1, int(nyquist / width))

    def rings(part: slice) -> tuple[Array, Index]:
        qy, qx = wave_numbers(waves, part)
        q = np.hypot(qy[:, None], qx[None, :])
        return q, (q * TIED / width).astype(np.int64)

    def sums(part: slice, density: Array) -> Array:
        ring = rings(part)[1].ravel()
        found = (density * waves.weight).ravel(), np.tile(waves.weight, len(density))
        return np.stack([np.bincount(ring, v, count)[:count] for v in found])

    power, number = sum(over_rows(sums, waves.values), np.zeros((2, count)))
    power /= np.maximum(number, 1)
    beyond = np.maximum.accumulate(power[::-1])[::-1]
    cliffs = np.flatnonzero(beyond[9:] < 1e-3 * power[3:-6]) + 6
    if not cliffs.size:
        return float(nyquist)
    before = cliffs[0] - 3
    least = 0.05 * power[before]
    last = before + np.flatnonzero(power[before:] > least)[-1]

    def largest(part: slice, density: Array) -> float:
        q, ring = rings(part)
        return float(np.max(q, where=(ring <= last) & (density > least), initial=0.0))

    return max(over_rows(largest, waves.values))


def _moment_table(qy: Array, qx: Array, power: Array, signed: Mask) -> Array:
    """Sums of powers 0, 1, 2, 4 of the wave numbers along y and x over the variances of modes; the
    odd power along y of rows that are `signed`, as others hold both signs."""
    columns = np.stack([np.ones_like(qx), qx, qx**2, qx**4], axis=1)
    rows = np.stack([np.ones_like(qy), qy * signed, qy**2, qy**4], axis=0)
    return np.asarray(rows @ power @ columns)


def _ring_edges(lowest: float, nyquist: float) -> Array:
    """Limits of rings, 12 % wide but at least one fundamental wave number."""
    edges = [0.5 * lowest]
    while edges[-1] < nyquist:
        edges.append(max(edges[-1] * _RING, edges[-1] + lowest))
    return TIED * np.array([*edges[:-1], nyquist])
