"""`Mechanism`: the joints behind the contacts, with Jacobian, compliance, limits, joint torques; tendons (`Cables`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.lcp.kernels.dense import add_transposed, bounded_least_squares, kernel, solve_least_squares

_EPS = float(np.finfo(float).eps)
_TORQUE_WEIGHT = 1e6  # that tensions make the torques weighs so many times as much as that they are small
_TORQUE_SHARE = 1e-6  # of the torques: tensions that miss them by less make them

NO_WRAP_SIDES = read_only(np.zeros((0, 3)))


class Cables(NamedTuple):
    """t tendons that move nv joints: they pull, and never push. Over m posts, and past b round bodies.

    names : (t,).
    arms (t, nv) : R, 0 of a joint that gives way to nothing [m/rad, m/m].
    springs (t, t) : k [N/m].
    passive (nv, nv) : K_p of the joints' own springs [N·m/rad].
    rest (nv,) : where these are at rest, from the grasp's posture [rad, m].
    pretension (t,) : T₀ in the grasp's posture before the hand closes [N]; inf where it is taut whatever comes, as a
        rod is.
    limits (t,) : what tendons bear, or their motors hold for good where that is less [N]; inf where nothing is known.
    post_tendon (m,) : number of the tendon that wraps around a post; those of a tendon in the order from its drive on.
    wrap_friction (m,) : μθ, friction times the angle of the wrap [rad].
    arms_beyond (m, nv) : arms of the tendon at this post and beyond.
    shift (t,) : of tendons whose arms change with the posture, l - R q in this one, with l what joints have drawn in
        [m]; 0 of others.
    elasticity_at : from joints at q (nv,) to the tendons there and the root of the joints' compliance with them, as in
        `Elasticity`; None: arms stay.
    arm_rates : gives ∂R/∂q (t, nv, nv) in this posture [m/rad²], by which tendons pull harder as joints move; None: 0.
    wrapped_bodies (b,) : round bodies that they pass, in words.
    wrap_sides (b, 3) : on which side of each, a unit vector in the axes of its link.
    """

    names: tuple[str, ...]
    arms: Array
    springs: Array
    passive: Array
    rest: Array
    pretension: Array
    limits: Array
    post_tendon: Ints
    wrap_friction: Array
    arms_beyond: Array
    shift: Array
    elasticity_at: Callable[[Array], tuple[Cables, Array]] | None = None
    arm_rates: Callable[[], Array] | None = None
    wrapped_bodies: tuple[str, ...] = ()
    wrap_sides: Array = NO_WRAP_SIDES

    @classmethod
    def without_tendons(cls, nv: int) -> Cables:
        """The cables of joints that no tendon moves: none."""
        none, row = np.zeros(0), np.zeros((0, nv))
        own, rest = np.zeros((nv, nv)), np.zeros(nv)
        return cls((), row, np.zeros((0, 0)), own, rest, none, none, np.zeros(0, dtype=np.int64), none, row, none)

    @property
    def is_elastic(self) -> bool:
        """Whether they act as springs whatever comes, and bear all of it."""
        return bool(np.isinf(self.pretension).all() and np.isinf(self.limits).all()) and not len(self.arms_beyond)

    def tensions(self, torque: Array) -> Array:
        """(t,) t [N] that make torques Rᵀ (t - T₀) (nv,) [N·m] with the least pull beyond T₀: none is let go below T₀
        where the others can do without, and none below 0. Of tendons without a known T₀, how much harder they pull.
        """
        return least_tensions(self.arms, self.initial_tension, np.isfinite(self.pretension), torque)

    def crossed_body(self, a: Array, b: Array) -> str:
        """The first round body, in words, that a tendon passes on one side with joints at a (nv,) and on the other at b
        (nv,), postures that lie close together; "": none.
        """
        if self.elasticity_at is None or not self.wrapped_bodies:
            return ""
        (before, _), (now, _) = self.elasticity_at(a), self.elasticity_at(b)
        turned = np.flatnonzero((before.wrap_sides * now.wrap_sides).sum(axis=1) < 0.0)
        return self.wrapped_bodies[turned[0]] if len(turned) else ""

    @property
    def initial_tension(self) -> Array:
        """(t,) T₀, the tension in the grasp's posture before the hand closes [N]; 0 where it is not known."""
        return np.where(np.isfinite(self.pretension), self.pretension, 0.0)

    def unmade_torque(self, torque: Array) -> Array:
        """(nv,) the part of torques (nv,) [N·m] that no tensions make."""
        return np.asarray(torque - self.arms.T @ (self.tensions(torque) - self.initial_tension))


@kernel
def least_tensions(arms: Array, initial: Array, known: Bools, torque: Array) -> Array:
    """(t,) t [N] that make torques Rᵀ (t - T₀) (nv,) [N·m] with the least pull beyond T₀, as `Cables.tensions` has it.

    arms (t, nv) : R. initial (t,) : T₀ [N], 0 where it is not known. known (t,) : whether it is.
    """
    t, nv = arms.shape
    if t == 0:
        return np.zeros(0)
    more, lacks, longest = solve_least_squares(arms.T.copy(), torque, _EPS * max(t, nv)), False, 0.0
    for i in range(t):
        lacks = lacks or (known[i] and more[i] < 0.0)
        for j in range(nv):
            longest = max(longest, abs(arms[i, j]))
    rows, asked, least = np.zeros((nv + t, t)), np.zeros(nv + t), np.zeros(t)
    for j in range(nv):
        asked[j] = _TORQUE_WEIGHT / longest * torque[j]
        for i in range(t):
            rows[j, i], rows[nv + i, i] = _TORQUE_WEIGHT / longest * arms[i, j], 1.0
    for attempt in range(2 if lacks else 0):
        if attempt == 1:
            least = -initial
        more = bounded_least_squares(rows, asked, least, known)
        missed, largest, left = 0.0, 0.0, torque.copy()
        add_transposed(arms, more, -1.0, left)
        for j in range(nv):
            missed, largest = max(missed, abs(left[j])), max(largest, abs(torque[j]))
        if missed <= _TORQUE_SHARE * largest:
            break
    for i in range(t):
        more[i] += initial[i]
        if lacks and known[i]:
            more[i] = max(more[i], 0.0)
    return more


# ----------------------------------------------------------------
# What moves the fingers of a grasp, as far as the mechanics need to know it. This room knows no robots.


@kernel
def joint_flexibility(rows: Array, root: Array) -> Array:
    """E = J K⁻¹ Jᵀ = (J A)(J A)ᵀ, symmetric to the last bit; rows (m, nv) of J, and of turns; root (nv, k) A."""
    m, nv, k = len(rows), root.shape[0], root.shape[1]
    B, E = np.zeros((m, k)), np.empty((m, m))
    for i in range(m):
        for j in range(nv):
            x = rows[i, j]
            if x != 0.0:  # a finger's joints move no other finger
                for a in range(k):
                    B[i, a] += x * root[j, a]
        for j in range(i + 1):
            total = 0.0
            for a in range(k):
                total += B[i, a] * B[j, a]
            E[i, j] = E[j, i] = total
    return E


@dataclass(frozen=True, slots=True)
class JointReading:
    """What the joints do at an answer, (nv,) each: torque that the actuators hold [N·m], deflection from where the
    joints are commanded to be [rad], and how far joints at their limit are driven back beyond that [rad].
    """

    torque: Array
    deflection: Array
    yielded: Array


@dataclass(frozen=True, slots=True, eq=False)
class JointModel:
    """What the mechanics knows of nv joints beside their springs.

    position : (nv,) where they stand in the grasp's posture [rad, m]. ranges : (nv,) lower and (nv,) upper ends of
        their ranges [rad, m].
    dry_friction : (nv,) beside their springs [N·m, N].
    cables : the tendons that move them; None: each has its own motor, or tendons are not known as such.
    closing_limits : (nv + t,) with which joints, then tendons, can close [N·m, N]; None where no motor says it.
    """

    position: Array
    ranges: tuple[Array, Array]
    dry_friction: Array
    cables: Cables | None
    closing_limits: Array | None

    @property
    def is_elastic(self) -> bool:
        """Whether joints give way as springs do whatever comes: no dry friction, and tendons that always pull."""
        return not self.dry_friction.any() and (self.cables is None or self.cables.is_elastic)


@dataclass(frozen=True, eq=False)
class Mechanism:
    """nv independent joints that carry the fingers of n contacts; contacts of the environment are carried by none.

    names : (nv,). jacobian : (3n, nv) velocity of the contact points in contact axes [m/rad, m/m].
    compliance_factor : (nv, m) A of the joints' compliance K⁻¹ = A Aᵀ [rad/(N·m)].
    limits : (nv,) torque limits, inf where there is none or none is known [N·m, N].
    solution_class : the class of solutions, a subclass of `GraspSolution` with `torques` (nv,).
    variation : makes the grasp again with something changed (`handlcp.hand.grasp_variation`).
    report : what is said of the hand in verdicts and explanations (`handlcp.hand.report`).
    """

    solution_class: ClassVar[Any]
    variation: ClassVar[Any]
    report: ClassVar[Any]

    names: tuple[str, ...]
    jacobian: Array
    compliance_factor: Array
    limits: Array

    @property
    def joint_model(self) -> JointModel:
        """Posture, ranges, friction and tendons of the joints."""
        raise NotImplementedError

    def jacobian_rows(self, soft: tuple[int, ...]) -> Array:
        """Jacobian (3n + k, nv) [J; T] of the contact points, and of the turns of the k contacts in `soft` about their
        normals [rad/rad].
        """
        raise NotImplementedError

    def hessian(self) -> Array:
        """(3n, nv, nv) ∂J/∂q [m/rad²] of contact points that move with their fingers, in contact axes that don't."""
        raise NotImplementedError

    def contact_compliance(self, rows: Array) -> Array:
        """E = rows K⁻¹ rowsᵀ, symmetric to the last bit; rows (m, nv) of a Jacobian."""
        return joint_flexibility(rows, self.compliance_factor)

    def deflection(self, torque: Array) -> Array:
        """How far joints give way to torques τ (nv,) [N·m]: (nv,) K⁻¹ τ [rad]."""
        return np.asarray(self.compliance_factor @ (torque @ self.compliance_factor))

    def gravity_torque(self) -> Array | None:
        """(nv,) torque that would hold the fingers' own weight [N·m]; None where no gravity was given."""
        raise NotImplementedError

    def parallel_spring_torque(self, q: Array | None = None) -> Array | None:
        """(nv,) with which drives pull against springs beside them, with joints at q (nv,), in the grasp's posture
        without [N·m]; None: there are no such springs.
        """
        raise NotImplementedError

    def weight_of_object(self, point: Array) -> Array:
        """(6,) of the object about a point (3,) [N, N·m], in the load of the grasp; zero where it is not known apart
        from it.
        """
        raise NotImplementedError

    def moving_geometry(self, spec: Any) -> Any:
        """The `Geometry` of this grasp as it moves."""
        raise NotImplementedError

    def solution_fields(
        self, scene: Any, effects: Any, forces: Array, torsion: Array | None, extra: dict[str, Array]
    ) -> dict[str, Any]:
        """What the joints do at an answer, by the fields that `solution_class` has beside those of every solution.

        scene, effects : that were solved. forces (n, 3), torsion (n,) of soft contacts, extra : as in `GraspSolution`.
        """
        raise NotImplementedError


def evaluate_joints(
    mechanism: Mechanism, scene: Any, effects: Any, forces: Array, torsion: Array | None, extra: dict[str, Array]
) -> JointReading:
    """What the joints do at an answer; arguments as in `Mechanism.solution_fields`."""
    torque = forces.reshape(-1) @ mechanism.jacobian
    if torsion is not None:
        torque = torque + torsion[list(scene.soft)] @ mechanism.jacobian_rows(scene.soft)[len(mechanism.jacobian) :]
    total = torque if scene.bias_torque is None else torque + scene.bias_torque
    joints = JointReading(total, mechanism.deflection(torque), np.zeros(len(mechanism.names)))
    for e in effects:
        joints = e.read(scene, forces, extra, joints)
    return joints


def hard_contact_torques(mechanism: Mechanism, scene: Any, forces: Array) -> Array:
    """(nv,) what the actuators hold under forces (n, 3) of hard contacts [N·m], where no effect changes it."""
    torque = forces.reshape(-1) @ mechanism.jacobian
    return read_only(torque if scene.bias_torque is None else torque + scene.bias_torque)
