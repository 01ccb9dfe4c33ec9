"""A hand's grasp: contacts where the fingertips are, flexibility and Jacobians turned into contact axes, torques read
off.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError, Unsupported
from handlcp.grasp import arguments
from handlcp.grasp.changed import changed
from handlcp.grasp.contact import Contact
from handlcp.grasp.coordinates import soft_contacts
from handlcp.grasp.effects import Effect, TorqueSaturation
from handlcp.grasp.environment import beside
from handlcp.grasp.explain import Explanation
from handlcp.grasp.friction import LAW, LAWS, Coulomb, Friction
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.joints import Joints
from handlcp.grasp.others import Equilibria
from handlcp.grasp.pyramid import Pyramid, Section
from handlcp.grasp.solution import GraspSolution
from handlcp.hand.command import COMMAND, command_line, read_command
from handlcp.hand.curvature import contact_hessian
from handlcp.hand.detect import touching
from handlcp.hand.elasticity import Effort, transmission_line
from handlcp.hand.geometric import bends, geometric_change, of_the_joints, settle, under
from handlcp.hand.objects import Object
from handlcp.hand.stiffness import per_name
from handlcp.hand.table import surrounding
from handlcp.hand.torques import TorqueCheck, torque_check
from handlcp.hand.torsion import turning_jacobian, with_turning
from handlcp.hand.weight import WEIGHT, FingerWeight, line, read_weight, tip_motion
from handlcp.lcp import Auto, ContactSolver, Solver

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["HandGrasp", "HandGraspSolution", "grasp"]


@dataclass(frozen=True, kw_only=True)
class HandGraspSolution(GraspSolution):
    """A `GraspSolution` with what the joints have to do; NaN where there is no answer.

    torques : (nv,) τ = Jᵀ f that the actuators hold [N·m], plus g(q) when the fingers' weight was asked for.
    joint_deflection : (nv,) K⁻¹ Jᵀ f [rad], how far the joints give way to the grasp forces, and to the fingers' own
        weight where that is part of the elastic balance, from where they are commanded to be. With
        `GeometricStiffness` (K + K_g)⁻¹ (Jᵀ f + g + K_g δq), δq as commanded.
    joint_yield : (nv,) [rad] how far joints at their limit are driven back beyond that (`TorqueSaturation`): s⁺ - s⁻,
        with the sign of the torque; 0 for all others. Such a joint's torque is its limit.
    torque_check : joint by joint torque, limit, utilisation, and the binding joint.
    effort : what the tendons or synergies of the hand do for these torques, by name; None where it has neither.
    """

    torques: Array
    joint_deflection: Array
    joint_yield: Array
    torque_check: TorqueCheck
    effort: Effort | None = None

    @property
    def tendon_tension(self) -> Array | None:
        """(t,) k R K⁻¹ τ [N], how much harder each tendon pulls for these torques (below 0: less); None without
        `Tendons`.
        """
        return self.effort.values if self.effort is not None and self.effort.kind == "tendon tension" else None

    @property
    def actuator_force(self) -> Array | None:
        """(k,) η = Sᵀ τ [N·m where S has no unit] that each synergy's actuator holds; None without `Synergies`."""
        return self.effort.values if self.effort is not None and self.effort.kind == "actuator force" else None

    def __str__(self) -> str:
        """The grasp, then the joints, then what is behind them."""
        parts = [super().__str__(), *([self.torque_check, self.effort] if self.held else [])]
        return "\n".join(str(part) for part in parts if part is not None)


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
    gravity : (3,) [m/s²] that weighs the fingers; zero unless that was asked for.
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
        return _joints(
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

    def _explained(self, explanation: Explanation) -> Explanation:
        explanation = super()._explained(explanation)
        weight = line(self.finger_weight, self.gravity_torque, self.tip_sag)
        command = command_line(self.state.hand.joint_names, self.joint_offset)
        behind = transmission_line(self.state.hand.stiffness)
        lines = [*explanation.effects, behind, weight, command]
        lines.sort(key=lambda x: not x.on)  # what is on comes first
        return replace(explanation, effects=tuple(lines))

    def _without(self) -> list[tuple[str, Grasp]]:
        light, still = copy.copy(self), copy.copy(self)
        light.finger_weight, still.joint_offset = False, np.zeros_like(self.joint_offset)
        return [*super()._without(), (WEIGHT, light), (COMMAND, still)]

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


def grasp(
    state: HandState,
    target: Any,
    friction: Any = None,
    wrench: Any = None,
    gravity: Any = (0.0, 0.0, -9.81),
    preload: Any = 0.0,
    *,
    offset: Any = None,
    reference: Any = None,
    fingers: Sequence[str] | None = None,
    max_gap: Any = 1e-3,
    effects: Iterable[Any] = (),
    finger_weight: FingerWeight = False,
    plane: Any = None,
    joint_offset: Any = None,
    environment: Any = None,
) -> HandGrasp:
    """The grasp of an object by a hand in a posture; as a method, `state.grasp(target, …)`.

    target : an object (Box, Sphere, Cylinder, Ellipsoid, Mesh): contacts, normals and gaps are detected, and a
        fingertip that overlaps the object is preloaded by the overlap. Or contacts, a sequence with one for each
        finger, or a mapping by fingertip name: each moves rigidly with its fingertip, and is taken as touching.
    friction : of all contacts with an object, or a mapping by fingertip name; None: Coulomb(0.6). Contacts bring
        their own.
    wrench : (6,) force [N] and torque [N·m] about `reference` on the object, besides its weight; None: none.
    gravity : (3,) [m/s²], world axes; weighs the object at its centre of mass, and the fingers when asked to.
    preload : [m] a number or (n,), more squeeze of the normals. offset : (n, 3) [m], contact axes, as in `Grasp`.
    reference : (3,) [m], of wrench and object motion; None: the object's centre of mass, the origin for contacts.
    fingers : the fingertips that take part, in this order; None: all (those a mapping of contacts names).
    max_gap : [m] the farthest a fingertip may be from the object and still count as touching.
    effects, plane : as in `Grasp`; `TorqueSaturation()` lets joints at their limit yield, `GeometricStiffness()`
        lets the forces turn their own levers.
    finger_weight : True: the fingers' own weight is in the torques and in the elastic balance. The posture is then
        the one commanded: the joints sag from it by K⁻¹ g(q), and the tips with them, before the object is loaded.
        "torques": in the torques alone, for a posture that is measured: it has sagged already, and no offset applies.
    joint_offset : squeeze in joint space, (nv,) or a mapping by joint name [rad, m]: the joints are commanded this far
        beyond the posture, which adds -J δq to the offsets.
    environment : a `Table`, an `Environment`, or several: what the object touches besides the fingers. Those contacts
        come last; friction, preload and offset above are the fingers', n of them.

    Raises NotReached (naming each finger and its gap, or a table), UnknownName, InputError.
    """
    hand = state.hand
    heavy = read_weight(finger_weight)
    obj = target if isinstance(target, Object) else None
    if obj is not None:
        tips = hand.tip_numbers("fingers", fingers)
        laws = _frictions(friction, [hand.fingertips[i] for i in tips])
        contacts, gaps = touching(state, tips, obj, laws, number("max_gap", max_gap, minimum=0.0))
    else:
        tips, contacts = _given(state, target, fingers, friction)
        gaps = None
    n, around, own = len(contacts), None, None
    if environment is not None:
        around, own = surrounding(environment, obj), n
        contacts = arguments.contacts((*contacts, *around.contacts))
    positions = np.array([c.position for c in contacts])
    frames = np.array([c.rotation for c in contacts])
    normal = arguments.plane(plane, contacts, positions, frames)
    if normal is not None:
        frames = arguments.in_plane(frames, normal)
    turned, points = frames.transpose(0, 2, 1), positions
    if around is not None:
        turned, points = turned[:n], positions[:n]
    jacobian = (turned @ state.jacobian_at(points, tips)).reshape(3 * n, hand.nv)
    flexibility = hand.stiffness.compliance(jacobian)
    rotations = state.tip_rotations if tips is hand.tips.every else state.tip_rotations[list(tips)]
    hand.pads.add_to(flexibility, turned @ rotations, tips)
    shift = arguments.offset(offset, preload, n)
    if gaps is not None:
        shift = shift + np.concatenate([np.zeros((n, 2)), gaps[:, None]], axis=1)
    if around is not None:
        m = len(around.contacts)
        jacobian = np.concatenate([jacobian, np.zeros((3 * m, hand.nv))])
        flexibility, shift = beside(flexibility, around.flexibility), np.concatenate([shift, around.offset])
    g = array("gravity", gravity, (3,))
    if reference is None:
        point = read_only(np.zeros(3)) if obj is None else obj.center_of_mass
    else:
        point = arguments.reference(reference, normal, positions)
    load = arguments.wrench(wrench, normal, arguments.lift(positions, point, normal))
    load = _with_weight(load, obj, g, point, positions, normal)
    weigh = read_only(hand.kinematics.gravity_torque(state.q, g) if heavy else np.zeros(hand.nv))
    sag = read_only(hand.stiffness.deflection(weigh) if heavy is True else np.zeros(hand.nv))
    command = read_command(joint_offset, hand.joint_names)
    if heavy is True or joint_offset is not None:
        shift = shift + tip_motion(jacobian, sag - command, normal is not None)
    jacobian = read_only(jacobian)
    asked: tuple[Effect, ...] = ()
    if not isinstance(effects, tuple) or effects:
        known = _joints(state, tips, contacts, frames, jacobian, weigh, normal is not None)
        asked = arguments.effects(effects, len(contacts), known, own)
    made = HandGrasp.__new__(HandGrasp)
    made.jacobian, made.sag, made.joint_offset = jacobian, sag, command
    made.state, made.target = state, obj
    made.fingertips = hand.fingertips if tips is hand.tips.every else tuple(hand.fingertips[i] for i in tips)
    made._place(
        contacts,
        positions,
        frames,
        load,
        point,
        read_only(flexibility),
        read_only(shift),
        asked,
        normal,
        own,
    )
    made.finger_weight, made.gravity = heavy, g if heavy else _WEIGHTLESS
    made.gravity_torque = weigh
    return made


def _joints(
    state: HandState, tips: Sequence[int], contacts: tuple[Contact, ...], frames: Array, jacobian: Array,
    weight: Array, planar: bool,
) -> Joints:  # fmt: skip
    hand, k = state.hand, len(tips)
    hessian = partial(contact_hessian, state, tips, np.array([c.position for c in contacts[:k]]), frames[:k])
    turning: dict[int, Array] = {}
    if not all([c.plain for c in contacts]):
        soft = soft_contacts(contacts, (True,) * len(contacts), planar)
        turning = dict(zip(soft, turning_jacobian(state, tips, frames, soft), strict=True))
    return Joints(hand.joint_names, jacobian, weight, hand.torques.limits, hand.stiffness.root, hessian, turning)


_WEIGHTLESS = read_only(np.zeros(3))
_NOBODY: tuple[str, ...] = ()


def _frictions(friction: Any, names: list[str]) -> list[Friction]:
    laws: list[Any] = [Coulomb(0.6) if friction is None else friction] * len(names)
    if isinstance(friction, Mapping):
        laws = [per_name("friction", friction, names, "a fingertip").get(name, Coulomb(0.6)) for name in names]
    for name, law in zip(names, laws, strict=True):
        if not isinstance(law, LAWS):
            where = f"friction[{name!r}]" if isinstance(friction, Mapping) else "friction"
            raise InputError(where, f"{LAW}, or a mapping of fingertips to them", repr(law))
    return laws


def _given(state: HandState, target: Any, fingers: Any, friction: Any) -> tuple[tuple[int, ...], tuple[Contact, ...]]:
    hand = state.hand
    if friction is not None:
        raise InputError("friction", "None when contacts are given (each Contact has its own)", repr(friction))
    if isinstance(target, Mapping):
        if fingers is None:
            fingers = [name for name in hand.fingertips if name in target]
        per_name("contacts", target, hand.fingertips, "a fingertip")
        tips = hand.tip_numbers("fingers", fingers)
        if missing := [name for name in fingers if name not in target]:
            raise InputError("contacts", f"a Contact for {', '.join(missing)}", f"only {sorted(target)}")
        return tips, arguments.contacts(target[name] for name in fingers)
    if not isinstance(target, Iterable) or isinstance(target, (str, bytes)):
        raise InputError(
            "target", "an object (Box, Sphere, …), contacts, or a mapping of fingertips to contacts", repr(target)
        )
    tips, contacts = hand.tip_numbers("fingers", fingers), arguments.contacts(target)
    if len(contacts) != len(tips):
        names = ", ".join(hand.fingertips[i] for i in tips)
        raise InputError("contacts", f"{len(tips)}, one for each of {names}", f"{len(contacts)}")
    return tips, contacts


def _with_weight(
    wrench: Array, obj: Object | None, gravity: Array, point: Array, positions: Array, normal: Array | None
) -> Array:
    """(6,) the load and the object's weight at its centre of mass, both about `point`."""
    if obj is None or obj.mass == 0.0:
        return wrench
    weight = obj.mass * gravity
    if normal is not None and abs(float(weight @ normal)) > 1e-9 * float(abs(weight).max()):
        raise InputError("gravity", "gravity in the plane of a planar scene", gravity.tolist())
    if weight.any() and (off := arguments.lift(positions, obj.center_of_mass, normal)):
        expected = "an object whose centre of mass lies in the plane of a planar scene"
        raise InputError("target", expected, f"one {abs(off):.3g} m off it")
    x, y, z = obj.center_of_mass - point
    fx, fy, fz = weight
    return read_only(wrench + np.array([fx, fy, fz, y * fz - z * fy, z * fx - x * fz, x * fy - y * fx]))
