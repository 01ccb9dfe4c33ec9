"""The grasp with one parameter a little larger, for what is differenced as a whole."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.model.spec import GraspSpec

# [SI] that leave differences about as much rounding as truncation
STEPS = {
    "wrench": 1e-4, "squeeze": 1e-7, "joint_offset": 1e-6, "stiffness": 1e-4, "pads": 1e-8, "friction": 1e-5,
    "torque_limits": 1e-5, "positions": 1e-7, "normals": 1e-6, "posture": 1e-6, "lengths": 1e-7,
}  # fmt: skip
TOGETHER = ("friction", "pads", "squeeze", "stiffness", "torque_limits")  # of which a common change has a meaning
_NO_PAD = 1e-9  # of the flexibility: a pad softer by less is rounding
_OF_JOINTS = ("joint_offset", "stiffness", "torque_limits", "posture")


def shape_of(spec: GraspSpec, parameter: str) -> tuple[int, ...]:
    """Of a parameter's entries."""
    joints: Any = spec.mechanism
    if parameter in _OF_JOINTS:
        return (0 if joints is None else len(joints.names),)
    if parameter == "lengths":
        return (0 if joints is None else len(joints.lengths), 3)
    return {"wrench": (6,), "positions": (spec.n, 3), "normals": (spec.n, 3)}.get(parameter, (spec.n,))


def vary(spec: GraspSpec, parameter: str, k: int, step: float) -> GraspSpec:
    """The grasp with the k-th entry of a parameter larger by a step; contacts, commands and offsets stay, but by
    stiffness, torque limits, posture and lengths the grasp is made again as it was asked for.
    """
    mechanism: Any = spec.mechanism
    if parameter == "wrench":
        return spec.replace(wrench=_more(spec.wrench, k, step))
    if parameter == "squeeze":
        return spec.replace(offset=_more(spec.offset, 3 * k + 2, -step))
    if parameter == "pads":
        along = (0, 2) if spec.planar else (0, 1, 2)
        E = spec.flexibility
        for a in along:
            E = _more(E, (3 * k + a) * (len(E) + 1), step)
        return spec.replace(flexibility=E)
    if parameter == "friction":
        laws = [c.friction for c in spec.contacts]
        laws[k] = laws[k].with_mu(laws[k].mu + step)
        return spec.with_laws(tuple(laws))
    if parameter == "joint_offset":
        told = next((e.command for e in spec.effects if isinstance(e, JointOffset)), np.zeros(len(mechanism.names)))
        others = tuple([e for e in spec.effects if not isinstance(e, JointOffset)])
        return spec.replace(effects=(*others, JointOffset(_more(told, k, step))))
    if parameter in ("positions", "normals"):
        return moved(spec, parameter, k, step)
    made: GraspSpec = mechanism.varied(spec, parameter, k, step)
    return made


def vary_all(spec: GraspSpec, parameter: str, steps: Array) -> GraspSpec:
    """The grasp with each entry of a parameter larger by a step of its own, steps in the parameter's shape; contacts
    without friction, and joints without a limit, stay without.
    """
    keeps = _without(spec, parameter)
    for k, step in enumerate(steps.reshape(-1)):
        if step != 0.0 and not (len(keeps) and keeps[k]):
            spec = vary(spec, parameter, k, float(step))
    return spec


def _without(spec: GraspSpec, parameter: str) -> Bools:
    """Which entries are no number to change; () where all are."""
    mechanism: Any = spec.mechanism
    if parameter == "friction":
        return np.array([c.mu <= 0.0 for c in spec.contacts])
    if parameter == "torque_limits":
        return np.asarray(~np.isfinite(mechanism.limits))
    return np.zeros(0, bool)


def sizes_of(spec: GraspSpec, parameter: str) -> Array:
    """How large the entries of a parameter are, in its shape, SI; 0 where that has no meaning, such as of a pose."""
    mechanism: Any = spec.mechanism
    if parameter == "wrench":
        return spec.wrench
    if parameter == "friction":
        return np.array([c.mu for c in spec.contacts])
    if parameter == "squeeze":
        return np.maximum(-spec.offset[:, 2], 0.0)
    if parameter == "pads":
        return _pads(spec)
    if mechanism is None or parameter not in ("joint_offset", "stiffness", "torque_limits"):
        return np.zeros(shape_of(spec, parameter))
    if parameter == "joint_offset":
        told: Any = next((e.command for e in spec.effects if isinstance(e, JointOffset)), None)
        return np.zeros(shape_of(spec, parameter)) if told is None else np.asarray(told)
    if parameter == "torque_limits":
        return np.where(np.isfinite(mechanism.limits), mechanism.limits, 0.0)
    C = (mechanism.root**2).sum(axis=1)
    return np.where(C > 0.0, 1.0 / np.where(C > 0.0, C, 1.0), 0.0) if mechanism.gives(spec) else np.zeros(len(C))


def _pads(spec: GraspSpec) -> Array:
    """(n,) flexibility of each contact without that of the joints, the mean over its axes [m/N]."""
    mechanism: Any = spec.mechanism
    E, axes = spec.flexibility, (0, 2) if spec.planar else (0, 1, 2)
    own = np.diagonal(E)[: 3 * spec.n].reshape(spec.n, 3)
    if mechanism is not None and mechanism.gives(spec):
        through = mechanism.rows(())[: 3 * spec.n] @ mechanism.root
        own = own - (through**2).sum(axis=1).reshape(spec.n, 3)
    pads = own[:, axes].mean(axis=1)
    return np.asarray(np.where(pads > _NO_PAD * abs(E).max(initial=0.0), pads, 0.0))


def moved(spec: GraspSpec, parameter: str, k: int, step: float) -> GraspSpec:
    """The grasp with a contact's point moved along an axis of the world, or its axes turned about one of themselves."""
    positions, frames = spec.positions, spec.frames
    if parameter == "positions":
        positions = _more(positions, k, step)
    else:
        i, a = divmod(k, 3)
        x, y = (a + 1) % 3, (a + 2) % 3
        frames = frames.copy()
        frames[i, :, x] = np.cos(step) * spec.frames[i, :, x] + np.sin(step) * spec.frames[i, :, y]
        frames[i, :, y] = np.cos(step) * spec.frames[i, :, y] - np.sin(step) * spec.frames[i, :, x]
        frames = read_only(frames)
    if spec.mechanism is not None:
        made: GraspSpec = spec.mechanism.replaced(spec, positions, frames)
        return made
    contacts = tuple([
        c.placed(p, read_only(R @ before.T @ c.rotation), c.friction, c.planar, c.name)  # its own axes turn along
        for c, p, R, before in zip(spec.contacts, positions, frames, spec.frames, strict=True)
    ])  # fmt: skip
    return spec.replace(contacts=contacts, positions=positions, frames=frames)


def _more(values: Array, k: int, step: float) -> Array:
    """A copy with its k-th entry larger."""
    out = values.copy()
    out.reshape(-1)[k] += step
    return read_only(out)
