"""Load limits with the geometry followed: closed forms, and what binds."""

import numpy as np
import pytest

import handlcp as hl
from tests.limits.pinches import C, K, pinch
from tests.loading.hands import ball, box_on_a_table, cube
from tests.support.limits import limits_of_grasp

EXACT = 1e-4  # the stated share to which a limit is located
X, Z = np.eye(6)[0], np.eye(6)[2]


def test_a_pinch_slips_through_at_twice_the_friction_of_one_finger(tmp_path):
    g, normal = pinch(tmp_path, friction=0.4)
    limit = g.load_limit(-Z)
    assert limit.geometry == "followed"
    assert limit.factor == pytest.approx(2 * 0.4 * normal, rel=EXACT)
    assert {b.kind for b in limit.binds} == {"slips"}
    assert {b.who for b in limit.binds} == set(g.names)


def test_a_joint_at_its_torque_limit_binds_where_half_the_load_reaches_it(tmp_path):
    g, normal = pinch(tmp_path, torque_limits=2.0 + 1.5)
    assert normal == pytest.approx(2.0)
    limit = g.load_limit(X)  # two springs alike share it
    assert limit.factor == pytest.approx(2 * 1.5, rel=EXACT)
    assert [(b.kind, b.who) for b in limit.binds] == [("torque", "right_slide")]
    assert abs(limit.at_limit.torques).max() == pytest.approx(3.5, rel=EXACT)


def test_a_joint_at_the_end_of_its_range_binds(tmp_path):
    g, normal = pinch(tmp_path, left=1e-3)
    limit = g.load_limit(X)
    left = 1e-3 - C * normal  # the squeeze has pressed the pads, and joints follow
    assert limit.factor == pytest.approx(2 * K * left, rel=EXACT)
    assert [(b.kind, b.who) for b in limit.binds] == [("range", "left_slide")]


def test_the_motion_that_is_allowed_binds(tmp_path):
    g, _ = pinch(tmp_path, friction=0.8)
    limit = g.load_limit(-Z, motion=1e-4)
    assert limit.factor == pytest.approx(2 * 1e-4 / C, rel=EXACT)
    assert [(b.kind, b.who) for b in limit.binds] == [("motion", "the object")]


def test_nothing_binds_where_a_table_takes_the_load():
    limit = box_on_a_table().load_limit(Z)
    assert limit.factor == np.inf
    assert not limit.binds
    assert "nothing gives out" in limit.why


def test_what_the_squeeze_does_not_hold_has_no_limit_above_nothing():
    limit = cube(squeeze=None).load_limit(Z)
    assert limit.factor == 0.0
    assert "not held" in limit.why


@pytest.mark.parametrize("direction", [(0.74, 0.54, -0.4), (-0.9, -0.44, 0.03)])
def test_following_the_load_holds_below_the_limit_and_not_above(direction):
    g, wrench = ball(), np.append(direction, np.zeros(3))
    limit = g.load_limit(wrench)

    def reached(share):
        order = ("squeeze", hl.Stage("weight", weight=1.0), hl.Stage("load", load=share * limit.load))
        return g.follow(order=order, steps=80).held

    assert reached(0.98)  # steps of a limit are coarse where something slides: about a percent
    assert not reached(1.02)


@pytest.mark.parametrize(("direction", "mujoco"), [((-0.897, -0.442, 0.029), 1.979), ((-0.878, -0.083, -0.471), 1.726)])
def test_an_object_that_slides_too_far_is_lost_where_the_simulator_loses_it(direction, mujoco):
    limit = cube().load_limit((*direction, 0.0, 0.0, 0.0))
    assert limit.factor == limit.slides
    assert limit.first_slip < limit.slides < 0.9 * limit.lost
    assert limit.lost == pytest.approx(mujoco, rel=0.01)  # of `simulate_limit`, in 8 s
    assert limit.marks["slides"].moved < limit.marks["lost"].moved


def test_the_state_at_the_limit_is_certified_and_balances_the_load():
    g = ball()
    limit = g.load_limit(Z)
    assert limit.at_limit.held
    force = limit.at_limit.forces_world.sum(axis=0)
    np.testing.assert_allclose(force, -limit.load[:3] - g.mechanism.weight_of_object(g.reference)[:3], atol=1e-6)


def test_events_come_in_order_and_the_path_ends_at_the_limit():
    limit = ball().load_limit(Z)
    factors = [e.factor for e in limit.events]
    assert factors == sorted(factors)
    assert factors[-1] <= limit.lost * (1.0 + 1e-9)
    assert limit.factor == limit.slides < limit.lost
    assert any(e.kind == "slips" for e in limit.events)
    assert limit.path.factors[0] == 0.0
    assert limit.path.factors[-1] <= limit.factor
    assert limit.path.forces.shape == (len(limit.path.factors), 5, 3)


@pytest.mark.parametrize("load", [(-1.0, 0, 0, 0, 0, 0), (0, 1.0, 0, 0, 0, 0)])
def test_fingers_begin_to_slip_where_short_steps_of_load_see_it(load):
    g = cube(squeeze=5e-3)
    limit = g.load_limit(load)
    first = next(e for e in limit.events if e.kind == "slips")
    end = 1.2 * first.factor
    stages = ["squeeze", hl.Stage("weight", weight=1.0), hl.Stage("load", load=end * np.array(load))]
    followed = g.follow(order=stages, steps=100)
    seen = next(e for e in followed.events if e.stage == "load")
    assert (seen.kind, first.factor) == ("slips", pytest.approx(seen.share * end, rel=0.015))


def test_joints_that_yield_are_no_limit_and_hold_their_torque():
    wrench = (0.36, 0.92, -0.11, 0.0, 0.0, 0.0)
    strict = ball(limits=0.16).load_limit(wrench)
    assert strict.factor == 0.0  # the squeeze alone asks for more
    assert strict.binds[0].kind == "torque"
    saturated = ball(limits=0.16, effects=[hl.TorqueSaturation()])
    yielding = saturated.load_limit(wrench)
    assert yielding.factor > 1.0
    assert yielding.binds[0].kind == "slips"
    assert abs(yielding.path.torques).max() <= 0.16 * (1 + 1e-8)
    beyond = saturated.follow(3.0 * np.array(wrench))  # the limit is a jump, after which two joints hold again
    assert 3.0 * beyond.jump.share == pytest.approx(yielding.factor, rel=1e-3)
    assert any(e.kind == "holds" for e in beyond.events)


def test_many_directions_have_each_the_limit_that_it_has_alone():
    g, loads = ball(), np.array([X, Z, [0.0, 0.5, 0.0, 0.01, 0.0, 0.0]])
    found = limits_of_grasp(g, loads, geometry="followed")
    alone = [g.load_limit(load) for load in loads]
    assert found.geometry == "followed"
    np.testing.assert_array_equal(found.factors, [limit.factor for limit in alone])
    assert found.binds == tuple([limit.binds for limit in alone])


def test_a_grasp_that_slides_too_far_under_the_weight_alone_holds_no_load_and_check_says_so():
    grasp = cube(squeeze=0.005, friction=0.28)
    limit = grasp.load_limit(-Z)
    assert limit.factor == limit.slides == 0.0
    assert limit.lost > 0.0  # the path goes on: slowly loaded it comes to rest
    assert "the weight alone is not held: finger_1_tip has slid as far as it may" in limit.why
    verdict = grasp.check()
    assert verdict.word == "NOT HELD"
    assert verdict.about("slides")


def test_more_friction_holds_more():
    """The object moves less under the same load the rougher it is: 5.6 mm with 0.84 under 6.4 N, 2.7 mm with 0.88."""
    first, then = [cube(squeeze=0.005, friction=mu).load_limit(-Z).factor for mu in (0.84, 0.88)]
    assert then > first
