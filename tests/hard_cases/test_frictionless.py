"""No friction anywhere: with pads the forces are unique (a convex problem), and they are the built-in ones."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, backwards, ball, count, examine, fingers, frames


def _irregular(rng, n):
    p, R = ball(rng, n)
    return p, frames(R[:, :, 2] + 0.6 * rng.normal(size=(n, 3)), rng=rng)


def _family(tag, states, least=7, most=10, pads=True):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([40 + tag, i])
            n = int(rng.integers(least, most))
            p, R = _irregular(rng, n)
            E = fingers(rng, n, pad=(2e-4, 2e-4, 1e-4) if pads else (0, 0, 0))
            yield backwards(f"{i}", rng, p, R, 0.0, E, faces, rng.choice(states, n), unique=pads)

    return cases


FAMILIES = {
    "frictionless: all push": _family(0, ["slide"]),
    "frictionless: some open": _family(1, ["slide", "open"]),
    "frictionless: some at rest": _family(2, ["slide", "touch", "graze", "open"]),
    "frictionless: few fingers": _family(3, ["slide"], 1, 6),
    "frictionless: no pads": _family(4, ["slide", "touch", "open"], pads=False),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_forces_without_friction_are_the_unique_ones(family, faces):
    """Found, and equal to the built-in forces wherever E is definite."""
    examine(FAMILIES[family](faces, count(4))).demand()
