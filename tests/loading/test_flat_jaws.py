"""Flat jaws on flat sides: the pressed place moves between the corners; what rests on a palm stays."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import trimesh

import handlcp as hl

TALL, WIDE = 0.03, 0.04  # of the block [m]
STIFFNESS, SQUEEZE = 2000.0, 0.002  # of a jaw's drive [N/m], how far it closes [m]


def vise():
    """Two plates, 10 mm thick, that close along x."""
    parts = ["<robot name='vise'><link name='base'/>"]
    for name, side in (("left", -1), ("right", 1)):
        at = side * (WIDE / 2 + 0.005)
        parts.append(
            f"<joint name='{name}' type='prismatic'><parent link='base'/><child link='{name}_jaw'/>"
            f"<origin xyz='{at} 0 0'/><axis xyz='{-side} 0 0'/>"
            f"<limit lower='-0.01' upper='0.01' effort='100' velocity='1'/></joint>"
            f"<link name='{name}_jaw'><collision><geometry><box size='0.01 0.06 0.06'/></geometry></collision></link>"
        )
    urdf = "".join([*parts, "</robot>"])
    return hl.Hand.from_urdf(urdf, joint_stiffness=STIFFNESS, fingertips=["left_jaw", "right_jaw"])


def block(kind):
    size = (WIDE, TALL, TALL)
    return hl.Box(size, mass=0.1) if kind == "box" else hl.Mesh(trimesh.creation.box(size), mass=0.1)


def turned(kind, moment, friction=0.2, steps=20):
    more = {"squeeze": SQUEEZE, "wrench": (0, 0, 0, 0, moment, 0), "gravity": (0, 0, 0)}
    return vise().at([0.0, 0.0]).grasp(block(kind), friction, **more).follow(steps=steps)


def rocking(angle, friction):
    """Moment [N·m] that holds the block turned by an angle, on two corners that slide: F (b cos θ - w sin θ) of the
    normal forces, μ F (w cos θ + b sin θ) of friction, F as far as the corners push the jaws apart.
    """
    c, s = np.cos(angle), np.sin(angle)
    force = STIFFNESS * (SQUEEZE + 0.5 * (WIDE * c + TALL * s - WIDE))
    return force * (TALL * c - WIDE * s + friction * (WIDE * c + TALL * s))


@pytest.mark.parametrize("kind", ["box", "mesh"])
@pytest.mark.parametrize("friction", [0.02, 0.2])
def test_a_block_between_flat_jaws_turns_as_far_as_its_corners_and_friction_say(kind, friction):
    held = rocking(0.0, friction)
    flat = turned(kind, 0.9 * held, friction)
    assert flat.reached, flat.why
    assert abs(flat.displacement[4]) < 1e-3, "below that moment the sides stay flat on the jaws"
    np.testing.assert_allclose(flat.solution.forces[:, 2], STIFFNESS * SQUEEZE, rtol=2e-3)
    rocks = turned(kind, 1.3 * held, friction)
    assert rocks.reached, rocks.why
    assert rocks.displacement[4] > 0.02
    np.testing.assert_allclose(rocking(rocks.displacement[4], friction), 1.3 * held, rtol=2e-3)


@pytest.mark.parametrize(
    ("friction", "links"), [(hl.SoftFinger(0.3, 0.005), "tips"), (0.3, "all")], ids=["soft jaws", "corners"]
)
@pytest.mark.parametrize("angle", [0.0, -9e-4])
def test_a_block_that_is_slightly_turned_comes_to_lie_flat_and_is_held(angle, friction, links):
    """The nearest points are corners, on opposite ends of the jaws."""
    turn = pin.SE3(pin.exp3(np.array([0.0, angle, 0.0])), np.zeros(3))
    obj = hl.Box((WIDE, TALL, TALL), turn, mass=0.1)
    grasp = vise().at([0.0, 0.0]).grasp(obj, friction, squeeze=SQUEEZE, links=links)
    path = grasp.follow()
    assert path.reached, path.why
    np.testing.assert_allclose(path.displacement[4], -angle, atol=2e-4)
    assert grasp.check().word == "HELD"


# ---------------------------------------------------------------- one jaw that slides towards a flat palm, the
STIFF, PAD, MU, GAP, PULL = 5e4, 2e-5, 0.6, 1e-4, 10.0  # [N/m], [m/N], friction, [m], [N]
CLOSES = STIFF * 1e-6  # [N] as near as a hand closes, in metres
URDF = """
<robot name="one_jaw">
  <link name="palm"><collision><origin xyz="0 -0.035 0"/><geometry><box size="0.06 0.02 0.08"/></geometry></collision>
  </link>
  <link name="jaw"><collision><geometry><box size="0.04 0.01 0.04"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="palm"/><child link="jaw"/><origin xyz="0 0.03 0"/>
    <axis xyz="0 -1 0"/><limit lower="0" upper="0.06" effort="40" velocity="1"/></joint>
</robot>
"""


@cache
def held(pad=PAD, links="all"):
    """A cylinder of 30 mm that lies on the palm along z, the jaw a tenth of a millimetre away."""
    hand = hl.Hand.from_urdf(URDF, ["jaw"], joint_stiffness=STIFF, pad_flexibility=pad)
    rod = hl.Cylinder(0.015, 0.05, (0, -0.01, 0), mass=0.2)
    return hand.at([0.02 - GAP]).grasp(rod, MU, links=links, closing_torque=PULL, gravity=(0, 0, 0))


@pytest.mark.parametrize("pad", [0.0, PAD])
def test_what_lies_on_the_palm_stays_there_until_the_jaw_has_come(pad):
    followed = held(pad).follow()
    assert followed.reached, followed.why
    forces = followed.solution.forces
    on = [sum(f[2] for f, name in zip(forces, followed.solution.names, strict=True) if link in name)
          for link in ("jaw", "palm")]  # fmt: skip
    assert on[0] == pytest.approx(on[1], rel=1e-6)
    assert on[0] == pytest.approx(PULL, rel=1e-6)  # however far pads give way: the motor turns on until it pulls so


def test_across_it_holds_what_friction_holds_on_both_sides():
    """The rod would have to slide on the palm or on the jaw, and roll on the other: 2 μ N."""
    limit = held().load_limit((0, 0, 1.0, 0, 0, 0))
    assert limit.factor == pytest.approx(2.0 * MU * PULL, rel=1e-6)


def test_a_hand_of_one_joint_has_all_that_hands_have():
    """Pinocchio hands out the Jacobian of one joint as a row."""
    grasp = held()
    assert grasp.check().ok
    assert len(hl.to_mujoco(grasp)) > 0
    moved = hl.GraspStream(grasp).update(q=grasp.state.q + 1e-5)
    assert moved.held
    assert np.shape(moved.torques) == (1,)
