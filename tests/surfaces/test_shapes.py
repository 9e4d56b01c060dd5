"""Test bodies: their sections are what their names say."""

from __future__ import annotations

import numpy as np
import pytest

from surfaces import InputError
from surfaces.shapes import (
    bent_body,
    cosine_polygon,
    deviation,
    polygon,
    random_polygon,
    random_section,
    rounded_polygon,
    section,
)

TURN = 2 * np.pi * np.arange(720) / 720


@pytest.mark.parametrize("sides", [3, 4, 5, 8])
def test_means_of_the_polygon_factor(sides):
    n = sides
    assert polygon(n).psi(TURN).mean() == pytest.approx(n / np.pi * np.sin(np.pi / n), rel=1e-4)
    square = polygon(n, 2).psi(TURN).mean()
    assert square == pytest.approx(0.5 + n / (4 * np.pi) * np.sin(2 * np.pi / n), rel=1e-4)
    np.testing.assert_allclose(cosine_polygon(n, 2).psi(TURN), polygon(n).psi(TURN))


@pytest.mark.parametrize("k", [1.0, 2.0])
def test_level_lines_of_the_square_are_straight(k):
    body = polygon(4, k)
    y = np.linspace(-0.9, 0.9, 11)
    np.testing.assert_allclose(body(np.hypot(1.0, y), np.arctan2(y, 1.0)), 1.0, rtol=1e-12)


def test_rounded_polygon_lies_between_the_polygon_and_its_circle():
    sharp, round_ = polygon(5), rounded_polygon(5, corner=0.4)
    assert np.all(round_.psi(TURN) >= sharp.psi(TURN) - 1e-12)
    assert np.all(round_.psi(TURN) <= 1 + 1e-12)
    np.testing.assert_allclose(rounded_polygon(5, corner=1.0).psi(TURN), 1.0)
    np.testing.assert_allclose(rounded_polygon(5, corner=0.0).psi(TURN), sharp.psi(TURN))
    assert rounded_polygon(5, corner=0.0).corners == sharp.corners and round_.corners == ()
    step = np.diff(round_.psi(np.linspace(0, 7, 20001)))
    assert np.max(np.abs(np.diff(step))) < 1e-6


def test_random_sections_have_the_wanted_deviation():
    for seed in range(5):
        body = random_section(1.0, deviation=0.15, seed=seed)
        assert deviation(body) == pytest.approx(0.15, rel=1e-3)


def test_random_polygons_are_convex_with_kinks_only_at_their_corners():
    body = random_polygon(1.0, seed=3)
    corners = np.array(body.corners)
    e = 1e-6
    kink = (body.psi(corners + e) - 2 * body.psi(corners) + body.psi(corners - e)) / e
    assert np.all(kink > 0.01)
    smooth = TURN[np.min(np.abs(np.angle(np.exp(1j * (TURN[:, None] - corners)))), axis=1) > 0.01]
    fine = (body.psi(smooth + e) - 2 * body.psi(smooth) + body.psi(smooth - e)) / e
    assert np.max(np.abs(fine)) < 1e-4


@pytest.mark.parametrize(("sides", "seed"), [(3, 34), (7, 3), (12, 0), (40, 0)])
def test_random_polygons_are_closed_and_straight_between_their_corners(sides, seed):
    """Of many faces some lie outside the others; a face is A cos(phi) + B sin(phi)."""
    body = random_polygon(1.0, sides=sides, seed=seed)
    first = np.sort(np.mod(body.corners, 2 * np.pi))
    half = 0.5 * np.mod(np.roll(first, -1) - first, 2 * np.pi)
    ends = body.psi(first) + body.psi(first + 2 * half)
    np.testing.assert_allclose(ends, 2 * np.cos(half) * body.psi(first + half), rtol=1e-12)
    assert body.psi(TURN).min() > 0.0


def test_bent_body_and_given_sections_are_positive():
    assert np.all(bent_body()(np.linspace(0.01, 3, 50)[:, None], TURN) > 0)
    star = section(lambda phi: 1 + 0.2 * np.cos(5 * phi), 2.0)
    np.testing.assert_allclose(star(1 + 0.2 * np.cos(5 * TURN), TURN), 1.0)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: polygon(2), "3 to 1000 sides"),
        (lambda: polygon(3.5), "sides is 3.5"),
        (lambda: random_section(1.0, deviation=0.1, seed=1.5), "seed is 1.5"),
        (lambda: rounded_polygon(4, corner=1.5), "corner must lie"),
        (lambda: random_section(1.0, deviation=2.0), "makes psi negative"),
    ],
)
def test_impossible_shapes_are_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()
