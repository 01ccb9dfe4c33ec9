"""What is wrong in the paper, in depth: displacements that do not fit, Example 4 without an equilibrium."""

import numpy as np
import pytest

from handlcp.lcp import Status
from handlcp.studies.paper import PRELOAD, example
from tests.support.grasp import arrays
from tests.support.scripts import script

misprints = script("paper/misprints")


@pytest.mark.parametrize("number", range(3, 11))
def test_no_printed_displacement_keeps_touching_fingers_in_touch(number):
    (slip, fits), (gap, touches), _ = misprints.misses(number).values()
    assert fits, "signs and E_T were found that give the printed slips"
    assert slip < 0.1e-6
    assert not touches
    assert gap > 0.5e-6


@pytest.mark.parametrize(("number", "fits"), [(3, 6e-6), (5, 6e-6), *((k, 1.5e-6) for k in range(6, 11))])
def test_which_tangential_flexibility_the_printed_slips_fit(number, fits):
    assert misprints.motion(number).tangential == fits


@pytest.mark.parametrize(("number", "holds"), [(3, True), (6, True), (7, False), (8, False), (9, False), (10, False)])
def test_which_printed_slips_are_against_the_faces_of_their_forces(number, holds):
    *_, (_, against) = misprints.misses(number).values()
    assert against is holds


def test_the_overwritten_forces_of_table_9_follow_from_balance():
    found = misprints.recovered(9)
    assert list(found) == [(1, "o"), (1, "t"), (2, "o")]
    np.testing.assert_allclose(np.abs(list(found.values())), [0.36114, 1.25, 0.41667], rtol=1e-4)


def test_example_4_has_no_equilibrium_but_one_with_preload():
    every = misprints.example_4()
    assert {faces for _, faces in every} == {4, 6, 8}
    assert {value for value, _ in every} == {6e-6, 1.5e-6}
    for found in every.values():
        assert found.complete
        assert not found.found
    unloaded = example(4).grasp.solve(6, throw=False)
    assert unloaded.status in (Status.UNDECIDED, Status.NO_EQUILIBRIUM), "held by friction, so never NOT_HOLDABLE"
    (held,) = misprints.with_preload()
    assert held.contact_state == ("sticking",) * 3
    np.testing.assert_allclose(held.normal_force, [40 / 13, 140 / 39, 40 / 13], rtol=1e-9)


def test_preloaded_forces_hold_the_unloaded_cube():
    bare, held = arrays(example(4).grasp), example(4, preload=PRELOAD).grasp.solve(8)
    np.testing.assert_allclose(bare.grasp_matrix @ held.forces.ravel() + bare.wrench, 0, atol=1e-9)
    assert (np.hypot(*held.tangential_force.T) <= 0.6 * held.normal_force).all()


@pytest.mark.parametrize(("number", "faces"), [(3, 8), (5, 6), (2, 4)])
def test_all_choices_of_modes_hold_the_equilibria_that_exist(number, faces):
    grasp = example(number).grasp
    solved = grasp.solve(faces).normal_force
    assert any(np.allclose(one.normal_force, solved, rtol=1e-5) for one in grasp.equilibria(faces))
