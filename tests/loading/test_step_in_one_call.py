"""A step in one compiled call is the step that Python makes of its parts: the same path, to rounding."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from handlcp.contact.friction import as_section
from handlcp.grasp.path.advance import advance
from handlcp.grasp.path.follow import begun, geometry_of, loading_of
from handlcp.grasp.path.geometry import Geometry
from handlcp.grasp.path.step import StepState
from handlcp.grasp.path.watch import watch_of
from handlcp.kinematics.rigid_motion import rotation_vector
from tests.loading.hands import ball, box_on_a_table, cube
from tests.paths.corpus import case_of
from tests.support.power import WEAK, power_grasp
from tests.support.routed import LOAD, threes

ROUNDING = 1e-7  # of the largest force: paths amplify the rounding of their steps where contacts slide


class InPython(Geometry):
    """A geometry as a user brings one: it has methods alone."""

    def __init__(self, inner):
        self.inner, self.start, self.posture, self.apart = inner, inner.start, inner.posture, inner.apart
        self.follows, self.weighs, self.noise, self.quick = inner.follows, inner.weighs, inner.noise, False

    def __getattribute__(self, name):
        own = ("inner", "start", "posture", "apart", "follows", "weighs", "noise", "quick", "arrays")
        if name in own or name.startswith("__"):
            return object.__getattribute__(self, name)
        return getattr(self.inner, name)


def paths(grasp, load, geometry=None, faces="cone", steps=12):
    """The same grasp followed by steps in one call, and by steps in Python."""
    spec, section = grasp.spec, as_section(faces)
    for wrap in (lambda body: body, InPython):
        body = wrap(geometry_of(spec, geometry))
        first, goals, stepper = begun(spec, section, body, 1e-9, ("squeeze", "load"), load)
        may_slide = np.full(spec.n, np.inf)
        run = advance(stepper, watch_of(spec, body, may_slide), first, goals, steps)
        yield loading_of(run, goals, stepper, section, may_slide)


def assert_same(grasp, load, **how):
    one, other = paths(grasp, load, **how)
    assert isinstance(one.last, StepState)
    assert not isinstance(other.last, StepState)
    a, b = one.steps, other.steps
    assert (one.reached, one.outcome) == (other.reached, other.outcome)
    assert len(a.states) == len(b.states)
    np.testing.assert_allclose(a.share, b.share, atol=1e-6)
    size = abs(b.forces).max()
    np.testing.assert_allclose(a.forces, b.forces, atol=ROUNDING * size)
    assert [s.kinds for s in a.states] == [s.kinds for s in b.states]
    assert [s.iterates for s in a.states] == [s.iterates for s in b.states]
    for k in (1, -1):
        s, t = a.states[k], b.states[k]
        for name in ("touch", "frames", "elastic", "reference", "weight_arm"):
            for x, y in zip(flat(getattr(s.iterate, name)), flat(getattr(t.iterate, name)), strict=True):
                np.testing.assert_allclose(x, y, atol=1e-6 * max(1e-3, abs(y).max(initial=0.0)), err_msg=name)
        for part in ("loads", "read"):
            for x, y in zip(getattr(s, part), getattr(t, part), strict=True):
                np.testing.assert_allclose(x, y, atol=1e-6 * max(1e-3, abs(y).max(initial=0.0)), err_msg=part)
        for name in ("slip_memory", "slid", "yielded", "start", "rubs", "met"):
            x, y = getattr(s, name), getattr(t, name)
            np.testing.assert_allclose(x, y, atol=1e-5 * max(1e-3, abs(y).max(initial=0.0)), err_msg=name)

    for x, y in zip(one.last.pull, other.last.pull, strict=True):
        np.testing.assert_allclose(x, y, atol=1e-6 * max(1e-3, abs(y).max(initial=0.0)))


def flat(value):
    return [part for one in value for part in flat(one)] if isinstance(value, tuple) else [np.asarray(value)]


@pytest.mark.parametrize(
    ("number", "direction"), [(17, 5), (18, 6), (26, 2), (42, 6), (92, 8), (163, 7), (8, 8), (44, 8)]
)
def test_the_path_of_a_random_grasp_is_the_same(number, direction):
    case = case_of(0, number)
    size = 1.2 * case.grasp.load_limit(case.directions[direction], geometry="fixed", faces=case.faces).factor
    load = min(size, 20.0) * case.directions[direction]
    assert_same(case.grasp, load, geometry=case.geometry, faces=case.faces, steps=6)


def test_a_cube_that_is_pulled_out_of_three_fingers_leaves_them_at_the_same_load():
    assert_same(cube(), np.array([0.0, 0.0, -12.0, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize("load", [(0.0, 0.0, 4.0), (2.0, 1.0, 0.0)])
def test_soft_fingers_around_a_ball_follow_the_same_path(load):
    assert_same(ball(friction=hl.SoftFinger(0.6, 0.004)), np.append(load, np.zeros(3)))


def test_fingers_that_bear_their_own_weight_follow_the_same_path():
    assert_same(ball(finger_weight=True), np.array([1.0, 0.0, 2.0, 0.0, 0.0, 0.0]), steps=4)


def test_a_box_on_a_table_follows_the_same_path():
    """Corners are points of the box, on a plane that stays."""
    assert_same(box_on_a_table(), np.array([1.0, 0.5, 0.0, 0.0, 0.0, 0.0]), steps=5)


@pytest.mark.parametrize(
    "round_one",
    [
        hl.Sphere(0.03, (0, 0, 0.09), mass=0.3),
        hl.Cylinder(0.03, 0.06, pin.SE3(pin.exp3(np.array([0.0, np.pi / 2, 0.0])), np.array([0, 0, 0.09])), mass=0.3),
    ],
)
def test_what_is_round_rolls_on_a_table_along_the_same_path(round_one):
    hand = hl.example_hand("two_finger", joint_stiffness=6.0, pad_flexibility=2e-4)
    table = hl.Table((0, 0, 0.12), (0, 0, -1), hl.Coulomb(0.4), flexibility=1e-4)
    state = hand.at(hand.close_on(round_one))
    grasp = state.grasp(round_one, hl.Coulomb(0.8), gravity=(0, 0, 9.81), squeeze=0.002, environment=table)
    assert_same(grasp, np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0]), steps=4)


def test_contacts_that_were_given_without_an_object_follow_the_same_path():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    state = hand.at(hand.close_on(hl.Box(0.05, (0, 0, 0.08))))
    given = state.grasp(hl.Box(0.05, (0, 0, 0.08), mass=0.2), friction=0.8).spec.contacts
    contacts = [hl.Contact(c.position, c.normal, hl.Coulomb(0.8), None, c.name) for c in given]
    grasp = state.grasp(contacts, preload=0.004, wrench=(0, 0, -2, 0, 0, 0))
    assert_same(grasp, np.array([0.5, 0.0, -2.0, 0.0, 0.0, 0.0]), steps=4)


def test_joints_that_rub_follow_the_same_path():
    box = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, joint_friction=0.02)
    grasp = hand.at(hand.close_on(box)).grasp(box, friction=0.8, squeeze=0.005)
    assert_same(grasp, np.array([1.0, 0.0, -2.0, 0.0, 0.0, 0.0]), steps=4)


@pytest.mark.parametrize("routed", [False, True])
@pytest.mark.parametrize(("extensors", "pretension", "friction"), [(False, 0.0, 0.0), (True, 4.0, 0.1)])
def test_tendons_with_fixed_arms_and_along_routes_follow_the_same_path(routed, extensors, pretension, friction):
    grasp = threes(extensors, pretension, routed, friction)
    assert_same(grasp, np.array(LOAD), steps=4)


def test_many_contacts_that_are_eliminated_one_by_one_follow_the_same_path():
    grasp = power_grasp(12, 1, WEAK, loaded=False).factored()
    assert_same(grasp, None, steps=4)


def test_a_state_of_one_call_is_pickled_as_what_it_says():
    loading = cube().follow(np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0]), steps=3)
    kept = pickle.loads(pickle.dumps(loading.last))
    assert np.array_equal(kept.read.forces, loading.last.read.forces)
    assert kept.kinds == loading.last.kinds


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.0, 2.7, 3.0, 3.14, np.pi - 1e-7, np.pi])
def test_a_rotation_has_the_vector_that_pinocchio_gives_it(angle):
    for axis in np.random.default_rng(1).normal(size=(6, 3)):
        axis /= np.linalg.norm(axis)
        R = pin.exp3(angle * axis)
        found = rotation_vector(R)
        np.testing.assert_allclose(pin.exp3(found), R, atol=1e-14)
        assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-7)
