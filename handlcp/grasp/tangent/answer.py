"""An answer as the derivatives need it: its arrays about the grasp's reference, its contact states, its joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import joints_commanded
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.friction import Section
from handlcp.grasp.model.limit import Limit
from handlcp.grasp.model.mechanism import JointReading
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.verify.judge import friction_of, limits_at_answer
from handlcp.lazy import lazy
from handlcp.tolerances import ACTIVE


@dataclass(frozen=True, eq=False)
class Yielding:
    """The limits that an answer has reached. every : all limits of the scene. at (m,) : which of them, in the order in
    which they are stacked; the first `active` of them give way, the others are just reached. rows (m, c) : in natural
    units. sizes (m,) : SI of one natural unit of each row's room. joints (m, nv) : which torque each row limits, with
    its sign; 0 for limits of forces.
    """

    every: tuple[Limit, ...]
    at: Ints
    active: int
    rows: Array
    sizes: Array
    joints: Array


@dataclass(frozen=True, eq=False)
class Answer:
    """What was solved, and the certified numbers. forces (n, 3) [N] and torsion (n,) [N·m] in contact axes, twist (6,)
    of the object about the grasp's reference, extra : as in `GraspSolution`. weak [N] and slow [m] count as nothing.
    """

    spec: GraspSpec
    scene: Scene
    section: Section
    forces: Array
    torsion: Array | None
    twist: Array
    extra: dict[str, Array]
    weak: float
    slow: float

    @lazy
    def components(self) -> Array:
        """(c,) forces in contact axes, moments of soft contacts last [N, N·m]."""
        flat = self.forces.reshape(-1)
        if not self.scene.soft:
            return flat
        moments = np.zeros(self.scene.n) if self.torsion is None else self.torsion
        return np.append(flat, moments[list(self.scene.soft)])

    @lazy
    def lawful(self) -> Array:
        """(c,) the same in the coordinates of the friction laws [N]."""
        return self.scene.lawful(self.components)

    @lazy
    def scale(self) -> Array:
        """(c,) S, which turns the laws' forces into those in contact axes."""
        return np.ones(self.scene.components) if self.scene.scale is None else self.scene.scale

    @lazy
    def sizes(self) -> Array:
        """(5,) natural units of force, motion and length; weak and slow."""
        u = self.scene.units
        return np.array([u.force, u.motion, u.length, self.weak, self.slow])

    @lazy
    def balance_sizes(self) -> Array:
        """(dof,) SI of one natural unit of each row of balance [N, N·m]."""
        u, k = self.scene.units, 3 if self.scene.plane is None else 2
        return np.array((u.force,) * k + (u.force * u.length,) * (self.scene.dof - k))

    # ---- joints
    @lazy
    def rows(self) -> Array:
        """(c, nv) [J; T]: how fast the joints move the contact points, and turn the soft ones about their normals."""
        mechanism = self.spec.mechanism
        return np.zeros((self.scene.components, 0)) if mechanism is None else mechanism.rows(self.scene.soft)

    @lazy
    def joints(self) -> JointReading:
        """Torques [N·m] and deflections [rad] of the joints."""
        mechanism = self.spec.mechanism
        if mechanism is None:
            return JointReading(np.zeros(0), np.zeros(0), np.zeros(0))
        return mechanism.joints(self.scene, self.spec.effects, self.forces, self.torsion, self.extra)

    @lazy
    def command(self) -> Array:
        """(nv,) how far the joints are commanded beyond the posture."""
        return joints_commanded(self.spec.effects, self.rows.shape[1])

    @lazy
    def bent(self) -> Array | None:
        """(nv, nv) K_g of the forces [N·m/rad], where it is asked for (`GeometricStiffness`)."""
        found = next((e.bent for e in self.spec.effects if isinstance(e, GeometricStiffness)), None)
        return None if found is None else found.stiffness

    @lazy
    def compliance(self) -> Array:
        """(nv, nv) K⁻¹, or (K + K_g)⁻¹ [rad/(N·m)]."""
        mechanism = self.spec.mechanism
        if mechanism is None:
            return np.zeros((0, 0))
        C = mechanism.root @ mechanism.root.T
        bent = next((e.bent for e in self.spec.effects if isinstance(e, GeometricStiffness)), None)
        return C if bent is None else C + bent.softer

    @lazy
    def levers(self) -> Array | None:
        """(c, nv) how K_g of one unit of each force component turns the joints that stand where the answer has them:
        ∂(K_g z)/∂r for z = δq - δ; None without `GeometricStiffness`.
        """
        if self.bent is None:
            return None
        assert self.spec.mechanism is not None  # the effect needs joints
        return np.asarray(self.spec.mechanism.hessian() @ (self.command - self.joints.deflection))

    @lazy
    def tangent(self) -> Array:
        """(c, c) ∂v/∂r in the laws' coordinates: E, and with `GeometricStiffness` what turning levers add."""
        if self.levers is None:
            return self.scene.flexibility
        more = self.rows @ self.compliance @ self.levers.T
        return np.asarray(self.scene.flexibility + self.scale[:, None] * more * self.scale)

    @lazy
    def torque_rows(self) -> Array:
        """(c, nv) ∂τ/∂r of the forces in contact axes."""
        if self.levers is None or self.bent is None:
            return self.rows
        kept = np.eye(len(self.bent)) - self.bent @ self.compliance
        return np.asarray((self.rows + self.levers) @ kept.T)

    # ---- limits and friction
    @lazy
    def friction(self) -> Any:
        """The friction sets."""
        return friction_of(self.scene, self.section)

    @lazy
    def friction_shares(self) -> Array:
        """(n,) of each coefficient, how much its section bears [-]; NaN without friction."""
        mu = np.array([c.mu for c in self.spec.contacts])
        return np.where(mu > 0.0, self.friction.limits / np.where(mu > 0.0, mu, 1.0), np.nan)

    @lazy
    def opening(self) -> Array:
        """(c,) d with what yielding limits open, in the laws' coordinates."""
        offset = self.scene.offset
        for e in self.spec.effects:
            if (more := e.opening(self.scene, self.extra)) is not None:
                offset = offset + more
        return offset

    @lazy
    def yielding(self) -> Yielding:
        """The limits that are reached."""
        scene = self.scene
        if not any(e.stamps for e in self.spec.effects):
            return _nothing_limited(scene.components, self.rows.shape[1])
        candidate = Candidate(self.lawful, self.twist, self.extra, len(scene.soft))
        found = limits_at_answer(scene, self.spec.effects, candidate)
        active, resting = found.motion > ACTIVE, found.resting.copy()
        for k in np.flatnonzero(resting):  # two limits that meet are one equation
            for j in np.flatnonzero(found.resting | active):
                if j != k and resting[k] and (found.rows[j] == -found.rows[k]).all():
                    resting[[j, k]], active[k] = False, not active[j]
        at = np.concatenate([np.flatnonzero(active), np.flatnonzero(resting)])
        room = [np.ones(len(limit.room)) if limit.levers is None else limit.levers for limit in found.every]
        sizes = scene.units.force * np.concatenate([np.zeros(0), *room])[at]
        joints = read_only(_of_joints(self.spec.effects, scene, len(found.rows), self.rows.shape[1])[at])
        return Yielding(found.every, at, int(active.sum()), read_only(found.rows[at]), sizes, joints)

    @property
    def governed(self) -> Bools:
        """(n,) contacts whose force is not prescribed."""
        return self.scene.governed_mask

    @lazy
    def elastic_joints(self) -> bool:
        """Whether E follows the springs of the joints, because no other one was given."""
        mechanism = self.spec.mechanism
        return mechanism is not None and mechanism.gives(self.spec)


@lru_cache(maxsize=64)
def _nothing_limited(components: int, nv: int) -> Yielding:
    none = read_only(np.zeros((0, components)))
    return Yielding((), np.zeros(0, np.int64), 0, none, np.zeros(0), read_only(np.zeros((0, nv))))


def _of_joints(effects: tuple[Effect, ...], scene: Scene, m: int, nv: int) -> Array:
    """(m, nv) which torque each of all limits of a scene limits, with its sign."""
    out, at = np.zeros((m, nv)), 0
    for e in effects:
        for limit in e.present(scene):
            if isinstance(e, TorqueSaturation):
                rows = at + np.arange(len(limit.room))
                out[rows, e.limited(scene)[2]] = 1.0 if limit.name == "s⁺" else -1.0
            at += len(limit.room)
    return out
