"""Fingers from 1e-12 to 1 m/N, and 1e8 apart in one hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, backwards, count, examine, fingers


def uniform(faces, k):
    """All fingers alike, between steel and rubber band; forces of some newtons."""
    for i in range(k):
        rng = np.random.default_rng([1, i])
        n = int(rng.integers(3, 7))
        scale = 10.0 ** np.linspace(-8, 4, 7)[i % 7]  # times 1e-4 m/N
        p, R = around(rng, n)
        yield backwards(f"{i}: {1e-4 * scale:.0e} m/N", rng, p, R, 0.5, fingers(rng, n) * scale, faces)


def spread(faces, k, family, travel, what=None):
    """Hands whose fingers differ by 1e8; `what` all of them do."""
    for i in range(k):
        rng = np.random.default_rng([family, i])
        n = int(rng.integers(3, 7))
        size = np.repeat(10.0 ** (rng.permutation(np.linspace(-4, 4, n)) / 2), 3)
        p, R = around(rng, n)
        E = fingers(rng, n) * np.outer(size, size)
        yield backwards(f"{i}", rng, p, R, 0.6, E, faces, None if what is None else [what] * n, travel=travel)


def apart(faces, k):
    """Neighbours that differ by 1e8 in the hand, each bent by forces of some newtons of its own."""
    return spread(faces, k, 2, 1e-5)


def stuck_apart(faces, k):
    """The same, where every finger sticks and the object moves by what the stiffest allows."""
    return spread(faces, k, 3, 1e-8, "stick")


FAMILIES = {"flexibility: uniform": uniform, "flexibility: apart": apart, "flexibility: stuck apart": stuck_apart}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_any_stiffness_is_solved(family, faces):
    """A solution was built in: it, or another that obeys every law, is found at any stiffness."""
    examine(FAMILIES[family](faces, count(4))).demand()
