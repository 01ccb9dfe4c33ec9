"""Two opposing hard fingers: forces by hand, the spin about their line loose, and what they cannot hold."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, Case, count, examine, frames, turn
from tests.support.friction_sets import corners, reach

C, SQUEEZE = (2e-4, 1e-4), 1e-3  # tangential and normal flexibility [m/N], squeeze of each finger [m]
PUSH = SQUEEZE / C[1]


def pinch(name, rng, faces, mu, side, push=0.0, spin=0.0, answer="solvable"):
    """A load `side` (2,) N in the tangent plane, the same axes for both fingers, `push` N along their line, `spin` N·m
    about it. Equal springs share the load: half the side force each, the push moves half of itself across.
    """
    Q, c = turn(rng), rng.uniform(-0.1, 0.1, 3)
    z = np.array([Q[:, 0], -Q[:, 0]])
    p = c - 0.03 * z
    R = frames(z, np.tile(Q[:, 1], (2, 1)))
    force = R[0] @ np.r_[side, push]
    w = np.r_[force, np.cross(c, force) + spin * Q[:, 0]]
    f = np.zeros((2, 3))
    half = -(R[0][:, :2] @ np.asarray(side, float)) / 2
    f[0], f[1] = R[0].T @ half + [0, 0, PUSH - push / 2], R[1].T @ half + [0, 0, PUSH + push / 2]
    d = np.tile([0.0, 0.0, -SQUEEZE], (2, 1))
    known = f if answer == "solvable" else None
    return Case(name, p, R, np.full(2, mu), np.diag(np.tile([C[0], C[0], C[1]], 2)), d, w, faces, None, answer, known)


def _towards(rng, faces, corner):
    """A unit direction: at a corner of the polygon (the same for both fingers' mirrored axes), or a side's middle."""
    if faces == "cone":
        a = rng.uniform(0, 2 * np.pi)
        return np.array([np.cos(a), np.sin(a)])
    k = int(rng.integers(faces))
    return corners(faces)[k] if corner else np.array([np.cos(2 * np.pi * k / faces), np.sin(2 * np.pi * k / faces)])


def _family(tag, share, **more):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([30 + tag, i])
            mu = float(rng.choice([0.02, 0.3, 0.8]))
            limit = 2 * PUSH * reach(mu, faces)
            yield pinch(f"{i}", rng, faces, mu, share * limit * _towards(rng, faces, i % 2), **more)

    return cases


def pushed(faces, k):
    """A push along the line on top, as far as the weaker finger still sticks."""
    for i in range(k):
        rng = np.random.default_rng([35, i])
        mu = float(rng.uniform(0.1, 1))
        push = rng.uniform(-1, 1) * PUSH
        limit = 2 * (PUSH - abs(push) / 2) * reach(mu, faces)
        yield pinch(f"{i}", rng, faces, mu, 0.9 * limit * _towards(rng, faces, i % 2), push)


FAMILIES = {
    "two: well inside": _family(0, 0.5),
    "two: on the limit": _family(1, 1.0),
    "two: 1e-9 inside the limit": _family(2, 1 - 1e-9),
    "two: beyond the limit": _family(3, 1.001, answer="no equilibrium"),
    "two: far beyond": _family(4, 20.0, answer="no equilibrium"),
    "two: spun": _family(6, 0.5, spin=1e-2, answer="not holdable"),
    "two: pushed": pushed,
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_a_pinch_is_what_its_springs_say(family, faces):
    """Forces as by hand inside and on the limit; beyond it no answer is made up; a spin is proven an escape."""
    examine(FAMILIES[family](faces, count(4))).demand()
