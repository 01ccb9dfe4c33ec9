"""`certify_candidate`: every law of a scene recomputed from positions, frames and flexibility, without the solver.

Arrays over the c force components are in the coordinates of the friction laws, where every law is a ball, a polygon or
a polyhedron about the origin of its tangents. `contacts` (n, 4) lists each contact's normal component and its tangents,
padded by -1; a contact whose force is prescribed has none.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.contact.friction import Section
from handlcp.grasp.assembly.problem import SolverCandidate, polyhedron_normals
from handlcp.grasp.effects import Effect
from handlcp.grasp.model.effect import Limit
from handlcp.grasp.model.flexibility import FlexibilityFactor
from handlcp.grasp.model.scene import GraspArrays, GraspGeometry, Scene, matrix_diagonal
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.kernels.projection import project_on_set
from handlcp.tolerances import ACTIVE_TOLERANCE, CERTIFY_TOLERANCE, MAX_RESIDUAL_GROWTH

_ROUNDING_SHARE = 1e-6  # of the largest term: the certifier allows 1e-8 of it, a hundred roundings of the sum
_RIGID_MOTION_SHARE = 1e-3  # of the natural unit of motion: the certifier allows 1e-11 of that unit, as the solvers do


class FrictionLimits(NamedTuple):
    """coefficients (n,) of friction: radius of each contact's friction set, or distance of its faces, per newton of
    normal force; faces and normals (f, 3) as in `ContactProblem`.
    """

    coefficients: Array
    faces: int
    normals: Array


class LawResiduals(NamedTuple):
    """By how much a candidate misses each law: force [N] and moment [N·m] that balance lacks, and relative to
    force_size [N] and each contact's own motion: balance, normal, cone, slip. motion_size [m]: of the largest motion.
    """

    lost_force: float
    lost_moment: float
    balance: float
    normal: float
    cone: float
    slip: float
    force_size: float
    motion_size: float


@kernel
def laws_pass(m: LawResiduals) -> bool:
    """Whether a candidate keeps the laws of balance, contact and friction to what the certifier accepts: as
    `Residuals.passes`, without effects that have laws of their own. NaN never passes.
    """
    # Each by itself: the largest of numbers and NaN may be a number
    kept = m.balance <= CERTIFY_TOLERANCE and m.normal <= CERTIFY_TOLERANCE
    return kept and m.cone <= CERTIFY_TOLERANCE and m.slip <= CERTIFY_TOLERANCE


@kernel
def compute_motions_and_residuals(
    g: GraspArrays,
    p: GraspGeometry,
    contacts: Ints,
    f: FrictionLimits,
    offset: Array,
    forces: Array,
    twist: Array,
    growth: float,
) -> tuple[Array, LawResiduals]:
    """The motions v = Gᵀ u + E r + d (c,) of the object minus the fingertips, and the residuals of every law.

    offset (c,) : d, with what effects open.
    forces (c,), twist (6,) : r and u.
    growth : see `_residual_scales`. NaN throughout where a force or the twist is not finite.
    """
    total = 0.0
    for x in forces:
        total += 0.0 * x  # NaN where any of them is not finite
    for x in twist:
        total += 0.0 * x
    if total != 0.0:
        nan = np.nan
        return np.full(len(forces), nan), LawResiduals(nan, nan, nan, nan, nan, nan, nan, nan)
    moved = _contact_motions(p.grasp_matrix, g.flexibility, offset, forces, twist)
    return moved.v, compute_residuals(g, p, contacts, f, offset, forces, moved, growth)


class ContactMotions(NamedTuple):
    """Motions v (c,), the largest of what adds up to each, Gᵀ u, E r and d, and the largest single term; and the
    diagonal of E.
    """

    v: Array
    own: Array
    terms: Array
    softness: Array


@kernel
def compute_residuals(
    g: GraspArrays,
    p: GraspGeometry,
    contacts: Ints,
    f: FrictionLimits,
    offset: Array,
    forces: Array,
    moved: ContactMotions,
    growth: float,
) -> LawResiduals:
    """The misses of forces (c,) and the motions that go with them, whatever is the flexibility in g."""
    G, lost, v = p.grasp_matrix, p.wrench.copy(), moved.v
    for k in range(6):
        for j in range(len(forces)):
            lost[k] += G[k, j] * forces[j]
    lost_force = np.sqrt(lost[0] ** 2 + lost[1] ** 2 + lost[2] ** 2)
    lost_moment = np.sqrt(lost[3] ** 2 + lost[4] ** 2 + lost[5] ** 2)
    unit = _component_units(g, p.length_unit)
    F, V = _residual_scales(p, unit, contacts, offset, forces, moved, growth)
    normal, cone, slip = _worst_residuals(contacts, f, unit, forces, v, F, V)
    balance = np.sqrt(lost_force**2 + (lost_moment / p.length_unit) ** 2) / F
    return LawResiduals(lost_force, lost_moment, balance, normal, cone, slip, F, np.max(V))


@kernel
def _contact_motions(G: Array, E: Array, offset: Array, forces: Array, twist: Array) -> ContactMotions:
    """The motions of the components (c,), with what they are summed of."""
    c = len(forces)
    v, own, terms = np.empty(c), np.empty(c), np.empty(c)
    for i in range(c):
        move, retreat, largest = 0.0, 0.0, abs(offset[i])
        for k in range(6):
            term = G[k, i] * twist[k]
            move += term
            largest = max(largest, abs(term))
        for j in range(c):
            term = E[i, j] * forces[j]
            retreat += term
            largest = max(largest, abs(term))
        v[i] = move + retreat + offset[i]
        own[i] = max(abs(move), abs(retreat), abs(offset[i]))
        terms[i] = largest
    return ContactMotions(v, own, terms, matrix_diagonal(E))


@kernel
def contact_motions_of_factor(
    G: Array, E: FlexibilityFactor, offset: Array, forces: Array, twist: Array
) -> ContactMotions:
    """The same of E = J A (J A)ᵀ + P, which is not formed."""
    J, root, P = E.rows, E.root, E.pads
    c, nv, m = len(forces), root.shape[0], root.shape[1]
    torque, strain, bent = np.zeros(nv), np.zeros(m), np.zeros(nv)
    for i in range(c):
        if forces[i] != 0.0:
            for j in range(nv):
                torque[j] += J[i, j] * forces[i]
    for j in range(nv):
        for a in range(m):
            strain[a] += root[j, a] * torque[j]
    for j in range(nv):
        for a in range(m):
            bent[j] += root[j, a] * strain[a]
    v, own, terms, softness, line = np.empty(c), np.empty(c), np.empty(c), np.empty(c), np.empty(m)
    for i in range(c):
        move, retreat, largest = 0.0, 0.0, abs(offset[i])
        line[:] = 0.0
        for k in range(6):
            term = G[k, i] * twist[k]
            move += term
            largest = max(largest, abs(term))
        for j in range(nv):
            x = J[i, j]
            if x != 0.0:  # a finger's joints move no other finger
                term = x * bent[j]
                retreat += term
                largest = max(largest, abs(term))
                for a in range(m):
                    line[a] += x * root[j, a]
        for b in range(3):
            term = P[i // 3, i % 3, b] * forces[i - i % 3 + b]
            retreat += term
            largest = max(largest, abs(term))
        softness[i] = P[i // 3, i % 3, i % 3]
        for a in range(m):
            softness[i] += line[a] * line[a]
        v[i] = move + retreat + offset[i]
        own[i] = max(abs(move), abs(retreat), abs(offset[i]))
        terms[i] = largest
    return ContactMotions(v, own, terms, softness)


@kernel
def _component_units(g: GraspArrays, length: float) -> Array:
    """(c,) what one unit of each component is in contact axes: newtons, or newtons at the grasp's size for a moment."""
    n, k = len(g.positions), g.spin.shape[1]
    unit = np.empty(3 * n + k)
    for i in range(n):
        for a in range(3):
            unit[3 * i + a] = np.sqrt(g.frames[i, 0, a] ** 2 + g.frames[i, 1, a] ** 2 + g.frames[i, 2, a] ** 2)
    for j in range(k):
        unit[3 * n + j] = np.sqrt(g.spin[0, j] ** 2 + g.spin[1, j] ** 2 + g.spin[2, j] ** 2) / length
    return unit


@kernel
def _residual_scales(
    p: GraspGeometry, unit: Array, contacts: Ints, offset: Array, forces: Array, moved: ContactMotions, growth: float
) -> tuple[float, Array]:
    """The force F [N] and each contact's motion V (n,) [m] that residuals are measured by.

    A component counts as what it is in contact axes where the law's coordinates make it larger: a large lever excuses
    no overlap, a small one no imbalance.
    F is the largest force of the candidate, at least the load's size (the natural unit where there is no load) and at
    most `growth` times that. V is the largest of what adds up to the contact's motion, at least its retreat under F.
    A rigid contact that sticks has neither: it is measured by the retreat of the stiffest of the others, as a motion of
    it changes their forces.
    """
    load, wrench, own, terms, E = 0.0, p.wrench, moved.own, moved.terms, moved.softness
    for k in range(6):
        load += (wrench[k] / (p.length_unit if k >= 3 else 1.0)) ** 2
    load = np.sqrt(load)
    if load == 0.0:
        load = p.force_unit
    F = load
    for j in range(len(forces)):
        F = max(F, abs(forces[j]) * min(1.0, unit[j]))
    F = min(F, growth * load)
    V, rigid = np.empty(len(contacts)), np.inf
    for i in range(len(contacts)):
        softness = 0.0
        for a in range(3):  # a pad that turns easily excuses no overlap
            softness += E[3 * i + a] / 3
        V[i] = softness * F
        if V[i] > 0.0:
            rigid = min(rigid, V[i])
    if rigid == np.inf:  # forces depend on no motion
        rigid = _RIGID_MOTION_SHARE * p.motion_unit
    for i in range(len(contacts)):
        largest, shift, rounded = 0.0, 0.0, 0.0
        count = 4 if contacts[i, 3] >= 0 else 3
        for a in range(count):
            j = 3 * i + a if a < 3 else contacts[i, 3]
            w = max(1.0, unit[j])
            largest, shift = max(largest, own[j] / w), max(shift, abs(offset[j]) / w)
            rounded = max(rounded, terms[j] / w)
        # A long slide excuses no overlap: beyond `growth` times what the finger itself can give way, no more allowance
        give, least = max(V[i], shift), V[i] if V[i] > 0.0 else rigid
        V[i] = max(min(largest, growth * give) if give > 0.0 else largest, least, _ROUNDING_SHARE * rounded)
    return F, V


@kernel
def _worst_residuals(
    contacts: Ints, f: FrictionLimits, unit: Array, forces: Array, v: Array, F: float, V: Array
) -> tuple[float, float, float]:
    """Worst (normal, cone, slip) residual, each relative to F [N] and V (n,) [m].

    normal: |min(r_N / F, v_N / V)|. cone: excess of r_T over the set of radius μ r_N, and any force along what is
    no tangent, / F. slip: distance of r_T / F from the projection of r_T / F - v_T / V on that set; zero exactly when
    the contact sticks, or slides against a force on the limit (maximum dissipation). Where the law's coordinates make a
    motion smaller than it is, what friction has to spare must hold it, too: up to a force of F in contact axes.
    """
    normal, cone, slip, mu, normals = 0.0, 0.0, 0.0, f.coefficients, f.normals
    r, s, P, D = np.zeros(3), np.zeros(3), np.empty(3), np.empty((3, 4))
    for i in range(len(contacts)):
        if contacts[i, 0] < 0:
            continue
        push = forces[3 * i + 2] / F
        normal = max(normal, abs(min(push, v[3 * i + 2] / V[i])))
        tangents, outside = 0, 0.0
        r[:], s[:] = 0.0, 0.0
        while tangents < 3 and contacts[i, tangents + 1] >= 0:
            j = contacts[i, tangents + 1]
            r[tangents] = forces[j] / F
            s[tangents] = r[tangents] - v[j] / V[i]
            tangents += 1
        for a in range(min(tangents, 2), 2):
            outside += (forces[3 * i + a] / F) ** 2
        if tangents == 0:
            cone = max(cone, np.sqrt(outside))
            continue
        a = mu[i] * max(push, 0.0)
        project_on_set(r, tangents, a, 0.0, f.faces, normals, P, D)
        for k in range(tangents):
            outside += (r[k] - P[k]) ** 2
        cone = max(cone, np.sqrt(outside))
        project_on_set(s, tangents, a, 0.0, f.faces, normals, P, D)
        missed, used = 0.0, 0.0
        for k in range(tangents):
            missed += (r[k] - P[k]) ** 2
            used += r[k] ** 2
        slip, spare = max(slip, np.sqrt(missed)), a - np.sqrt(used)
        for k in range(tangents):
            j = contacts[i, k + 1]
            if unit[j] < 1.0 and spare > 0.0:
                idle = min(spare * unit[j], 1.0)
                slip = max(slip, idle * min(abs(v[j]) / (V[i] * unit[j]), 1.0))
    return normal, cone, slip


@kernel
def forces_in_world(frames: Array, forces: Array) -> Array:
    """(n, 3) world axes from force components (≥ 3n,) and the frames (n, 3, 3) that they are measured in."""
    out = np.zeros((len(frames), 3))
    for i in range(len(frames)):
        for k in range(3):
            for a in range(3):
                out[i, k] += frames[i, k, a] * forces[3 * i + a]
    return out


# ----------------------------------------------------------------
# The limits of a scene's effects, together, and which of them give way at an answer.

_MAX_RESTING_LIMITS = 4  # limits just reached whose 2^k choices are all looked at; beyond that all or none give way


def effect_limits(scene: Scene, effects: tuple[Effect, ...]) -> tuple[Limit, ...]:
    """What the effects limit, empty groups left out, in the effects' order."""
    return tuple([limit for e in effects for limit in e.present(scene)])


def stack_limits(scene: Scene, every: tuple[Limit, ...]) -> tuple[Array, Array]:
    """(m, c) rows A and (m,) room b of all limits A r ≤ b, natural units."""
    rows = [np.zeros((0, scene.components)), *(limit.natural_rows for limit in every)]
    return np.concatenate(rows), np.concatenate([np.zeros(0), *(limit.natural_room(scene) for limit in every)])


@dataclass(frozen=True, slots=True, eq=False)
class LimitsAtAnswer:
    """The m limits of a scene at an answer, natural units.

    rows (m, c), motion (m,) s and slack (m,) b - A r. resting (m,): just reached, and not giving way yet.
    every : what they are made of. extra : the answer's unknowns of effects, SI.
    """

    rows: Array
    motion: Array
    slack: Array
    resting: Bools
    every: tuple[Limit, ...]
    extra: dict[str, Array]

    def choices(self) -> list[Bools]:
        """Which limits give way: those that do, with those at rest in every way."""
        if not len(self.rows):
            return [self.resting]
        at = np.flatnonzero(self.resting)
        few = len(at) <= _MAX_RESTING_LIMITS
        ways = list(itertools.product((False, True), repeat=len(at))) if few else [(False,), (True,)]
        out = np.tile(self.motion > ACTIVE_TOLERANCE, (len(ways), 1))
        out[:, at] = ways
        return list(out)

    def conditions(self, basis: Array, active: Bools, multipliers: Array) -> tuple[Array, Array]:
        """The rows D and values `now`, in the limits' order, of now + D c ≥ 0 along a branch's basis.

        They keep every limit, and every motion ≥ 0.
        """
        D = -self.rows @ basis[: self.rows.shape[1]]
        D[active] = multipliers
        return D, np.where(active, self.motion, self.slack)

    def move_extra(self, scene: Scene, active: Bools, change: Array) -> dict[str, Array]:
        """The answer's `extra` after a change (active.sum(),) of what gives way, natural units."""
        s = self.motion.copy()
        s[active] = np.maximum(s[active] + change, 0.0)
        moved, at = dict(self.extra), 0
        for limit in self.every:
            moved[limit.name] = s[at : at + len(limit.room)] * limit.unknown.sizes(scene)[0]
            at += len(limit.room)
        return moved


def limits_at_answer(scene: Scene, effects: tuple[Effect, ...], candidate: SolverCandidate) -> LimitsAtAnswer:
    """The limits where this candidate stands."""
    if not (
        every := effect_limits(scene, effects)
    ):  # nearly all scenes: a tenth of what follows where motions are free
        return LimitsAtAnswer(
            np.zeros((0, scene.components)), _NO_MOTION, _NO_MOTION, _NO_MOTION > 0.0, (), candidate.extra
        )
    rows, room = stack_limits(scene, every)
    motion = np.concatenate([np.zeros(0), *(limit.natural_motion(scene, candidate.extra) for limit in every)])
    slack = room - rows @ (candidate.components / scene.units.force_unit)
    resting = (motion <= ACTIVE_TOLERANCE) & (slack <= ACTIVE_TOLERANCE * np.maximum(abs(room), 1.0))
    return LimitsAtAnswer(rows, motion, slack, resting, every, candidate.extra)


_NO_MOTION = np.zeros(0)


# ----------------------------------------------------------------
# The grasp's certifier: every law of the scene recomputed from its physics. Imports no solver; NaN never passes.


@dataclass(frozen=True, slots=True)
class Residuals:
    """How far an answer misses each law. Relative ones are fractions of `force_scale` or of each contact's own motion.

    balance : |Σ forces + wrench|, moments over the grasp's size. balance_force [N], balance_moment [N·m]: the same, SI.
    normal : worst |min(r_N, gap)|. cone : worst excess over the friction limit. slip : worst miss of "sticks, or slides
    against a force on the limit". effects : worst of the further effects' own laws.
    force_scale [N], motion_scale [m] : what 1 means (each contact's motion is measured by its own, at most this).
    """

    balance: float
    normal: float
    cone: float
    slip: float
    effects: float
    balance_force: float
    balance_moment: float
    force_scale: float
    motion_scale: float

    @staticmethod
    def from_law_residuals(m: LawResiduals, effects: float) -> Residuals:
        """From what `compute_motions_and_residuals` found, and the worst of the effects' own laws."""
        return Residuals(
            m.balance, m.normal, m.cone, m.slip, effects, m.lost_force, m.lost_moment, m.force_size, m.motion_size
        )

    @property
    def worst(self) -> float:
        """The largest relative residual; infinite where anything is not a number."""
        values = (self.balance, self.normal, self.cone, self.slip, self.effects)
        return max(values) if sum(values) == sum(values) else np.inf  # a sum is NaN wherever a term is

    @property
    def si(self) -> dict[str, float]:
        """The same in SI, unit by name; what is relative to a contact's own motion is bounded by the largest."""
        return {
            "balance_force_N": self.balance_force,
            "balance_moment_Nm": self.balance_moment,
            "normal_m": self.normal * self.motion_scale,
            "cone_N": self.cone * self.force_scale,
            "slip_m": self.slip * self.motion_scale,
        }

    @property
    def passes(self) -> bool:
        """Whether the worst residual is at most CERTIFY_TOLERANCE (1e-8): what makes `status` SOLVED.

        The compiled first stage asks `laws_pass`.
        """
        return self.worst <= CERTIFY_TOLERANCE


class Certification(NamedTuple):
    """What was recomputed, in the laws' coordinates: motion (c,) object minus fingertip [m], and the residuals."""

    motion: Array
    residuals: Residuals


def certify_candidate(
    scene: Scene, effects: tuple[Effect, ...], section: Section, candidate: SolverCandidate
) -> Certification:
    """Recompute balance, contact, friction and elastic compatibility of a candidate."""
    offset = scene.offset
    for e in effects:
        if (opening := e.opening(scene, candidate.extra)) is not None:
            offset = offset + opening
    v, misses = compute_motions_and_residuals(
        scene.arrays,
        scene.geometry,
        scene.kind.contact_components,
        friction_limits(scene, section),
        offset,
        candidate.components,
        candidate.twist,
        MAX_RESIDUAL_GROWTH,
    )
    F = misses.force_size
    others = F  # NaN where a force or the twist is not finite: no law is worth asking then
    if F == F:
        own = [e.residual(scene, candidate.components, candidate.extra, F, misses.motion_size) for e in effects]
        others = max(own, default=0.0) if sum(own) == sum(own) else np.inf  # max passes over NaN, a sum does not
    return Certification(v, Residuals.from_law_residuals(misses, others))


def friction_limits(scene: Scene, section: Section) -> FrictionLimits:
    """The friction sets of all contacts."""
    return FrictionLimits(scene.friction_coefficients(section), section.faces, polyhedron_normals(scene, section))
