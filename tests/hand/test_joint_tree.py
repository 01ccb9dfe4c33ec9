"""The tree of joints that compiled code reads, against Pinocchio on the model that it was read from."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from handlcp.hand import HANDS, example_hand
from handlcp.kinematics.joint_tree import compose_placement, write_gravity_torque, write_joint_motions
from handlcp.robot.joint import read_model_facts
from handlcp.robot.kinematics import Kinematics, read_joint_tree

EXACT = 1e-14
GRAVITY = np.array([1.0, 2.0, -9.0])
AXIS = np.array([0.6, 0.0, -0.8])


def apart(kinematics, frames, q):
    """How far placements, Jacobian and torque of gravity are from Pinocchio's, as a share of the largest entry."""
    tree, tips = kinematics.tree, kinematics.tip_placements(frames)
    joints = len(tree.parents)
    R, p, columns = np.empty((joints, 3, 3)), np.empty((joints, 3)), np.empty((joints, 6))
    write_joint_motions(tree, q, R, p, columns)
    placements, J = kinematics.frames_at(q, frames)
    worst = [abs(columns - J.T).max()]
    for carrier, rotation, origin, there in zip(*tips, placements, strict=True):
        turn, place = np.empty((3, 3)), np.empty(3)
        compose_placement(R, p, int(carrier), rotation, origin, turn, place)
        worst += [abs(turn - there[:3, :3]).max(), abs(place - there[:3, 3]).max()]
    torque, known = np.empty(kinematics.nv), kinematics.gravity_torque(q, GRAVITY)
    write_gravity_torque(tree, R, p, columns, GRAVITY, torque)
    return max(*worst, abs(torque - known).max() / max(abs(known).max(), 1e-3))


@pytest.mark.parametrize("name", HANDS)
def test_example_hands_move_as_pinocchio_moves_them(name):
    hand, rng = example_hand(name, joint_stiffness=1.0), np.random.default_rng(0)
    for _ in range(3):
        q = rng.uniform(-1.5, 1.5, hand.nv)
        assert apart(hand.kinematics, list(hand.tips.frames), q) < EXACT


def test_mimic_and_continuous_joints_move_as_pinocchio_moves_them(coupled):
    q = np.array([4.0 if name == "w" else 0.2 for name in coupled.joint_names])
    assert apart(coupled.kinematics, list(coupled.tips.frames), q) < EXACT


KINDS = [
    pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ(), pin.JointModelRevoluteUnaligned(AXIS),
    pin.JointModelRUBX(), pin.JointModelRUBY(), pin.JointModelRUBZ(),
    pin.JointModelPX(), pin.JointModelPY(), pin.JointModelPZ(), pin.JointModelPrismaticUnaligned(AXIS),
]  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_a_random_tree_of_every_kind_of_joint_moves_as_pinocchio_moves_it(seed):
    rng, model = np.random.default_rng(seed), pin.Model()
    for number in rng.permutation(len(KINDS)):
        parent = int(rng.integers(0, model.njoints))
        joint = model.addJoint(parent, KINDS[number], pin.SE3.Random(), f"joint {number}")
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Random())
        model.addFrame(pin.Frame(f"tip {number}", joint, pin.SE3.Random(), pin.FrameType.OP_FRAME))
    kinematics = Kinematics(model, read_model_facts(model))
    frames = [i for i, frame in enumerate(model.frames) if frame.name.startswith("tip")]
    assert apart(kinematics, frames, rng.uniform(-2.0, 2.0, kinematics.nv)) < 20 * EXACT


def test_a_joint_that_turns_and_slides_at_once_is_left_to_pinocchio():
    model = pin.Model()
    model.addJoint(0, pin.JointModelHX(0.1), pin.SE3.Identity(), "screw")
    assert read_joint_tree(model, None, np.zeros(1)) is None
