"""One jaw that slides towards a flat palm, the smallest hand: what rests on the palm stays until it is reached."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import handlcp as hl

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
