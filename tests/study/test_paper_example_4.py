"""Example 4: no elastic equilibrium within bounds, one with preload; the same search finds what exists."""

from __future__ import annotations

import numpy as np
import pytest

from handlcp.lcp import Status
from handlcp.method.paper import example
from tests.support.grasp import arrays
from tests.support.study import PRELOAD, no_equilibrium, search_grasp


def test_no_equilibrium_within_bounds_but_one_with_preload() -> None:
    e = no_equilibrium()
    assert e.proved
    assert {f for f, *_ in e.searches} == {4, 6, 8}
    assert e.unloaded.status in (Status.UNDECIDED, Status.NO_EQUILIBRIUM), "held by friction, so never NOT_HOLDABLE"
    assert e.preloaded.held
    assert e.preloaded.contact_state == ("sticking",) * 3
    np.testing.assert_allclose(e.preloaded.normal_force, [40 / 13, 140 / 39, 40 / 13], rtol=1e-9)
    np.testing.assert_allclose(e.control_normal, e.preloaded.normal_force, rtol=1e-6)


def test_preloaded_forces_hold_the_unloaded_cube() -> None:
    bare, held = arrays(example(4).grasp), example(4, preload=PRELOAD).grasp.solve(8)
    np.testing.assert_allclose(bare.grasp_matrix @ held.forces.ravel() + bare.wrench, 0, atol=1e-9)
    assert (np.hypot(*held.tangential_force.T) <= 0.6 * held.normal_force).all()


@pytest.mark.parametrize(("number", "faces"), [(3, 8), (5, 6), (2, 4)])
def test_the_search_finds_what_exists(number: int, faces: int) -> None:
    grasp = example(number).grasp
    found = search_grasp(grasp, faces)
    assert found.z is not None
    normal = grasp.problem(faces).candidate(found.z).forces[:, 2]
    np.testing.assert_allclose(normal, grasp.solve(faces).normal_force, rtol=1e-5)
