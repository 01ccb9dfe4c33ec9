"""What gives out: the judge against numbers made by hand, its tolerance at both sides, and the words of each kind."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.grasp.failure.failure_mode import (
    FailureMode,
    StateLimits,
    find_binding,
    find_exceeded,
    find_slipping,
    is_exceeded,
    limit_shares,
    state_limits,
)
from handlcp.grasp.failure.failure_text import describe_load, explain_limit
from handlcp.grasp.model.status import SEPARATED, SLIDING, STICKING
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

NAMES = ("thumb", "index")
JOINTS = ("a", "b", "c")
INF = np.inf


def limits(**more):
    """Torque limits 2, none, 0.5; ranges of 2 rad, none, and one that is a single place."""
    lower, upper = np.array([-1.0, -INF, 0.3]), np.array([1.0, INF, 0.3])
    return StateLimits(NAMES, JOINTS, np.array([2.0, INF, 0.5]), lower, upper, **more)


AT = np.array([0.0, 0.0, 0.3])
NONE = np.zeros(3)


# ---------------------------------------------------------------- the judge
def test_shares_are_those_of_torques_ranges_and_motion():
    q = np.array([1.5, 100.0, 0.2])
    share = limit_shares(
        limits(motion=(0.01, 0.5)), np.array([-1.0, 7.0, 0.5]), q, np.array([0, 0.03, 0.04, 0.1, 0, 0])
    )
    np.testing.assert_allclose(share, [0.5, 0, 1, 1.25, -INF, 1.1, 5, 0.2])


def test_shares_of_torques_alone_need_no_positions():
    np.testing.assert_allclose(limit_shares(limits(), np.array([1.0, 1.0, 1.0])), [0.5, 0, 2])
    assert find_exceeded(limits(), np.array([1.0, 1.0, 1.0])) == (FailureMode("torque", "c"),)


def test_a_joint_beyond_its_limit_is_named_with_what_is_missing():
    found = find_exceeded(limits(), np.array([-3.0, 1e6, 0.1]), np.array([-1.5, 0.0, 0.3]))
    assert found == (FailureMode("torque", "a"), FailureMode("range", "a"))
    assert [one.margin for one in found] == pytest.approx([-0.5, -0.25])


def test_a_joint_below_its_range_is_over_it_though_nothing_else_is():
    alone = StateLimits(NAMES, ("a",), np.array([2.0]), np.array([-1.0]), np.array([1.0]))
    assert find_exceeded(alone, np.zeros(1), np.array([-1.5])) == (FailureMode("range", "a"),)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("beyond", "is_over"), [(0.9, False), (1.1, True)])
def test_the_one_tolerance_holds_for_torque_range_and_motion_on_both_sides(sign, beyond, is_over):
    slack = beyond * OVER_LIMIT_TOLERANCE
    every = limits(motion=(0.01, 0.5))
    assert bool(find_exceeded(every, sign * np.array([2.0 * (1 + slack), 0, 0]), AT)) is is_over
    assert bool(find_exceeded(every, NONE, AT + sign * np.array([1.0 + 2.0 * slack, 0, 0]))) is is_over
    assert bool(find_exceeded(every, NONE, AT, sign * np.array([0, 0, 0.01 * (1 + slack), 0, 0, 0]))) is is_over
    assert bool(find_exceeded(every, NONE, AT, sign * np.array([0, 0, 0, 0.5 * (1 + slack), 0, 0]))) is is_over
    assert bool(is_exceeded(1 + slack)) is is_over


def test_at_the_limit_itself_nothing_is_over_and_that_is_what_binds():
    torque, q = np.array([2.0, 0, 0]), np.array([-1.0, 0, 0.2])
    assert find_exceeded(limits(), torque, AT) == ()
    assert find_binding(limits(), torque, np.array([-1.0, 0, 0.3])) == (
        FailureMode("torque", "a"), FailureMode("range", "a"), FailureMode("range", "c"),
    )  # fmt: skip
    assert find_exceeded(limits(), torque, q) == (FailureMode("range", "c"),)


def test_what_binds_below_every_limit_is_the_nearest_to_it_as_near_as_the_place_is_known():
    torque = np.array([1.0, 0, 0.2499])
    assert find_binding(limits(), torque) == (FailureMode("torque", "a"),)
    assert find_binding(limits(), torque)[0].margin == pytest.approx(0.5)
    assert find_binding(limits(), torque, near=1e-3) == (FailureMode("torque", "a"), FailureMode("torque", "c"))
    assert find_binding(limits(), NONE) == ()


def test_the_object_that_moves_and_turns_too_far_is_named_once():
    found = find_exceeded(limits(motion=(0.01, 0.5)), NONE, AT, np.array([0.02, 0, 0, 1.5, 0, 0]))
    assert found == (FailureMode("motion", "the object"),)
    assert found[0].margin == pytest.approx(-2.0)


def test_numbers_that_are_missing_exceed_nothing():
    assert find_exceeded(limits(), np.full(3, np.nan), AT) == ()
    assert find_exceeded(limits(), np.array([np.nan, 0, 1.0]), AT) == (FailureMode("torque", "c"),)


def test_joints_that_yield_have_no_torque_to_exceed_and_a_grasp_without_joints_has_no_limits():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=0.2)
    box = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    state = hand.at(hand.close_on(box))
    plain, yields = (state.grasp(box, 0.8, squeeze=0.005, effects=e).spec for e in ((), (hl.TorqueSaturation(),)))
    torque = np.full(6, 0.3)
    assert {one.who for one in find_exceeded(state_limits(plain), torque)} == set(hand.joint_names)
    assert find_exceeded(state_limits(yields), torque) == ()
    far = np.array(hand.upper) + 1.0
    assert {one.kind for one in find_exceeded(state_limits(yields), torque, far)} == {"range"}
    assert find_exceeded(state_limits(yields, ranges=False), torque, far) == ()
    assert find_exceeded(state_limits(yields, nominal=far), torque, far + 1.0) == ()  # it stood out of its range before
    bare = hl.Grasp([hl.Contact((0, 0, 0), (0, 0, 1), 0.5)], flexibility=1e-3)
    assert find_exceeded(state_limits(bare.spec), np.zeros(0), np.zeros(0)) == ()


def test_contacts_give_way_by_opening_or_else_by_slipping_or_else_balance_does():
    stick, slide, open_ = STICKING, SLIDING, SEPARATED
    assert find_slipping(NAMES, (slide, stick)) == (FailureMode("slips", "thumb"),)
    assert find_slipping(NAMES, (slide, open_), (slide, stick)) == (FailureMode("opens", "index"),)
    assert find_slipping(NAMES, (slide, open_), (slide, open_)) == (FailureMode("slips", "thumb"),)
    assert find_slipping(NAMES, (stick, stick), (slide, stick)) == (FailureMode("slips", "thumb"),)
    assert find_slipping(NAMES, (stick, open_)) == (FailureMode("equilibrium", "the object"),)


# ---------------------------------------------------------------- words


def test_a_sentence_says_at_which_load_what_gives_out():
    push = np.array([0, 0, 2.0, 0, 0, 0])
    slips, balance, torque = (FailureMode(k, "thumb") for k in ("slips", "equilibrium", "torque"))
    assert explain_limit([slips], 1.6, push) == (
        "at 1.6 times the load, 3.2 N along +z: thumb slips, and nothing else balances more load"
    )
    assert explain_limit([balance], 1.6, push) == "at 1.6 times the load, 3.2 N along +z: no forces balance more load"
    assert explain_limit([balance], 0.0, push) == "it holds nothing of this load: no forces balance it"
    assert explain_limit([slips], 0.0, push).endswith(": thumb slips, and nothing else balances it")
    assert explain_limit([torque], 0.0, push) == "before there is any load, thumb reaches its torque limit"
    assert explain_limit((), INF, push) == "nothing gives out, however large the load"
    assert describe_load(np.array([0, 0, 0, 0, -0.5, 0])) == "0.5 N·m about -y"
