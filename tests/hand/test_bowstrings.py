"""A string from the palm to a lever, whose tension turns the lever aside: it is stable up to a load that is known."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand import Hand

L, R = 0.08, 0.005  # m: the lever, and the radius of the tips of its fork, which hold a box of 20 mm
A, B, LEAN = 0.03, 0.05, 0.4  # m, m, rad: from the hinge to the ends of the string, and to where that is straight
T, KT = 60.0, 200.0  # N, N/m

FORK = f"""<robot name="fork"><link name="palm"/><link name="lever"/><link name="left"/><link name="right"/>
  <joint name="hinge" type="revolute"><parent link="palm"/><child link="lever"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="1"/></joint>
  <joint name="l" type="fixed"><parent link="lever"/><child link="left"/><origin xyz="{-0.01 - R} 0 {L}"/></joint>
  <joint name="r" type="fixed"><parent link="lever"/><child link="right"/><origin xyz="{0.01 + R} 0 {L}"/></joint>
  </robot>"""


def fork(write, own):
    """A box between two tips of one lever, whose spring `own` [N·m/rad] balances the string in the posture zero."""
    string = hl.Route([hl.Site("palm", (-A * np.sin(LEAN), 0, -A * np.cos(LEAN))), hl.Site("lever", (0, 0, B))])
    return boxed(write, hl.Tendons({"string": string}, KT, own, pretension=T), np.zeros(6))


def boxed(write, tendons, wrench):
    hand = Hand.from_urdf(write(FORK), ["left", "right"], joint_stiffness=tendons, pad_flexibility=1e-6, tip_radius=R)
    box = hl.Box(0.02, placement=(0, 0, L))
    return hand.at([0.0]).grasp(box, friction=hl.SoftFinger(0.8, 0.01), preload=2e-5, wrench=wrench)


def arm(q):
    return A * B * np.sin(q - LEAN) / length(q)


def length(q):
    return np.sqrt(A * A + B * B + 2 * A * B * np.cos(q - LEAN))


def force(q, own):
    """(n,) [N] along x at the box that holds the lever at q, with own q of its spring and the string's torque."""
    zero = np.zeros(1)
    return (own * q + arm(zero) * T - arm(q) * (T + KT * (length(q) - length(zero)))) / (L * np.cos(q))


def test_a_path_goes_as_the_string_says_where_the_spring_is_stiff_enough(write):
    """T a b / (a + b) = 1.125 N·m/rad is what the string takes of the spring where it is straight."""
    steps = fork(write, 1.2).follow((1.0, 0, 0, 0, 0, 0), steps=20).steps
    np.testing.assert_allclose(force(steps.q[:, 0], 1.2), steps.load[:, 0], atol=1e-7)
    assert steps.q[-1, 0] > LEAN
    np.testing.assert_allclose(steps.work[-1], steps.stored[-1], rtol=1e-3)


def test_the_lever_gives_way_at_the_load_where_the_string_wins(write):
    """Stable in the posture zero, and unstable where the string is straight: the largest force on the way."""
    q, own = np.linspace(0.0, LEAN, 100_001), 1.105
    most = force(q, own).max()
    assert 0.0 < q[force(q, own).argmax()] < LEAN
    path = fork(write, own).follow((2.0 * most, 0, 0, 0, 0, 0), steps=20)
    assert [e.kind for e in path.events] == ["lost"]
    np.testing.assert_allclose(path.steps.load[-1, 0], most, rtol=1e-5)


def test_a_lever_that_the_string_turns_over_holds_nothing(write):
    """Its spring is weaker than what the string takes of it, T ∂R/∂q, in the posture itself."""
    for own, holds in ((1.05, False), (1.12, True)):
        assert fork(write, own).follow(steps=5).reached == holds


# ---------------------------------------------------------------- a pulley about the hinge
ROUND = 0.006  # m


def on_pulley(write, side, shape="cylinder"):
    """The fork with its string past a round body about the hinge, to the left of its centre up to q = LEAN."""
    around = hl.Around("palm", ((0, 0, 0), (0.0, 1.0, 0.0)), ROUND, shape, side)
    ends = hl.Site("palm", (-A * np.sin(LEAN), 0, -A * np.cos(LEAN))), hl.Site("lever", (0, 0, B))
    tendons = hl.Tendons({"string": hl.Route([ends[0], around, ends[1]])}, KT, 1.4, pretension=6.0)
    return boxed(write, tendons, (14.0, 0, 0, 0, 0, 0))


@pytest.mark.parametrize("shape", ["cylinder", "sphere"])
def test_without_a_side_a_string_crosses_the_pulley_where_both_ways_are_as_long(write, shape):
    grasp = on_pulley(write, None, shape)
    cables = grasp.state.hand.stiffness.cables
    assert "'string'" in cables.crossed_body(np.array([LEAN - 0.01]), np.array([LEAN + 0.01]))
    for a in (-1.2, 0.0, LEAN - 0.03, LEAN + 0.01, 1.2):  # it leaves the pulley, and comes back to it
        assert not cables.crossed_body(np.array([a]), np.array([a + 0.02]))
    sided = on_pulley(write, (-0.02, 0, 0), shape).state.hand.stiffness.cables
    assert not sided.crossed_body(np.array([LEAN - 0.01]), np.array([LEAN + 0.01]))


def test_a_path_on_which_a_string_would_cross_a_pulley_is_given_up_there(write):
    grasp = on_pulley(write, None)
    path = grasp.follow(steps=20)
    assert not path.reached
    np.testing.assert_allclose(path.steps.q[-1, 0], LEAN, atol=1e-5)
    assert "goes over to the other side of the cylinder at places[1], on palm" in path.why
    verdict = grasp.check()
    assert verdict.word == "UNDECIDED"
    assert "pass the side (Around.side)" in str(verdict).replace("\n", " ")


def test_with_a_side_it_goes_on_with_the_radius_as_its_arm(write):
    path = on_pulley(write, (-0.02, 0, 0)).follow(steps=20)
    assert path.reached
    q, load = path.steps.q[:, 0], path.steps.load[:, 0]
    late = q > LEAN
    assert late.any()
    slope = np.diff(load[late] * L * np.cos(q[late])) / np.diff(q[late])
    np.testing.assert_allclose(slope, 1.4 + KT * ROUND**2, rtol=1e-5)  # own spring and the string, K_p + r² k
