"""No load, loads of 1e-9 and of 1e9 newtons."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, Case, around, backwards, ball, count, examine, fingers


def _scaled(tag, force):
    def cases(faces, k):
        for i in range(k):
            rng = np.random.default_rng([80 + tag, i])
            n = int(rng.integers(3, 7))
            p, R = (around, ball)[i % 2](rng, n)
            yield backwards(f"{i}", rng, p, R, 0.5, fingers(rng, n), faces, force=force)

    return cases


def tiny_load_on_a_firm_grasp(faces, k):
    """Preload of some newtons that balances by itself; then 1e-9 N more: it must not become an error."""
    for i in range(k):
        rng = np.random.default_rng([83, i])
        n = int(rng.integers(3, 7))
        p, R = around(rng, n, rough=0.0)
        d = np.tile([0.0, 0.0, -1e-3], (n, 1))
        f = rng.normal(size=3) * 1e-9
        w = np.r_[f, np.cross(p.mean(0), f)]
        yield Case(f"{i}", p, R, np.full(n, 0.5), np.diag(np.tile([2e-4, 2e-4, 1e-4], n)), d, w, faces)


def zero(faces, k):
    """No load on an even squeeze: each finger pushes by its own, nothing moves. Without squeeze nothing at all."""
    for i in range(k):
        rng = np.random.default_rng([84, i])
        n = int(rng.integers(2, 7))
        p, R = around(rng, n, rough=0.0)
        squeeze = [1e-3, 0.0, -1e-3][i % 3]
        d = np.tile([0.0, 0.0, -squeeze], (n, 1))
        f = np.tile([0.0, 0.0, max(squeeze, 0.0) / 1e-4], (n, 1))
        E = np.diag(np.tile([2e-4, 2e-4, 1e-4], n))
        yield Case(f"{i}", p, R, np.full(n, 0.5), E, d, np.zeros(6), faces, forces=f if squeeze != 0 else None)


FAMILIES = {
    "wrench: 1e-9 N": _scaled(0, 1e-9),
    "wrench: 1e9 N": _scaled(1, 1e9),
    "wrench: 1e-9 N on a firm grasp": tiny_load_on_a_firm_grasp,
    "wrench: zero": zero,
}


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("family", FAMILIES)
def test_any_load_is_solved(family, faces):
    """Loads over eighteen decades, and none: an answer exists by construction and is found."""
    examine(FAMILIES[family](faces, count(4))).demand()
