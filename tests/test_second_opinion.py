"""The checker that answers are held to, itself checked: sets are what they say, and each law sees what breaks it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.hard_cases.scenes import FACES, around, backwards, fingers
from tests.support.friction_sets import Ball, Interval, Polygon, Smooth, polyhedron
from tests.support.laws import Laws, of_case

ASIDE = (1e-3, 2e-3, 0, 0, 0, 0)
SETS = {
    "none": (Smooth(), 2), "interval": (Interval(0.7), 2), "disc": (Ball(0.7), 2), "ball": (Ball(0.7), 3),
    "3 sides": (Polygon(0.7, 3), 2), "8 sides": (Polygon(0.7, 8), 2), "polyhedron of 4": (polyhedron(0.7, 4), 3),
    "polyhedron of 8": (polyhedron(0.7, 8), 3), "polyhedron of 13": (polyhedron(0.7, 13), 3)
}  # fmt: skip


@pytest.mark.parametrize("name", SETS)
def test_the_nearest_point_of_a_set_is_in_it_and_no_other_lies_further_towards_the_point(name):
    """What is left, y - x, has its most along itself at x: the variational inequality of the nearest point."""
    allowed, k = SETS[name]
    rng = np.random.default_rng(0)
    for _ in range(200):
        y, push = rng.normal(size=k) * 2, rng.uniform(0.1, 3)
        x = allowed.nearest(y, push)
        assert all(d @ x <= allowed.most(d, push) + 1e-9 for d in rng.normal(size=(20, k)))
        assert (y - x) @ x == pytest.approx(allowed.most(y - x, push), abs=1e-8)
        np.testing.assert_allclose(allowed.nearest(x, push), x, atol=1e-9)


@pytest.mark.parametrize("name", SETS)
def test_a_pull_allows_no_friction(name):
    allowed, k = SETS[name]
    np.testing.assert_array_equal(allowed.nearest(np.ones(k), -1.0), 0.0)
    assert allowed.most(np.ones(k), -1.0) == 0.0


# ---------------------------------------------------------------- the laws of a scene as arrays
@pytest.fixture(params=FACES)
def known(request):
    """A case with the solution that it was made from; a finger of each kind."""
    rng = np.random.default_rng(3)
    states = ["stick", "slide", "open", "slide", "stick"]
    case = backwards("known", rng, *around(rng, 5), 0.5, fingers(rng, 5), request.param, states, unique=True)
    return case, case.solve()


def test_a_solution_obeys_every_law(known):
    case, s = known
    assert of_case(case, s).worst < 1e-8


@pytest.mark.parametrize(
    ("law", "by"),
    [
        ("balance", lambda s, case: {"forces": 1.001 * s.forces}),
        ("normal", lambda s, case: {"forces": s.forces * [1, 1, -1]}),
        ("cone", lambda s, case: {"forces": s.forces * [1.5, 1.5, 1]}),
        ("slip", lambda s, case: {"object_displacement": np.add(s.object_displacement, ASIDE)}),
        ("work", lambda s, case: {"object_displacement": np.add(s.object_displacement, ASIDE)}),
        ("reported", lambda s, case: {"gap": s.gap + 1e-6}),
        ("reported", lambda s, case: {"slip": s.slip + 1e-6}),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_each_law_sees_what_breaks_it(known, law, by):
    case, s = known
    told = {name: getattr(s, name) for name in ("forces", "object_displacement", "gap", "slip")}
    assert getattr(of_case(case, SimpleNamespace(**(told | by(s, case)))), law) > 1e-5


def test_what_is_no_number_misses_everything(known):
    case, s = known
    assert of_case(case, replace(s, forces=np.full_like(s.forces, np.nan))).worst == np.inf
    assert Laws(0.0, 0.0, np.nan, 0.0, 0.0, 0.0).worst == np.inf
