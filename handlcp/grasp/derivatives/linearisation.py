"""`LinearisationPoint`: an answer, and the laws that its changes obey while every contact keeps its state.

A parameter enters these laws through `LawChange`: what it changes in them while forces and motion stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.contact.friction import Section
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.assembly.problem import SolverCandidate
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.active_set import LinearLaws, active_rows, saddle_matrix, solve_inverse
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness, LoadedJoints
from handlcp.grasp.effects.joint_offset import commanded_offset
from handlcp.grasp.effects.joint_torque import TorqueSaturation
from handlcp.grasp.model.mechanism import JointReading, Mechanism, evaluate_joints
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene, wrench_map
from handlcp.grasp.verify.certifier import FrictionLimits, friction_limits, limits_at_answer
from handlcp.grasp.verify.contact_state import ContactStates, find_states
from handlcp.lazy_property import lazy_property
from handlcp.tolerances import ACTIVE_TOLERANCE, RANK_TOLERANCE

_DEPTH_STEP = 1e-6  # [m]: what is differenced is linear in the depth
_SIDEWAYS_TOLERANCE = 1e-6  # of a depth: a sideways motion that is rounding


class LawChange:
    """What p parameters change in the laws of an answer, SI, each (…, p).

    contact_motion (c, p) : δv, of the object relative to the tips, in the coordinates of the friction laws [m].
    balance (6, p) : δb, of the wrench that is left over, about the reference.
    friction (n, p) : δμ of the coefficients of the sections (`Scene.friction_coefficients`) [-].
    torque (nv, p) : of what the joints hold [N·m]. torque_limits (nv, p) : of the joints' limits [N·m].
    values (k, p) : all of these, one above the other.
    by_depth (k, t) : the same by the depths of t fingertips that just touch the object they were detected on [1/m]. One
        that goes deeper counts as squeezed, and its joints take it sideways; one that leaves a gap does not.
    rates (t, p) : how fast the parameters take these fingertips deeper [m].
    """

    def __init__(
        self, answer: LinearisationPoint, values: Array, by_depth: Array | None = None, rates: Array | None = None
    ) -> None:
        self.answer, self.values = answer, values
        self.by_depth = np.zeros((len(values), 0)) if by_depth is None else by_depth
        self.rates = np.zeros((0, values.shape[1])) if rates is None else rates
        parts = np.split(values, np.cumsum(answer.law_sizes)[:-1])  # views
        self.contact_motion, self.balance, self.friction, self.torque, self.torque_limits = parts

    @property
    def ahead(self) -> LawChange:
        """Of parameters that grow, one at a time."""
        return LawChange(self.answer, self.values + self.by_depth @ np.maximum(self.rates, 0.0))

    def along(self, direction: Array) -> LawChange:
        """Of one parameter (…, 1) that grows along a direction (p,) of these."""
        way = direction[:, None]
        return LawChange(self.answer, self.values @ way, self.by_depth, self.rates @ way).ahead


class ReachedLimits(NamedTuple):
    """The m limits that an answer has reached, those that give way first.

    names (m,). gives (m,) : which give way. rows (m, c) : in natural units.
    sizes (m,) : SI of one natural unit of each row's room.
    joints (m, nv) : which torque each limits, with its sign; 0 of limits of forces.
    """

    names: tuple[str, ...]
    gives: Bools
    rows: Array
    sizes: Array
    joints: Array


class TipDepths(NamedTuple):
    """How far fingertips are inside the object that they were detected on, and t of them that this takes sideways.

    inside (k,) : of all fingertips [m]; None where contacts were given, so that none counts as inside.
    contacts (t,) : numbers of those that are inside, or just touch and may be inside soon.
    touch (t,) : those that just touch.
    change : of the laws by their depths, (…, t) [1/m].
    """

    inside: Array | None
    contacts: Ints
    touch: Bools
    change: LawChange


@dataclass(frozen=True, eq=False)
class LinearisationPoint:
    """What was solved, and the certified numbers. forces (n, 3) [N] and torsion (n,) [N·m] in contact axes, twist (6,)
    of the object about the grasp's reference, extra : as in `GraspSolution`. force_tolerance [N] and motion_tolerance
    [m] count as nothing.
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
    def law_forces(self) -> Array:
        """(c,) forces in the coordinates of the friction laws, moments of soft contacts last [N]."""
        moments = np.zeros(self.scene.n) if self.torsion is None else self.torsion
        return self.scene.forces_to_law_axes(np.append(self.forces, moments[list(self.scene.soft)]))

    @lazy_property
    def scale(self) -> Array:
        """(c,) S, which turns the laws' forces into those in contact axes."""
        return np.ones(self.scene.components) if self.scene.scale is None else self.scene.scale

    @property
    def law_sizes(self) -> tuple[int, ...]:
        """The numbers of rows of the parts of a `LawChange`."""
        nv = self.jacobian_rows.shape[1]
        return self.scene.components, 6, self.scene.n, nv, nv

    # ---- joints
    @property
    def mechanism(self) -> Mechanism:
        """What moves the fingers; asked where there is a hand."""
        assert self.spec.mechanism is not None
        return self.spec.mechanism

    @lazy_property
    def jacobian_rows(self) -> Array:
        """How fast the joints move the contact points, and turn the soft ones about their normals: [J; T] (c, nv)."""
        mechanism = self.spec.mechanism
        return np.zeros((self.scene.components, 0)) if mechanism is None else mechanism.jacobian_rows(self.scene.soft)

    @lazy_property
    def joints(self) -> JointReading:
        """Torques [N·m] and deflections [rad] of the joints."""
        return evaluate_joints(self.mechanism, self.scene, self.spec.effects, self.forces, self.torsion, self.extra)

    @lazy_property
    def command(self) -> Array:
        """(nv,) how far the joints are commanded beyond the posture."""
        return commanded_offset(self.spec.effects, self.jacobian_rows.shape[1])

    @property
    def elastic_joints(self) -> bool:
        """Whether E follows the springs of the joints, because no other one was given."""
        return bool(self.mechanism.variation.has_joint_flexibility(self.spec))

    @lazy_property
    def loaded_joints(self) -> LoadedJoints | None:
        """What the forces do to the joints, where that is asked for (`GeometricStiffness`)."""
        return next((e.bent for e in self.spec.effects if isinstance(e, GeometricStiffness)), None)

    @lazy_property
    def compliance(self) -> Array:
        """(nv, nv) K⁻¹, or (K + K_g)⁻¹ [rad/(N·m)]."""
        C = self.mechanism.compliance_factor @ self.mechanism.compliance_factor.T
        return C if self.loaded_joints is None else C + self.loaded_joints.added_compliance

    @lazy_property
    def geometric_stiffness_rows(self) -> Array:
        """(c, nv) ∂(K_g z)/∂r, z = δq - δ: torque on the joints, held where the answer has them, by the geometric
        stiffness of one unit of each force component.
        """
        return np.asarray(self.mechanism.hessian() @ (self.command - self.joints.deflection))

    @lazy_property
    def tangent(self) -> Array:
        """(c, c) ∂v/∂r in the laws' coordinates: E, and with `GeometricStiffness` what turning levers add."""
        if self.loaded_joints is None:
            return self.scene.flexibility
        more = self.jacobian_rows @ self.compliance @ self.geometric_stiffness_rows.T
        return np.asarray(self.scene.flexibility + self.scale[:, None] * more * self.scale)

    @lazy_property
    def torque_rows(self) -> Array:
        """(c, nv) ∂τ/∂r of the forces in contact axes."""
        if self.loaded_joints is None:
            return self.jacobian_rows
        K_g = self.loaded_joints.stiffness
        rows = self.jacobian_rows + self.geometric_stiffness_rows
        return np.asarray(rows @ (np.eye(len(K_g)) - K_g @ self.compliance).T)

    # ---- contacts and limits
    def tangential_components(self, i: int) -> list[int]:
        """Of the friction force of a contact, the moment of a soft one last."""
        return [int(j) for j in self.scene.kind.contact_components[i, 1:] if j >= 0]

    @lazy_property
    def friction(self) -> FrictionLimits:
        """The friction sets of the contacts."""
        return friction_limits(self.scene, self.section)

    @lazy_property
    def v(self) -> Array:
        """(c,) motions of the object relative to the tips in the laws' coordinates [m], as the certifier has them."""
        return _motions(self, self.scene, self.spec.effects, self._grasp_matrix)

    @lazy_property
    def states(self) -> ContactStates:
        """The states of the contacts."""
        contacts, weak, slow = self.scene.kind.contact_components, self.force_tolerance, self.motion_tolerance
        return find_states(contacts, self.friction, self.law_forces, self.v, weak, slow)

    @lazy_property
    def reached_limits(self) -> ReachedLimits:
        """The limits that are reached; two that meet are one equation."""
        scene, nv, effects = self.scene, self.jacobian_rows.shape[1], self.spec.effects
        candidate = SolverCandidate(self.law_forces, self.twist, self.extra, len(scene.soft))
        found = limits_at_answer(scene, effects, candidate)
        gives, resting = found.motion > ACTIVE_TOLERANCE, found.resting.copy()
        for k in np.flatnonzero(resting):
            for j in np.flatnonzero(found.resting | gives):
                if j != k and resting[k] and (found.rows[j] == -found.rows[k]).all():
                    resting[[j, k]], gives[k] = False, not gives[j]
        at = np.concatenate([np.flatnonzero(gives), np.flatnonzero(resting)])
        names: list[str] = []
        sizes, joints = [np.zeros(0)], np.zeros((len(found.rows), nv))
        for e in effects:
            for limit in e.present(scene):
                own, size = len(names) + np.arange(len(limit.room)), len(limit.room)
                if isinstance(e, TorqueSaturation):
                    joints[own, e.limited(scene)[2]] = 1.0 if limit.name == "s⁺" else -1.0
                names += [limit.name] * size
                sizes.append(np.ones(size) if limit.levers is None else limit.levers)
        units = scene.units.force_unit * np.concatenate(sizes)
        return ReachedLimits(tuple([names[k] for k in at]), gives[at], found.rows[at], units[at], joints[at])

    # ---- the laws, linear while contacts keep their states
    @lazy_property
    def _grasp_matrix(self) -> Array:
        """(6, c) about the reference."""
        scene = self.scene
        return wrench_map(scene.positions, self.spec.reference, scene.frames, scene.arrays.spin)

    @lazy_property
    def _balance_row_units(self) -> Array:
        """(dof,) natural unit of each component of balance over that of force: 1 of forces, a length [m] of moments."""
        return np.asarray(self.scene.units.motion_unit / self.scene.twist_units)

    @lazy_property
    def laws(self) -> LinearLaws:
        """The laws about the reference."""
        scene, reached, units = self.scene, self.reached_limits, self.scene.units
        stiffness_unit = units.force_unit / units.motion_unit
        G = scene.freedom @ self._grasp_matrix / self._balance_row_units[:, None]
        kept = np.concatenate([np.zeros(scene.components, bool), np.ones(scene.dof, bool), reached.gives])
        K = saddle_matrix(self.tangent, stiffness_unit, G, reached.rows)
        return LinearLaws(K, kept, scene.kind.contact_components, self.friction.coefficients, stiffness_unit)

    @lazy_property
    def response_matrix(self) -> tuple[Array, bool]:
        """(k, k + n) the changes in natural units that unit right-hand sides cause, A⁻¹B of `active_rows`; and whether
        they are unique.
        """
        return solve_inverse(*active_rows(self.laws, self.states), RANK_TOLERANCE)

    def equations(self, states: ContactStates, gives: Bools) -> tuple[Array, Array]:
        """(A, B) of `active_rows` with these states; gives (m,) : which of the limits that are reached give way."""
        kept = np.append(self.laws.kept[: len(self.laws.kept) - len(gives)], gives)
        return active_rows(self.laws._replace(kept=kept), states)

    def right_hand_sides(self, change: LawChange) -> Array:
        """(k + n, p) in natural units, as `active_rows` orders them."""
        reached, force, n = self.reached_limits, self.scene.units.force_unit, self.scene.n
        # δA r - δb_s: limits of forces depend on no parameter
        used = reached.joints @ change.torque - abs(reached.joints) @ change.torque_limits
        balance = self.scene.freedom @ change.balance / (force * self._balance_row_units)[:, None]
        slides = change.friction * (self.law_forces[2 : 3 * n : 3] / force)[:, None]
        motion = change.contact_motion / self.scene.units.motion_unit
        return np.concatenate([motion, balance, used / reached.sizes[:, None], slides])

    def object_twist(self, x: Array) -> Array:
        """(6, p) of the object about the reference, SI, from x (k, p) in natural units."""
        s = self.scene
        return np.asarray(s.freedom.T @ (x[s.components : s.components + s.dof] * s.twist_units[:, None]))

    def contact_motion_changes(self, x: Array) -> Array:
        """(c, p) changes of v by x (k, p), SI, in the laws' coordinates, beside those of `LawChange.contact_motion`."""
        return np.asarray(self.laws.K[: self.scene.components] @ x * self.scene.units.motion_unit)

    # ---- what parameters change in them
    def law_change(self, p: int, **parts: Array) -> LawChange:
        """Of p parameters that change these parts alone; in a planar scene nothing moves across the plane."""
        change = LawChange(self, np.zeros((sum(self.law_sizes), p)))
        for name, part in parts.items():
            getattr(change, name)[:] = part
        if self.spec.planar:
            change.contact_motion[1 : 3 * self.scene.n : 3] = 0.0
        return change

    @lazy_property
    def tip_depths(self) -> TipDepths:
        """Of the fingertips, where contacts were detected on an object."""
        spec, mechanism = self.spec, self.spec.mechanism
        found = None if mechanism is None else mechanism.variation.inside_depths(spec)
        if mechanism is None or found is None:
            return TipDepths(None, np.zeros(0, np.int64), np.zeros(0, bool), self.law_change(0))
        inside, touch = found
        some, remake = np.flatnonzero(touch | (inside > 0.0)), mechanism.variation.vary_parameter

        def go_deeper(j: int, h: float) -> GraspSpec:
            more = inside.copy()
            more[some[j]] += h
            made: GraspSpec = remake(spec, "posture", 0, 0.0, more)
            return made

        change = difference_laws(self, len(some), _DEPTH_STEP, go_deeper)
        sideways = abs(change.contact_motion).max(axis=0, initial=0.0) > _SIDEWAYS_TOLERANCE
        contacts = some[sideways]
        return TipDepths(inside, contacts, touch[contacts], LawChange(self, change.values[:, sideways]))


# ----------------------------------------------------------------
# What any change of a grasp changes in the laws of an answer: central differences of its laws, not of its answer.
#
#     δv ≈ [v(p + h) - v(p - h)] / 2h,    forces, motion and contact states staying as they are
#
# What is differenced is smooth and costs no solve; with steps as the parameters have them, the error is about 1e-9 of
# the largest change.


def difference_laws(
    answer: LinearisationPoint, count: int, h: float, made: Callable[[int, float], GraspSpec]
) -> LawChange:
    """Of the laws of grasps made(k, ±h)."""
    change = answer.law_change(count)
    for k in range(count):
        try:
            change.values[:, k] = (_law_values(answer, made(k, h)) - _law_values(answer, made(k, -h))) / (2.0 * h)
        except InputError:  # no such grasp, as where a link leaves the plane of a planar one
            change.contact_motion[:, k] = np.nan
    return change


def _law_values(answer: LinearisationPoint, spec: GraspSpec) -> Array:
    """What the answer's forces and motion make of the parts of a `LawChange` in another grasp, torque limits left out:
    motions in the laws' coordinates, the wrench that is left over about the answer's reference, coefficients, torques.
    """
    effects = []
    for e in spec.effects:
        made = e.under(spec, answer.forces, spec.effects) if e.depends_on_forces else e
        if isinstance(made, str):
            raise Unsupported(made)
        effects.append(made)
    scene = build_scene(spec.replace(effects=tuple(effects)))
    G = wrench_map(scene.positions, answer.spec.reference, scene.frames, scene.arrays.spin)
    b = G @ answer.law_forces
    b[:3] += scene.force
    b[3:] += scene.moment - np.cross(answer.spec.reference, scene.force)
    mu, torque = scene.friction_coefficients(answer.section), np.zeros(0)
    if spec.mechanism is not None:
        others = tuple([e for e in effects if not isinstance(e, TorqueSaturation)])
        torque = evaluate_joints(spec.mechanism, scene, others, answer.forces, answer.torsion, answer.extra).torque
    v = _motions(answer, scene, tuple(effects), G)
    if spec.planar:
        v[1 : 3 * scene.n : 3] = 0.0
    return np.concatenate([v, b, mu, torque, np.zeros(len(torque))])


def _motions(answer: LinearisationPoint, scene: Scene, effects: tuple[Effect, ...], G: Array) -> Array:
    """(c,) v = Gᵀ u + E r + d of the answer's forces and motion in a scene, with what yielding limits open."""
    v = G.T @ answer.twist + scene.flexibility @ answer.law_forces + scene.offset
    for e in effects:
        if (more := e.opening(scene, answer.extra)) is not None:
            v = v + more
    return np.asarray(v)
