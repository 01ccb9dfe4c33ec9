"""`required_friction` and `required_preload` say what `solve` says: the value holds, what it names as failing does not,
and neither does half of that where the claim is proven.
"""

import os

import numpy as np
import pytest

import handlcp as hl
from tests.support.grasp import with_friction, with_preload

KINDS = ("spatial", "planar", "soft", "environment")
# Those of the first hundred where a search of a tenth of a second overlooked an equilibrium just below the value
FOUND = [("spatial", 13, "friction"), ("soft", 1, "preload")]
LONG = [("spatial", 7, "friction"), ("soft", 2, "friction"), ("soft", 21, "friction")]
FEW = [(kind, seed, what) for kind in KINDS for seed in (4,) for what in ("friction", "preload")]
MANY = [(kind, seed, what) for kind in KINDS for seed in range(60) for what in ("friction", "preload")]

SOME = [*FOUND, *FEW, *(pytest.param(*one, marks=pytest.mark.long) for one in LONG)]


def grasp(kind, seed):
    """Fingers of two joints and a pad around a waist, an arbitrary load, some squeeze or none."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    n, planar = int(rng.integers(2, 5)), kind == "planar"
    t = 2 * np.pi * (np.arange(n) + 0.3 * rng.uniform(-1, 1, n)) / n
    out = np.column_stack([np.cos(t), np.sin(t), np.zeros(n) if planar else 0.3 * rng.uniform(-1, 1, n)])
    out /= np.linalg.norm(out, axis=1)[:, None]
    law = hl.SoftFinger(0.5, 0.003, 2.0) if kind == "soft" else hl.Coulomb(0.5)
    J = rng.normal(size=(3 * n, 2 * n)) * np.kron(np.eye(n), np.ones((3, 2))) * 0.05
    E = J @ J.T + 1e-4 * np.eye(3 * n)
    w = rng.normal(size=6) * np.r_[np.ones(3), 0.01 * np.ones(3)]
    around = None
    if planar:
        across = np.arange(3 * n) % 3 == 1
        w, E[across], E[:, across] = w * [1, 1, 0, 0, 0, 1], 0.0, 0.0
    if kind == "environment":
        w[2] = -abs(w[2]) - 1
        feet = [(0.02 * np.cos(a), 0.02 * np.sin(a), -0.03) for a in (0.3, 2.4, 4.5)]
        around = [hl.Environment([hl.Contact(p, (0, 0, 1), hl.Coulomb(0.4)) for p in feet], 1e-5)]
    return hl.Grasp(
        [hl.Contact(0.03 * o, -o, law) for o in out], w, flexibility=E, preload=float(rng.choice([0, 1e-3, 5e-3])),
        plane=(0, 0, 1) if planar else None, environment=around,
    )  # fmt: skip


@pytest.mark.parametrize(("kind", "seed", "what"), MANY if os.environ.get("HANDLCP_HARD") == "1" else SOME)
def test_what_is_required_is_what_solve_says(kind, seed, what):
    g = grasp(kind, seed)
    change = with_friction if what == "friction" else with_preload
    r = getattr(g, f"required_{what}")(faces="cone")

    def held(x):
        return change(g, x).solve("cone", throw=False).held

    if r.value is None:
        assert not any(held(x) for x in np.geomspace(1e-3, r.limit, 4))
        return
    assert held(r.value)
    if r.fails is not None:
        assert not held(r.fails)
        assert r.value - r.fails <= r.tolerance * r.value * (1 + 1e-9)
        assert not (r.proven and held(0.5 * r.fails))
