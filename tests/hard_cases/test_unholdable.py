"""Loads outside all cones: refused with a motion whose signs prove it; loads just inside are not refused."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, Case, count, examine, fingers, frames, turn
from tests.support.friction_sets import corners, reach


def one_sided(faces, k):
    """Every force has a part along an axis, and so has the load."""
    for i in range(k):
        rng = np.random.default_rng([100, i])
        n, mu = int(rng.integers(1, 7)), rng.uniform(0, 0.8)
        axis = turn(rng)[0]
        side = np.cross(axis, rng.normal(size=(n, 3)))
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        tilt = rng.uniform(0, 0.95, (n, 1)) * (np.pi / 2 - np.arctan(mu))
        z = np.cos(tilt) * axis + np.sin(tilt) * side
        p = -0.03 * z + rng.uniform(-0.1, 0.1, 3)
        w = np.r_[rng.normal(size=3), 0.01 * rng.normal(size=3)]
        w[:3] += (abs(w[:3] @ axis) + 1) * axis
        E = fingers(rng, n)
        d = np.tile([0, 0, -1e-3], (n, 1))
        yield Case(f"{i}", p, frames(z, rng=rng), np.full(n, mu), E, d, w, faces, answer="not holdable")


def _table(tag, share, answer, squeeze=0.0):
    """Props under a plate, all alike, pushed sideways through their plane with `share` of what friction allows."""

    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([101 + tag, i])
            n, mu, weight = int(rng.integers(3, 7)), float(rng.choice([1e-3, 0.3, 2.0])), 10.0
            Q, c = turn(rng), rng.uniform(-0.1, 0.1, 3)
            t = 2 * np.pi * np.arange(n) / n
            p = 0.03 * np.column_stack([np.cos(t), np.sin(t), 0 * t]) @ Q.T + c
            R = frames(np.tile(Q[:, 2], (n, 1)), np.tile(Q[:, 0], (n, 1)))
            if faces == "cone":
                a = rng.uniform(0, 2 * np.pi)
                towards = np.array([np.cos(a), np.sin(a)])
            else:
                j, C = int(rng.integers(faces)), corners(faces)
                towards = C[j] if i % 2 else (C[j] + C[j - 1]) / 2
            force = R[0] @ np.r_[share * reach(mu, faces) * weight * towards, -weight]
            w = np.r_[force, np.cross(c, force)]
            E = np.diag(np.tile([2e-4, 2e-4, 1e-4], n))
            yield Case(f"{i}", p, R, np.full(n, mu), E, np.zeros((n, 3)), w, faces, answer=answer)

    return cases


def frictionless(faces, k):
    """Nothing without friction resists a load in the tangent plane of all contacts."""
    for i in range(k):
        rng = np.random.default_rng([105, i])
        n, Q = int(rng.integers(2, 8)), turn(rng)
        t = 2 * np.pi * np.arange(n) / n
        out = np.column_stack([np.cos(t), np.sin(t), 0 * t]) @ Q.T
        w = np.r_[rng.uniform(0.1, 1) * Q[:, 2] + 0.1 * Q[:, 0], np.zeros(3)]
        d = np.tile([0, 0, -1e-3], (n, 1))
        R = frames(-out, rng=rng)
        yield Case(f"{i}", 0.03 * out, R, np.zeros(n), fingers(rng, n), d, w, faces, answer="not holdable")


def pulled(faces, k):
    """One finger, and the load away from it."""
    for i in range(k):
        rng = np.random.default_rng([106, i])
        z = turn(rng)[:1]
        c = rng.uniform(-0.1, 0.1, (1, 3))
        f = 10.0 ** rng.uniform(-6, 6) * z[0]
        R = frames(z, rng=rng)
        w = np.r_[f, np.cross(c[0], f)]
        yield Case(f"{i}", c, R, np.array([0.5]), fingers(rng, 1), np.zeros((1, 3)), w, faces, answer="not holdable")


FAMILIES = {
    "unholdable: one-sided": one_sided,
    "unholdable: table, 1.01 of the limit": _table(0, 1.01, "not holdable"),
    "unholdable: table, 20 of the limit": _table(1, 20.0, "not holdable"),
    "holdable: table, 0.99 of the limit": _table(2, 0.99, "solvable"),
    "holdable: table, on the limit": _table(3, 1.0, "solvable"),
    "unholdable: frictionless": frictionless,
    "unholdable: pulled": pulled,
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_what_escapes_is_proven_and_nothing_else(family, faces):
    """NOT_HOLDABLE with a certificate that holds by its signs; SOLVED as long as friction allows it."""
    examine(FAMILIES[family](faces, count(4))).demand()
