"""What a hand tells a grasp: how its joints move the contacts, how they give way, and what they do at an answer.

    E = J K⁻¹ Jᵀ + pads,    τ = Jᵀ f + Tᵀ m + g + p

p holds springs beside the drives (`robot/servo_stiffness.py`). m are the moments about the normals of soft contacts,
T how fast the joints turn their fingertips about them. Source: the package's README, "The model and its symbols".
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
import pinocchio as pin

from handlcp.actuation.joint_stiffness import Effort, FingertipPads, tip_flexibility
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array, Bools, read_only
from handlcp.errors import InputError
from handlcp.geometry.contact_detection import detect_tip_contacts
from handlcp.geometry.object import Object, describe_missing_weight, object_weight_wrench, total_load
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.joint_offset import OVERLAP_TOLERANCE, commanded_offset, find_command
from handlcp.grasp.model.contact import MANY_CONTACTS
from handlcp.grasp.model.flexibility import Flexibility, FlexibilityFactor
from handlcp.grasp.model.mechanism import Cables, Mechanism
from handlcp.grasp.model.request import GraspSpec, replace_load, with_changes
from handlcp.grasp.model.scene import Scene
from handlcp.hand.solution import HandGraspSolution
from handlcp.hand.squeeze import overlap_depths
from handlcp.hand.torque_check import MotorPull, motor_pull_reasons
from handlcp.lazy_property import lazy_property
from handlcp.robot.grasp_variation import GraspVariation
from handlcp.robot.hand_model import HandPosture
from handlcp.robot.joint import TorqueLimits

if TYPE_CHECKING:
    from handlcp.grasp.failure.failure_mode import FailureMode
    from handlcp.grasp.solution.verdict import Reason
    from handlcp.hand.moving_geometry import MovingHandGeometry
    from handlcp.hand.torque_check import TorqueCheck


@dataclass(frozen=True, eq=False)
class HandMechanism(GraspVariation, Mechanism):
    """A hand in a posture, as the mechanism of a grasp.

    posture : where the hand is. tips : numbers of the fingertips that take part, in the order of the contacts.
    positions (k, 3), frames (k, 3, 3) : of the fingers' contacts, contact axes. target : the object, if it is known.
    relaxed (nv,) : where springs at the joints are at rest [rad, m]: in the grasp's posture, wherever that is followed.
    gravity : (3,) as given [m/s²]. stand_off : (k, 3) offsets of the gaps and overlaps that were detected [m], part of
    the grasp's; 0 for contacts that were given.
    """

    solution: ClassVar[Any] = HandGraspSolution

    posture: HandPosture
    tips: tuple[int, ...]
    positions: Array
    frames: Array
    target: Object | None
    gravity: Array
    stand_off: Array
    rest_posture: Array

    @property
    def fingertips(self) -> tuple[str, ...]:
        """Their names."""
        every = self.posture.hand.fingertips
        return tuple([every[i] for i in self.tips])

    @property
    def links(self) -> dict[str, str]:
        """Of a hand whose fingertips are places on its links."""
        hand = self.posture.hand
        return {} if hand.links_of_sites is None else dict(zip(hand.fingertips, hand.links_of_sites, strict=True))

    def turning_rates(self, contacts: tuple[int, ...]) -> Array:
        """(k, nv) T of these contacts, zero for those of the environment."""
        J = self.posture.angular_jacobian(self.tips)
        still = np.zeros(self.posture.hand.nv)
        rows = [self.frames[i, :, 2] @ J[i] if i < len(self.tips) else still for i in contacts]
        return read_only(np.array(rows).reshape(len(contacts), len(still)))

    def with_joint_shift(self, q: Array) -> Self:
        """Springs at the joints keep their rest angle."""
        return replace(self, rest_posture=self.rest_posture - q)

    def has_joint_flexibility(self, spec: GraspSpec) -> bool:
        """Unless another flexibility was asked for."""
        return getattr(spec.asked, "flexibility", None) is None

    def flexibility(self) -> Array:
        """(3k, 3k) of the fingers."""
        return finger_flexibility(self)

    def hessian(self) -> Array:
        """(3n, nv, nv), zero for contacts of the environment."""
        return self._hessian

    @lazy_property
    def _hessian(self) -> Array:
        from handlcp.robot.hand_model import contact_hessian

        H = contact_hessian(self.posture, self.tips, self.positions, self.frames)
        still = np.zeros((len(self.jacobian) - len(H), *H.shape[1:]))
        return read_only(np.concatenate([H, still]))

    def inside_depths(self, spec: GraspSpec) -> tuple[Array, Bools] | None:
        """Of a grasp whose contacts were detected."""
        if self.target is None or getattr(spec.asked, "found", ()) is not None:
            return None
        gaps = self.gaps()
        return overlap_depths(gaps), np.asarray(abs(gaps) <= OVERLAP_TOLERANCE)

    def gaps(self) -> Array:
        """As they were detected."""
        return self.stand_off[:, 2]

    def gravity_torque(self) -> Array | None:
        """g(q), where gravity is not zero."""
        return read_only(self.posture.gravity_torque(self.gravity)) if self.gravity.any() else None

    def parallel_spring_torque(self, q: Array | None = None) -> Array | None:
        """Of a hand whose file has springs beside servos."""
        return self.posture.hand.stiffness.parallel_spring_torque(self.posture.q if q is None else q)

    def moving_geometry(self, spec: GraspSpec) -> MovingHandGeometry:
        """Of this grasp."""
        from handlcp.hand.moving_geometry import MovingHandGeometry

        return MovingHandGeometry(spec)

    @property
    def nominal(self) -> Array:
        """As the hand was placed."""
        return self.posture.q

    @property
    def ranges(self) -> tuple[Array, Array]:
        """Of the joints, as the URDF has them."""
        hand = self.posture.hand
        return hand.lower, hand.upper

    def place_at(self, q: Array, pose: Any) -> tuple[HandPosture, Object | None]:
        """A hand's posture, and its object moved."""
        placed = None
        if self.target is not None:
            R, t = pose
            placed = self.target.moved_to(pin.SE3(R, t) * self.target.placement)
        return type(self.posture)(self.posture.hand, q), placed

    def weight_of_object(self, point: Array) -> Array:
        """Its mass times gravity, at its centre of mass."""
        return read_only(object_weight_wrench(self.target, self.gravity, point))

    def explanation_lines(self) -> tuple[tuple[str, str, bool, str, str], ...]:
        """Of its joints, motors and tendons."""
        from handlcp.hand.explanation_lines import explanation_lines

        return explanation_lines(self.posture.hand, self.parallel_spring_torque())

    def reasons(self, solution: Any) -> Iterator[Reason]:
        """Of its torques, its limits and its posture."""
        from handlcp.hand.torque_check import torque_reasons
        from handlcp.robot.audit import doubt_reasons

        if solution.held:
            yield from torque_reasons(solution.torque_check)
            yield from self.open_reasons(solution)
            yield from doubt_reasons(self.posture.hand.doubts)
        yield from self.command_reasons(solution.spec)
        yield from self.place_reasons(self.posture, self.target, "in the given posture")

    def open_reasons(self, solution: Any) -> Iterator[Reason]:
        """Between what and what torques are, where forces are open."""
        from handlcp.hand.torque_check import open_torque_reasons

        yield from open_torque_reasons(solution)

    def command_reasons(self, spec: GraspSpec) -> Iterator[Reason]:
        """What of a squeeze no command of the joints makes; the weight, where the load leaves it out."""
        from handlcp.grasp.solution.verdict import Reason
        from handlcp.hand.squeeze import reach_reasons
        from handlcp.hand.torque_check import unmade_reasons

        yield from self.start_inside_reasons(spec)
        yield from reach_reasons(spec)
        if (command := find_command(spec.effects)) is not None and command.keeps:
            yield Reason("object_kept", "note", "the object is kept in place until the hand has closed")
        if command is not None:
            yield from unmade_reasons(
                self.names, self.posture.hand.stiffness, command.command, self.posture.hand.sliding
            )
        if text := describe_missing_weight(spec, object_weight_wrench(self.target, self.gravity, spec.reference)):
            yield Reason("weight_left_out", "note", text)

    def start_inside_reasons(self, spec: GraspSpec) -> Iterator[Reason]:
        """Of links of the hand."""
        from handlcp.hand.squeeze import start_penetration_reasons

        yield from start_penetration_reasons(spec)

    def with_squeeze(self, spec: GraspSpec, depth: float) -> GraspSpec:
        """By commands of the joints."""
        from handlcp.hand.squeeze import squeeze_further

        return squeeze_further(spec, depth)

    def with_squeeze_share(self, spec: GraspSpec, share: float) -> GraspSpec:
        """Commands of the joints included."""
        from handlcp.hand.squeeze import ease_squeeze

        return ease_squeeze(spec, share)

    def end_reasons(self, torque: Array, yielded: Array, place: tuple[Any, Any]) -> Iterator[Reason]:
        """Of torques and posture at the end of a loading."""
        from handlcp.hand.torque_check import torque_reasons
        from handlcp.robot.audit import doubt_reasons

        at_limit = np.where(yielded != 0.0, np.clip(torque, -self.limits, self.limits), torque)  # but for rounding
        yield from torque_reasons(self._check(at_limit, yielded))
        yield from doubt_reasons(self.posture.hand.doubts)
        yield from self.place_reasons(*place, "at the end of the loading")

    @property
    def dry_friction(self) -> Array:
        """Of the hand and its drives."""
        return self.posture.hand.dry_friction

    @lazy_property
    def cables(self) -> Cables | None:
        """Of a hand with tendons."""
        stiffness = self.posture.hand.stiffness
        if not isinstance(stiffness, TendonStiffness):
            return None
        return stiffness.cables._replace(rest=read_only(self.rest_posture - self.posture.q))

    @property
    def closing_limits(self) -> Array | None:
        """Of a hand with motors of joints or of tendons."""
        limits, stiffness = self.posture.hand.torques, self.posture.hand.stiffness
        if not isinstance(stiffness, TendonStiffness):
            return None if limits.drives is None else limits.closing_limits
        if limits.drives is None and stiffness.drives is None:
            return None
        return read_only(np.append(limits.closing_limits, stiffness.closing_tensions))

    def closing_reasons(self, beyond: Iterable[FailureMode]) -> Iterator[Reason]:
        """Of its motors."""
        from handlcp.hand.torque_check import JOINT_EFFORT, TENDON_EFFORT, closing_reasons

        hand, all_of_them = self.posture.hand, tuple(beyond)
        if (drives := hand.torques.drives) is not None:
            yield from closing_reasons(JOINT_EFFORT, self.names, all_of_them, drives, hand.sliding)
        if isinstance(hand.stiffness, TendonStiffness) and (drives := hand.stiffness.drives) is not None:
            yield from closing_reasons(TENDON_EFFORT, hand.stiffness.cables.names, all_of_them, drives)

    def tension_reasons(self, tension: Array) -> Iterator[Reason]:
        """Of its tendons."""
        from handlcp.hand.torque_check import tension_reasons

        if isinstance(stiffness := self.posture.hand.stiffness, TendonStiffness):
            yield from tension_reasons(stiffness, tension)

    def motor_pull(self, spec: GraspSpec, torque: Array) -> tuple[MotorPull, Array] | None:
        """What a closing torque asked of the joints, and the shares of it with which they pull, (nv,), where their
        springs pull with torque (nv,) [N·m]; None: they are commanded otherwise.
        """
        command, closed, hand = find_command(spec.effects), getattr(spec.asked, "closed", None), self.posture.hand
        if command is None or closed is None or closed.torque is None or (command.command != closed.command).any():
            return None
        found = MotorPull.from_torque(closed.torque, hand.moving_joints[list(self.tips)], hand.stiffness)
        return found, found.torque_shares(torque, command.motor_offset)

    def pulling_reasons(self, spec: GraspSpec, torque: Array) -> Iterator[Reason]:
        """Of a closing torque."""
        if (found := self.motor_pull(spec, torque)) is not None:
            yield from motor_pull_reasons(self.names, *found, spec.asked.closed.stuck, self.posture.hand.sliding)

    def regrip_shifted(self, spec: GraspSpec, shift: Array) -> GraspSpec | None:
        """The hand closes anew on its object, moved by shift (3,) [m]. None beside a command of the joints, which would
        be another one there.
        """
        from handlcp.hand.closing import close_fingertips

        if self.has_command(spec) or self.target is None or spec.plane is not None or spec.of_hand < spec.n:
            return None
        place, hand = self.target.placement, self.posture.hand
        obj = self.target.moved_to(pin.SE3(place.rotation, place.translation + shift))
        try:
            posture = type(self.posture)(hand, close_fingertips(hand, obj, fingers=self.fingertips))
            contacts, gaps = detect_tip_contacts(posture, self.tips, obj, [c.friction for c in spec.contacts], 1e-3)
        except InputError:
            return None
        positions, frames = np.array([c.position for c in contacts]), np.array([c.rotation for c in contacts])
        made = make_hand_mechanism(
            posture, self.tips, read_only(positions), read_only(frames), obj, self.gravity, self.stand_off
        )
        return spec.replace(
            contacts=contacts, positions=made.positions, frames=made.frames, mechanism=made,
            flexibility=finger_flexibility(made), reference=read_only(spec.reference + shift),
            offset=read_only(spec.offset + np.outer(gaps, (0.0, 0.0, 1.0))),
        )  # fmt: skip

    def move_object_out(self, spec: GraspSpec) -> tuple[str, float, GraspSpec] | None:
        """Of links of the hand, which closes anew."""
        from handlcp.hand.squeeze import move_out_of_link

        return move_out_of_link(spec)

    def with_softer_pad(self, contact: int, more: float) -> Self:
        """Of the fingertip that touches there; a loading that is followed asks its pad."""
        if contact >= len(self.tips):
            return self
        hand = self.posture.hand
        blocks = hand.pads.blocks.copy()
        blocks[self.tips[contact]] += more * np.eye(3)
        made = hand.with_parts(pads=FingertipPads(blocks))
        return replace(self, posture=type(self.posture)(made, self.posture.q))

    def with_stiffness_factor(self, factor: float) -> Self:
        """The same hand in the same posture, with springs that are so many times as stiff."""
        hand = self.posture.hand.scale_stiffness(factor)
        return replace(self, root=hand.stiffness.root, posture=type(self.posture)(hand, self.posture.q))

    @property
    def has_joint_springs(self) -> bool:
        """Not of a transmission."""
        return not self.posture.hand.stiffness.law[1]

    def with_torque_limits(self, spec: GraspSpec, limits: Array) -> GraspSpec:
        """Of the same hand in the same posture; all limits count as known."""
        hand = self.posture.hand.limited(TorqueLimits(read_only(limits), (True,) * len(self.names), self.names))
        made = replace(self, limits=hand.torques.limits, posture=type(self.posture)(hand, self.posture.q))
        asked = None if spec.asked is None else with_changes(spec.asked, {"state": made.posture})
        return spec.replace(mechanism=made, asked=asked)

    def has_command(self, spec: GraspSpec) -> bool:
        """By a squeeze, a grip force or a joint offset."""
        return find_command(spec.effects) is not None

    def regrip(self, spec: GraspSpec) -> GraspSpec:
        """A grip force stays the force that it is."""
        from handlcp.hand.squeeze import apply_grip_force

        command = find_command(spec.effects)
        reach = None if command is None else command.reach
        return spec if reach is None or reach.unit != "N" else apply_grip_force(spec, reach.asked)

    @property
    def object_mass(self) -> float:
        """As it was given."""
        return 0.0 if self.target is None else self.target.mass

    def with_object_mass(self, mass: float) -> Self:
        """Held in the same way."""
        return self if self.target is None else replace(self, target=self.target.weighing(mass))

    def with_load(self, spec: GraspSpec, load: Array) -> GraspSpec:
        """As `replace(load=…)` makes it."""
        whole = total_load(load, spec.reference, self.target, self.gravity, spec.positions, spec.plane)
        asked = None if spec.asked is None else with_changes(spec.asked, {"load": None, "wrench": load})
        return replace_load(spec, whole, asked)

    def place_reasons(self, posture: HandPosture | None, obj: Object | None, when: str) -> Iterator[Reason]:
        """Of a posture, with the object there; None: not known."""
        from handlcp.geometry.link_penetration import posture_reasons

        if posture is not None:
            yield from posture_reasons(posture, obj, self.tips, when)

    def find_links_inside(self, q: Array, pose: Any) -> tuple[set[str], str]:
        """By distances of their collision geometry."""
        from handlcp.geometry.link_penetration import find_impossible_links

        posture, obj = self.place_at(q, pose)
        return (set(), "") if obj is None else find_impossible_links(posture, obj, self.tips)

    def move_contacts(self, posture: HandPosture, positions: Array, frames: Array) -> HandMechanism:
        """The same fingers in another posture, with contacts of all fingers elsewhere, as in `make_hand_mechanism`."""
        made = make_hand_mechanism(posture, self.tips, positions, frames, self.target, self.gravity, self.stand_off)
        still = len(self.jacobian) // 3 - len(self.tips)
        return replace(made, rest_posture=self.rest_posture).with_environment(still)

    def with_environment(self, environment: int) -> HandMechanism:
        """The same with so many contacts of the environment, which no joint moves."""
        still = np.zeros((3 * environment, len(self.names)))
        return replace(self, jacobian=read_only(np.concatenate([self.jacobian, still]))) if environment else self

    def solution_fields(
        self, scene: Scene, effects: tuple[Effect, ...], forces: Array, torsion: Array | None, extra: dict[str, Array]
    ) -> dict[str, Any]:
        """As `HandGraspSolution` has it."""
        joints = self.joints(scene, effects, forces, torsion, extra)
        total = read_only(joints.torque)
        return {
            "torques": total, "joint_deflection": read_only(joints.deflection),
            "joint_yield": read_only(joints.yielded), "torque_check": self._check(total, joints.yielded),
            "effort": self._effort(total, effects),
        }  # fmt: skip

    def _effort(self, torque: Array, effects: tuple[Effect, ...]) -> Effort | None:
        """What tendons or synergies do for torques (nv,), or what is known of it from a path."""
        stiffness, command = self.posture.hand.stiffness, find_command(effects)
        if isinstance(stiffness, TendonStiffness) and command is not None and command.tension is not None:
            return stiffness.tension_effort(command.tension)
        return stiffness.effort(torque, self.command_from_rest(effects))

    def command_from_rest(self, effects: Iterable[Effect]) -> Array:
        """(nv,) from where the joints' own springs are at rest to where the joints are commanded [rad, m]."""
        return np.asarray(self.posture.q - self.rest_posture + commanded_offset(effects, len(self.names)))

    def _check(self, torque: Array, yielded: Array) -> TorqueCheck:
        from handlcp.hand.torque_check import torque_check

        hand, limits, yielding = self.posture.hand, self.posture.hand.torques, tuple[str, ...]()
        if yielded.any():  # NaN without an answer
            yielding = tuple([self.names[k] for k in np.flatnonzero(abs(yielded) > 0.0)])
        drives = limits.drives
        return torque_check(self.names, read_only(torque), limits.limits, limits.known, yielding, hand.sliding, drives)


def hand_mechanism(spec: GraspSpec) -> HandMechanism:
    """The hand of a hand's grasp."""
    assert isinstance(spec.mechanism, HandMechanism)
    return spec.mechanism


def make_hand_mechanism(
    posture: HandPosture, tips: tuple[int, ...], positions: Array, frames: Array, target: Object | None, gravity: Array,
    stand_off: Array,
) -> HandMechanism:  # fmt: skip
    """Of fingers whose contacts are at positions (k, 3) with frames (k, 3, 3)."""
    hand, k = posture.hand, len(tips)
    jacobian = (frames.transpose(0, 2, 1) @ posture.jacobian_at(positions, tips)).reshape(3 * k, hand.nv)
    return HandMechanism(
        hand.joint_names, read_only(jacobian), hand.stiffness.root, hand.torques.limits, posture, tips, positions,
        frames, target, gravity, stand_off, posture.q,
    )  # fmt: skip


def finger_flexibility(mechanism: HandMechanism) -> Array:
    """(3k, 3k) E = J K⁻¹ Jᵀ + pads of the fingers, contact axes [m/N]."""
    return read_only(tip_flexibility(*flexibility_factor(mechanism)))


def flexibility_factor(mechanism: HandMechanism) -> FlexibilityFactor:
    """The same as a factor."""
    posture, tips, axes = mechanism.posture, mechanism.tips, mechanism.frames.transpose(0, 2, 1)
    pads = posture.hand.pads.rotate_blocks(lambda: axes @ posture.tip_rotations[list(tips)], tips)
    return FlexibilityFactor(mechanism.jacobian, mechanism.root, pads)


def stored_flexibility(mechanism: HandMechanism) -> Array | Flexibility:
    """E of the fingers as a grasp keeps it: with many contacts the factor, which solves are faster with."""
    if len(mechanism.tips) >= MANY_CONTACTS:
        return Flexibility.from_factor(flexibility_factor(mechanism))
    return finger_flexibility(mechanism)
