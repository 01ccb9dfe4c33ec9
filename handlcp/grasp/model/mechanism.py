"""What moves the fingers of a grasp, as far as the mechanics need to know it. This room knows no robots."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from handlcp.check import Array, Bools, read_only
from handlcp.grasp.model.cables import Cables
from handlcp.lcp.kernels.dense import kernel


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

    def turning(self, contacts: tuple[int, ...]) -> Array:
        """(k, nv) how fast the fingertips of these contacts turn about their normals [rad/rad]."""
        raise NotImplementedError

    def hessian(self) -> Array:
        """(3n, nv, nv) ∂J/∂q [m/rad²] of contact points that move with their fingers, in contact axes that don't."""
        raise NotImplementedError

    def angular(self) -> Array:
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
    def springs_alone(self) -> bool:
        """Whether joints give way as springs do whatever comes: no dry friction, and tendons that always pull."""
        return not self.dry_friction.any() and (self.cables is None or self.cables.springs_alone)

    def turned_on(self, q: Array) -> Self:
        """The same with joints that stand farther by q (nv,) [rad, m] than its posture has them."""
        return self

    def gives(self, spec: Any) -> bool:
        """Whether the flexibility of a grasp is that of these joints and the pads, and follows them."""
        return False

    def varied(self, spec: Any, what: str, k: int, step: float, inside: Array | None = None) -> Any:
        """The grasp made again, as it was asked for, with the k-th "posture" [rad, m], "lengths" [m] or "stiffness"
        [N·m/rad] larger by a step. Contacts with an object are detected anew; those that were given stay.
        inside : (k,) [m] how far fingertips count as inside the object, in place of what is detected.
        """
        raise NotImplementedError

    def inside(self, spec: Any) -> tuple[Array, Bools] | None:
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

    def replaced(self, spec: Any, positions: Array, frames: Array) -> Any:
        """The grasp with its contacts at positions (n, 3), with frames (n, 3, 3), and all that follows from where they
        are.
        """
        raise NotImplementedError

    def weight(self) -> Array | None:
        """(nv,) torque that would hold the fingers' own weight [N·m]; None where no gravity was given."""
        return None

    def against_springs(self, q: Array | None = None) -> Array | None:
        """(nv,) with which drives pull against springs beside them, with joints at q (nv,), in the grasp's posture
        without [N·m]; None: there are no such springs.
        """
        return None

    def followed(self, spec: Any) -> Any:
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

    def at_end(self, q: Array, pose: Any) -> tuple[Any, Any]:
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

    def weighing(self, mass: float) -> Self:
        """The same with an object of another mass [kg]."""
        raise NotImplementedError

    def loaded(self, spec: Any, load: Array) -> Any:
        """The grasp under a load (6,) beside the object's weight, about the reference [N, N·m]."""
        return spec.replace(wrench=read_only(self.weight_of_object(spec.reference) + load))

    def lines(self) -> tuple[tuple[str, str, bool, str, str], ...]:
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

    def begins_reasons(self, spec: Any) -> Iterable[Any]:
        """The same of links that the object begins inside, before the hand closes."""
        return ()

    def squeezed(self, spec: Any, depth: float) -> Any:
        """The grasp with every finger whose force is not prescribed squeezed by depth [m] more."""
        return spec.squeezed(depth)

    def eased(self, spec: Any, share: float) -> Any:
        """The grasp with this share of its squeeze."""
        return spec

    def commands(self, spec: Any) -> bool:
        """Whether the joints of a grasp are commanded beyond their posture."""
        return False

    def gripping_again(self, spec: Any) -> Any:
        """A grasp whose springs have changed with its command worked out anew, where that is to press with a force."""
        return spec

    def end_reasons(self, torque: Array, yielded: Array, place: tuple[Any, Any]) -> Iterable[Any]:
        """The same of the end of a loading: torques (nv,), how far joints yield (nv,), and `at_end`."""
        return ()

    @property
    def closes(self) -> Array | None:
        """(nv + t,) with which joints, then tendons, can close [N·m, N]; None where no motor says it."""
        return None

    def closing_reasons(self, beyond: Any) -> Iterable[Any]:
        """The same of `Cause`s, joints and tendons that closing took more of than their motors give."""
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

    def in_the_way(self, q: Array, pose: Any) -> tuple[set[str], str]:
        """Links that are deep in the object where no contact is, and a sentence about them; arguments of `at_end`."""
        return set(), ""

    def elsewhere(self, spec: Any, shift: Array) -> Any:
        """The same grasp of the object moved by shift (3,) [m], closed anew; None where that is not known, or does not
        reach the object.
        """
        return None

    def moved_out(self, spec: Any) -> tuple[str, float, Any] | None:
        """Where the object begins inside links: the words for moving it out of them, by how much [m], and the grasp
        then; None where it does not, or that is not known.
        """
        return None

    @property
    def springs_by_joint(self) -> bool:
        """Whether each joint has a spring that can change on its own."""
        return True

    def limited(self, spec: Any, limits: Array) -> Any:
        """The grasp with other torque limits (nv,) [N·m], inf for none."""
        return spec.replace(mechanism=replace(self, limits=limits))

    def padded(self, contact: int, more: float) -> Self:
        """The same with the pad of a finger's contact softer by so much along all axes [m/N]; pads that only the
        flexibility of a grasp has are not the mechanism's.
        """
        return self

    def stiffer(self, factor: float) -> Self:
        """The same with joints that are so many times as stiff."""
        return replace(self, root=read_only(self.root / np.sqrt(factor)))

    def rows(self, soft: tuple[int, ...]) -> Array:
        """(3n + k, nv) [J; T]: the Jacobian of the points, then of the turns of the k contacts in `soft`."""
        return np.concatenate([self.jacobian, self.turning(soft)]) if soft else self.jacobian

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
            torque = torque + torsion[list(scene.soft)] @ self.turning(scene.soft)
        total = torque if scene.held is None else torque + scene.held
        joints = JointReading(total, self.deflection(torque), np.zeros(len(self.names)))
        for e in effects:
            joints = e.read(scene, forces, extra, joints)
        return joints

    def torques(self, scene: Any, forces: Array) -> Array:
        """(nv,) what the actuators hold under forces (n, 3) of hard contacts [N·m], where no effect changes it."""
        torque = forces.reshape(-1) @ self.jacobian
        return read_only(torque if scene.held is None else torque + scene.held)

    def read(
        self, scene: Any, effects: Any, forces: Array, torsion: Array | None, extra: dict[str, Array]
    ) -> dict[str, Any]:
        """What the joints do at an answer, by the fields that `solution` has beside those of every solution.

        scene, effects : that were solved. forces (n, 3), torsion (n,) of soft contacts, extra : as in `GraspSolution`.
        """
        raise NotImplementedError
