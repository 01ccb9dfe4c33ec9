"""Elastic fingers beside something rigid that sticks: a ball that rolls on a table, a box that stands on one."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, STATES, around, backwards, count, examine, fingers, turn


def _family(tag, least, most, rolls, supports):
    """Fingers in any state beside `least` to `most` rigid supports in one of the states `supports`."""

    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([tag, i])
            n, m = int(rng.integers(2, 6)), int(rng.integers(least, most + 1))
            p, R = around(rng, n)
            floor = turn(rng)
            below = p.mean(0) + 0.03 * _corners(rng, m) @ floor.T
            p, R = np.concatenate([p, below]), np.concatenate([R, np.tile(floor, (m, 1, 1))])
            E = np.zeros((3 * (n + m), 3 * (n + m)))
            pads = (2e-4, 2e-4, 1e-4) if i % 3 else (0.0, 0.0, 0.0)
            E[: 3 * n, : 3 * n] = fingers(rng, n, pad=pads) * 10.0 ** rng.uniform(-3, 1)
            states = [*rng.choice(STATES, n), *rng.choice(supports, m)]
            travel = float(np.trace(E)) / (3 * n)
            twist = travel * np.r_[np.zeros(3), rng.normal(size=3) / 0.03] if rolls else np.zeros(6)
            if rolls:  # about the one support
                twist[:3] = -np.cross(twist[3:], p[-1] - p.mean(0))
            yield backwards(f"{i}", rng, p, R, rng.uniform(0.1, 1, n + m), E, faces, states, travel=travel, twist=twist)

    return cases


def _corners(rng, m):
    """(m, 3) corners of a rectangle one below the origin, or the point below it."""
    if m == 1:
        return np.array([[0.0, 0.0, -1.0]])
    return np.array([[1.0, 1, -1], [-1, 1, -1], [-1, -1, -1], [1, -1, -1]])[:m] * [*rng.uniform(0.5, 1, 2), 1]


FAMILIES = {
    "rigid: a ball rolls": _family(201, 1, 1, True, ["stick"]),
    "rigid: a box stands": _family(202, 2, 4, False, ["stick"]),
    "rigid: any state": _family(203, 1, 4, False, ["stick", "limit", "touch"]),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_a_rigid_support_that_sticks_is_solved(family, faces):
    """A motion of rounding alone at a support that nothing bends is no motion."""
    examine(FAMILIES[family](faces, count(6))).demand()
