"""`GeometricStiffness`: a finger that gives way turns the lever of the force it carries.

    E = J (K + K_g)⁻¹ Jᵀ + pads,    K_g(f) = ∂(J(q)ᵀ f)/∂q,    f the finger's force on the object, fixed in the world
    d += J [(K + K_g)⁻¹ g - K⁻¹ g + (K + K_g)⁻¹ K_g δq],       g the fingers' weight, δq a commanded offset, if any
    τ = Jᵀ f + g + K_g (δq - δ)

The springs hold K δ = J(q)ᵀ f where the joints stand at q = q_c - δ. To first order in δ that is Jᵀ f - K_g δ, so that
(K + K_g) δ = Jᵀ f. The torques are those of that posture, what the springs hold. The sign, on one link p with a spring
k: τ = f · (ω × p) and ∂τ/∂q = -f · p across the axis. A finger that pushes along itself, away from its joint, is a
column: k - |f||p|, softer, and it buckles where nothing is left. One that pulls is stiffer. K_g is symmetric: it holds
second derivatives of the contact points.

Small changes about a posture that carries f are exact. Seen from the unloaded posture, joint deflections have an error
of second order, where K alone has one of first order. Tips keep about half of the error of K alone, because their
path is still taken as straight. The weight's own gradient ∂g/∂q is left out.

With K⁻¹ = A Aᵀ, which may be singular, (K + K_g)⁻¹ = A (1 + Aᵀ K_g A)⁻¹ Aᵀ: nothing inverts it, and a finger is
stable where the bracket is positive definite. E depends on the forces it produces, so a solve repeats with E(f) until f
stays (`handlcp.grasp.solve.solve_spec`); an answer passes only with the E of its own forces.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, check_init_call, read_only
from handlcp.errors import InputError
from handlcp.grasp.effects.joint_offset import JointOffset
from handlcp.grasp.effects.joint_torque import FingerWeight, TorqueSaturation
from handlcp.grasp.model.contact import Placement
from handlcp.grasp.model.effect import ONE_SOLVE, Effect, EffectTrial, FileKey
from handlcp.grasp.model.mechanism import JointReading
from handlcp.grasp.model.scene import Scene
from handlcp.tolerances import SEMIDEFINITE_TOLERANCE

_BUCKLING_SHARE = 0.1  # of the largest motion: joints that move less are not what buckles


class LoadedJoints(NamedTuple):
    """Joints under the forces of an answer. added_compliance : (nv, nv) [rad/(N·m)], by how much they give way more.
    command_shift : (nv,) [rad], how far their command and weight move them for it. stiffness : (nv, nv) K_g [N·m/rad].
    held : (nv,) [rad], how far they stand beyond the given posture, δq - K⁻¹ g, before forces and K_g move them.
    """

    added_compliance: Array
    command_shift: Array
    stiffness: Array
    held: Array


@check_init_call()
@dataclass(frozen=True, eq=False)
class GeometricStiffness(Effect):
    """Asked for on a hand's grasp, which knows the joints: `state.grasp(..., effects=[GeometricStiffness()])`.

    The grasp's `flexibility`, `problem()` and `plan()` are those of unloaded fingers; the solution's `scene` has the E
    of its forces.

    bent : what the forces of an answer do to the joints; None where no forces are known.
    """

    bent: LoadedJoints | None = field(default=None, repr=False)

    title = "geometric stiffness"
    equation = "E = J (K + K_g)⁻¹ Jᵀ + …,  K_g = ∂(Jᵀ f)/∂q"
    when = "Soft joints under large forces, where fingers may buckle."
    in_python = "effects=[GeometricStiffness()]"
    in_file = "effects.geometric_stiffness = true"
    brings = "none: E(f), solved again"
    source = (
        "Chen & Kao, Int. J. Robotics Research 19 (2000); Cutkosky & Kao, IEEE Trans. Robotics and Automation 5 (1989)"
    )
    order = 280
    needs_joints = True
    depends_on_forces = True
    answers = ONE_SOLVE  # a loading that is followed has it in its geometry
    file_key = FileKey(
        "geometric_stiffness",
        bool,
        "true or false",
        "fingers are softened or stiffened by the forces they carry; a scene with a [hand]",
        default=False,
    )

    def check(self, argument: str, at: Placement, others: tuple[Effect, ...]) -> None:
        """Beside springs, and beside friction whose work has a potential."""
        if any(isinstance(e, TorqueSaturation) for e in others):
            expected = "geometric stiffness or torque saturation: a joint that yields has no spring to add to"
            raise InputError(argument, expected, "both")
        known = {i for e in others for i in e.prescribed()}
        soft = [i for i, c in enumerate(at.contacts) if c.friction.lever > 0.0 and i not in known and not at.planar]
        if soft:
            expected = "no soft fingers beside geometric stiffness: their moments have no potential to take it from"
            raise InputError(argument, expected, f"{len(soft)} of them")

    @classmethod
    def trial(cls, at: Placement, others: tuple[Effect, ...], forces: Array, torque: Array) -> EffectTrial | None:
        """One correction of the flexibility, under the answer's own forces."""
        if at.mechanism is None:
            return None
        try:
            cls().check("effects", at, others)
        except InputError:
            return None
        bent = cls().under(at, forces, others)
        none = EffectTrial(None, np.inf, "fingers buckle under their forces, or there is no equilibrium with it")
        return none if isinstance(bent, str) else EffectTrial(bent, words=none.words)

    def why(self, scene: Scene) -> str:
        return "asked for: solved again with the flexibility under its own forces until these stay"

    def under(self, at: Placement, forces: Array, others: tuple[Effect, ...]) -> Effect | str:
        """With what the fingers give way more under these forces; or which joints buckle."""
        joints = at.mechanism
        assert joints is not None  # `needs_joints` saw to it
        A, K_g = joints.root, np.tensordot(forces.reshape(-1), joints.hessian(), 1)
        change = A.T @ K_g @ A
        change = (change + change.T) / 2
        bracket = np.eye(len(change)) + change
        resisted, motions = np.linalg.eigh(bracket)
        if not resisted[0] > SEMIDEFINITE_TOLERANCE:
            moved = abs(A @ motions[:, resisted <= SEMIDEFINITE_TOLERANCE]).max(axis=1, initial=0.0)
            names = [name for name, m in zip(joints.names, moved, strict=True) if m > _BUCKLING_SHARE * moved.max()]
            return f"K + K_g is not positive definite: {', '.join(names)} buckle under these forces"
        softer = -A @ np.linalg.solve(bracket, change @ A.T)  # the difference itself, not that of two large matrices
        softer, off, held = (softer + softer.T) / 2, np.zeros(len(joints.names)), np.zeros(len(joints.names))
        for e in others:
            if isinstance(e, FingerWeight) and e.sags:
                off += softer @ e.torque
                held -= joints.deflection(e.torque)
            elif isinstance(e, JointOffset):
                torque = K_g @ e.command
                off += joints.deflection(torque) + softer @ torque
                held += e.command
        return GeometricStiffness(LoadedJoints(*map(read_only, (softer, off, K_g, held))))

    def added_flexibility(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """J [(K + K_g)⁻¹ - K⁻¹] Jᵀ."""
        if self.bent is None or at.mechanism is None:
            return None
        rows = at.mechanism.jacobian_rows(soft)
        E = rows @ self.bent.added_compliance @ rows.T
        return np.asarray((E + E.T) / 2)

    def added_offset(self, at: Placement, soft: tuple[int, ...]) -> Array | None:
        """What weight and command do with the fingers bent."""
        bent, joints = self.bent, at.mechanism
        return None if bent is None or joints is None else np.asarray(joints.jacobian_rows(soft) @ bent.command_shift)

    def read(self, scene: Scene, forces: Array, extra: dict[str, Array], joints: JointReading) -> JointReading:
        """δ = (K + K_g)⁻¹ (Jᵀ f + g + K_g δq), and the torques of the posture that it leads to."""
        bent = self.bent
        if bent is None or scene.mechanism is None:
            return joints
        push = forces.reshape(-1) @ scene.mechanism.jacobian
        more = bent.added_compliance @ push + bent.command_shift
        moved = bent.held - scene.mechanism.deflection(push) - more
        return replace(joints, torque=joints.torque + bent.stiffness @ moved, deflection=joints.deflection + more)
