"""Geometric stiffness: a finger that gives way turns the lever of the force it carries.

    E = J (K + K_g)⁻¹ Jᵀ + pads,    K_g(f) = ∂(J(q)ᵀ f)/∂q,    f the finger's force on the object, fixed in the world

The springs hold K δ = J(q)ᵀ f where the joints stand at q = q_c - δ. To first order in δ that is Jᵀ f - K_g δ, so that
(K + K_g) δ = Jᵀ f. The sign, on one link p with a spring k: τ = f · (ω × p) and ∂τ/∂q = -f · p across the axis. A
finger that pushes along itself, away from its joint, is a column: k - |f||p|, softer, and it buckles where nothing is
left. One that pulls is stiffer. K_g is symmetric: it holds second derivatives of the contact points. Exact for what
changes about a posture that carries f. From the unloaded posture on, joint deflections miss by a second order where K
alone misses by a first; tips, whose path is still taken as straight, by about half of what K alone misses.

With K⁻¹ = A Aᵀ, which may be singular, (K + K_g)⁻¹ = A (1 + Aᵀ K_g A)⁻¹ Aᵀ: nothing inverts it, and a finger is
stable where the bracket is positive definite. E depends on the forces it produces, so a solve repeats with E(f) until f
stays (`handlcp.hand.geometric`); an answer passes only with the E of its own forces.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.needs import need_joints
from handlcp.grasp.effects.prescribed_force import PrescribedForce
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.joints import Joints
from handlcp.grasp.scene import Scene
from handlcp.tolerances import SEMIDEFINITE

__all__ = ["GeometricStiffness", "relative"]

_SHARE = 0.1  # of the largest motion: joints that move less are not what buckles


@dataclass(frozen=True, eq=False)
class GeometricStiffness(Effect):
    """Asked for on a hand's grasp, which knows the joints: `state.grasp(..., effects=[GeometricStiffness()])`.

    The grasp's `flexibility`, `problem()` and `plan()` are those of unloaded fingers; the solution's `scene` has the E
    of its forces.

    joints : the hand's, once it has completed the effect. hessian : (3n, nv, nv) ∂J/∂q of the contact points, which
    move with their fingers, in contact axes that don't.
    """

    joints: Joints | None = field(default=None, init=False, repr=False)
    hessian: Array | None = field(default=None, init=False, repr=False)

    title = "geometric stiffness"
    equation = "E = J (K + K_g)⁻¹ Jᵀ + …,  K_g = ∂(Jᵀ f)/∂q"
    when = "Soft joints under large forces, where fingers may buckle."
    in_python = "effects=[GeometricStiffness()]"
    in_file = "effects.geometric_stiffness = true"
    brings = "none: E(f), solved again"
    source = (
        "Chen & Kao, Int. J. Robotics Research 19 (2000); Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989)"
    )

    def for_grasp(self, argument: str, n: int, joints: Joints | None, others: tuple[Effect, ...]) -> Self:
        """Completed by the joints and by how their Jacobian changes."""
        joints = need_joints(argument, joints, self)
        if any(isinstance(e, TorqueSaturation) for e in others):
            expected = "geometric stiffness or torque saturation: a joint that yields has no spring to add to"
            raise InputError(argument, expected, "both")
        if soft := set(joints.turning) - {e.contact for e in others if isinstance(e, PrescribedForce)}:
            expected = "no soft fingers beside geometric stiffness: their moments have no potential to take it from"
            raise InputError(argument, expected, f"{len(soft)} of them")
        made, hessian = type(self)(), joints.hessian()
        still = np.zeros((3 * n - len(hessian), *hessian.shape[1:]))  # contacts of the environment
        object.__setattr__(made, "joints", joints)
        object.__setattr__(made, "hessian", read_only(np.concatenate([hessian, still])))
        return made

    @property
    def opens(self) -> bool:
        """Contact modes with one E for all forces prove nothing here."""
        return True

    def why(self, scene: Scene) -> str:
        """Asked for."""
        return "asked for: solved again with the flexibility under its own forces until these stay"

    def stiffness(self, forces: Array) -> Array:
        """(nv, nv) K_g [N·m/rad] of forces (n, 3) [N], contact axes."""
        assert self.hessian is not None  # `for_grasp` saw to it
        return np.asarray(np.tensordot(forces.reshape(-1), self.hessian, 1))

    def compliance(self, forces: Array) -> Array | None:
        """(nv, nv) (K + K_g)⁻¹ [rad/(N·m)] under these forces; None where a finger buckles."""
        A, bracket = self._bracket(forces)
        if not _stable(bracket):
            return None
        C = A @ np.linalg.solve(bracket, A.T)
        return np.asarray((C + C.T) / 2)

    def change(self, forces: Array) -> Array | None:
        """(3n, 3n) by how much E under these forces [m/N] differs from that under none; None where a finger buckles."""
        A, bracket = self._bracket(forces)
        if not _stable(bracket):
            return None
        assert self.joints is not None
        B, more = self.joints.jacobian @ A, bracket - np.eye(len(bracket))
        E = -B @ np.linalg.solve(bracket, more) @ B.T  # the difference itself, not that of two large matrices
        return np.asarray((E + E.T) / 2)

    def buckling(self, forces: Array) -> tuple[str, ...]:
        """The joints that these forces bend away, in every direction in which the springs do not resist."""
        A, bracket = self._bracket(forces)
        assert self.joints is not None
        resisted, motions = np.linalg.eigh(bracket)
        moved = abs(A @ motions[:, resisted <= SEMIDEFINITE]).max(axis=1, initial=0.0)
        return tuple(name for name, m in zip(self.joints.names, moved, strict=True) if m > _SHARE * moved.max())

    def residual(
        self, scene: Scene, forces: Array, extra: dict[str, Array], force_size: float, motion_size: float
    ) -> float:
        """By how much the scene's E, that of unloaded fingers, differs from E(f), relative; infinite for fingers that
        buckle.
        """
        change = self.change(scene.physical(forces.reshape(-1, 3)))
        if change is not None and scene.scale is not None:
            change = change * scene.scale[:, None] * scene.scale
        return np.inf if change is None else relative(change, scene.flexibility)

    def _bracket(self, forces: Array) -> tuple[Array, Array]:
        """A, and 1 + Aᵀ K_g A."""
        assert self.joints is not None
        A = self.joints.root
        K = A.T @ self.stiffness(forces) @ A
        return A, np.eye(len(K)) + (K + K.T) / 2


def relative(difference: Array, of: Array) -> float:
    """The largest entry of a difference beside the largest of what differs."""
    size = float(abs(of).max(initial=0.0))
    return float(abs(difference).max(initial=0.0)) / size if size > 0.0 else 0.0


def _stable(bracket: Array) -> bool:
    return bool(np.linalg.eigvalsh(bracket)[0] > SEMIDEFINITE)
