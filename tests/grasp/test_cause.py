"""What gives out: the judge against numbers made by hand, its tolerance at both sides, and the words of each kind."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.grasp import Bind
from tests.support import cause as c

NAMES = ("thumb", "index")
JOINTS = ("a", "b", "c")
INF = np.inf


def limits(**more):
    """Torque limits 2, none, 0.5; ranges of 2 rad, none, and one that is a single place."""
    lower, upper = np.array([-1.0, -INF, 0.3]), np.array([1.0, INF, 0.3])
    return c.Limits(NAMES, JOINTS, np.array([2.0, INF, 0.5]), lower, upper, **more)


AT = np.array([0.0, 0.0, 0.3])
NONE = np.zeros(3)


# ---------------------------------------------------------------- the judge
def test_shares_are_those_of_torques_ranges_and_motion():
    q = np.array([1.5, 100.0, 0.2])
    share = c.used(limits(motion=(0.01, 0.5)), np.array([-1.0, 7.0, 0.5]), q, np.array([0, 0.03, 0.04, 0.1, 0, 0]))
    np.testing.assert_allclose(share, [0.5, 0, 1, 1.25, -INF, 1.1, 5, 0.2])


def test_shares_of_torques_alone_need_no_positions():
    np.testing.assert_allclose(c.used(limits(), np.array([1.0, 1.0, 1.0])), [0.5, 0, 2])
    assert c.over(limits(), np.array([1.0, 1.0, 1.0])) == (c.Cause("torque", "c"),)


def test_a_joint_beyond_its_limit_is_named_with_what_is_missing():
    found = c.over(limits(), np.array([-3.0, 1e6, 0.1]), np.array([-1.5, 0.0, 0.3]))
    assert found == (c.Cause("torque", "a"), c.Cause("range", "a"))
    assert [one.margin for one in found] == pytest.approx([-0.5, -0.25])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("beyond", "is_over"), [(0.9, False), (1.1, True)])
def test_the_one_tolerance_holds_for_torque_range_and_motion_on_both_sides(sign, beyond, is_over):
    slack = beyond * c.OVER
    every = limits(motion=(0.01, 0.5))
    assert bool(c.over(every, sign * np.array([2.0 * (1 + slack), 0, 0]), AT)) is is_over
    assert bool(c.over(every, NONE, AT + sign * np.array([1.0 + 2.0 * slack, 0, 0]))) is is_over
    assert bool(c.over(every, NONE, AT, sign * np.array([0, 0, 0.01 * (1 + slack), 0, 0, 0]))) is is_over
    assert bool(c.over(every, NONE, AT, sign * np.array([0, 0, 0, 0.5 * (1 + slack), 0, 0]))) is is_over
    assert bool(c.exceeded(1 + slack)) is is_over


def test_at_the_limit_itself_nothing_is_over_and_that_is_what_binds():
    torque, q = np.array([2.0, 0, 0]), np.array([-1.0, 0, 0.2])
    assert c.over(limits(), torque, AT) == ()
    assert c.binding(limits(), torque, np.array([-1.0, 0, 0.3])) == (
        c.Cause("torque", "a"), c.Cause("range", "a"), c.Cause("range", "c"),
    )  # fmt: skip
    assert c.over(limits(), torque, q) == (c.Cause("range", "c"),)


def test_what_binds_below_every_limit_is_the_nearest_to_it_as_near_as_the_place_is_known():
    torque = np.array([1.0, 0, 0.2499])
    assert c.binding(limits(), torque) == (c.Cause("torque", "a"),)
    assert c.binding(limits(), torque)[0].margin == pytest.approx(0.5)
    assert c.binding(limits(), torque, near=1e-3) == (c.Cause("torque", "a"), c.Cause("torque", "c"))
    assert c.binding(limits(), NONE) == ()


def test_the_object_that_moves_and_turns_too_far_is_named_once():
    found = c.over(limits(motion=(0.01, 0.5)), NONE, AT, np.array([0.02, 0, 0, 1.5, 0, 0]))
    assert found == (c.Cause("motion", "the object"),)
    assert found[0].margin == pytest.approx(-2.0)


def test_numbers_that_are_missing_exceed_nothing():
    assert c.over(limits(), np.full(3, np.nan), AT) == ()
    assert c.over(limits(), np.array([np.nan, 0, 1.0]), AT) == (c.Cause("torque", "c"),)


def test_joints_that_yield_have_no_torque_to_exceed_and_a_grasp_without_joints_has_no_limits():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=0.2)
    box = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    state = hand.at(hand.close_on(box))
    plain, yields = (state.grasp(box, 0.8, squeeze=0.005, effects=e).spec for e in ((), (hl.TorqueSaturation(),)))
    torque = np.full(6, 0.3)
    assert {one.who for one in c.over(c.limits_of(plain), torque)} == set(hand.joint_names)
    assert c.over(c.limits_of(yields), torque) == ()
    far = np.array(hand.upper) + 1.0
    assert {one.kind for one in c.over(c.limits_of(yields), torque, far)} == {"range"}
    assert c.over(c.limits_of(yields, ranges=False), torque, far) == ()
    assert c.over(c.limits_of(yields, nominal=far), torque, far + 1.0) == ()  # it stood out of its range before
    bare = hl.Grasp([hl.Contact((0, 0, 0), (0, 0, 1), 0.5)], flexibility=1e-3)
    assert c.over(c.limits_of(bare.spec), np.zeros(0), np.zeros(0)) == ()


def test_contacts_give_way_by_opening_or_else_by_slipping_or_else_balance_does():
    stick, slide, open_ = "sticking", "sliding", "separated"
    assert c.slipping(NAMES, (slide, stick)) == (c.Cause("slips", "thumb"),)
    assert c.slipping(NAMES, (slide, open_), (slide, stick)) == (c.Cause("opens", "index"),)
    assert c.slipping(NAMES, (slide, open_), (slide, open_)) == (c.Cause("slips", "thumb"),)
    assert c.slipping(NAMES, (stick, stick), (slide, stick)) == (c.Cause("slips", "thumb"),)
    assert c.slipping(NAMES, (stick, open_)) == (c.Cause("equilibrium", "the object"),)
    assert c.slides_through((slide, open_)) == (c.Cause("slides through", "the object"),)
    assert c.slides_through((slide, stick)) == c.slides_through((open_, open_)) == ()


# ---------------------------------------------------------------- data
def test_causes_are_equal_by_kind_and_name_whatever_their_margins():
    one, other = Bind("torque", "a"), Bind("torque", "a", -0.25)
    assert one == other
    assert len({one, other, Bind("range", "a")}) == 2
    assert (repr(one), repr(other)) == ("Cause('torque', 'a')", "Cause('torque', 'a', margin=-0.25)")


# ---------------------------------------------------------------- words
ONE = {
    "slips": "thumb slips", "opens": "thumb lets go", "torque": "thumb reaches its torque limit",
    "range": "thumb reaches the end of its range",
}  # fmt: skip
SEVERAL = {
    "slips": "thumb and index slip", "opens": "thumb and index let go",
    "torque": "thumb and index reach their torque limits", "range": "thumb and index reach the ends of their ranges",
}  # fmt: skip
OBJECT = {
    "equilibrium": "no forces balance more load", "motion": "the object moves farther than allowed",
    "slides through": "the object slides through: no contact that presses sticks any more", "undecided": "undecided",
}  # fmt: skip


@pytest.mark.parametrize("kind", ONE)
def test_each_kind_has_words_for_one_and_for_several(kind):
    one, both = c.Cause(kind, "thumb"), (c.Cause(kind, "thumb"), c.Cause(kind, "index"))
    assert c.said([one]) == ONE[kind]
    assert c.said(both) == SEVERAL[kind]
    assert c.said([*both, c.Cause(kind, "ring")], brief=True) == SEVERAL[kind].replace("index", "2 more")


@pytest.mark.parametrize("kind", OBJECT)
def test_what_happens_to_the_object_has_one_sentence(kind):
    assert c.said([c.Cause(kind, "the object")]) == OBJECT[kind]


def test_causes_of_several_kinds_and_none_at_all_have_words():
    assert c.said([c.Cause("torque", "a"), c.Cause("range", "b")]) == (
        "a reaches its torque limit; b reaches the end of its range"
    )
    assert c.said(()) == "nothing gives out"


def test_all_fingers_or_joints_of_a_grasp_are_called_so():
    spec = hl.Grasp([hl.Contact((0, 0, z), (1, 0, 0), 0.5, name=f"f{z}") for z in (0, 1, 2)], flexibility=1e-3).spec
    assert c.said([c.Cause("slips", n) for n in spec.names], spec) == "all 3 fingers slip"
    assert c.said([c.Cause("slips", n) for n in spec.names[:2]], spec) == "f0 and f1 slip"
    assert c.happens("opens by turns", spec.names, spec) == "all 3 fingers let go and touch by turns"
    assert c.happens("sticks", ["f1"], spec) == "f1 sticks again"


def test_a_sentence_says_at_which_load_what_gives_out():
    push = np.array([0, 0, 2.0, 0, 0, 0])
    slips, balance, torque = (c.Cause(k, "thumb") for k in ("slips", "equilibrium", "torque"))
    assert c.why([slips], 1.6, push) == (
        "at 1.6 times the load, 3.2 N along +z: thumb slips, and nothing else balances more load"
    )
    assert c.why([balance], 1.6, push) == "at 1.6 times the load, 3.2 N along +z: no forces balance more load"
    assert c.why([balance], 0.0, push) == "it holds nothing of this load: no forces balance it"
    assert c.why([slips], 0.0, push).endswith(": thumb slips, and nothing else balances it")
    assert c.why([torque], 0.0, push) == "before there is any load, thumb reaches its torque limit"
    assert c.why((), INF, push) == "nothing gives out, however large the load"
    assert c.amount(np.array([0, 0, 0, 0, -0.5, 0])) == "0.5 N·m about -y"


def test_a_lost_object_is_told_with_what_its_contacts_did():
    spec = hl.Grasp([hl.Contact((0, 0, z), (1, 0, 0), 0.5, name=n) for z, n in enumerate(NAMES)], flexibility=1e-3).spec
    told = c.why_lost("runs away", spec, ("sliding", "separated"), np.array([0, 0, -1.0, 0, 0, 0]))
    assert told == (
        "the object runs away along -z: the fingers give way faster than their forces grow "
        "(thumb slides and index has let go)"
    )
    assert (
        c.why_lost("loose", spec, ("separated",) * 2)
        == "no finger holds the object any more (both fingers have let go)"
    )
    assert c.under_load(np.array([0, 0, 3.0, 0, 0, 0]), np.array([0, 0, 6.0, 0, 0, 0])) == ", under 3 N of 6 N"
