"""Planar scenes, in whatever plane they lie."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, backwards, count, examine, frames, springs, turn


def _flat(rng, n, plane):
    a = plane[:, 0]
    t = 2 * np.pi * (np.arange(n) + 0.2 * rng.uniform(-1, 1, n)) / n
    out = np.outer(np.cos(t), a) + np.outer(np.sin(t), plane[:, 1])
    z = -out + 0.3 * rng.normal(size=(n, 1)) * np.cross(plane[:, 2], out)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return 0.03 * out + rng.uniform(-0.1, 0.1, 3), frames(z, np.cross(plane[:, 2], z))


def _planes(rng, i):
    fixed = [np.eye(3), np.eye(3)[:, [1, 0, 2]] * [1, 1, -1], np.eye(3)[:, [1, 2, 0]]]
    return fixed[i] if i < 3 else turn(rng)


def built(faces, k):
    """Backwards, all states; joints that bend in the plane and pads."""
    for i in range(k):
        rng = np.random.default_rng([110, i])
        n, Q = int(rng.integers(2, 7)), _planes(rng, i)
        p, R = _flat(rng, n, Q)
        E = np.diag(np.tile([2e-4, 2e-4, 1e-4], n))
        for j in range(n):
            J = np.zeros((3, 2))
            J[[0, 2]] = 0.05 * rng.normal(size=(2, 2))
            E[3 * j : 3 * j + 3, 3 * j : 3 * j + 3] += J @ J.T
        yield backwards(f"{i}", rng, p, R, rng.uniform(0, 1, n), E, faces, plane=Q[:, 2])


def sprung(faces, k):
    """By formula, without and with squeeze."""
    for i in range(k):
        rng = np.random.default_rng([111, i])
        n, Q = int(rng.integers(2, 7)), _planes(rng, i)
        p, R = _flat(rng, n, Q)
        d = np.zeros((n, 3))
        d[:, 2] = -rng.choice([0.0, 1e-3])
        u = 1e-3 * np.r_[Q[:, :2] @ rng.normal(size=2), Q[:, 2] * rng.normal() / 0.03]
        yield springs(f"{i}", p, R, 0.5, (2e-4, 1e-4), faces, d, u, plane=Q[:, 2])


FAMILIES = {"planar: built": built, "planar: springs": sprung}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_planar_scenes_are_solved(family, faces):
    """In xy, upside down, on edge and askew: an answer exists by construction and is found."""
    examine(FAMILIES[family](faces, count(6))).demand()
