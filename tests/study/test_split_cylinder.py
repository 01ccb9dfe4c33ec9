"""A split cylinder: closed forms of the force across it, a scan of all splits, levers at their torque limit."""

from functools import cache

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import handlcp as hl
from handlcp.studies.grip_strength.measure import close_with_full_torque
from handlcp.studies.grip_strength.result import ContactsAroundAxis
from tests.hand.levers import L, lever_hand, lever_pinch

R, N, MU, K = 0.025, 3.0, 0.5, 1e-3  # radius [m], grip [N], friction, flexibility [m/N]
Z, ORIGIN = (0, 0, 1), (0, 0, 0)


def pressed(angles, load=(0, 0, 0)):
    """Contacts around the z axis that press with N each, under a force."""
    ways = [np.array([np.cos(a), np.sin(a), 0.0]) for a in np.radians(angles)]
    contacts = [hl.Contact(R * d, -d, MU) for d in ways]
    solution = hl.Grasp(contacts, (*load, 0, 0, 0), flexibility=K, preload=K * N).solve()
    return ContactsAroundAxis.from_solution(solution, Z, ORIGIN)


def unit(degrees):
    return (np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0)


# ---------------------------------------------------------------- closed forms
@pytest.mark.parametrize("turn", [0.0, 20.0, -75.0])
def test_two_opposing_fingers_press_with_the_cosine_of_the_split(turn):
    around = pressed([turn, turn + 180])
    for off in (0, 30, -60, 89):
        assert around.split_force(unit(turn + off)) == pytest.approx(N * np.cos(np.radians(off)), abs=1e-9)
    assert around.largest[0] == pytest.approx(N, rel=1e-9)
    assert abs(around.largest[1] @ unit(turn)) == pytest.approx(1.0)
    assert around.least[0] == pytest.approx(0.0, abs=1e-9)
    assert abs(around.closing_normal @ unit(turn)) == pytest.approx(1.0)


def test_three_fingers_all_around_press_with_one_of_them_at_most():
    """One half has one finger; half of it has two others that lean by 60°. Turned by 30°, one touches the split."""
    around = pressed([0, 120, 240])
    assert around.split_force(unit(0)) == pytest.approx(N, rel=1e-9)
    assert around.split_force(unit(30)) == pytest.approx(N * np.cos(np.radians(30)), rel=1e-9)
    assert around.largest[0] == pytest.approx(N, rel=1e-9)
    assert around.least[0] == pytest.approx(N * np.cos(np.radians(30)), rel=1e-9)
    assert around.split_force(around.closing_normal) == pytest.approx(N, rel=1e-9)  # alike all around: the largest


def test_a_thumb_against_two_fingers_is_measured_across_the_thumb():
    around = pressed([180, 60, -60])
    assert around.split_force((1, 0, 0)) == pytest.approx(N, rel=1e-9)
    narrow = pressed([180, 20, -20])  # two press more than the thumb bears: they settle
    thumb = float(np.linalg.norm(narrow.forces[0]))
    assert abs(narrow.closing_normal @ (1, 0, 0)) == pytest.approx(1.0)
    assert narrow.split_force(narrow.closing_normal) == pytest.approx(thumb, rel=1e-9)


def test_a_load_is_borne_half_by_half():
    """2 N along x: one finger has a newton more, the other one less; the halves are pressed as before."""
    around = pressed([0, 180], (2.0, 0, 0))
    np.testing.assert_allclose(abs(around.forces[:, 0]), (N + 1.0, N - 1.0), rtol=1e-9)
    assert around.split_force((1, 0, 0)) == pytest.approx(N, rel=1e-9)


def test_both_halves_press_alike_without_a_load():
    found = of_hand("three_finger").pinch.around
    for n in (found.closing_normal, found.largest[1], np.cross(found.axis, found.closing_normal)):
        side = np.sign(found.positions @ n)
        halves = [-s * found.forces[side == s].sum(axis=0) @ n for s in (1.0, -1.0)]
        np.testing.assert_allclose(halves, found.split_force(n), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_no_split_of_a_scan_has_more_or_less(seed):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    around = ContactsAroundAxis(rng.normal(size=(5, 3)), rng.normal(size=(5, 3)), axis)
    x = np.cross(axis, (1, 0, 0))
    x /= np.linalg.norm(x)
    y = np.cross(axis, x)
    scan = [around.split_force(np.cos(a) * x + np.sin(a) * y) for a in np.linspace(0, np.pi, 20001)]
    for (value, n), known in ((around.largest, max(scan)), (around.least, min(scan))):
        assert value == pytest.approx(known, abs=2e-3)
        assert n @ axis == pytest.approx(0.0, abs=1e-9)
        near = [around.split_force(np.cos(a) * n + np.sin(a) * np.cross(axis, n)) for a in (-1e-7, 1e-7)]
        assert min(abs(f - value) for f in near) < 1e-5  # on one side of it at least
    assert around.largest[0] >= max(scan) - 1e-12
    assert around.least[0] <= min(scan) + 1e-12


def test_a_normal_along_the_axis_is_refused():
    around = pressed([0, 180])
    with pytest.raises(hl.InputError, match="normal"):
        around.split_force(Z)
    with pytest.raises(hl.InputError, match="axis"):
        ContactsAroundAxis.from_solution(of_hand("three_finger").pinch.solution, ORIGIN, ORIGIN)


# ---------------------------------------------------------------- full torque
@cache
def of_hand(name, diameter=0.05, stiffness=6.0):
    return hl.split_cylinder(hl.example_hand(name, joint_stiffness=stiffness), diameter, grasps=["pinch"])


@pytest.mark.parametrize("most", [0.1, 0.4])
def test_levers_press_with_their_torque_over_their_length(tmp_path, most):
    def write(text):
        path = tmp_path / "levers.urdf"
        path.write_text(text, encoding="utf-8")
        return path

    hand = lever_hand(write, torque_limits=most, joint_stiffness=2e3, pad_flexibility=1e-6)
    grasp = lever_pinch(hand, (0.0, 0.0, 0.0), grip_force=1.0)
    share = float(grasp.solve().torque_check.utilisation.max())
    one = close_with_full_torque(grasp, np.ones(2), share)
    assert {(b.kind, b.who) for b in one.binds} == {("torque", "left_joint"), ("torque", "right_joint")}
    around = ContactsAroundAxis.from_solution(one.path.solution, (0, 1, 0), (0, 0, L))
    assert around.split_force((1, 0, 0)) == pytest.approx(most / L, rel=1e-4)


def test_a_little_more_grip_is_over_a_limit_and_a_little_less_is_held():
    pinch = of_hand("three_finger").pinch
    assert pinch.word == "HELD"
    assert {b.kind for b in pinch.binds} == {"torque"}
    check = pinch.solution.torque_check
    assert check.utilisation.max() == pytest.approx(1.0, abs=1e-6)
    assert check.binding in {b.who for b in pinch.binds}
    for share, word in ((0.97, "HELD"), (1.03, "OVER LIMIT")):
        grip = share * np.array(pinch.grasp.spec.asked.grip_force)
        assert pinch.grasp.replace(grip_force=grip).check().word == word


def test_a_motor_with_half_the_torque_presses_half_as_hard():
    """In the same grasp; a search by a weaker hand may find another one."""
    hand = hl.example_hand("three_finger", joint_stiffness=200.0)  # stiff: the motions are small
    cylinder = hl.Cylinder(0.025, 0.15, mass=0.0)
    found = hl.find_grasp(hand, cylinder, gravity=(0, 0, 0), tries=6)[0]
    grip, forces = np.array(found.grasp.spec.asked.grip_force), []
    for limits in (hand.torque_limits, 0.5 * hand.torque_limits):
        grasp = hand.replace(torque_limits=limits).at(found.q).grasp(found.object, gravity=(0, 0, 0), grip_force=grip)
        share = float(grasp.solve().torque_check.utilisation.max())
        forces.append(close_with_full_torque(grasp, grip, share).path.solution.normal_force.max())
    assert forces[1] == pytest.approx(0.5 * forces[0], rel=0.02)


def test_bad_questions_are_refused():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    with pytest.raises(hl.InputError, match=r"hand: expected a hand with a torque limit.*finger_1_distal"):
        hl.split_cylinder(hand.replace(torque_limits={"finger_1_distal": np.inf}), 0.05)
    for given in ({"diameter": 0.0}, {"grasps": ["hook"]}, {"grasps": "pinch"}, {"normal": (1, 0)}, {"length": -1.0}):
        asked = {"diameter": 0.05} | given
        with pytest.raises(hl.InputError, match=next(iter(given))):
            hl.split_cylinder(hand, asked.pop("diameter"), **asked)


@pytest.mark.long
def test_a_cylinder_that_no_hand_pinches_is_said():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    with pytest.raises(hl.NoGraspFound, match="no pinch grasp"):
        hl.split_cylinder(hand, 0.6, grasps=["pinch"])


@pytest.mark.long
def test_a_power_grasp_presses_all_around_with_all_its_torque():
    """Let go, the cylinder settles, and the joints that closed with their limits need a little more or less."""
    found = hl.split_cylinder(hl.example_hand("five_finger", joint_stiffness=6.0), 0.065, grasps=["power"])
    assert found.missing == {}
    assert found.pinch is None
    assert found.power.word in ("HELD", "OVER LIMIT")
    assert found.power.solution.utilisation.max() == pytest.approx(1.0, abs=0.1)
    assert 0.0 < found.power.least <= found.power.force <= found.power.largest
    assert len(found.power.grasp.contacts) > 5


# ---------------------------------------------------------------- as text and as a picture


@pytest.mark.long
def test_the_normal_that_is_given_is_measured_across():
    found, hand = of_hand("three_finger"), hl.example_hand("three_finger", joint_stiffness=6.0)
    n = np.cross(found.pinch.around.axis, found.pinch.normal)
    turned = hl.split_cylinder(hand, 0.05, normal=n, grasps=["pinch"]).pinch
    assert turned.force == pytest.approx(found.pinch.around.split_force(n), rel=1e-9)
    assert turned.largest == pytest.approx(found.pinch.largest, rel=1e-9)


def test_the_picture_has_an_arrow_for_each_contact_and_the_force_over_the_angle(tmp_path):
    found = of_hand("three_finger")
    figure = found.plot(title="How hard?")
    FigureCanvasAgg(figure).draw()
    section, curve = figure.axes
    words = " ".join(t.get_text() for t in section.texts)
    assert all(name in words for name in found.pinch.solution.names)
    angles, forces = curve.lines[0].get_data()
    assert max(forces) == pytest.approx(found.pinch.largest, rel=1e-3)
    assert forces[np.argmin(abs(angles))] == pytest.approx(found.pinch.force)
    assert found.plot(tmp_path / "split.png").read_bytes().startswith(b"\x89PNG")
