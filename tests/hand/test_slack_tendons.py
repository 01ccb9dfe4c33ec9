"""Tendons pull and never push: closed forms of levers, limits of tensions, energy, MuJoCo, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName
from handlcp.hand import example_hand

from .levers import PAD, L, lever_hand, lever_pinch

ARM, KT, OWN = 0.01, 6e4, 4.0  # m, N/m, N·m/rad
SHUT, PULL = 0.05, 8.0  # rad commanded; N on the object
BOTH = OWN + 2 * KT * ARM**2  # N·m/rad of a joint with both tendons
ONE = OWN + KT * ARM**2
PRESSED = SHUT * L / (L * L / BOTH + PAD)  # N of each finger once the hand has closed
ASIDE = [PULL, 0.0, 0.0, 0.0, 0.0, 0.0]
WAYS = {"flexor": ARM, "extensor": -ARM}
ARMS = {f"{side}_{way}": {f"{side}_joint": arm} for side in ("left", "right") for way, arm in WAYS.items()}


def along(K):
    """[N/m] of a tip along its normal, joint and pad."""
    return 1.0 / (L * L / K + PAD)


def pinch(write, pretension=0.0, shut=SHUT, **tendons):
    """Levers with a flexor and an extensor each."""
    hand = lever_hand(write, joint_stiffness=hl.Tendons(ARMS, KT, OWN, pretension=pretension, **tendons))
    return lever_pinch(hand, (0.0, 0.0, 0.0), **({"joint_offset": [shut] * 2} if shut else {}))


@pytest.mark.parametrize("steps", [1, 40])
def test_a_finger_pushed_open_loses_its_extensor_and_the_other_keeps_both(write, steps):
    """Of the joint behind the flexor alone is left; the one that follows the object has both. In one step or many."""
    path = pinch(write).follow(ASIDE, steps=steps, geometry="fixed")
    load, moved = path.steps.load[:, 0], path.steps.displacement[:, 0]
    np.testing.assert_allclose(moved, load / (along(ONE) + along(BOTH)), atol=1e-8 * moved.max())
    assert [(e.kind, e.who) for e in path.events] == [("slackens", "right_extensor")]
    assert path.steps.tensions[-1, 3] == 0.0
    assert path.solution.held


@pytest.mark.parametrize("more", [1.0, 2.5])
def test_pretension_keeps_an_extensor_taut_until_the_joint_has_let_it_go(write, more):
    """T₀ = k r Δq, where the joint gives way by Δq = F L / K."""
    path = pinch(write, pretension=more).follow(ASIDE, steps=80, geometry="fixed")
    load, moved = path.steps.load[:, 0], path.steps.displacement[:, 0]
    first = 2.0 * more * BOTH / (KT * ARM * L)  # half of the load on each
    assert 0.0 < first < PULL
    before = load / (2.0 * along(BOTH))
    after = first / (2.0 * along(BOTH)) + (load - first) / (along(ONE) + along(BOTH))
    np.testing.assert_allclose(moved, np.where(load < first, before, after), atol=1e-7 * moved.max())


def test_a_rod_pushes_and_is_as_stiff_as_a_spring(write):
    path = pinch(write, pretension=np.inf).follow(ASIDE, geometry="fixed")
    np.testing.assert_allclose(path.steps.displacement[-1, 0], PULL / (2.0 * along(BOTH)), rtol=1e-8)
    assert not path.events


def test_drives_let_no_tendon_go_below_its_pretension_while_they_close(write):
    """The flexor makes the torque of the contact and turns the joint against its own spring; the extensor stays at
    T₀.
    """
    for pretension in (0.0, 3.0):
        end = pinch(write, pretension=pretension).follow(order="squeeze", geometry="fixed").last
        made = (PRESSED * L + OWN * (SHUT - PRESSED * L / BOTH)) / ARM
        np.testing.assert_allclose(end.pull.tension, pretension + made * np.array([1.0, 0.0] * 2), atol=1e-6)


def test_a_flexor_that_works_against_a_spring_never_goes_slack(write):
    """Contacts push joints open alone, so that such a hand is what it was when tendons were springs."""
    arms = {name: row for name, row in ARMS.items() if "flexor" in name}
    moved = []
    for pretension in (0.0, np.inf):
        hand = lever_hand(write, joint_stiffness=hl.Tendons(arms, KT, OWN, pretension=pretension))
        path = lever_pinch(hand, (0.0, 0.0, 0.0), joint_offset=[0.01] * 2).follow(ASIDE, geometry="fixed")
        assert "opens" in {e.kind for e in path.events}
        assert path.steps.tensions[-1].min() > 0.0
        moved.append(path.steps.displacement)
    np.testing.assert_allclose(moved[0], moved[1], rtol=0.0, atol=1e-12)


def test_two_tendons_that_share_a_spring_go_slack_as_the_rest_allows(write):
    """Coupled tendons, k not diagonal: of a pair of which one is slack the other is as stiff as k₁₁ - k₁₂² / k₂₂."""
    k = np.kron(np.eye(2), KT * np.array([[1.0, 0.4], [0.4, 1.0]]))
    hand = lever_hand(write, joint_stiffness=hl.Tendons(ARMS, k, OWN))
    path = lever_pinch(hand, (0.0, 0.0, 0.0), joint_offset=[SHUT] * 2).follow(ASIDE, geometry="fixed")
    both, one = OWN + 1.2 * KT * ARM**2, OWN + (1.0 - 0.16) * KT * ARM**2
    np.testing.assert_allclose(path.steps.displacement[-1, 0], PULL / (along(one) + along(both)), rtol=1e-8)


def test_what_a_tendon_bears_ends_a_load_and_decides_a_verdict(write):
    """The flexor behind the load takes F along(ONE) / (along(ONE) + along(BOTH)) of it at its tip, all but the share of
    the joint's own spring.
    """
    closed = (PRESSED * L + OWN * (SHUT - PRESSED * L / BOTH)) / ARM
    more = 10.0
    taken = more * ARM * ONE / (KT * ARM**2) / L  # N at the tip
    load = taken * (along(ONE) + along(BOTH)) / along(ONE)
    limit = pinch(write, limits={"right_flexor": closed + more}).load_limit(ASIDE, geometry="fixed")
    assert [(c.kind, c.who) for c in limit.binds] == [("tension", "right_flexor")]
    np.testing.assert_allclose(limit.factor * PULL, load, rtol=1e-6)
    assert "right_flexor reaches the limit of its tension" in limit.why
    verdict = pinch(write, limits=0.5 * closed).check()
    assert verdict.word == "OVER LIMIT"
    (reason,) = verdict.about("tension_over_limit")
    assert [r["tendon"] for r in reason.values["tendons"]] == ["left_flexor", "right_flexor"]
    for r in reason.values["tendons"]:
        np.testing.assert_allclose(r["tension_N"], closed, rtol=1e-4)


LOAD = [2.0, 1.0, 0.0, 0.0, 0.02, 0.0]


def boxed(pretension, k=1e4):
    """A box in three fingers with a flexor and an extensor at each joint."""
    box = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    joints = example_hand("three_finger").joint_names
    arms = {f"{j} {way}": {j: arm} for j in joints for way, arm in (("flexor", 0.01), ("extensor", -0.008))}
    tendons = hl.Tendons(arms, k, 1.0, pretension=pretension)
    hand = example_hand("three_finger", joint_stiffness=tendons, pad_flexibility=3e-5)
    return hand.at(hand.close_on(box)).grasp(box, friction=0.8, squeeze=0.008, wrench=LOAD)


@pytest.mark.parametrize("pretension", [0.0, 1.0])
def test_mujoco_has_the_same_forces_and_tensions(pretension):
    pytest.importorskip("mujoco")
    from handlcp.simulator import simulate

    grasp = boxed(pretension)
    path, truth = grasp.follow(), simulate(grasp)
    assert path.reached
    assert truth.held
    size = np.abs(truth.forces_world).max()
    np.testing.assert_allclose(path.solution.forces_world, truth.forces_world, atol=0.02 * size)


def test_what_a_slack_tendon_falls_short_of_is_the_pretension_that_keeps_it_taut():
    """As `required_torque` advises. Tried: with as much none goes slack, with less some do."""
    missing = -min(float(s.pull.taut.min()) for s in boxed(0.0).follow().steps.states)
    assert missing > 0.0
    assert not [e for e in boxed(1.05 * missing).follow().events if e.kind == "slackens"]
    assert [e for e in boxed(0.8 * missing).follow().events if e.kind == "slackens"]


@pytest.mark.parametrize(
    ("more", "error", "words"),
    [
        ({"pretension": -1.0}, InputError, "Tendons.pretension: expected a number ≥ 0"),
        ({"pretension": {"thumb": 1.0}}, UnknownName, "thumb"),
        ({"limits": {"left_flexor": -2.0}}, InputError, r"Tendons.limits\['left_flexor'\]"),
        ({"limits": {"left_flexor": 2.0}, "pretension": 3.0}, InputError, "at least the pretension, 3 N"),
    ],
)
def test_tendons_that_cannot_be_are_refused(more, error, words):
    with pytest.raises(error, match=words):
        hl.Tendons(ARMS, KT, OWN, **more)


def test_a_command_against_the_way_of_every_tendon_is_not_called_held(write):
    arms = {f"{side}_extensor": {f"{side}_joint": -ARM} for side in ("left", "right")}
    grasp = lever_pinch(lever_hand(write, joint_stiffness=hl.Tendons(arms, KT, OWN)), joint_offset=[SHUT] * 2)
    assert grasp.solve().verdict.word == "UNDECIDED"
    verdict = grasp.check()
    (reason,) = verdict.about("command_not_made")
    assert verdict.word == "UNDECIDED"
    assert "it takes tendons that pull the other way to turn left_joint with 0." in reason.sentence
    assert reason.values["share"] == pytest.approx(1.0)
    assert grasp.load_limit(ASIDE).doubt == reason.sentence


@pytest.mark.long
def test_motors_sized_for_tendons_that_pull_the_other_way_are_not_confirmed():
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.3)
    arms = {f"cable_{k}": {f"finger_{k}_proximal": -0.012, f"finger_{k}_distal": -0.008} for k in (1, 2, 3)}
    hand = example_hand("three_finger", joint_stiffness=hl.Tendons(arms, 2e4, 4.0))
    grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, grip_force=5.0)
    sized = grasp.required_torque(tolerance=0.5)
    assert not sized.confirmed
    assert not sized.enough


@pytest.mark.parametrize(("share", "word"), [(0.005, "HELD"), (0.02, "UNDECIDED")])
def test_a_hundredth_of_a_command_that_no_tendon_makes_is_a_doubt_and_more_decides(write, share, word):
    arms = {"both": {"left_joint": ARM, "right_joint": ARM}}
    hand = lever_hand(write, joint_stiffness=hl.Tendons(arms, KT, OWN))
    told = np.linalg.solve(hand.joint_stiffness, [1.0 + share, 1.0 - share])  # N·m, of which the tendon makes 1 and 1
    verdict = lever_pinch(hand, (0.0, 0.0, 0.0), joint_offset=told).check()
    (reason,) = verdict.about("command_not_made")
    assert verdict.word == word
    assert reason.values["share"] == pytest.approx(share, rel=0.05)


def test_what_a_tendon_uses_of_its_limit_stands_beside_its_tension(write):
    """Its whole tension, pretension included, whether that is of one solve or of the end of a path."""
    grasp = pinch(write, pretension=3.0, limits={"left_flexor": 80.0, "right_flexor": 80.0})
    one, end = grasp.solve(throw=False), grasp.follow(ASIDE, geometry="fixed").solution
    for solution, begun in ((one, 3.0), (end, 0.0)):
        effort = solution.effort
        np.testing.assert_allclose(effort.limits, [80.0, np.inf] * 2)
        np.testing.assert_allclose(effort.used[::2], (effort.values[::2] + begun) / 80.0, rtol=1e-12)
        assert not effort.used[1::2].any()
        first, second, *_ = effort.table.rows
        assert (first[2], second[2:]) == ("80.00", ("none", "–"))
        assert first[3] == f"{100 * effort.used[0]:.0f} %"
    plain = pinch(write).solve(throw=False).effort
    assert plain.table.heads == ("tendon tension", "N")
