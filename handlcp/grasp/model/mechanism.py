"""Tendons that move joints, as far as the mechanics need to know them: they pull, and never push."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.lcp.kernels.dense import kernel

_COST_TOLERANCE = 1e-14  # of the cost
_TORQUE_WEIGHT, _TORQUE_SHARE = (
    1e6,
    1e-6,
)  # times as heavy as small tensions: that these make the torques; to this share of them


NO_WRAP_SIDES = read_only(np.zeros((0, 3)))


class Cables(NamedTuple):
    """Tendons that move joints. names (t,). arms (t, nv) : R, 0 of a joint that gives way to nothing [m/rad, m/m].
    springs (t, t) : k [N/m]. passive (nv, nv) : K_p of the joints' own springs [N·m/rad]; rest (nv,) : where these are
    at rest, from the grasp's posture [rad, m]. pretension (t,) : T₀ in the grasp's posture before the hand closes [N];
    inf : taut whatever comes, as a rod is. limits (t,) : what they bear [N], inf where nothing is known.
    Posts that tendons wrap around, m of them, those of a tendon in the order from its drive on: of (m,) : number of the
    tendon. grips (m,) : μθ, friction times the angle of the wrap [rad]. posts (m, nv) : arms of the tendon at this post
    and beyond.
    Of tendons whose arms change with the posture these are those of one: shift (t,) : l - R q there, with l what joints
    have drawn in [m]; 0 of others. way : from joints at q (nv,) to the tendons there and the
    root of the joints' compliance with them, as in `Elasticity`; None: arms stay. turning : from
    tensions T (t,) to Σ T ∂R/∂q (nv, nv) there [N·m/rad], by which the tendons pull harder as joints move; None: 0.
    around (b,) : round bodies that they pass, in words; sides (b, 3) : on which side of each, a unit vector in the axes
    of its link.
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
    posts: Array
    shift: Array
    elasticity_at: Callable[[Array], tuple[Cables, Array]] | None = None
    moment_arm_stiffness: Callable[[Array], Array] | None = None
    wrapped_bodies: tuple[str, ...] = ()
    wrap_sides: Array = NO_WRAP_SIDES

    @classmethod
    def without_tendons(cls, nv: int) -> Cables:
        """Of joints without tendons."""
        none, row = np.zeros(0), np.zeros((0, nv))
        own, rest = np.zeros((nv, nv)), np.zeros(nv)
        return cls((), row, np.zeros((0, 0)), own, rest, none, none, np.zeros(0, dtype=np.int64), none, row, none)

    @property
    def is_elastic(self) -> bool:
        """Whether they act as springs whatever comes, and bear all of it."""
        return bool(np.isinf(self.pretension).all() and np.isinf(self.limits).all()) and not len(self.posts)

    def tensions(self, torque: Array) -> Array:
        """(t,) t [N] that make torques Rᵀ (t - T₀) (nv,) [N·m] with the least pull beyond T₀: none is let go below T₀
        where the others can do without, and none below 0. Of tendons without a known T₀, how much harder they pull.
        """
        begun, more = self.initial_tension, np.asarray(np.linalg.lstsq(self.arms.T, torque)[0])
        known = np.isfinite(self.pretension)
        if (more >= 0.0)[known].all():
            return begun + more
        from scipy.optimize import lsq_linear  # half a second of import that only antagonists should pay

        size = float(abs(self.arms).max())
        rows = np.vstack([_TORQUE_WEIGHT * self.arms.T / size, np.eye(len(known))])
        asked = np.append(_TORQUE_WEIGHT * torque / size, np.zeros(len(known)))
        for least in (np.zeros(len(known)), -begun):
            bounds = np.where(known, least, -np.inf), np.inf
            more = lsq_linear(rows, asked, bounds, "bvls", _COST_TOLERANCE).x
            if abs(self.arms.T @ more - torque).max() <= _TORQUE_SHARE * abs(torque).max():
                break
        return np.where(known, np.maximum(begun + more, 0.0), more)

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
        """(t,) T₀; 0 where it is not known."""
        return np.where(np.isfinite(self.pretension), self.pretension, 0.0)

    def unmade_torque(self, torque: Array) -> Array:
        """(nv,) the part of torques (nv,) [N·m] that no tensions make."""
        return np.asarray(torque - self.arms.T @ (self.tensions(torque) - self.initial_tension))


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


@dataclass(frozen=True, eq=False)
class Mechanism:
    """nv independent joints that carry the fingers of n contacts; contacts of the environment are carried by none.

    names : (nv,). jacobian : (3n, nv) velocity of the contact points in contact axes [m/rad, m/m].
    root : (nv, m) A of the joints' compliance K⁻¹ = A Aᵀ [rad/(N·m)].
    limits : (nv,) torque limits, inf where there is none or none is known [N·m, N].
    solution : the class of solutions, a subclass of `GraspSolution` with `torques` (nv,).
    """

    solution: ClassVar[Any]

    names: tuple[str, ...]
    jacobian: Array
    root: Array
    limits: Array

    def turning_rates(self, contacts: tuple[int, ...]) -> Array:
        """(k, nv) how fast the fingertips of these contacts turn about their normals [rad/rad]."""
        raise NotImplementedError

    def hessian(self) -> Array:
        """(3n, nv, nv) ∂J/∂q [m/rad²] of contact points that move with their fingers, in contact axes that don't."""
        raise NotImplementedError

    def angular_jacobian(self) -> Array:
        """(n, 3, nv) how fast the joints turn the fingers of the contacts, world axes [rad/rad]."""
        raise NotImplementedError

    @property
    def dry_friction(self) -> Array:
        """(nv,) at the joints, beside their springs [N·m, N]."""
        return np.zeros(len(self.names))

    @property
    def cables(self) -> Cables | None:
        """The tendons that move the joints; None: each has its own motor, or tendons are not known as such."""
        return None

    @property
    def is_elastic(self) -> bool:
        """Whether joints give way as springs do whatever comes: no dry friction, and tendons that always pull."""
        return not self.dry_friction.any() and (self.cables is None or self.cables.is_elastic)

    def with_joint_shift(self, q: Array) -> Self:
        """The same with joints that stand farther by q (nv,) [rad, m] than its posture has them."""
        return self

    def has_joint_flexibility(self, spec: Any) -> bool:
        """Whether the flexibility of a grasp is that of these joints and the pads, and follows them."""
        return False

    def vary_parameter(self, spec: Any, what: str, k: int, step: float, inside: Array | None = None) -> Any:
        """The grasp made again, as it was asked for, with the k-th "posture" [rad, m], "lengths" [m] or "stiffness"
        [N·m/rad] larger by a step. Contacts with an object are detected anew; those that were given stay.
        inside : (k,) [m] how far fingertips count as inside the object, in place of what is detected.
        """
        raise NotImplementedError

    def inside_depths(self, spec: Any) -> tuple[Array, Bools] | None:
        """(k,) how far each fingertip counts as inside the object [m], and (k,) which ones just touch it. None where
        contacts were given, so that nothing counts as inside.
        """
        return None

    def gaps(self) -> Array:
        """(k,) of the fingertips, as `inside` has found them [m]."""
        raise NotImplementedError

    @property
    def links(self) -> dict[str, str]:
        """By the names of contacts that are places on links: the link; {} where fingertips alone touch."""
        return {}

    @property
    def lengths(self) -> tuple[str, ...]:
        """Names of what `varied` counts as "lengths", three (x, y, z) each; () where none are known."""
        return ()

    def replace_contacts(self, spec: Any, positions: Array, frames: Array) -> Any:
        """The grasp with its contacts at positions (n, 3), with frames (n, 3, 3), and all that follows from where they
        are.
        """
        raise NotImplementedError

    def gravity_torque(self) -> Array | None:
        """(nv,) torque that would hold the fingers' own weight [N·m]; None where no gravity was given."""
        return None

    def parallel_spring_torque(self, q: Array | None = None) -> Array | None:
        """(nv,) with which drives pull against springs beside them, with joints at q (nv,), in the grasp's posture
        without [N·m]; None: there are no such springs.
        """
        return None

    def moving_geometry(self, spec: Any) -> Any:
        """The `Geometry` of this grasp as it moves; None where only its first posture is known."""
        return None

    @property
    def nominal(self) -> Array | None:
        """(nv,) where the joints stand in the grasp's posture [rad, m]; None where that is not known."""
        return None

    @property
    def ranges(self) -> tuple[Array, Array] | None:
        """(nv,) lower and upper ends of the joints' ranges [rad, m]; None where they are not known."""
        return None

    def place_at(self, q: Array, pose: Any) -> tuple[Any, Any]:
        """The posture with joints at q (nv,), and the object in this pose of `followed`; None for what is not known."""
        return None, None

    def weight_of_object(self, point: Array) -> Array:
        """(6,) of the object about a point (3,) [N, N·m], in the load of the grasp; zero where it is not known apart
        from it.
        """
        return read_only(np.zeros(6))

    @property
    def object_mass(self) -> float:
        """Of the object [kg]; 0 where it is not known."""
        return 0.0

    def with_object_mass(self, mass: float) -> Self:
        """The same with an object of another mass [kg]."""
        raise NotImplementedError

    def with_load(self, spec: Any, load: Array) -> Any:
        """The grasp under a load (6,) beside the object's weight, about the reference [N, N·m]."""
        return spec.replace(wrench=read_only(self.weight_of_object(spec.reference) + load))

    def explanation_lines(self) -> tuple[tuple[str, str, bool, str, str], ...]:
        """(title, equation, whether it is on, why, which answers count it) of what else it is made of, for `explain()`;
        the last as `Effect.answers`.
        """
        return ()

    def reasons(self, solution: Any) -> Iterable[Any]:
        """What only it knows of whether a solution of its grasp holds, as `Reason`s of a verdict."""
        return ()

    def open_reasons(self, solution: Any) -> Iterable[Any]:
        """The same of torques, where a solution of its grasp leaves forces open."""
        return ()

    def command_reasons(self, spec: Any) -> Iterable[Any]:
        """The same of what is asked of the fingers of a grasp."""
        return ()

    def start_inside_reasons(self, spec: Any) -> Iterable[Any]:
        """The same of links that the object begins inside, before the hand closes."""
        return ()

    def with_squeeze(self, spec: Any, depth: float) -> Any:
        """The grasp with every finger whose force is not prescribed squeezed by depth [m] more."""
        return spec.with_squeeze(depth)

    def with_squeeze_share(self, spec: Any, share: float) -> Any:
        """The grasp with this share of its squeeze."""
        return spec

    def has_command(self, spec: Any) -> bool:
        """Whether the joints of a grasp are commanded beyond their posture."""
        return False

    def regrip(self, spec: Any) -> Any:
        """A grasp whose springs have changed with its command worked out anew, where that is to press with a force."""
        return spec

    def end_reasons(self, torque: Array, yielded: Array, place: tuple[Any, Any]) -> Iterable[Any]:
        """The same of the end of a loading: torques (nv,), how far joints yield (nv,), and `at_end`."""
        return ()

    @property
    def closing_limits(self) -> Array | None:
        """(nv + t,) with which joints, then tendons, can close [N·m, N]; None where no motor says it."""
        return None

    def closing_reasons(self, beyond: Any) -> Iterable[Any]:
        """The same of `FailureMode`s, joints and tendons that closing took more of than their motors give."""
        return ()

    def tension_reasons(self, tension: Array) -> Iterable[Any]:
        """The same of what tendons pull with at the end, (t,) [N], beside what they bear and their motors hold."""
        return ()

    def pulling_reasons(self, spec: Any, torque: Array) -> Iterable[Any]:
        """The same of torques (nv,) [N·m] where the hand has closed, beside those that it was to close with."""
        return ()

    def place_reasons(self, posture: Any, obj: Any, when: str) -> Iterable[Any]:
        """The same of a posture alone, with the object where it is then; None for what is not known. when : that is,
        such as "at the end of the loading".
        """
        return ()

    def find_links_inside(self, q: Array, pose: Any) -> tuple[set[str], str]:
        """Links that are deep in the object where no contact is, and a sentence about them; arguments of `at_end`."""
        return set(), ""

    def regrip_shifted(self, spec: Any, shift: Array) -> Any:
        """The same grasp of the object moved by shift (3,) [m], closed anew; None where that is not known, or does not
        reach the object.
        """
        return None

    def move_object_out(self, spec: Any) -> tuple[str, float, Any] | None:
        """Where the object begins inside links: the words for moving it out of them, by how much [m], and the grasp
        then; None where it does not, or that is not known.
        """
        return None

    @property
    def has_joint_springs(self) -> bool:
        """Whether each joint has a spring that can change on its own."""
        return True

    def with_torque_limits(self, spec: Any, limits: Array) -> Any:
        """The grasp with other torque limits (nv,) [N·m], inf for none."""
        return spec.replace(mechanism=replace(self, limits=limits))

    def with_softer_pad(self, contact: int, more: float) -> Self:
        """The same with the pad of a finger's contact softer by so much along all axes [m/N]; pads that only the
        flexibility of a grasp has are not the mechanism's.
        """
        return self

    def with_stiffness_factor(self, factor: float) -> Self:
        """The same with joints that are so many times as stiff."""
        return replace(self, root=read_only(self.root / np.sqrt(factor)))

    def jacobian_rows(self, soft: tuple[int, ...]) -> Array:
        """(3n + k, nv) [J; T]: the Jacobian of the points, then of the turns of the k contacts in `soft`."""
        return np.concatenate([self.jacobian, self.turning_rates(soft)]) if soft else self.jacobian

    def compliance(self, rows: Array) -> Array:
        """Rows K⁻¹ rowsᵀ, symmetric to the last bit."""
        return joint_flexibility(rows, self.root)

    def deflection(self, torque: Array) -> Array:
        """(nv,) K⁻¹ τ [rad]."""
        return np.asarray(self.root @ (torque @ self.root))

    def joints(
        self, scene: Any, effects: Any, forces: Array, torsion: Array | None, extra: dict[str, Array]
    ) -> JointReading:
        """What the joints do at an answer; arguments as in `read`."""
        torque = forces.reshape(-1) @ self.jacobian
        if torsion is not None:
            torque = torque + torsion[list(scene.soft)] @ self.turning_rates(scene.soft)
        total = torque if scene.held is None else torque + scene.held
        joints = JointReading(total, self.deflection(torque), np.zeros(len(self.names)))
        for e in effects:
            joints = e.read(scene, forces, extra, joints)
        return joints

    def torques(self, scene: Any, forces: Array) -> Array:
        """(nv,) what the actuators hold under forces (n, 3) of hard contacts [N·m], where no effect changes it."""
        torque = forces.reshape(-1) @ self.jacobian
        return read_only(torque if scene.held is None else torque + scene.held)

    def solution_fields(
        self, scene: Any, effects: Any, forces: Array, torsion: Array | None, extra: dict[str, Array]
    ) -> dict[str, Any]:
        """What the joints do at an answer, by the fields that `solution` has beside those of every solution.

        scene, effects : that were solved. forces (n, 3), torsion (n,) of soft contacts, extra : as in `GraspSolution`.
        """
        raise NotImplementedError
