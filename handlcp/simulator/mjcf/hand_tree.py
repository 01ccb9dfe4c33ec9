"""The moving links of a hand as MuJoCo bodies: one body a joint, links that are fixed to each other are one."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand.robot.model import HandModel
from handlcp.simulator.mjcf.words import add, placed

_LEAST_MASS = 1e-6  # [kg] of a link without <inertial>
_LEAST_INERTIA = 1e-9  # [kg·m²]
_ARMATURE = 1e-5  # [kg·m²] of every joint: links without inertia would move without limit


def add_hand(world: ET.Element, hand: HandModel, weighs: bool) -> dict[int, ET.Element]:
    """Bodies of all links that move, by the number of their joint in Pinocchio's model; 0 is the world.

    weighs : whether gravity acts on them.
    """
    model = hand.kinematics.model
    bodies = {0: world}
    for i in range(1, model.njoints):
        at = model.jointPlacements[i]
        weight = {} if weighs else {"gravcomp": 1.0}
        body = add(
            bodies[model.parents[i]], "body", name=model.names[i], **placed(at.rotation, at.translation), **weight
        )
        _add_inertia(body, model.inertias[i])
        bodies[i] = body
        kind, axis = axis_of(model, i)
        if kind:
            add(body, "joint", name=model.names[i], type=kind, axis=axis, armature=_ARMATURE)
    return bodies


def full_names(hand: HandModel) -> tuple[str, ...]:
    """Names of all movable joints, mimic joints included, in the order of rows of the coupling."""
    model = hand.kinematics.model
    moving = [(joint.idx_v, model.names[i]) for i, joint in enumerate(model.joints) if i and joint.nv]
    return tuple([name for _, name in sorted(moving)])


def axis_of(model: Any, i: int) -> tuple[str, Array]:
    """MuJoCo's word for joint i, and its axis (3,) in its own frame; no word for one that does not move."""
    joint = model.joints[i]
    if not joint.nv:
        return "", np.zeros(3)
    data = model.createData()
    column = pin.computeJointJacobian(model, data, pin.neutral(model), i)[:, joint.idx_v]  # in the joint's own frame
    return ("slide", column[:3]) if np.linalg.norm(column[3:]) < 0.5 else ("hinge", column[3:])


def _add_inertia(body: ET.Element, inertia: Any) -> None:
    mass, I = max(float(inertia.mass), _LEAST_MASS), np.array(inertia.inertia)  # noqa: E741
    least = max(float(np.linalg.eigvalsh(I)[0]), 0.0)
    if least < _LEAST_INERTIA:
        I = I + _LEAST_INERTIA * np.eye(3)  # noqa: E741
    full = (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])
    add(body, "inertial", pos=np.array(inertia.lever), mass=mass, fullinertia=full)
