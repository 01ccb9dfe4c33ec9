"""Joint stiffness from the position servos that an MJCF file states.

    K = Cᵀ (Σ kp a aᵀ) C

with kp of a servo, its arms a over all joints, and the coupling C of joints that follow others. A servo on one joint is
a spring there. One that pulls several joints by a tendon resists their common motion alone, a matrix of rank one; where
no other servo resists the rest, the file leaves that motion free. No hand can be computed with it, so it is taken to be
as stiff as the motion that the tendon resists: kp |a|² for each of its joints, which along a is what the file says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.motor import Drives
from handlcp.hand.elasticity.stiffness import HOW_STIFF, JointStiffness, read_stiffness, stiff_as
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.source.description import Description
from handlcp.hand.robot.source.stated import Servo
from handlcp.tolerances import SEMIDEFINITE

FILE = "file"  # what users pass for the stiffness that the file states


class ServoStiffness(JointStiffness):
    """Stiffness from servos. widened : those whose tendon leaves a motion free, of which the file says nothing."""

    def __init__(self, matrix: Array, widened: tuple[str, ...]) -> None:
        super().__init__(matrix)
        self.widened = widened


def read_elasticity(
    value: Any, kinematics: Kinematics, described: Description, drives: Drives | None = None
) -> Elasticity:
    """From "file", the stiffness that the file states, or from what `read_stiffness` takes; motors that say how stiff
    their joints are come first. Ellipsis : these alone.
    """
    joints = kinematics.joint_names
    own = {} if drives is None else drives.stiffness(joints)
    if value is ... or (isinstance(value, Mapping) and own):
        return read_stiffness(({} if value is ... else dict(value)) | own, joints)
    if isinstance(value, str) and value == FILE:
        return stiff_as(servo_stiffness(described.servos, kinematics), own, joints)
    return stiff_as(read_stiffness(value, joints, kinematics=kinematics), own, joints)


def servo_stiffness(servos: Sequence[Servo], kinematics: Kinematics) -> ServoStiffness:
    """K (nv, nv) [N·m/rad] of the independent joints. Raises InputError where a joint has no servo, naming it."""
    movable, coupling = kinematics.movable, kinematics.all_joints
    index = {name: i for i, name in enumerate(movable)}
    rows = np.zeros((len(servos), len(movable)))
    for row, servo in zip(rows, servos, strict=True):
        for joint, arm in servo.arms.items():
            row[index[joint]] = arm
    rows, kp = rows @ coupling.C, np.array([servo.kp for servo in servos])
    K = rows.T @ (kp[:, None] * rows)
    if bare := [name for name, k in zip(coupling.names, np.diagonal(K), strict=True) if k <= 0.0]:
        what = "none" if len(bare) == coupling.C.shape[1] else f"none for {', '.join(bare)}"
        expected = f"{HOW_STIFF}, where the file has no position actuators that say it"
        raise InputError("joint_stiffness", expected, what)
    loose = _loose(K)
    widened = tuple(i for i, row in enumerate(rows) if np.count_nonzero(row) > 1 and loose[row != 0.0].any())
    for i in widened:
        row = rows[i]
        K += kp[i] * (np.diag(np.where(row != 0.0, row @ row, 0.0)) - np.outer(row, row))
    return ServoStiffness((K + K.T) / 2, tuple(servos[i].name for i in widened))


def _loose(K: Array) -> Array:
    """(nv,) of joints that take part in a motion that nothing resists."""
    size = np.sqrt(np.diagonal(K))
    stiff, motions = np.linalg.eigh(K / np.outer(size, size))  # without units, so that hinges and slides compare
    return np.asarray((abs(motions[:, stiff <= SEMIDEFINITE * stiff[-1]]) > 1e-6).any(axis=1))
