"""Pyramids of three to a hundred and twenty-eight faces."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import around, backwards, count, examine, fingers

MANY = (3, 5, 6, 7, 12, 24, 32, 64, 128)


def built(m, k):
    """Backwards from a solution, states drawn at random, sides and corners of the polygon included."""
    for i in range(k):
        rng = np.random.default_rng([120, m, i])
        n = int(rng.integers(3, 7))
        p, R = around(rng, n)
        yield backwards(f"{m} faces, {i}", rng, p, R, 0.5, fingers(rng, n), m)


def every(faces, k):
    """For the table: one scene in turn of each number of faces, whatever `faces` says, at 4 only."""
    if faces == 4:
        for m in MANY:
            yield from built(m, max(1, k // 3))


FAMILIES = {"faces: 3 to 128 (in column 4)": every}


@pytest.mark.parametrize("m", MANY)
def test_any_number_of_faces_is_solved(m):
    """The built-in answer, or another that obeys every law of that very polygon."""
    examine(built(m, count(3))).demand()
