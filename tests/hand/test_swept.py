"""Swept balls: the nearest station beside a search over all of them, and how contacts move beside differences."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from tests.support.hand import swept_contacts, swept_station

OBJECTS = [
    hl.Sphere(0.03), hl.Box((0.05, 0.04, 0.06)), hl.Cylinder(0.03, 0.08), hl.Ellipsoid((0.02, 0.03, 0.05)),
]  # fmt: skip


def drawn(rng, lines):
    """Centre, spans and radius of a swept ball beside an object."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    spans = np.zeros((2, 3))
    spans[:lines] = (axes[:, :lines] * rng.uniform(0.005, 0.03, lines)).T
    way = rng.normal(size=3)
    return 0.09 * way / np.linalg.norm(way), spans, rng.uniform(0.0, 0.01)


@pytest.mark.parametrize("obj", OBJECTS, ids=lambda o: type(o).__name__)
@pytest.mark.parametrize("lines", [1, 2])
def test_no_station_is_nearer_than_the_one_found(obj, lines):
    rng = np.random.default_rng(3)
    for _ in range(8):
        centre, spans, _ = drawn(rng, lines)
        found = obj.closest(swept_station(obj, centre, spans))[0]
        grid = np.linspace(-1.0, 1.0, 21)
        every = [
            obj.closest(centre + s * spans[0] + t * spans[1])[0] for s in grid for t in (grid if lines > 1 else (0.0,))
        ]
        assert found <= min(every) + 1e-9


@pytest.mark.parametrize("obj", [OBJECTS[0], OBJECTS[2], OBJECTS[3]], ids=lambda o: type(o).__name__)
@pytest.mark.parametrize("lines", [0, 1, 2])
def test_contacts_turn_and_shift_as_differences_of_them_do(obj, lines):
    rng = np.random.default_rng(5)
    for _ in range(6):
        centre, spans, radius = drawn(rng, lines)
        place, turn = rng.normal(size=3) * 0.01, pin.exp3(rng.normal(size=3))
        swept = turn.T @ (centre - place), spans @ turn, radius
        _, _, _, dn, dx = swept_contacts(obj, swept, place, turn)
        h = 1e-6
        for a in range(6):
            by = np.zeros(3)
            by[a % 3] = h
            ends = []
            for sign in (1.0, -1.0):
                moved = (place + sign * by, turn) if a < 3 else (place, pin.exp3(sign * by) @ turn)
                ends.append(swept_contacts(obj, swept, *moved))
            x, n = ((ends[0][k] - ends[1][k]) / (2 * h) for k in (0, 1))
            np.testing.assert_allclose(dn[:, a], n, atol=2e-3 * (1 + abs(n).max()))
            np.testing.assert_allclose(dx[:, a], x, atol=2e-3 * (1 + abs(x).max()))
