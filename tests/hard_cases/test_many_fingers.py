"""From one finger to forty."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, backwards, ball, count, examine, fingers

NUMBERS = (1, 2, 3, 6, 10, 16, 25, 40)


def _family(tag, place, states):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([90 + tag, i])
            n = NUMBERS[i % len(NUMBERS)]
            p, R = place(rng, n)
            E = fingers(rng, n, shared=i % 2 == 0)
            yield backwards(f"{i}: {n} fingers", rng, p, R, 0.5, E, faces, rng.choice(states, n))

    return cases


FAMILIES = {
    "number: stick or open": _family(0, around, ["stick", "open"]),
    "number: any state": _family(1, ball, ["stick", "slide", "corner", "limit", "touch", "open"]),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_any_number_of_fingers_is_solved(family, faces):
    """One finger to forty, with an answer by construction."""
    examine(FAMILIES[family](faces, count(8))).demand()
