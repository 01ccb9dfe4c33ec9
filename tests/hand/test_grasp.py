"""A hand's grasp: contact axes, weight, torques by virtual work, and the torque check."""

import numpy as np
import pytest

from handlcp import Contact, Coulomb, Frictionless, Grasp, NoSolutionFound
from handlcp.errors import InputError, UnknownName
from handlcp.geometry import Box, Cylinder, Sphere
from handlcp.hand import TorqueCheck, example_hand
from tests.support.grasp import arrays
from tests.support.hand import jacobian_at, torque_check_of
from tests.support.refusals import refused
from tests.support.texts import says, without_numbers

BALL = Sphere(0.03, (0.001, -0.002, 0.09), mass=0.03)


@pytest.fixture
def held(five):
    """Five fingers squeezing a ball by 6 mm."""
    return five.at(five.close_on(BALL, squeeze=6e-3)).grasp(BALL)


def contacts_of(grasp):
    """The same contacts, made by hand."""
    return [Contact(c.position, c.normal, c.friction, c.tangent) for c in grasp.contacts]


def test_detected_contacts_are_ordinary_contacts(held):
    """Made in one go, they equal what the constructor makes, frame by frame."""
    for c, name in zip(held.contacts, held.fingertips, strict=True):
        same = Contact(c.position, c.normal, c.friction, None, c.name)
        np.testing.assert_allclose(c.rotation, same.rotation, atol=1e-15)
        assert (c.name, c.mu, c.planar, repr(c)) == (name, 0.6, False, repr(same))
        assert not c.position.flags.writeable
        assert not c.rotation.flags.writeable


def test_flexibility_is_turned_into_contact_axes(five):
    """E of the grasp = Rᵀ (J K⁻¹ Jᵀ + pads) R at the contact points, with anisotropic pads and tendons."""
    rng = np.random.default_rng(0)
    A = rng.normal(size=(10, 10))
    pads = np.diag([1e-4, 3e-4, 6e-4])
    hand = example_hand("five_finger", joint_stiffness=A @ A.T + 5 * np.eye(10), pad_flexibility=pads)
    state = hand.at(five.close_on(BALL))
    grasp = state.grasp(BALL)
    positions, frames = arrays(grasp).positions, grasp.frames
    J = jacobian_at(state, positions).reshape(15, 10)
    world = J @ np.linalg.solve(hand.joint_stiffness, J.T)
    R = np.zeros((15, 15))
    for i in range(5):
        block = slice(3 * i, 3 * i + 3)
        world[block, block] += state.tip_rotations[i] @ pads @ state.tip_rotations[i].T
        R[block, block] = frames[i]
    np.testing.assert_allclose(arrays(grasp).flexibility, R.T @ world @ R, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(grasp.jacobian, R.T @ J, atol=1e-15)
    E = arrays(grasp).flexibility
    assert (E == E.T).all()


def test_contacts_given_equal_contacts_found(held):
    """Contacts in a list, in a mapping, and a plain Grasp with the same arrays: the same forces."""
    state, load = held.state, np.array([0, 0, -0.03 * 9.81, 0, 0, 0])
    cs, reference = contacts_of(held), BALL.center_of_mass
    shift = held.offset
    expected = held.solve()
    as_list = state.grasp(cs, wrench=load, offset=shift, reference=reference)
    named = dict(reversed(list(zip(held.fingertips, cs, strict=True))))
    as_mapping = state.grasp(named, wrench=load, offset=shift, reference=reference)
    plain = Grasp(cs, load, flexibility=arrays(held).flexibility, offset=shift, reference=reference)
    for grasp in (as_list, as_mapping, plain):
        solution = grasp.solve()
        np.testing.assert_allclose(solution.forces, expected.forces, atol=1e-9)
        np.testing.assert_allclose(solution.object_displacement, expected.object_displacement, atol=1e-9)
    assert as_list.names == as_mapping.names == held.fingertips
    np.testing.assert_allclose(as_list.solve().torques, expected.torques, atol=1e-9)


def test_weight_acts_at_the_centre_of_mass(held):
    """The same load about another reference, weight included: the same forces, and the moment that belongs to it."""
    point = np.array([0.1, 0.2, -0.3])
    other = held.state.grasp(BALL, reference=point)
    np.testing.assert_allclose(arrays(other).force, [0, 0, -0.03 * 9.81], atol=1e-15)
    arm = BALL.center_of_mass
    np.testing.assert_allclose(arrays(other).moment, np.cross(arm, arrays(other).force), atol=1e-15)
    np.testing.assert_allclose(arrays(other).moment, arrays(held).moment, atol=1e-15)
    np.testing.assert_allclose(other.solve().forces, held.solve().forces, atol=1e-9)
    light = held.state.grasp(BALL, gravity=(0, 0, 0))
    assert not arrays(light).force.any()


def test_the_ring_grasps_in_its_plane():
    """Contacts made of 2-vectors, and a detected disc with a plane, give the same planar grasp."""
    hand = example_hand("planar_ring", torque_limits={"finger_1_distal": 0.001})
    disc = Cylinder(0.03, 0.02, mass=0.1)
    state = hand.at(hand.close_on(disc, np.tile([0.5, -0.9], 6), squeeze=2e-3))
    load = (0.3, 0.1, 0.0, 0.0, 0.0, 0.002)
    found = state.grasp(disc, wrench=load, gravity=(0, -9.81, 0), plane=(0, 0, 1))
    flat = [Contact(c.position[:2], c.normal[:2], c.friction) for c in found.contacts]
    given = state.grasp(flat, wrench=(0.3, 0.1 - 0.981, 0.002), preload=-found.offset[:, 2])
    a, b = found.solve(), given.solve()
    assert a.held
    np.testing.assert_allclose(a.forces_world, b.forces_world, atol=1e-7)
    np.testing.assert_allclose(a.torques, b.torques, atol=1e-9)
    assert abs(a.forces_world[:, 2]).max() < 1e-12
    assert a.torque_check.binding == "finger_1_distal"
    with pytest.raises(InputError):
        state.grasp(disc, plane=(0, 0, 1))


def test_a_plane_may_miss_the_reference():
    """A load in the plane of the contacts has a moment out of it 100 mm below: 0.1 z × f."""
    hand = example_hand("planar_ring")
    disc = Cylinder(0.03, 0.02)
    state = hand.at(hand.close_on(disc, np.tile([0.5, -0.9], 6), squeeze=2e-3))
    flat = {"gravity": (0, 0, 0), "plane": (0, 0, 1)}
    here = state.grasp(disc, wrench=(0.3, 0.1, 0, 0, 0, 0.002), **flat).solve()
    for wrench in [(0.3, 0.1, 0, -0.01, 0.03, 0.002), (0.3, 0.1, 0.002)]:
        below = state.grasp(disc, wrench=wrench, reference=(0, 0, -0.1), **flat).solve()
        np.testing.assert_allclose(below.forces, here.forces, atol=1e-12)
        np.testing.assert_allclose(below.object_displacement, here.object_displacement, atol=1e-15)
    with pytest.raises(InputError, match=r"0\.1 m ") as caught:
        state.grasp(disc, wrench=(0.3, 0.1, 0, 0, 0, 0.002), reference=(0, 0, -0.1), **flat)
    on_the_side = Cylinder(0.03, 0.02, (0, 0, 0.005), mass=0.1)
    says(caught.value.expected, "reference")
    with pytest.raises(InputError, match=r"0\.005 m ") as caught:
        state.grasp(on_the_side, gravity=(0, -9.81, 0), plane=(0, 0, 1))
    says(caught.value.expected, "centre")


def test_no_solution_leaves_nan_torques(five):
    """Not held: NaN torques that nobody can mistake for an answer, ok is False, and the error carries them."""
    state = five.at(five.close_on(BALL))
    grasp = state.grasp(BALL, Frictionless(), wrench=(0, 0, 0, 0, 0, 1))
    solution = grasp.solve(throw=False)
    assert not solution.held
    assert np.isnan(solution.torques).all()
    assert not solution.torque_check.ok
    with pytest.raises(NoSolutionFound) as caught:
        grasp.solve()
    assert isinstance(caught.value.solution.torque_check, TorqueCheck)


def test_torque_check_names_the_binding_joint(held):
    """Joint by joint torque, limit and utilisation; the highest binds; printed as a table."""
    hand = example_hand("five_finger", torque_limits={"finger_3_distal": 0.01})
    solution = hand.at(held.state.q).grasp(BALL).solve()
    check = solution.torque_check
    assert check.binding == "finger_3_distal"
    assert not check.ok
    row = check["finger_3_distal"]
    assert row.limit == 0.01
    assert row.utilisation == pytest.approx(abs(row.torque) / 0.01)
    assert [r.joint for r in check] == list(hand.joint_names)
    text = str(solution)
    (marked,) = (line for line in text.splitlines() if line.strip().startswith("finger_3_distal") and "%" in line)
    says(without_numbers(marked), "finger_3_distal")
    says(check.verdict, "finger_3_distal")
    assert check.verdict in str(check)
    assert held.solve().torque_check.ok
    with pytest.raises(UnknownName, match="finger_1_distal"):
        check["thumb"]


def test_torque_check_without_limits_claims_nothing():
    """An unknown limit is neither used up nor ok; an explicit inf is no limit; the rows stay finite."""
    check = torque_check_of(("a", "b", "c"), [1.0, -2.0, 0.0], [np.inf, np.inf, 2.0], (False, True, True))
    assert np.isfinite(check.utilisation).all()
    assert check.unknown == ("a",)
    assert not check.ok
    assert check.binding == "b"  # the first of two that use nothing of their limits
    says(check.verdict, "a")
    assert check.verdict in str(check)
    assert torque_check_of(("a",), [1.0], [np.inf]).ok
    nothing = torque_check_of(("a",), [1.0], [np.inf], (False,))
    assert nothing.binding is None
    assert not nothing.ok


@pytest.mark.parametrize(
    ("target", "arguments", "argument", "kind"),
    [
        ("ball", {"friction": {"finger_1_tip": "rubber"}}, "friction['finger_1_tip']", InputError),
        ("ball", {"friction": {"thumb": Coulomb(0.5)}}, "friction", UnknownName),
        ("ball", {"gravity": (0, 0, np.nan)}, "gravity", InputError),
        ("ball", {"wrench": (0, 0, 1)}, "wrench", InputError),
        ("ball", {"preload": [1.0, 2.0]}, "preload", InputError),
        ("ball", {"fingers": ["finger_1_tip", "finger_1_tip"]}, "fingers", InputError),
        ("ball", {"effects": ["friction"]}, "effects[0]", InputError),
        ("contacts", {"friction": Coulomb(0.5)}, "friction", InputError),
        ("too few", {}, "contacts", InputError),
        ("unknown finger", {}, "contacts", UnknownName),
        ("missing finger", {"fingers": ["finger_1_tip", "finger_2_tip"]}, "contacts", InputError),
    ],
)
def test_bad_arguments_are_named(held, target, arguments, argument, kind):
    """One broken argument a time."""
    cs = contacts_of(held)
    unknown, missing = {"thumb": cs[0]}, {"finger_1_tip": cs[0]}
    named = {"ball": BALL, "contacts": cs, "too few": cs[:3], "unknown finger": unknown, "missing finger": missing}
    refused(argument, held.state.grasp, named[target], error=kind, **arguments)


def test_box_between_two_fingers_is_held_by_friction():
    """Two fingers pinch a 50 g box: each carries half its weight, the squeeze is symmetric."""
    hand = example_hand("two_finger")
    box = Box((0.03, 0.04, 0.06), (0.0, 0.0, 0.08), mass=0.05)
    grasp = hand.at(hand.close_on(box, squeeze=5e-3)).grasp(box)
    solution = grasp.solve()
    np.testing.assert_allclose(solution.forces_world[:, 2], 0.05 * 9.81 / 2, rtol=1e-6)
    np.testing.assert_allclose(solution.forces_world[0, 0], -solution.forces_world[1, 0], rtol=1e-6)
