"""Doors into a hand: the URDFs that ship, how tips touch objects, how joints carry torques, how a finger curves."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.geometry.link_contacts import body_gaps, contact_bodies
from handlcp.geometry.table import _support_corners as _points_needed
from handlcp.hand.torque_check import TorqueCheck
from handlcp.robot.fingertip import TipShape, make_sphere_tip
from handlcp.robot.hand_model import contact_hessian
from handlcp.robot.servo_stiffness import ServoStiffness


# ---------------------------------------------------------------- how tips touch
def ball_near(radius, centre, obj):
    """How a ball stands to an object: gap, position on the object, tip_point on the ball, normal into the object."""
    return nearest_proximity(make_sphere_tip(radius), np.asarray(centre, float), np.eye(3), obj)


def shape_near(geometry, rotation, position, obj):
    """As `ball_near` for any shape of coal's, placed by rotation (3, 3) and position (3,) [m]."""
    shape = TipShape(geometry, np.eye(3), np.zeros(3), None)
    return nearest_proximity((shape,), position, rotation, obj)


def link_gap(hand, q, obj):
    """How far the nearest link or fingertip is from an object, in a posture [m]."""
    return min(gap for _, gap in body_gaps(hand.at(q), contact_bodies(hand, "all"), obj))


def gaps(hand, q, obj):
    """(n,) signed gaps of the fingertips in a posture."""
    s = hand.at(q)
    each = zip(hand.tips.numbers, s.tip_positions, s.tip_rotations, strict=True)
    return np.array([nearest_proximity(hand.tip_shapes(i), p, R, obj).gap for i, p, R in each])


def points_needed(points, heights, up):
    """Which of the points (n, 3) on a plane keep an object from coming nearer to it, whatever small motion it makes."""
    return _points_needed(points, heights, up)


# ---------------------------------------------------------------- joints
def mimic(hand):
    """(C (joints, nv), offset (joints,)): positions of all joints, those that follow included, are C q + offset."""
    return hand.kinematics.coupling, hand.kinematics.offset


def full_positions(hand, q):
    """(joints,) of all joints at a posture of the independent ones."""
    coupling, offset = mimic(hand)
    return coupling @ q + offset


def configuration(hand, q):
    """A posture as Pinocchio wants it for `hand.model`."""
    return hand.kinematics.configuration(q)


def jacobian_at(state, points):
    """(n, 3, nv) of points (n, 3) that move with the fingertips, one each, world axes."""
    return state.jacobian_at(points, state.hand.tips.numbers)


def curvature(state, points, frames):
    """(3n, nv, nv) derivative of their Jacobian in the axes of frames (n, 3, 3)."""
    return contact_hessian(state, state.hand.tips.numbers, points, frames)


# ---------------------------------------------------------------- what gives way
def deflection(hand, torque):
    """(nv,) by how much the joints give way under a torque (nv,)."""
    return hand.stiffness.deflection(torque)


def effort(hand, torque):
    """What tendons or actuators do under a torque: names and values."""
    return hand.stiffness.effort(torque, np.zeros(len(torque)))


def is_one_spring_a_joint(hand):
    """Whether all joints have the same spring and nothing else."""
    return hand.stiffness.uniform


def tendons_of(hand):
    """The stiffness of a hand with tendons, with what these bear and their motors."""
    assert isinstance(hand.stiffness, TendonStiffness)
    return hand.stiffness


def servos_of(hand):
    """The stiffness of a hand whose file says it, by servos and springs of joints."""
    assert isinstance(hand.stiffness, ServoStiffness)
    return hand.stiffness


def under_load(grasp):
    """What forces r (n, 3) do to a grasp's joints: stiffness(r) is added, compliance(r) left, and change(r) is that of
    the contacts' flexibility; None where they buckle.
    """
    (effect,) = (e for e in grasp.effects if isinstance(e, hl.GeometricStiffness))
    return _UnderLoad(grasp.spec, effect)


class _UnderLoad:
    def __init__(self, spec, effect):
        self.spec, self.effect, self.joints = spec, effect, spec.mechanism

    def _bent(self, r):
        bent = self.effect.under(self.spec, r, self.spec.effects)
        return None if isinstance(bent, str) else bent

    def stiffness(self, r):
        """(nv, nv) K_g."""
        return np.tensordot(r.reshape(-1), self.joints.hessian(), 1)

    def compliance(self, r):
        """(nv, nv) (K + K_g)⁻¹."""
        bent = self._bent(r)
        return (
            None
            if bent is None
            else self.joints.compliance_factor @ self.joints.compliance_factor.T + bent.bent.added_compliance
        )

    def change(self, r):
        """(3n, 3n)."""
        bent = self._bent(r)
        return None if bent is None else bent.added_flexibility(self.spec, ())


# ---------------------------------------------------------------- torques
def agrees_with_mujoco(grasp, near, torques=False):
    """Forces, and joint torques, at the end of the loading are MuJoCo's to a share `near` of the largest."""
    pytest.importorskip("mujoco")
    from handlcp.simulator import simulate

    path, truth = grasp.follow(), simulate(grasp)
    assert path.reached
    assert truth.held
    size = np.abs(truth.forces_world).max()
    np.testing.assert_allclose(path.solution.forces_world, truth.forces_world, atol=near * size)
    if torques:
        size = np.abs(truth.torques).max()
        np.testing.assert_allclose(path.steps.torques[-1], truth.torques, atol=near * size)


def torque_check_of(joints, torque, limits, known=None):
    """Torques beside limits, some of which may not be known; None: all are."""
    torque, limits = np.asarray(torque, float), np.asarray(limits, float)
    told = (True,) * len(joints) if known is None else tuple(known)
    return TorqueCheck(tuple(joints), torque, limits, abs(torque) / limits, told)


def knows_all_limits(hand):
    """Whether no joint's torque limit is unknown."""
    return all(hand.torques.known)


def swept_station(obj, centre, spans):
    """(3,) the station of a swept ball that is nearest to an object at the origin."""
    from handlcp.contact.closest_point import nearest_station

    kind, sizes = obj.known
    return nearest_station(kind, np.array(sizes, dtype=float), centre, spans, np.zeros(2))


def swept_contacts(obj, swept, place, turn, corner=None):
    """Position, normal, gap, and how both turn and shift, of a swept ball (centre, spans, radius) in a moved frame;
    corner (3,) of the object, in the axes of its shape, that stands on it.
    """
    import coal

    from handlcp.geometry.contact_kinematics import SweptBallFinder
    from handlcp.robot.fingertip import SweptBall, TipShape

    shape = TipShape(coal.Sphere(0.01), np.eye(3), np.zeros(3), None, face=SweptBall(*swept), corner=corner)
    one = (np.empty((1, 3)), np.empty((1, 3)), np.empty(1), np.empty((1, 3, 6)), np.empty((1, 3, 6)))
    SweptBallFinder(obj, [shape])(place[None].copy(), turn[None].copy(), np.eye(3), np.zeros(3), one)
    return tuple(part[0] for part in one)
