"""Contacts at one point, twice the same, on a line, in a plane, and a hair's breadth from that."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, backwards, ball, count, examine, fingers, frames, turn


def _case(tag, i, faces, place, mu=0.5, states=None):
    rng = np.random.default_rng([20 + tag, i])
    p, R = place(rng)
    return backwards(f"{i}", rng, p, R, mu, fingers(rng, len(p)), faces, states)


def _coincident(rng):
    n = int(rng.integers(2, 6))
    p, R = ball(rng, n)
    return np.tile(p[:1], (n, 1)), R


def _duplicated(rng):
    n = int(rng.integers(2, 4))
    p, R = around(rng, n)
    return np.repeat(p, 2, axis=0), np.repeat(R, 2, axis=0)


def _collinear(rng):
    n = int(rng.integers(2, 6))
    along = turn(rng)[0]
    p = rng.uniform(-0.03, 0.03, (n, 1)) * along + rng.uniform(-0.1, 0.1, 3)
    return p, frames(rng.normal(size=(n, 3)), rng=rng)


def _coplanar(hair):
    def place(rng):
        n, Q = int(rng.integers(3, 7)), turn(rng)
        flat = np.column_stack([rng.uniform(-0.03, 0.03, (n, 2)), hair * rng.normal(size=n)])
        z = np.column_stack([hair * 30 * rng.normal(size=(n, 2)), np.ones(n) * rng.choice([-1, 1], n)])
        return flat @ Q.T + rng.uniform(-0.1, 0.1, 3), frames(z @ Q.T, rng=rng)

    return place


def _family(tag, place, **more):
    return lambda faces, k: (_case(tag, i, faces, place, **more) for i in range(k))


FAMILIES = {
    "places: coincident": _family(0, _coincident),
    "places: duplicated": _family(1, _duplicated),
    "places: collinear": _family(2, _collinear),
    "places: coplanar": _family(3, _coplanar(0.0)),
    "places: coplanar but 1e-12 m": _family(4, _coplanar(1e-12)),
    "places: coplanar but 1e-8 m": _family(5, _coplanar(1e-8)),
    "places: waist without slopes": _family(6, lambda rng: around(rng, int(rng.integers(3, 7)), rough=0.0)),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_degenerate_places_are_solved(family, faces):
    """Where contacts lie must not matter to whether the built-in answer, or another, is found."""
    examine(FAMILIES[family](faces, count(4))).demand()
