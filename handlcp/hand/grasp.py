"""A hand's grasp: contacts where the fingertips are, flexibility and Jacobians turned into contact axes, torques read
off.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.changed import changed
from handlcp.grasp.effects import TorqueSaturation
from handlcp.grasp.explain import Explanation
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.joints import Joints
from handlcp.grasp.others import Equilibria
from handlcp.grasp.pyramid import Pyramid, Section
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.suggest import Suggestion
from handlcp.hand.command import COMMAND, command_line, read_command
from handlcp.hand.elasticity import transmission_line
from handlcp.hand.geometric import bends, geometric_change, of_the_joints, settle, under
from handlcp.hand.objects import Object
from handlcp.hand.solution import HandGraspSolution
from handlcp.hand.suggest import hand_left_out
from handlcp.hand.told import joints_of
from handlcp.hand.torques import torque_check
from handlcp.hand.torsion import turning_jacobian, with_turning
from handlcp.hand.weight import WEIGHT, FingerWeight, line, tip_motion
from handlcp.lcp import Auto, ContactSolver, Solver

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["HandGrasp"]

_NOBODY: tuple[str, ...] = ()


class HandGrasp(Grasp):
    """A `Grasp` that knows its hand. Made by `state.grasp(...)`.

    state : the posture. fingertips : names, one for each finger; contacts of the environment come after them.
    target : the object, or None for contacts given one by one.
    jacobian : (3n, nv) velocity of the contact points in contact axes (x, y, z per contact) under the joints, zero for
        the environment's.
    finger_weight : what was asked for, as in `HandState.grasp`.
    gravity_torque : (nv,) g(q) that adds to the torques [N·m]; zero unless the fingers' weight was asked for.
    sag : (nv,) K⁻¹ g(q) [rad], how far the joints give way to the fingers' weight; zero unless it is in the elastic
        balance. The scene's offset has what that does to the tips, `tip_sag`, added.
    gravity : (3,) [m/s²] that weighs the fingers; zero unless that was asked for. given_gravity : what was given.
    joint_offset : (nv,) δq [rad, m], how far beyond the posture the joints are commanded.
    """

    state: HandState
    fingertips: tuple[str, ...]
    target: Object | None
    jacobian: Array
    finger_weight: FingerWeight
    gravity_torque: Array
    sag: Array
    gravity: Array
    given_gravity: Array
    joint_offset: Array

    def __init__(self, *_: Any, **__: Any) -> None:
        """Not called: a hand's grasp is made from a posture."""
        raise TypeError("make a HandGrasp with hand.at(q).grasp(...)")

    @property
    def names(self) -> tuple[str, ...]:
        """(n,) the fingertips' names, then those of the environment's contacts."""
        if not self.scene.environment:
            return self.fingertips
        return (*self.fingertips, *(str(c.name) for c in self.contacts[self.scene.fingers :]))

    @property
    def turning(self) -> Array:
        """(k, nv) of the k soft contacts' fingertips about their normals [rad/rad]; zero for the environment's."""
        return self._turning if self.scene.soft else read_only(np.zeros((0, self.state.hand.nv)))

    @property
    def tip_offset(self) -> Array:
        """(n, 3) the scene's offset without what the hand adds to it: gaps, preloads and `offset` [m]."""
        return read_only(self.offset - self._added) if self._adds else self.offset

    def replace(
        self,
        *,
        wrench: Any = None,
        flexibility: Any = None,
        offset: Any = None,
        preload: Any = None,
        joint_offset: Any = None,
    ) -> Self:
        """As `Grasp.replace`; joint_offset : as in `state.grasp`. Offset and preload are those of `tip_offset`, and
        what the joints' command and the fingers' weight add comes on top, here as there. Beside soft fingers, whose
        joints turn them, a flexibility has at least what the joints have, or is 0.
        """
        told = self
        if joint_offset is not None:
            told = copy.copy(self)
            told.joint_offset = read_command(joint_offset, self.state.hand.joint_names)
            told = changed(told, offset=told._shifted(self.tip_offset))
        made = super(HandGrasp, told).replace(wrench=wrench, flexibility=flexibility, offset=offset, preload=preload)
        if flexibility is not None and self.scene.soft and made.flexibility[: 3 * len(self.fingertips)].any():
            of_the_joints(made, "soft fingers")
        return made

    def solve(
        self,
        faces: int | str | Pyramid | None = None,
        solver: Solver | ContactSolver | Auto | None = None,
        throw: bool = True,
        accuracy: float | None = None,
        start: GraspSolution | None = None,
    ) -> HandGraspSolution:
        """As `Grasp.solve`, with torques. Raises InputError for an accuracy beside `GeometricStiffness`, too."""
        if accuracy is not None and bends(self) is not None:
            raise InputError("accuracy", "None beside GeometricStiffness: no estimate counts it", accuracy)
        return cast(HandGraspSolution, super().solve(faces, solver, throw, accuracy, start))

    @property
    def tip_sag(self) -> Array:
        """(n, 3) J K⁻¹ g(q) [m], contact axes: object minus fingertip, for tips that sag under the fingers' weight."""
        return tip_motion(self.jacobian, self.sag, self.scene.plane is not None)

    def equilibria(self, faces: int | str | Pyramid = 8, seconds: float = 2.0) -> Equilibria:
        """As `Grasp.equilibria`. Raises Unsupported beside `GeometricStiffness`."""
        if bends(self) is not None:
            raise Unsupported("no search covers equilibria of fingers that their own forces bend (GeometricStiffness)")
        return super().equilibria(faces, seconds)

    def geometric_change(self, solution: GraspSolution, faces: int | str | Pyramid = 8) -> Array:
        """(n,) share of the largest force by which `GeometricStiffness` would change each finger's, from one correction
        at this solution; infinite where fingers buckle. See `handlcp.hand.geometric`.
        """
        return geometric_change(self, solution, faces)

    @property
    def joints(self) -> Joints:
        """What the effects of this grasp may know of its joints."""
        tips = self.state.hand.tip_numbers("fingers", self.fingertips)
        return joints_of(
            self.state, tips, self.contacts, self.frames, self.jacobian, self.gravity_torque,
            self.scene.plane is not None,
        )  # fmt: skip

    def _in_stages(
        self, section: Section, solver: Solver | ContactSolver | Auto | None, throw: bool, start: Array
    ) -> GraspSolution:
        if (effect := bends(self)) is not None:
            return settle(self, effect, section, solver, throw, start)
        return super()._in_stages(section, solver, throw, start)

    def _answering(self, solution: GraspSolution) -> Grasp:
        effect = bends(self)
        return self if effect is None else under(self, effect, solution.forces) or self

    def _test(self, faces: int | str | Pyramid) -> Callable[[Grasp], bool] | None:
        return None if bends(self) is None else lambda g: g.solve(faces, Auto(search_seconds=0), throw=False).held

    def _left_out(self, solution: GraspSolution, faces: int | str | Pyramid) -> Iterator[Suggestion]:
        yield from super()._left_out(solution, faces)
        yield from hand_left_out(self, cast(HandGraspSolution, solution), faces)

    def _explained(self, explanation: Explanation) -> Explanation:
        explanation = super()._explained(explanation)
        weight = line(self.finger_weight, self.gravity_torque, self.tip_sag)
        command = command_line(self.state.hand.joint_names, self.joint_offset)
        behind = transmission_line(self.state.hand.stiffness)
        return replace(explanation, effects=(*explanation.effects, behind, weight, command))

    def _without(self) -> list[tuple[str, Grasp]]:
        light, still = copy.copy(self), copy.copy(self)
        light.finger_weight, still.joint_offset = False, np.zeros_like(self.joint_offset)
        return [*super()._without(), (WEIGHT.title, light), (COMMAND.title, still)]

    def _fingers_alone(self) -> Self:
        made = copy.copy(self)
        made.jacobian = self.jacobian[: 3 * len(self.fingertips)]
        return super(HandGrasp, made)._fingers_alone()

    def _placed(self) -> HandGrasp:
        made = changed(self)
        if self.finger_weight:
            hand = self.state.hand
            weigh = hand.kinematics.gravity_torque(self.state.q, self.gravity)
            if self.finger_weight is True:
                hand.stiffness.deflection(weigh)
        if self._adds:
            self._added  # noqa: B018  the work is what counts: its result is in the scene's offset
        return made

    @property
    def _adds(self) -> bool:
        """Whether the scene's offset is another than the one asked for."""
        return self.finger_weight is True or bool(self.joint_offset.any())

    @property
    def _added(self) -> Array:
        """(n, 3) J (K⁻¹ g - δq) [m]: what sagging and commanded joints add to the offset."""
        return tip_motion(self.jacobian, self.sag - self.joint_offset, self.scene.plane is not None)

    def _turning_too(self, flexibility: Array, soft: tuple[int, ...], frames: Array) -> Array:
        tips = self.state.hand.tip_numbers("fingers", self.fingertips)
        self._turning = read_only(turning_jacobian(self.state, tips, frames, soft))
        return with_turning(self.state, self.jacobian, self._turning, flexibility)

    def _spun(self) -> Array:
        return np.asarray(self._turning @ (self.sag - self.joint_offset))

    def _shifted(self, offset: Array) -> Array:
        return read_only(offset + self._added) if self._adds else offset

    def _complete(self, solution: GraspSolution) -> HandGraspSolution:
        hand, solution = self.state.hand, super()._complete(solution)
        torque = solution.forces.reshape(-1) @ self.jacobian
        if solution.torsion is not None:
            torque = torque + solution.torsion[list(self.scene.soft)] @ self.turning
        total, yielded, yielding = torque + self.gravity_torque, np.zeros(hand.nv), _NOBODY
        for e in self.effects:
            if isinstance(e, TorqueSaturation):
                total, yielded = e.read(self.scene, total, solution.extra)
                yielding = tuple(j for j, s in zip(hand.joint_names, yielded.tolist(), strict=True) if abs(s) > 0.0)
        total = read_only(total)
        check = torque_check(hand.joint_names, total, hand.torques.limits, hand.torques.known, yielding)
        deflection = hand.stiffness.deflection(torque) + self.sag
        return HandGraspSolution(
            **vars(solution), torques=total, joint_deflection=read_only(deflection), joint_yield=read_only(yielded),
            torque_check=check, effort=hand.stiffness.effort(total),
        )  # fmt: skip
