"""Corners of an object that stand on a link's face: they move with the object, and slide on the face."""

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl
from tests.support.hand import swept_contacts

PALM = """
<robot name="palm">
  <link name="palm"><collision><origin xyz="0 0 -0.01"/><geometry><box size="0.2 0.2 0.02"/></geometry></collision>
  </link>
  <link name="bar"><collision><origin xyz="0 0 0.04"/><geometry><box size="0.02 0.02 0.08"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute"><parent link="palm"/><child link="bar"/><axis xyz="0 -1 0"/>
    <origin xyz="0.15 0 0"/><limit lower="-0.5" upper="1.5" effort="2" velocity="1"/></joint>
</robot>
"""
HALF, HEIGHT, MASS, WEIGHT, PAD = 0.02, 0.06, 0.5, 0.5 * 9.81, 2e-5  # m, m, kg, N, m/N
CENTRE = np.array([0.01, -0.005, HEIGHT / 2])


SIZE = (2 * HALF, 2 * HALF, HEIGHT)


def standing(friction, rotation=None, centre=CENTRE, mesh=False, size=SIZE, urdf=PALM, pad=PAD, **arguments):
    """A block on its four corners on a wide palm, its weight alone presses it on; pads give way by 20 µm a newton."""
    hand = hl.Hand.from_urdf(urdf, fingertips=["bar"], joint_stiffness=5.0, pad_flexibility=pad)
    place = pin.SE3(np.eye(3) if rotation is None else rotation, np.array(centre))
    block = hl.Box(size, place, mass=MASS)
    if mesh:
        import trimesh

        block = hl.Mesh(trimesh.creation.box(size), placement=place, mass=MASS)
    return hand.at([0.0]).grasp(block, links=["palm"], friction=friction, **arguments)


def test_the_contacts_are_the_corners_of_the_block():
    where = np.array([c.position for c in standing(0.5).contacts]) - CENTRE
    np.testing.assert_allclose(abs(where), np.tile([HALF, HALF, HEIGHT / 2], (4, 1)), atol=2e-6)
    assert len({tuple(np.sign(row)) for row in where}) == 4


@pytest.mark.parametrize("mesh", [False, True], ids=["box", "mesh"])
def test_a_block_that_is_pushed_slides_when_friction_is_used_up_and_not_before(mesh):
    """μ m g, however far it has come: its corners stay below it, so that no edge is passed on the way."""
    limit = standing(0.3, mesh=mesh).load_limit((1, 0, 0, 0, 0, 0))
    assert limit.factor == pytest.approx(0.3 * WEIGHT, rel=1e-4)


def test_a_tall_block_tips_over_its_far_corners():
    """About them F H = m g A. The two pads that carry it have given way by then, and the block has turned as much."""
    turned = 0.5 * WEIGHT * PAD / (2 * HALF)
    lever, height = HALF - HEIGHT / 2 * turned, HEIGHT / 2 + HALF * turned
    limit = standing(2.0).load_limit((0, 1, 0, 0, 0, 0))
    assert limit.factor == pytest.approx(WEIGHT * lever / height, rel=1e-4)


def test_a_block_that_is_turned_resists_with_friction_at_its_corners():
    limit = standing(0.4).load_limit((0, 0, 0, 0, 0, 1))
    assert limit.factor == pytest.approx(0.4 * WEIGHT * np.sqrt(2) * HALF, rel=1e-3)


def test_a_block_that_leans_on_one_edge_has_all_its_corners_as_contacts():
    tilt, edge = 0.004, np.array([0.0, -0.01, 0.0])
    R = pin.exp3(np.array([tilt, 0.0, 0.0]))
    grasp = standing(0.5, R, edge + R @ np.array([0.0, HALF, HEIGHT / 2]))
    assert len(grasp.contacts) == 4
    gaps = np.sort(grasp.spec.offset[:, 2])
    np.testing.assert_allclose(gaps, [0, 0, 2 * HALF * np.sin(tilt), 2 * HALF * np.sin(tilt)], atol=2e-6)


def test_a_corner_that_hangs_over_the_rim_is_no_corner_on_the_face():
    """Two corners of the block stand on the palm; the other two contacts are where the palm's edge is."""
    where = np.array([c.position for c in standing(0.5, centre=(0.095, 0, HEIGHT / 2)).contacts])
    np.testing.assert_allclose(np.sort(where[:, 0]), [0.075, 0.075, 0.1, 0.1], atol=6e-4)


@pytest.mark.parametrize("beyond", [False, True], ids=["above the face", "beyond its rim"])
def test_contacts_at_corners_turn_and_shift_as_differences_of_them_do(beyond):
    rng, block = np.random.default_rng(4), hl.Box(0.04)
    for _ in range(6):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        axes[:, 2] *= np.linalg.det(axes)
        spans = axes[:, :2].T * np.array([[0.03], [0.02]])
        corner = np.array([0.02, 0.02, -0.02])
        away = 1.2 * spans[0] + 0.3 * spans[1] if beyond else 0.4 * spans[0] - 0.3 * spans[1]
        centre = corner - away - 0.002 * axes[:, 2]
        place, turn = rng.normal(size=3) * 0.01, pin.exp3(rng.normal(size=3))
        swept = turn.T @ (centre - place), spans @ turn, 1e-4
        at = swept_contacts(block, swept, place, turn, corner)
        assert at[2] == pytest.approx((np.hypot(0.2 * 0.03, 0.002) if beyond else 0.002) - 1e-4, rel=1e-9)
        h = 1e-6
        for a in range(6):
            by = np.zeros(3)
            by[a % 3] = h
            moves, turns = (by, 0.0 * by) if a < 3 else (0.0 * by, by)
            ends = [
                swept_contacts(block, swept, place + s * moves, pin.exp3(s * turns) @ turn, corner) for s in (1.0, -1.0)
            ]
            for k, rows in ((0, at[4]), (1, at[3])):
                np.testing.assert_allclose(rows[:, a], (ends[0][k] - ends[1][k]) / (2 * h), atol=1e-5)
            gap = (ends[0][2] - ends[1][2]) / (2 * h)
            moved = np.eye(3)[a] if a < 3 else np.cross(np.eye(3)[a - 3], at[0] - place)
            assert gap == pytest.approx(-float(at[1] @ moved), abs=1e-6)


# ---------------------------------------------------------------- Blocks that lean, and what stands on little.
def laid(R, size=SIZE, **arguments):
    """A block turned by R (3, 3) that just touches the palm."""
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    corners = 0.5 * signs * np.array(size) @ R.T
    return standing(0.5, R, (0.0, 0.0, -corners[:, 2].min()), size=size, **arguments)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0.3, 1, 0)])
@pytest.mark.parametrize("tilt", [1e-7, 1.9e-3, 2.1e-3, 1e-2])
def test_no_corner_is_lost_however_little_a_block_leans(tilt, axis):
    grasp = laid(pin.exp3(tilt * np.array(axis) / np.linalg.norm(axis)), max_gap=2e-3)
    assert len(grasp.contacts) == 4
    assert grasp.check().word == "HELD"


def test_a_thin_plate_on_its_edge_tips_over_its_thickness():
    """F h = m g w, where h is the height and w the thickness: with 1.4 mm the corners are near each other."""
    limit = laid(np.eye(3), (0.0014, 0.04, 0.03), pad=1e-7).load_limit((1, 0, 0, 0, 0, 0))
    assert limit.factor == pytest.approx(WEIGHT * 0.0014 / 0.03, rel=0.02)  # it leans on pads, which give way


def test_a_disc_is_a_palm_as_a_box_is():
    disc = PALM.replace('<box size="0.2 0.2 0.02"/>', '<cylinder radius="0.1" length="0.02"/>')
    grasp = laid(pin.exp3(np.array([0.0025, 0.0, 0.0])), urdf=disc, max_gap=2e-3)
    assert len(grasp.contacts) == 4
    assert grasp.check().word == "HELD"


@pytest.mark.parametrize("over", [0.0, 0.02], ids=["over the edge", "a degree beside it"])
def test_a_block_balanced_on_an_edge_is_not_held(over):
    """Forces balance its weight there, and the smallest push makes it fall."""
    lean = pin.exp3(np.array([0.0, np.arctan2(HALF, HEIGHT / 2) + over, 0.0]))
    found = standing(0.5, lean, (0.0, 0.0, np.hypot(HALF, HEIGHT / 2))).follow()
    assert not found.held
    # coal's distance of touching boxes is 0 or -2e-12 m, as its memory happens to be: the block stands there, or hops
    assert "drives it away: it tips over" in found.why or "the object would have to jump" in found.why
