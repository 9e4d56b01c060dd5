"""Area, patches and contours of a contact map."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import edges_by_hand, labels_by_hand

from asperity.bem import solution
from surfaces.patches import label_patches


def read(contact, spacing, periodic):
    """`read_contact` of a map, with more columns than it has."""
    pressure = np.ones((contact.shape[0], contact.shape[1] + 2))
    pressure[:, :-2] = contact
    return solution.read_contact(pressure, spacing, contact.shape[1], np.inf, periodic=periodic)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("filling", [0.0, 0.1, 0.3, 0.5, 0.65, 0.97, 1.0])
def test_patches_match_a_flood_fill(periodic, filling):
    """Same partition, labels without gaps in order of first pixel."""
    contact = np.random.default_rng(5).random((23, 31)) < filling
    labels, count = label_patches(contact, periodic=periodic)
    expected, number = labels_by_hand(contact, periodic)
    assert count == number == labels.max()
    raw, corrected, patches = read(contact, (0.5, 2.0), periodic)
    assert (raw, patches) == (contact.sum(), number)
    edge = solution.AREA_FACTOR * edges_by_hand(contact, periodic)
    assert corrected == pytest.approx(max(raw - edge, 0.0), rel=1e-12)
    pairs = np.unique(np.stack([labels[contact], expected[contact]]), axis=1)
    assert pairs.shape[1] == number
    assert not labels[~contact].any()


def test_area_of_a_disc():
    """Corrected area of a disc is right to a small part of the pixel bias of a BEM contact."""
    n = 400
    y, x = (np.indices((n, 2 * n)) + 0.5) * np.array([2.0, 1.0])[:, None, None]
    radius = 90.0
    disc = (x - 397.3) ** 2 + (y - 402.1) ** 2 < radius**2
    raw, corrected, _ = read(disc, (2.0, 1.0), False)
    assert raw == pytest.approx(np.pi * radius**2, rel=1e-3)
    edges = edges_by_hand(disc, False)
    assert edges == pytest.approx(8 * radius * 0.75, rel=0.02)
    assert raw - corrected == pytest.approx((np.pi - 1 + np.log(2)) / 24 * edges * 2.0)


@pytest.mark.parametrize("periodic", [False, True])
def test_full_contact_has_no_edge(periodic):
    """Nothing is taken off a closed contact: that of a punch ends where its pixels do."""
    full = np.ones((6, 9), bool)
    assert read(full, (1.0, 2.0), periodic) == (108.0, 108.0, 1)


@pytest.mark.parametrize("centre", [0.0, 30.4])
def test_area_of_half_a_disc_at_the_border(centre):
    """Half of a disc that the border cuts has half of its edge."""
    y, x = np.indices((100, 120)) + 0.5
    for radius in (20.0, 24.3):
        disc = (x - 60.2) ** 2 + (y - centre) ** 2 < radius**2
        raw, corrected, _ = read(disc, (1.0, 1.0), False)
        share = 0.5 if centre == 0.0 else 1.0
        edge = (np.pi - 1 + np.log(2)) / 24 * 8 * radius * share
        assert raw - corrected == pytest.approx(edge, rel=0.05)


def test_contours_enclose_their_patches():
    """One outline per patch (and per hole), in metres."""
    contact = np.zeros((20, 30), bool)
    contact[3:9, 4:12] = True
    contact[14:17, 20:25] = True
    found = solution.contours(contact, (0.5, 0.25))
    assert len(found) == 2
    box = sorted(tuple(np.ptp(outline, axis=0)) for outline in found)
    assert box == [(4 * 0.25, 2 * 0.5), (7 * 0.25, 5 * 0.5)]
