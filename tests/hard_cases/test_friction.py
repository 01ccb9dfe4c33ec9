"""Coefficients from none to ten, alone and together in one hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, backwards, ball, count, examine, fingers


def _family(tag, mu):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([50 + tag, i])
            n = int(rng.integers(3, 7))
            p, R = (around, ball)[i % 2](rng, n)
            yield backwards(f"{i}", rng, p, R, mu(rng, n), fingers(rng, n), faces)

    return cases


FAMILIES = {
    "friction: 1e-6": _family(0, lambda rng, n: 1e-6),
    "friction: 0.02": _family(1, lambda rng, n: 0.02),
    "friction: 1": _family(2, lambda rng, n: 1.0),
    "friction: 10": _family(3, lambda rng, n: 10.0),
    "friction: 0, 1e-6, 0.02, 0.5, 10": _family(4, lambda rng, n: rng.choice([0.0, 1e-6, 0.02, 0.5, 10.0], n)),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_any_coefficient_is_solved(family, faces):
    """The built-in answer, or another that obeys every law, is found at any coefficient."""
    examine(FAMILIES[family](faces, count(4))).demand()
