"""Forces exactly on the friction limit, gaps exactly zero, and both at once."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, backwards, count, examine, fingers


def _family(tag, states, shared=True):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([60 + tag, i])
            n = int(rng.integers(3, 7))
            p, R = around(rng, n)
            here = [states[j % len(states)] for j in range(n)]
            yield backwards(f"{i}", rng, p, R, rng.uniform(0.3, 1, n), fingers(rng, n, shared=shared), faces, here)

    return cases


FAMILIES = {
    "limits: all on the limit": _family(0, ["limit"]),
    "limits: some at rest": _family(1, ["stick", "touch"]),
    "limits: all at rest": _family(2, ["touch"]),
    "limits: limit, rest, stick": _family(3, ["limit", "touch", "stick"]),
    "limits: limit, graze, corner": _family(4, ["limit", "graze", "corner"]),
    "limits: all slide": _family(5, ["slide", "corner"]),
    "limits: all at corners": _family(6, ["corner"]),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_degenerate_states_are_solved(family, faces):
    """Complementary pairs that are both zero at the answer keep nobody from finding it, or another."""
    examine(FAMILIES[family](faces, count(6))).demand()
