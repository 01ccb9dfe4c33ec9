"""Fingers without pads: two joints leave a direction rigid, a straight finger two, a rigid one all three."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, backwards, count, examine, fingers


def _family(tag, rank):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([10 + tag, i])
            n = int(rng.integers(3, 7))
            p, R = around(rng, n)
            r = rank(rng, n)
            E = np.zeros((3 * n, 3 * n))
            for j in range(n):
                b = slice(3 * j, 3 * j + 3)
                E[b, b] = fingers(rng, 1, int(r[j]), pad=(0, 0, 0)) if r[j] else 0.0
            yield backwards(f"{i}", rng, p, R, 0.5, E, faces)

    return cases


FAMILIES = {
    "no pads: two joints": _family(0, lambda rng, n: np.full(n, 2)),
    "no pads: straight fingers": _family(1, lambda rng, n: np.full(n, 1)),
    "no pads: rigid": _family(2, lambda rng, n: np.zeros(n)),
    "no pads: a mixture": _family(3, lambda rng, n: rng.integers(0, 4, n)),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_singular_flexibility_is_solved(family, faces):
    """E may be singular, or zero: forces may then be undetermined, but an answer exists and is found."""
    examine(FAMILIES[family](faces, count(4))).demand()
