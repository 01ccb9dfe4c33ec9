"""No preload at all, gaps to be closed, and preload a million times the load."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, count, examine, springs


def _family(tag, offset, twist=1e-3, rough=1.0):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([70 + tag, i])
            n = int(rng.integers(3, 7))
            p, R = around(rng, n, rough=rough)
            d = np.zeros((n, 3))
            d[:, 2] = offset(rng, n)
            soft = np.tile([2e-4, 1e-4], (n, 1)) * 10.0 ** rng.uniform(-0.5, 0.5, (n if rough else 1, 1))
            u = twist * np.r_[rng.normal(size=3), rng.normal(size=3) / 0.03]
            yield springs(f"{i}", p, R, rng.uniform(0.3, 1), soft, faces, d, u)

    return cases


FAMILIES = {
    "preload: none": _family(0, lambda rng, n: 0.0),
    "preload: gaps": _family(1, lambda rng, n: rng.uniform(0, 1e-3, n)),
    "preload: some": _family(2, lambda rng, n: -rng.uniform(0, 2e-3, n)),
    # equal squeeze of equal springs, evenly around: the load is what a motion of a millionth of the squeeze calls for
    "preload: a million times the load": _family(3, lambda rng, n: -1e-2, twist=1e-8, rough=0.0),
    "preload: 1e9 times the load": _family(4, lambda rng, n: -1e-2, twist=1e-11, rough=0.0),
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_any_preload_is_solved(family, faces):
    """Springs give the answer by formula; it, or another that obeys every law, is found."""
    examine(FAMILIES[family](faces, count(5))).demand()
