"""A grasp in one posture as the arrays that its paths are followed with: what stays, and what is watched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np

from handlcp.check import Array, read_only
from handlcp.contact.friction import Cone, Section, limit_set
from handlcp.errors import Unsupported
from handlcp.grasp.assembly.problem import polyhedron_normals
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import commanded_offset
from handlcp.grasp.effects.joint_torque import FingerWeight, TorqueSaturation
from handlcp.grasp.limits.kernels.happens import Watch
from handlcp.grasp.limits.kernels.onward import Sets
from handlcp.grasp.limits.kernels.parts import Parts
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.effect import Limit
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.path.geometry import supports


@dataclass(frozen=True, eq=False)
class System:
    """spec : the grasp, with the flexibility and the effects that count in one posture. scene : of it. weight (6,) :
    what rests on the object, as `GraspSpec.resting_wrench`. limits : that give way, in the order of their unknowns.
    watched : (kind, name) of each row of `watch`. sets : of friction.
    """

    spec: GraspSpec
    section: Section
    scene: Scene
    parts: Parts
    weight: Array
    limits: tuple[Limit, ...]
    watched: tuple[tuple[str, str], ...]
    watch: Watch
    sets: Sets

    def load(self, wrench: Array) -> Array:
        """(dof,) in natural units, from a wrench (6,) about the reference."""
        return np.asarray(self.loads(wrench[None])[0])

    def loads(self, wrenches: Array) -> Array:
        """(m, dof) the same of wrenches (m, 6)."""
        scene, units = self.scene, self.scene.units
        about = wrenches / units.force_unit
        arm = np.broadcast_to(self.spec.reference - units.centre, (len(wrenches), 3))
        about[:, 3:] = (about[:, 3:] + cross_rows(arm, about[:, :3])) / units.length_unit
        return np.ascontiguousarray(about @ scene.freedom.T)


@overload
def system_of(spec: GraspSpec, section: Section, wrench: Array) -> System: ...
@overload
def system_of(spec: GraspSpec, section: Section, wrench: None) -> System | None: ...
def system_of(spec: GraspSpec, section: Section, wrench: Array | None) -> System | None:
    """The arrays of a grasp. wrench (6,) : its load beside the weight, which sets the natural units where there is
    neither squeeze nor weight; without any of these there is no system. Raises Unsupported.
    """
    if held := [e for e in spec.effects if e.prescribed()]:
        names = ", ".join(type(e).__name__ for e in held)
        raise Unsupported(f"forces that are known or prescribed cannot be followed through a loading ({names})")
    if foreign := [e for e in spec.effects if e.stamps and not e.only_limits]:
        names = ", ".join(type(e).__name__ for e in foreign)
        raise Unsupported(f"a load limit knows no unknowns but forces and limits that give way ({names})")
    effects = tuple([e for e in spec.effects if not isinstance(e, GeometricStiffness)])
    weight = spec.resting_wrench
    E = spec.flexibility.copy()
    E[3 * spec.of_hand :, 3 * spec.of_hand :] = supports(spec)
    spec = spec.replace(flexibility=read_only(E), effects=effects, wrench=read_only(weight))
    scene = build_scene(spec)
    if not weight.any() and not scene.offset.any():  # nothing else has a size
        if wrench is None:
            return None
        spec = spec.replace(wrench=wrench)
        scene = build_scene(spec)
    limits = tuple([limit for e in effects for limit in e.present(scene)])
    watched, watch = _watch(spec, scene, effects, limits)
    return System(
        spec, section, scene, _parts(scene, section, limits), weight, limits, watched, watch, _sets(scene, section)
    )


def _parts(scene: Scene, section: Section, limits: tuple[Limit, ...]) -> Parts:
    kind, blocks = scene.kind, scene.natural
    place = np.full(kind.components + 1, -1)
    place[kind.index] = np.arange(len(kind.index))
    contacts = place[kind.contact_components]
    owner, normals, moving = list[int](), list[Array](), list[int]()
    for i, t in enumerate(kind.tangent_count):
        if t == 0:
            continue
        round_ = isinstance(section, Cone) and t > 1
        faces = np.zeros((1 if round_ else len(limit_set(section, t).normals.T), 3))
        if not round_:
            faces[:, :t] = limit_set(section, t).normals.T
        owner += [i] * len(faces)
        normals.append(faces)
        moving += [int(round_)] * len(faces)
    rows = np.concatenate([limit.natural_rows for limit in limits]) if limits else np.zeros((0, kind.components))
    every = np.concatenate(normals) if normals else np.zeros((0, 3))
    return Parts(
        _own(blocks.E), _own(blocks.G), _own(rows[:, kind.index]), contacts, _own(scene.friction_coefficients(section)),
        np.array(owner, dtype=np.int64), _own(every), np.array(moving, dtype=np.int64),
    )  # fmt: skip


def _sets(scene: Scene, section: Section) -> Sets:
    round_ = [int(isinstance(section, Cone) and t > 1) for t in scene.kind.tangent_count]
    return Sets(section.faces, _own(polyhedron_normals(scene, section)), np.array(round_, dtype=np.int64))


def _own(a: Array) -> Array:
    """A copy that compiled code takes as the same type whatever it was made of."""
    return np.array(a, dtype=float, order="C")


def _watch(
    spec: GraspSpec, scene: Scene, effects: tuple[Effect, ...], limits: tuple[Limit, ...]
) -> tuple[tuple[tuple[str, str], ...], Watch]:
    """Torques, unless they saturate, and ends of joints' ranges."""
    units, index, k = scene.units, scene.kind.index, sum([len(limit.room) for limit in limits])
    moves = np.zeros((6, scene.dof))
    arm = spec.reference - units.centre
    for c in range(scene.dof):
        twist = scene.twist(np.eye(scene.dof)[c])
        moves[:3, c], moves[3:, c] = twist[:3] + cross_rows(twist[3:], arm), twist[3:]
    rows, level, watched = np.zeros((0, len(index) + k)), np.zeros(0), tuple[tuple[str, str], ...]()
    joints = spec.mechanism
    if joints is not None and len(joints.names):
        T = joints.jacobian_rows(scene.soft)
        T = (T if scene.scale is None else T * scene.scale[:, None])[index].T * units.force_unit
        if not any(isinstance(e, TorqueSaturation) for e in effects):
            held, most = scene.bias_torque_or_zero, joints.limits
            some = np.flatnonzero(np.isfinite(most) & (abs(T).max(axis=1, initial=0.0) > 0.0))
            own = np.hstack([T[some], np.zeros((len(some), k))])
            rows = np.concatenate([rows, own, -own])
            level = np.concatenate([level, most[some] - held[some], most[some] + held[some]])
            watched += tuple([("torque", joints.names[j]) for j in some]) * 2
        nominal = joints.joint_model.position
        if nominal is not None and joints.joint_model.ranges is not None:
            sag = sum([e.torque for e in effects if isinstance(e, FingerWeight) and e.sags], np.zeros(len(T)))
            command = commanded_offset(effects, len(T))
            q = nominal + command - joints.deflection(sag)
            Q = joints.compliance_factor @ (joints.compliance_factor.T @ T)
            give = _yield_rows(scene, effects, limits, len(T))
            for end, sign in (
                (joints.joint_model.ranges[0], 1.0),
                (joints.joint_model.ranges[1], -1.0),
            ):  # q = q0 - Q r - give
                some = np.flatnonzero(np.isfinite(end) & (sign * (q - end) >= 0.0))
                rows = np.concatenate([rows, sign * np.hstack([Q, give])[some]])
                level = np.append(level, (sign * (q - end))[some])
                watched += tuple([("range", joints.names[j]) for j in some])
    return watched, Watch(
        np.ascontiguousarray(rows), level, moves, np.zeros(6), np.inf, np.inf
    )  # fmt: skip


def _yield_rows(scene: Scene, effects: tuple[Effect, ...], limits: tuple[Limit, ...], nv: int) -> Array:
    """(nv, k) how far one natural unit of each limit that gives way drives each joint back [rad, m]."""
    out = np.zeros((nv, sum([len(limit.room) for limit in limits])))
    at, joints = 0, scene.mechanism
    for e in effects:
        for limit in e.present(scene):
            if isinstance(e, TorqueSaturation) and joints is not None and limit.levers is not None:
                sign = 1.0 if limit.name == "s⁺" else -1.0
                for c, j in enumerate(e.limited(scene)[2]):
                    out[j, at + c] = sign * scene.units.motion_unit / limit.levers[c]
            at += len(limit.room)
    return out
