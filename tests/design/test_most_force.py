"""Grips and motors for objects that bear no more than a certain force at a contact: an egg in two fingers."""

import numpy as np
import pytest

import handlcp as hl
from tests.design.hands import cube_grasp, pinch
from tests.hand.levers import MU, L
from tests.support.texts import says, without_numbers

LOAD = 1.0
EXACT = LOAD / (2 * MU)  # normal force of a pinch that just carries it


# ---------------------------------------------------------------- against the closed form of a pinch
@pytest.mark.parametrize("bears", [1.02 * EXACT, pytest.param(3.0 * EXACT, marks=pytest.mark.long)])
def test_a_grip_that_the_object_bears_is_the_one_without_that_question(tmp_path, bears):
    grasp = pinch(tmp_path)
    r = grasp.required_grip(tolerance=1e-2, most_force=bears)
    assert r.value == pytest.approx(EXACT, rel=1.1e-2)
    assert r.verdict == "HELD"
    motors = grasp.required_torque(safety=1.0, tolerance=0.02, most_force=bears)
    np.testing.assert_allclose(motors.torque, L * EXACT, rtol=0.021)
    assert motors.confirmed


def test_no_grip_holds_an_object_that_bears_less_than_its_weight_over_twice_the_friction(tmp_path):
    grasp, bears = pinch(tmp_path), 0.98 * EXACT
    r = grasp.required_grip(tolerance=1e-3, most_force=bears)
    assert r.value is None
    assert r.fails < EXACT, "which loses the object"
    says(without_numbers(r.hint), "not held", "presses with # N, and the object bears")
    motors = grasp.required_torque(safety=1.0, most_force=bears)
    assert not motors.holds
    assert f"the object bears {bears:.4g} N" in motors.lost[1]
    assert f"the object bears {bears:.4g} N" in " ".join(str(motors).split())


@pytest.mark.long
def test_the_same_of_a_squeeze(tmp_path):
    grasp = pinch(tmp_path)
    least = grasp.required_squeeze()
    assert grasp.required_squeeze(most_force=1.05 * EXACT).value == pytest.approx(least.value, rel=1e-3)
    assert grasp.required_squeeze(most_force=0.95 * EXACT).value is None


def test_a_push_counts_as_well_as_the_grip(tmp_path):
    """Half of a push along the normals goes to one finger; what is left of the other must still carry the weight."""
    grasp, push = pinch(tmp_path), (0.6, 0, -LOAD, 0, 0, 0)
    one = grasp.required_torque({"push": push}, safety=1.0).torque.max() / L
    assert one > 1.1 * EXACT
    assert grasp.required_torque({"push": push}, safety=1.0, most_force=1.05 * one).holds
    assert not grasp.required_torque({"push": push}, safety=1.0, most_force=0.95 * one).holds


# ---------------------------------------------------------------- by contact, and on the way
def test_forces_may_be_given_by_contact():
    grasp = cube_grasp()
    free = grasp.required_grip(tolerance=0.1)
    path = grasp.replace(grip_force=free.value).check().loading
    largest = path.steps.forces[:, :, 2].max(axis=0)
    thumb = grasp.fingertips[int(np.argmax(largest))]
    for bears in ({thumb: 1.1 * largest.max()}, 1.1 * largest):
        found = grasp.required_grip(tolerance=0.1, most_force=bears)
        assert found.value == pytest.approx(free.value, rel=1e-12)
    none = grasp.required_grip(tolerance=0.1, most_force={thumb: 0.9 * largest.max()})
    assert none.value is None
    assert f"{thumb} presses with" in none.hint


@pytest.mark.parametrize(
    ("value", "fact"), [(0.0, "> 0"), (-1.0, "> 0"), ((1.0, 2.0), "3 values"), ("3 N", "a finite number > 0")]
)
def test_what_no_object_bears_is_refused(value, fact):
    with pytest.raises(hl.InputError, match=f"most_force.*{fact}"):
        cube_grasp().required_grip(most_force=value)
