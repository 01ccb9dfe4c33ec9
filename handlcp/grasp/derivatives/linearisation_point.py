"""`LinearisationPoint`: an answer as the derivatives need it: its arrays about the grasp's reference, its contact
states, its joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.assembly.problem import SolverCandidate
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.joint_offset import commanded_offset
from handlcp.grasp.effects.joint_torque import TorqueSaturation
from handlcp.grasp.model.effect import Limit
from handlcp.grasp.model.mechanism import JointReading, read_joints
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.certifier import friction_limits, limits_at_answer
from handlcp.lazy_property import lazy_property
from handlcp.tolerances import ACTIVE_TOLERANCE


@dataclass(frozen=True, eq=False)
class ReachedLimits:
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
class LinearisationPoint:
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
    force_tolerance: float
    motion_tolerance: float

    @lazy_property
    def components(self) -> Array:
        """(c,) forces in contact axes, moments of soft contacts last [N, N·m]."""
        flat = self.forces.reshape(-1)
        if not self.scene.soft:
            return flat
        moments = np.zeros(self.scene.n) if self.torsion is None else self.torsion
        return np.append(flat, moments[list(self.scene.soft)])

    @lazy_property
    def law_forces(self) -> Array:
        """(c,) the same in the coordinates of the friction laws [N]."""
        return self.scene.forces_to_law_axes(self.components)

    @lazy_property
    def scale(self) -> Array:
        """(c,) S, which turns the laws' forces into those in contact axes."""
        return np.ones(self.scene.components) if self.scene.scale is None else self.scene.scale

    @lazy_property
    def sizes(self) -> Array:
        """(5,) natural units of force, motion and length; weak and slow."""
        u = self.scene.units
        return np.array([u.force_unit, u.motion_unit, u.length_unit, self.force_tolerance, self.motion_tolerance])

    @lazy_property
    def balance_sizes(self) -> Array:
        """(dof,) SI of one natural unit of each row of balance [N, N·m]."""
        u, k = self.scene.units, 3 if self.scene.plane is None else 2
        return np.array((u.force_unit,) * k + (u.force_unit * u.length_unit,) * (self.scene.dof - k))

    # ---- joints
    @lazy_property
    def jacobian_rows(self) -> Array:
        """How fast the joints move the contact points, and turn the soft ones about their normals: [J; T] (c, nv)."""
        mechanism = self.spec.mechanism
        return np.zeros((self.scene.components, 0)) if mechanism is None else mechanism.jacobian_rows(self.scene.soft)

    @lazy_property
    def joints(self) -> JointReading:
        """Torques [N·m] and deflections [rad] of the joints."""
        mechanism = self.spec.mechanism
        if mechanism is None:
            return JointReading(np.zeros(0), np.zeros(0), np.zeros(0))
        return read_joints(mechanism, self.scene, self.spec.effects, self.forces, self.torsion, self.extra)

    @lazy_property
    def command(self) -> Array:
        """(nv,) how far the joints are commanded beyond the posture."""
        return commanded_offset(self.spec.effects, self.jacobian_rows.shape[1])

    @lazy_property
    def geometric_stiffness(self) -> Array | None:
        """(nv, nv) K_g of the forces [N·m/rad], where it is asked for (`GeometricStiffness`)."""
        found = next((e.bent for e in self.spec.effects if isinstance(e, GeometricStiffness)), None)
        return None if found is None else found.stiffness

    @lazy_property
    def compliance(self) -> Array:
        """(nv, nv) K⁻¹, or (K + K_g)⁻¹ [rad/(N·m)]."""
        mechanism = self.spec.mechanism
        if mechanism is None:
            return np.zeros((0, 0))
        C = mechanism.compliance_factor @ mechanism.compliance_factor.T
        bent = next((e.bent for e in self.spec.effects if isinstance(e, GeometricStiffness)), None)
        return C if bent is None else C + bent.added_compliance

    @lazy_property
    def levers(self) -> Array | None:
        """(c, nv) how K_g of one unit of each force component turns the joints that stand where the answer has them:
        ∂(K_g z)/∂r for z = δq - δ; None without `GeometricStiffness`.
        """
        if self.geometric_stiffness is None:
            return None
        assert self.spec.mechanism is not None  # the effect needs joints
        return np.asarray(self.spec.mechanism.hessian() @ (self.command - self.joints.deflection))

    @lazy_property
    def tangent(self) -> Array:
        """(c, c) ∂v/∂r in the laws' coordinates: E, and with `GeometricStiffness` what turning levers add."""
        if self.levers is None:
            return self.scene.flexibility
        more = self.jacobian_rows @ self.compliance @ self.levers.T
        return np.asarray(self.scene.flexibility + self.scale[:, None] * more * self.scale)

    @lazy_property
    def torque_rows(self) -> Array:
        """(c, nv) ∂τ/∂r of the forces in contact axes."""
        if self.levers is None or self.geometric_stiffness is None:
            return self.jacobian_rows
        kept = np.eye(len(self.geometric_stiffness)) - self.geometric_stiffness @ self.compliance
        return np.asarray((self.jacobian_rows + self.levers) @ kept.T)

    # ---- limits and friction
    @lazy_property
    def friction(self) -> Any:
        """The friction sets of the contacts at this answer."""
        return friction_limits(self.scene, self.section)

    @lazy_property
    def friction_shares(self) -> Array:
        """(n,) of each coefficient, how much its section bears [-]; NaN without friction."""
        mu = np.array([c.mu for c in self.spec.contacts])
        return np.where(mu > 0.0, self.friction.limits / np.where(mu > 0.0, mu, 1.0), np.nan)

    @lazy_property
    def opening(self) -> Array:
        """(c,) d with what yielding limits open, in the laws' coordinates."""
        offset = self.scene.offset
        for e in self.spec.effects:
            if (more := e.opening(self.scene, self.extra)) is not None:
                offset = offset + more
        return offset

    @lazy_property
    def reached_limits(self) -> ReachedLimits:
        """The limits that are reached."""
        scene = self.scene
        if not any(e.stamps for e in self.spec.effects):
            return _no_reached_limits(scene.components, self.jacobian_rows.shape[1])
        candidate = SolverCandidate(self.law_forces, self.twist, self.extra, len(scene.soft))
        found = limits_at_answer(scene, self.spec.effects, candidate)
        active, resting = found.motion > ACTIVE_TOLERANCE, found.resting.copy()
        for k in np.flatnonzero(resting):  # two limits that meet are one equation
            for j in np.flatnonzero(found.resting | active):
                if j != k and resting[k] and (found.rows[j] == -found.rows[k]).all():
                    resting[[j, k]], active[k] = False, not active[j]
        at = np.concatenate([np.flatnonzero(active), np.flatnonzero(resting)])
        room = [np.ones(len(limit.room)) if limit.levers is None else limit.levers for limit in found.every]
        sizes = scene.units.force_unit * np.concatenate([np.zeros(0), *room])[at]
        joints = read_only(_joint_of_limits(self.spec.effects, scene, len(found.rows), self.jacobian_rows.shape[1])[at])
        return ReachedLimits(found.every, at, int(active.sum()), read_only(found.rows[at]), sizes, joints)

    @property
    def force_unknown(self) -> Bools:
        """(n,) contacts whose force is not prescribed."""
        return self.scene.force_unknown_mask

    @lazy_property
    def elastic_joints(self) -> bool:
        """Whether E follows the springs of the joints, because no other one was given."""
        mechanism = self.spec.mechanism
        return mechanism is not None and mechanism.variation.has_joint_flexibility(self.spec)


@lru_cache(maxsize=64)
def _no_reached_limits(components: int, nv: int) -> ReachedLimits:
    none = read_only(np.zeros((0, components)))
    return ReachedLimits((), np.zeros(0, np.int64), 0, none, np.zeros(0), read_only(np.zeros((0, nv))))


def _joint_of_limits(effects: tuple[Effect, ...], scene: Scene, m: int, nv: int) -> Array:
    """(m, nv) which torque each of all limits of a scene limits, with its sign."""
    out, at = np.zeros((m, nv)), 0
    for e in effects:
        for limit in e.present(scene):
            if isinstance(e, TorqueSaturation):
                rows = at + np.arange(len(limit.room))
                out[rows, e.limited(scene)[2]] = 1.0 if limit.name == "s⁺" else -1.0
            at += len(limit.room)
    return out


# ----------------------------------------------------------------
# What parameters change in the laws of a grasp while forces and motion stay, and what an answer does about it.


@dataclass(frozen=True, eq=False)
class LawChange:
    """By p parameters, SI, each (…, p). Contacts' motions in the coordinates of the friction laws.

    motion (c, p) : δv, of the object relative to the tips [m]. balance (6, p) : δb, of the wrench that is left over,
    about the reference. friction (n, p) : δμ of the coefficients of the sections (`Scene.friction_coefficients`) [-].
    torque (nv, p) : of what the joints hold [N·m].
    torque_limits (nv, p) : of the joints' limits [N·m]. depth_change : what comes on top where fingertips go deeper
    into an object that they just touch; None: nothing does.
    """

    motion: Array
    balance: Array
    friction: Array
    torque: Array
    torque_limits: Array
    depth_change: DepthChange | None = None

    def along_direction(self, direction: Array) -> LawChange:
        """The change along one direction (p,) of the parameters, as a single column (…, 1)."""
        straight = _from_parts([(part @ direction)[:, None] for part in self._parts])
        if self.depth_change is None:
            return straight
        return replace(
            straight, depth_change=self.depth_change.with_rates(self.depth_change.rates @ direction[:, None])
        ).ahead

    @property
    def ahead(self) -> LawChange:
        """Of parameters that grow, one at a time."""
        if self.depth_change is None:
            return self
        depth = np.maximum(self.depth_change.rates, 0.0)
        pairs = zip(self._parts, self.depth_change.change._parts, strict=True)
        return _from_parts([part + more @ depth for part, more in pairs])

    def columns(self, which: Bools) -> LawChange:
        """Of these (p,) of the parameters."""
        return _from_parts([part[:, which] for part in self._parts])

    def with_touching(self, touches: Bools) -> LawChange:
        """Where only these (t,) of the fingertips in `depth_change` just touch: the others are inside already, and what
        takes them deeper counts on both sides.
        """
        if self.depth_change is None:
            return self
        rates, more = self.depth_change.rates, self.depth_change.change._parts
        already = np.where(touches[:, None], 0.0, rates)
        straight = [part + of @ already for part, of in zip(self._parts, more, strict=True)]
        left = DepthChange(
            self.depth_change.contacts[touches], rates[touches], self.depth_change.change.columns(touches)
        )
        return replace(_from_parts(straight), depth_change=left if touches.any() else None)

    @property
    def _parts(self) -> tuple[Array, ...]:
        return self.motion, self.balance, self.friction, self.torque, self.torque_limits


def _from_parts(parts: Sequence[Array]) -> LawChange:
    motion, balance, friction, torque, torque_limits = parts
    return LawChange(motion, balance, friction, torque, torque_limits)


@dataclass(frozen=True, eq=False)
class DepthChange:
    """Fingertips that just touch the object they were detected on. One that goes deeper counts as squeezed, and its
    joints take it sideways; one that leaves a gap does not.

    contacts (t,) : their numbers. rates (t, p) : how fast p parameters take them deeper [m]. change : by depth
    (…, t) [1/m].
    """

    contacts: Ints
    rates: Array
    change: LawChange

    def with_rates(self, rates: Array) -> DepthChange:
        """The same change of depths with the rates of other parameters."""
        return replace(self, rates=rates)


def zero_change(answer: LinearisationPoint, p: int) -> LawChange:
    """Of p parameters that change nothing: a place to write to."""
    scene, nv = answer.scene, answer.jacobian_rows.shape[1]
    sizes = (scene.components, 6, scene.n, nv, nv)
    return _from_parts([np.zeros((size, p)) for size in sizes])


def restrict_to_plane(answer: LinearisationPoint, change: LawChange) -> LawChange:
    """In a planar scene nothing moves across the plane."""
    if answer.spec.planar:
        change.motion[1 : 3 * answer.scene.n : 3] = 0.0
    return change


class ResponseRates(NamedTuple):
    """What p parameters do to an answer, SI, each (…, p). forces (c, p) in contact axes, moments of soft contacts last;
    motion (6, p) of the object about the reference; slip (c, p) of v, contact axes. NaN where it is not determined.
    """

    forces: Array
    motion: Array
    slip: Array
