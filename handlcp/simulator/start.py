"""Where a simulation starts: the fingertips touch, and whatever overlap the posture has is still to be closed."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.model.kind import cross_rows
from handlcp.hand import HandGrasp
from handlcp.hand.objects.detect import nearest
from handlcp.hand.reach import joint_by_joint
from handlcp.hand.robot.posture import Posture
from handlcp.simulator.mjcf.hand_tree import full_names
from handlcp.simulator.mjcf.springs import Springs
from handlcp.simulator.state import SimulatorState

_TOUCHING = 1e-6  # [m] an overlap up to this is what is left of touching
_NEAR = 1e-9  # [m] what is opened ends as near as this
_ITERATIONS = 30


def starting_state(grasp: HandGrasp, springs: Springs) -> SimulatorState:
    """Posture, commands and load. Raises Unsupported where tips overlap the object and joints cannot open them, and for
    rigid joints that would have to move.
    """
    hand, q, offset = grasp.state.hand, grasp.state.q, grasp.joint_offset
    kinematics, gravity = hand.kinematics, grasp.mechanism.gravity
    start = _opened(grasp)
    for j in springs.rigid:
        if offset[j] or start[j] != q[j]:
            raise Unsupported(f"joint {hand.joint_names[j]!r} is rigid: it cannot be commanded beyond where it stands")
    held, weighing = np.zeros(len(q)), tuple[str, ...]()
    if grasp.finger_weight == "torques":  # the posture has sagged already
        held = hand.stiffness.deflection(kinematics.gravity_torque(q, gravity))
    elif grasp.finger_weight:
        weighing = tuple(kinematics.model.names)[1:]
    full = start if kinematics.coupling is None else kinematics.coupling @ start + kinematics.offset
    before, after = springs.arms @ (start + held), springs.arms @ (q + held + offset)
    obj, spec = grasp.target, grasp.spec
    assert obj is not None
    weight = obj.mass * gravity
    moment = cross_rows(obj.center_of_mass - spec.reference, weight)
    return SimulatorState(
        dict(zip(full_names(hand), full.tolist(), strict=True)),
        dict(zip(springs.names, before.tolist(), strict=True)), dict(zip(springs.names, after.tolist(), strict=True)),
        float(obj.mass), weighing, read_only(spec.wrench - np.append(weight, moment)),
    )  # fmt: skip


def _opened(grasp: HandGrasp) -> Array:
    """(nv,) the posture, with fingers that overlap the object opened until they touch it, joint by joint."""
    posture: Posture = grasp.state
    mechanism, obj = grasp.mechanism, grasp.target
    assert obj is not None
    k, tips = len(mechanism.tips), mechanism.tips
    inside = np.zeros(k)
    for turn in range(_ITERATIONS):
        shapes = [posture.hand.tip_shapes(i) for i in tips]
        places, turns = posture.tip_positions[list(tips)], posture.tip_rotations[list(tips)]
        near = [nearest(s, p, R, obj) for s, p, R in zip(shapes, places, turns, strict=True)]
        gaps = np.array([n.gap for n in near])
        inside = np.where(gaps < -_TOUCHING if not turn else inside != 0.0, -gaps, 0.0)
        if abs(inside).max(initial=0.0) <= _NEAR:
            return posture.q
        positions, normals = np.array([n.position for n in near]), np.array([n.normal for n in near])
        frames = grasp.frames[:k].copy()
        frames[:, :, 2] = normals  # tangents do not matter: only depths along normals are asked for
        moved = mechanism.moved(posture, positions, frames)
        posture = Posture(posture.hand, posture.q - joint_by_joint(moved, grasp.spec.planar).deeper(inside))
    name, depth = grasp.fingertips[int(np.argmax(inside))], 1e3 * float(inside.max())
    raise Unsupported(f"fingertip {name!r} starts {depth:.3g} mm inside the object, and its joints cannot open it")
