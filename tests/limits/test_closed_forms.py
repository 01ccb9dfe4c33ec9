"""Load limits beside closed forms, written from the laws alone: Coulomb's cone, springs in series, levers."""

import numpy as np
import pytest

import handlcp as hl
from tests.limits.pinches import C, bare_pinch, polygon
from tests.loading.hands import sliders
from tests.support.grasp import limit_surface

NEAR = 1e-9
P = 1e-3  # squeeze of each normal [m]
N = P / C  # normal force of two opposite contacts [N]
MU, SPIN = 0.4, 0.004  # friction of forces [-] and of moments [m]
G, TIP = 9.81, 0.005
LIMIT = 0.13  # of the joints of a cube's three fingers [N·m]; the squeeze takes 0.116 of it


def limit(grasp, wrench, faces="cone", **more):
    """With the geometry of the posture."""
    return grasp.load_limit(wrench, geometry="fixed", faces=faces, **more)


def kinds(found):
    return {b.kind for b in found.binds}


def named(found):
    return {b.who for b in found.binds}


def pinch(law=MU, tangent=(0, 1, 0), **more):
    """Two contacts, 60 mm apart along x, that press with N each."""
    return bare_pinch(law, P, tangent=tangent, **more)


# ---------------------------------------------------------------- a pinch
@pytest.mark.parametrize("faces", ["cone", 4, 8, 16])
@pytest.mark.parametrize("degrees", [0.0, 10.0, 22.5, 45.0, 77.0, 180.0, 300.0])
def test_a_pinch_slips_at_twice_the_friction_of_one_contact(faces, degrees):
    angle = np.radians(degrees)
    found = limit(pinch(), (0, np.cos(angle), np.sin(angle), 0, 0, 0), faces)
    assert found.factor == pytest.approx(2 * MU * N * polygon(faces, angle), rel=NEAR)
    assert kinds(found) == {"slips"}
    assert named(found) == {"finger 1", "finger 2"}
    assert found.at_limit.held


@pytest.mark.parametrize(("along", "mu"), [((0, 0, 1), 0.6), ((0, 1, 0), 0.3)])
def test_an_anisotropic_pinch_slips_at_the_coefficient_of_its_direction(along, mu):
    law = hl.AnisotropicCoulomb(0.6, 0.3, along=(0, 0, 1))
    assert limit(pinch(law, None), (*along, 0, 0, 0)).factor == pytest.approx(2 * mu * N, rel=NEAR)


def test_hard_fingers_do_not_resist_a_turn_about_their_line():
    found = limit(pinch(), (0, 0, 0, 1, 0, 0))
    assert found.factor == 0.0
    assert kinds(found) == {"equilibrium"}


def test_a_motion_that_is_allowed_ends_the_path_where_springs_say():
    found = limit(pinch(), (0, 0, 1, 0, 0, 0), motion=1e-4)
    assert found.factor == pytest.approx(1e-4 * 2 / C, rel=NEAR)  # two springs side by side
    assert kinds(found) == {"motion"}


def test_a_total_bound_on_the_normal_forces_gives_way():
    found = limit(pinch(effects=[hl.TotalForceBound(1.2 * N)]), (0, 0, 1, 0, 0, 0))
    assert found.factor == pytest.approx(MU * 1.2 * N, rel=NEAR)
    assert found.bound == pytest.approx(found.factor, rel=1e-6)
    assert found.some_equilibrium == found.factor


def test_the_factor_on_the_own_load_is_its_safety():
    assert limit(pinch(wrench=(0, 0, MU * N, 0, 0, 0)), None).factor == pytest.approx(2.0, rel=NEAR)


def test_a_force_across_a_pinch_is_no_load_of_its_friction():
    # Along their line one contact is relieved, and opens at twice its squeeze; the other one bears the rest
    found = limit(pinch(), (1, 0, 0, 0, 0, 0), 8)
    assert found.factor == np.inf
    assert [(e.kind, e.who) for e in found.events] == [("opens", "finger 1")]
    assert found.events[0].factor == pytest.approx(2 * N, rel=NEAR)


@pytest.mark.parametrize("degrees", [15.0, 40.0, 80.0])
@pytest.mark.parametrize("faces", ["cone", 8])
def test_an_oblique_force_is_lost_at_the_contact_that_it_relieves(faces, degrees):
    # N1 = N - X/2; without a moment both bear Y/2, so that the object turns about contact 2 where Y/2 = μ N1
    a = np.radians(degrees)
    found = limit(pinch(), (np.cos(a), np.sin(a), 0, 0, 0, 0), faces)
    mu = MU * polygon(faces, 0.0)
    assert found.factor == pytest.approx(2 * mu * N / (np.sin(a) + mu * np.cos(a)), rel=NEAR)
    assert found.events == ()


@pytest.mark.parametrize("faces", ["cone", 4, 8])
def test_soft_fingers_spin_at_twice_the_torsion_of_one(faces):
    share = 1.0 if faces == "cone" else limit_surface(hl.Pyramid(faces)).share
    found = limit(pinch(hl.SoftFinger(MU, SPIN, 3.0)), (0, 0, 0, 1, 0, 0), faces)
    assert found.factor == pytest.approx(2 * SPIN * N * share, rel=1e-7)  # faces of the polyhedron meet in it
    assert kinds(found) == {"slips"}


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.9, 1.0])
def test_soft_fingers_bear_force_and_moment_within_one_ellipse(share):
    force, moment = np.cos(share * np.pi / 2) * 2 * MU * N, np.sin(share * np.pi / 2) * 2 * SPIN * N
    found = limit(pinch(hl.SoftFinger(MU, SPIN, 3.0)), (0, 0.6 * force, 0.8 * force, moment, 0, 0))
    assert found.factor == pytest.approx(1.0, rel=NEAR)
    assert kinds(found) == {"slips"}


def gripper(tmp_path, offset=2e-3, mass=0.1, limits=np.inf, effects=()):
    """Two sliders that press on opposite faces of a box: name, hand's grasp, and with which force."""
    way = {"left": ((-0.03 - TIP, 0, 0), (1, 0, 0)), "right": ((0.03 + TIP, 0, 0), (-1, 0, 0))}
    hand = sliders(tmp_path, way, 2000.0, pad_flexibility=C, torque_limits=limits, tip_radius=TIP)
    box = hl.Box(0.06, [0, 0, 0], mass=mass)
    held = hand.at(hand.neutral).grasp(box, hl.Coulomb(MU), joint_offset=np.full(2, offset), effects=effects)
    return held, offset / (1 / 2000.0 + C)


@pytest.mark.parametrize("degrees", [-90.0, -30.0, 0.0, 45.0, 90.0])
def test_a_hand_that_pinches_slips_where_weight_and_load_together_are_at_the_cone(tmp_path, degrees):
    held, squeeze = gripper(tmp_path)
    weight, a = 0.1 * G, np.radians(degrees)
    found = limit(held, (0, np.cos(a), np.sin(a), 0, 0, 0))
    # |(F cos a, F sin a - W)| = 2 μ N
    down = weight * np.sin(a)
    assert found.factor == pytest.approx(down + np.sqrt(down**2 - weight**2 + (2 * MU * squeeze) ** 2), rel=NEAR)
    assert named(found) == {"left_tip", "right_tip"}


def test_a_weight_that_is_too_much_leaves_nothing_for_a_load(tmp_path):
    held, squeeze = gripper(tmp_path, mass=1.01 * 2 * MU * 2e-3 / (1 / 2000.0 + C) / G)
    found = limit(held, (0, 0, -1, 0, 0, 0))
    assert found.factor == 0.0
    assert held.replace(mass=0.99 * 2 * MU * squeeze / G).load_limit((0, 0, -1, 0, 0, 0), geometry="fixed").factor > 0


# ---------------------------------------------------------------- a ring without friction
def ring(n, **more):
    """So many contacts of one circle in the plane, without friction, that press with N each."""
    turns = 2 * np.pi * np.arange(n) / n
    at = [0.03 * np.array([np.cos(t), np.sin(t)]) for t in turns]
    return hl.Grasp([hl.Contact(p, -p / 0.03, hl.Frictionless()) for p in at], flexibility=C, preload=P, **more)


@pytest.mark.parametrize("n", [3, 4, 5, 8])
def test_a_ring_opens_first_on_the_side_that_the_load_leaves_and_holds_on(n):
    # v = -2 C F / n, so that contact i has N + (2/n) F·(direction to it)
    found = limit(ring(n), (-1, 0, 0, 0, 0, 0), max_slip=np.inf)
    assert found.factor == np.inf
    assert (found.events[0].kind, found.events[0].who) == ("opens", "finger 1")
    assert found.events[0].factor == pytest.approx(n * N / 2, rel=NEAR)


@pytest.mark.parametrize("n", [3, 4, 6])
def test_a_ring_without_friction_holds_no_moment(n):
    assert limit(ring(n), (0, 0, 0, 0, 0, 1)).factor == 0.0


@pytest.mark.parametrize("most", [1.5, 2.5, 4.0])
def test_a_ring_of_four_with_bounded_forces_is_lost_at_the_bound(most):
    # F goes to the contact in front: N + F/2 until the one behind opens at 2 N, F from then on
    found = limit(ring(4, effects=[hl.FingerForceBound(most * N)]), (1, 0, 0, 0, 0, 0), max_slip=np.inf)
    # With a bound below that, the one in front yields there and the one behind is relieved by all that comes
    assert found.factor == pytest.approx(most * N, rel=NEAR)


# ---------------------------------------------------------------- torque limits
@pytest.mark.parametrize("most", [1.2, 1.9])
def test_a_slider_that_is_pressed_is_at_its_limit_where_the_lever_says(tmp_path, most):
    _, squeeze = gripper(tmp_path, mass=0.0)
    held, _ = gripper(tmp_path, mass=0.0, limits=most * squeeze)
    found = limit(held, (1, 0, 0, 0, 0, 0))
    assert found.factor == pytest.approx(2 * (most - 1) * squeeze, rel=NEAR)
    assert [(b.kind, b.who) for b in found.binds] == [("torque", "right_slide")]


def test_a_slider_that_yields_holds_until_the_other_one_opens(tmp_path):
    _, squeeze = gripper(tmp_path, mass=0.0)
    held, _ = gripper(tmp_path, mass=0.0, limits=1.5 * squeeze, effects=[hl.TorqueSaturation()])
    found = limit(held, (1, 0, 0, 0, 0, 0))
    assert found.factor == pytest.approx(1.5 * squeeze, rel=NEAR)
    yields = [e for e in found.events if e.kind == "yields"]
    assert yields[0].factor == pytest.approx(2 * 0.5 * squeeze, rel=NEAR)


@pytest.mark.parametrize(
    "way", [(1, 0, 0, 0, 0, 0), (0, -1, 0, 0, 0, 0), (0.3, 0.5, -0.8, 0, 0, 0), (0.5, 0, 0.5, 0, 0.02, 0)]
)
def test_joints_of_a_cube_are_at_their_limits_where_springs_and_levers_say(way):
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=LIMIT)
    cube = hl.Box(0.05, [0, 0, 0.08], mass=0.2)
    held = hand.at(hand.close_on(cube)).grasp(cube, hl.Coulomb(50.0), joint_offset=[0.02, 0.01] * 3)
    # Everything sticks: [E Gᵀ; G 0] (f, u) = (J δq - gaps, -load), linear in the load. Gaps are those of `close_on`
    J, frames = held.jacobian, held.frames
    arms = held.spec.positions - held.reference
    world = np.concatenate([np.vstack([R, np.cross(p, R.T).T]) for p, R in zip(arms, frames, strict=True)], axis=1)
    E = J @ J.T / 6.0 + 1e-4 * np.eye(9)
    K = np.block([[E, world.T], [world, np.zeros((6, 6))]])

    def torques(load):
        given = np.concatenate([J @ held.joint_offset - held.spec.offset.ravel(), -np.asarray(load, dtype=float)])
        return J.T @ np.linalg.solve(K, given)[:9]

    start = torques([0, 0, -0.2 * G, 0, 0, 0])
    rate = torques(np.array([0, 0, -0.2 * G, 0, 0, 0]) + way) - start
    ways = (LIMIT * np.sign(rate) - start) / np.where(rate == 0.0, np.nan, rate)
    found = limit(held, way)
    assert found.events == (), "nothing slips or opens before"
    assert found.factor == pytest.approx(np.nanmin(ways), rel=NEAR)
    assert [(b.kind, b.who) for b in found.binds] == [("torque", hand.joint_names[int(np.nanargmin(ways))])]


# ---------------------------------------------------------------- a table
HALF, HIGH, MASS = 0.02, 0.03, 0.5  # half of the foot, height of the centre [m], mass [kg]


def standing(tmp_path, table=0.5, fingers=None, faces_along=(0, 1, 0)):
    """A box on four corners, which two sliders without friction keep in the middle: they press along x alone."""
    way = {"left": ((-0.02 - TIP, 0, 0), (1, 0, 0)), "right": ((0.02 + TIP, 0, 0), (-1, 0, 0))}
    hand = sliders(tmp_path, way, 2000.0, pad_flexibility=C, torque_limits=np.inf, tip_radius=TIP)
    box = hl.Box([0.04, 0.04, 2 * HIGH], [0, 0, 0], mass=MASS)
    corners = [(x * HALF, y * HALF, -HIGH) for x in (-1, 1) for y in (-1, 1)]
    foot = [hl.Contact(p, (0, 0, 1), hl.Coulomb(table), faces_along) for p in corners]
    return hand.at(hand.neutral).grasp(
        box, fingers or hl.Frictionless(), joint_offset=[1e-3, 1e-3], environment=hl.Environment(foot, flexibility=2e-5)
    )


@pytest.mark.parametrize("faces", ["cone", 8])
def test_pressing_on_a_table_has_no_limit(tmp_path, faces):
    found = limit(standing(tmp_path), (0, 0, -1, 0, 0, 0), faces, max_slip=np.inf)
    assert found.factor == np.inf
    assert found.events == found.binds == ()
    assert "nothing gives out" in found.why


def test_what_only_stands_and_weighs_nothing_is_not_held_down():
    feet = [hl.Contact((x, y, 0), (0, 0, 1), hl.Coulomb(0.5)) for x in (-HALF, HALF) for y in (-HALF, HALF)]
    grasp = hl.Grasp(feet, flexibility=C)
    assert limit(grasp, (0, 0, 1, 0, 0, 0)).factor == 0.0
    assert limit(grasp, (0, 0, -1, 0, 0, 0)).factor == np.inf


@pytest.mark.parametrize("faces", ["cone", 8])
def test_a_box_leaves_its_table_under_its_weight_and_what_fingers_with_friction_add(tmp_path, faces):
    up, squeeze = (0, 0, 1, 0, 0, 0), 1e-3 / (1 / 2000.0 + C)
    assert limit(standing(tmp_path), up, faces).factor == pytest.approx(MASS * G, rel=NEAR)
    grasp = standing(tmp_path, fingers=hl.Coulomb(MU))
    found, frames = limit(grasp, up, faces), grasp.frames[:2]
    reach = [polygon(faces, np.arctan2(R[2, 1], R[2, 0])) for R in frames]  # of z, in contact axes
    assert found.factor == pytest.approx(MASS * G + MU * squeeze * sum(reach), rel=NEAR)
    assert "slips" in kinds(found)


@pytest.mark.parametrize("faces", ["cone", 4, 8, 12])
@pytest.mark.parametrize("degrees", [0.0, 180.0])
def test_a_box_slides_on_its_table_at_its_friction(tmp_path, faces, degrees):
    mu = 0.5  # below HALF / HIGH: it does not tip
    found = limit(standing(tmp_path, mu), (0, np.cos(np.radians(degrees)), 0, 0, 0, 0), faces)
    assert found.factor == pytest.approx(mu * polygon(faces, np.radians(degrees)) * MASS * G, rel=NEAR)
    assert kinds(found) == {"slips"}


@pytest.mark.parametrize("faces", ["cone", 8])
def test_a_box_that_does_not_slide_tips_over_its_edge(tmp_path, faces):
    found = limit(standing(tmp_path, 1.5), (0, 1, 0, 0, 0, 0), faces)
    assert found.factor == pytest.approx(MASS * G * HALF / HIGH, rel=NEAR)
    assert "opens" in kinds(found)
    assert len(named(found)) == 2
