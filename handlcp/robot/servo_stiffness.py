"""`ServoStiffness`: joint stiffness from the position servos and the springs at joints that an MJCF file states.

    K = K_s + K_p,    K_s = Cᵀ (Σ kp a aᵀ) C,    K_p = Cᵀ diag(k) C

with kp of a servo, its arms a over all joints, k of the joints' own springs, and the coupling C of joints that follow
others. A servo on one joint is a spring there. One that pulls several joints by a tendon resists their common motion
alone, a matrix of rank one; where nothing else resists the rest, the file leaves that motion free. No hand can be
computed with it, so it is taken to be as stiff as the motion that the tendon resists: kp |a|² for each of its joints,
which along a is what the file says.

Servos alone are commanded; springs keep their rest angle θ. With joints at q, a servo pulls with

    τ + k (q - θ),    τ = K (q_c - q) what is left for the contacts,

and its torque is what limits are for. A spring whose joint no servos turn on its own is taken to be at rest in the
grasp's posture, as springs beside tendons are, and a doubt says where that is much of a torque limit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np

from handlcp.actuation.joint_stiffness import (
    STIFFNESS_EXPECTED,
    Elasticity,
    JointStiffness,
    orthonormal_basis,
    read_stiffness,
    with_motor_stiffness,
)
from handlcp.actuation.motor import Drives
from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.robot.description import RobotDescription
from handlcp.robot.joint import Servo
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.mjcf_cable import (
    SERVO_TOPIC,
    FileCable,
    make_cable_stiffness,
    passive_stiffness,
    read_cables,
    rest_angles,
)
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE

FROM_FILE = "file"  # what users pass for the stiffness that the file states
_OWN_MOTION_TOLERANCE = 1e-6  # of a joint's motion: what servos miss of it where they turn it on its own
_TORQUE_ROUNDING = 1e-6  # of the largest torque of a command: less is rounding


class ServoStiffness(JointStiffness):
    """Stiffness from servos and springs of joints. rows (m, nv) : arms of the servos. passive (nv, nv) : K_p [N·m/rad],
    diagonal. rest (nv,) : where its springs are at rest [rad, m]. widened : servos whose tendon leaves a motion free,
    of which the file says nothing.
    """

    def __init__(self, matrix: Array, rows: Array, passive: Array, rest: Array, widened: tuple[str, ...] = ()) -> None:
        super().__init__(matrix)
        self.rows, self.passive, self.rest, self.widened = read_only(rows), read_only(passive), read_only(rest), widened
        self._beside = _find_parallel_springs(self.rows, self.passive.diagonal(), bool(widened))

    @property
    def joint_springs(self) -> Array:
        """The springs (nv,) that the file gives the joints beside the servos [N·m/rad, N/m]."""
        return np.asarray(self.passive.diagonal())

    @property
    def springs_with_rest(self) -> Array:
        """Of springs whose joints servos turn on their own."""
        return np.zeros(len(self.compliance_factor)) if self._beside is None else self._beside

    def parallel_spring_torque(self, q: Array) -> Array | None:
        """The torque k (q - θ) (nv,) of the springs beside the servos [N·m]; None: there are none."""
        return None if self._beside is None else read_only(self._beside * (q - self.rest))

    @property
    def is_from_file(self) -> bool:
        """It is the file's."""
        return True

    @property
    def command_directions(self) -> Array:
        """Where servos can turn the joints: not those that springs alone hold."""
        if self.widened or np.linalg.matrix_rank(self.rows) == len(self.compliance_factor):
            return super().command_directions
        return orthonormal_basis(self.compliance_factor @ (self.rows @ self.compliance_factor).T)

    def actuator_torque(self, torque: Array, command: Array) -> Array:
        """τ - K_p (C τ - δq), beside what holds the springs in the grasp's posture: they turn with the joints."""
        return np.asarray(torque - self.passive @ (self.deflection(torque) - command))

    def unmade_torque(self, command: Array) -> Array:
        """What of K δq no servos make."""
        asked = self.stiffness_matrix @ command
        if self.widened or not asked.any():
            return np.zeros(len(command))
        left = asked - self.rows.T @ np.linalg.lstsq(self.rows.T, asked)[0]
        return np.where(abs(left) > _TORQUE_ROUNDING * abs(asked).max(), left, 0.0)

    def scale_stiffness(self, factor: float) -> ServoStiffness:
        """The same with every spring so many times as stiff."""
        return ServoStiffness(self.stiffness_matrix * factor, self.rows, self.passive * factor, self.rest, self.widened)

    def scale_by_joint(self, factors: Array) -> Self:
        """Servos and springs of a joint alike."""
        made, by = super().scale_by_joint(factors), np.sqrt(factors)
        made.passive = read_only(self.passive * by * by[:, None])
        made._beside = _find_parallel_springs(self.rows, made.passive.diagonal(), bool(self.widened))
        return made


def _find_parallel_springs(rows: Array, springs: Array, widened: bool) -> Array | None:
    """(nv,) of springs (nv,) those of joints that servos with arms rows (m, nv) turn on their own; None where there are
    none. widened : whether each joint of a servo counts.
    """
    if not springs.any():
        return None
    turned = abs(rows).max(axis=0, initial=0.0) > 0.0
    if not widened:
        alone = np.eye(len(springs))
        turned &= np.linalg.norm(np.linalg.pinv(rows) @ rows - alone, axis=0) < _OWN_MOTION_TOLERANCE
    return read_only(np.where(turned, springs, 0.0)) if springs[turned].any() else None


def read_elasticity(
    value: Any, kinematics: Kinematics, described: RobotDescription, drives: Drives | None = None
) -> Elasticity:
    """From "file", the stiffness that the file states, or from what `read_stiffness` takes; motors that say how stiff
    their joints are come first. An ellipsis means these alone.
    """
    joints = kinematics.joint_names
    own = {} if drives is None else drives.stiffness(joints)
    if value is ... or (isinstance(value, Mapping) and own):
        return read_stiffness(({} if value is ... else dict(value)) | own, joints)
    if isinstance(value, str) and value == FROM_FILE:
        return with_motor_stiffness(read_file_stiffness(described, kinematics), own, joints)
    return with_motor_stiffness(read_stiffness(value, joints, kinematics=kinematics), own, joints)


def read_file_stiffness(described: RobotDescription, kinematics: Kinematics) -> JointStiffness:
    """As the servos and springs of a file say. Raises InputError where they do not, naming joints."""
    if cables := _description_cables(described):
        return make_cable_stiffness(cables, kinematics)
    try:
        return make_servo_stiffness(described.servos, kinematics)
    except InputError as error:
        if why := [f"{d.what} → {d.advice}" for d in described.doubts if d.about == SERVO_TOPIC]:
            expected = f"{STIFFNESS_EXPECTED}, as not all position actuators of the file are read"
            raise InputError(error.argument, expected, f"{error.got}: {'; '.join(why)}") from None
        raise


def has_servos(described: RobotDescription) -> bool:
    """Whether a file has position actuators that are read."""
    return bool(described.servos or _description_cables(described))


def _description_cables(described: RobotDescription) -> tuple[FileCable, ...]:
    return () if described.root is None else read_cables(described.root)


def make_servo_stiffness(servos: Sequence[Servo], kinematics: Kinematics) -> ServoStiffness:
    """K (nv, nv) [N·m/rad] of the independent joints. Raises InputError where a joint has neither a servo nor, beside
    other joints' servos, a spring, naming it.
    """
    movable, coupling = kinematics.movable, kinematics.all_joints
    index = {name: i for i, name in enumerate(movable)}
    rows = np.zeros((len(servos), len(movable)))
    for row, servo in zip(rows, servos, strict=True):
        for joint, arm in servo.arms.items():
            row[index[joint]] = arm
    rows, kp = rows @ coupling.C, np.array([servo.kp for servo in servos])
    own = passive_stiffness(kinematics)
    K = rows.T @ (kp[:, None] * rows) + (own if len(servos) else 0.0)
    if bare := [name for name, k in zip(coupling.names, np.diagonal(K), strict=True) if k <= 0.0]:
        what = "none" if len(bare) == coupling.C.shape[1] else f"none for {', '.join(bare)}"
        expected = f"{STIFFNESS_EXPECTED}, where the file has no position actuators that say it"
        raise InputError("joint_stiffness", expected, what)
    size = np.sqrt(np.diagonal(K))
    stiff, motions = np.linalg.eigh(K / np.outer(size, size))  # without units, so that hinges and slides compare
    free = abs(motions[:, stiff <= SEMIDEFINITE_TOLERANCE * stiff[-1]])
    loose = np.asarray((free > 1e-6).any(axis=1))  # joints that take part in a motion that nothing resists
    widened = tuple(i for i, row in enumerate(rows) if np.count_nonzero(row) > 1 and loose[row != 0.0].any())
    for i in widened:
        row = rows[i]
        K += kp[i] * (np.diag(np.where(row != 0.0, row @ row, 0.0)) - np.outer(row, row))
    rest = rest_angles(kinematics)
    return ServoStiffness((K + K.T) / 2, rows, own, rest, tuple(servos[i].name for i in widened))
