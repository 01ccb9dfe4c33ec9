"""`GraspVariation`: the grasp of a hand made again with another posture, other links, springs or limits.

A link's length is where its end is: the placement of the next joint in the frame of the one before, or of a fingertip
in the frame of the last joint. Its three coordinates are varied in Pinocchio's model; what it carries moves along.
That is all that derivatives take; a whole hand of other lengths, shapes and routes along, is made by `hand/vary`.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.actuation.joint_stiffness import FingertipPads
from handlcp.check import Array, Bools, read_only
from handlcp.errors import InputError
from handlcp.geometry.contact_detection import detect_tip_contacts
from handlcp.geometry.object import total_load
from handlcp.grasp.effects.joint_offset import OVERLAP_TOLERANCE, commanded_offset, find_command, replace_command
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model.request import GraspSpec, replace_load, with_changes
from handlcp.hand.closing import close_fingertips
from handlcp.hand.squeeze import apply_grip_force, overlap_depths, start_link_depths, tip_motions
from handlcp.robot.hand_model import HandModel, HandPosture
from handlcp.robot.joint import TorqueLimits
from handlcp.robot.kinematics import Kinematics
from handlcp.words import format_length

_MIN_NORMAL_SUM = 0.5  # of their number: normals whose sum is shorter say no way out


def lengthen_link(hand: HandModel, k: int, step: float) -> HandModel:
    """The hand with coordinate k of its lengths, three for each of `GraspVariation.lengths`, larger by a step [m]."""
    model, which, axis = hand.model, k // 3, k % 3
    joints = hand.kinematics.movable
    if which < len(joints):
        place = model.jointPlacements[model.getJointId(joints[which])]
    else:
        place = model.frames[hand.tips.frames[which - len(joints)]].placement
    place.translation[axis] += step
    made = copy(hand)
    made.__dict__["kinematics"] = Kinematics(model, hand.kinematics.facts)
    return made


def _add_spring(hand: HandModel, k: int, step: float) -> HandModel:
    """With a spring more at joint k: C' = C - C e eᵀ C / (1/step + C_kk), written as the square of its root."""
    made, springs, C = copy(hand), copy(hand.stiffness), hand.stiffness.contact_compliance(np.eye(hand.nv))
    if C[k, k] > 0.0:
        less, root = (1.0 - 1.0 / np.sqrt(1.0 + step * C[k, k])) / C[k, k], springs.compliance_factor
        springs.compliance_factor = read_only(root - less * np.outer(C[:, k], root[k]))
    made.__dict__["stiffness"] = springs
    return made


@dataclass(frozen=True, slots=True)
class GraspVariation:
    """Makes the grasp of a `HandMechanism` again, with something changed: posture, springs, limits, commands, …"""

    mechanism: Any

    def angular_jacobian(self) -> Array:
        """(n, 3, nv) how fast the joints turn the fingers of the contacts, world axes; zero for the environment's."""
        J = self.mechanism.posture.angular_jacobian(self.mechanism.tips)
        still = len(self.mechanism.jacobian) // 3 - len(self.mechanism.tips)
        return read_only(np.concatenate([J, np.zeros((still, *J.shape[1:]))]) if still else J)

    @property
    def lengths(self) -> tuple[str, ...]:
        """Names of joints and fingertips whose "lengths" `vary_parameter` counts, three (x, y, z) each."""
        return (*self.mechanism.posture.hand.kinematics.movable, *self.mechanism.posture.hand.fingertips)

    def vary_parameter(self, spec: GraspSpec, what: str, k: int, step: float, inside: Array | None = None) -> GraspSpec:
        """The grasp made again, as it was asked for, with the k-th "posture" [rad, m], "lengths" [m] or "stiffness"
        [N·m/rad] larger by a step. Contacts with an object are detected anew; those that were given stay.

        inside : (k,) [m] how far fingertips count as inside the object, in place of what is detected.
        Where nobody knows what was asked, contacts and commands of the joints stay.
        """
        hand, q = self.mechanism.posture.hand, self.mechanism.posture.q
        if what == "posture":
            q = q.copy()
            q[k] += step
        elif what == "stiffness":
            hand = _add_spring(hand, k, step)
        else:
            hand = lengthen_link(hand, k, step)
        posture = type(self.mechanism.posture)(hand, read_only(q))
        if hasattr(spec.asked, "state"):
            made: GraspSpec = replace(spec.asked, state=posture, inside=inside).spec()
            return made
        return _rebuild_in_posture(self.mechanism, spec, posture)

    def replace_contacts(self, spec: GraspSpec, positions: Array, frames: Array) -> GraspSpec:
        """The grasp with contacts at positions (n, 3), frames (n, 3, 3), and all that follows from where they are."""
        contacts = [  # whose own axes turn along
            c.from_arrays(p, read_only(R @ before.T @ c.rotation), c.friction, c.planar, c.name)
            for c, p, R, before in zip(spec.contacts, positions, frames, spec.frames, strict=True)
        ]
        moved = spec.replace(contacts=tuple(contacts), positions=positions, frames=frames, asked=spec.asked)
        return _rebuild_in_posture(self.mechanism, moved, self.mechanism.posture)

    def with_joint_shift(self, q: Array) -> Any:
        """The mechanism with joints q (nv,) [rad, m] farther than its posture has them; springs keep their rest."""
        return replace(self.mechanism, rest_posture=self.mechanism.rest_posture - q)

    def has_joint_flexibility(self, spec: GraspSpec) -> bool:
        """Whether the flexibility of a grasp is that of the joints and pads, and follows them: none was asked for."""
        return getattr(spec.asked, "flexibility", None) is None

    def inside_depths(self, spec: GraspSpec) -> tuple[Array, Bools] | None:
        """(k,) how far each fingertip counts as inside the object [m], and (k,) which ones just touch it. None where
        contacts were given, so that nothing counts as inside.
        """
        if self.mechanism.target is None or getattr(spec.asked, "found", ()) is not None:
            return None
        gaps = self.gaps()
        return overlap_depths(gaps), np.asarray(abs(gaps) <= OVERLAP_TOLERANCE)

    def gaps(self) -> Array:
        """(k,) gaps between fingertips and object as they were detected [m]; below 0 inside."""
        return np.asarray(self.mechanism.stand_off[:, 2])

    def with_squeeze(self, spec: GraspSpec, depth: float) -> GraspSpec:
        """The grasp with joints commanded on, so that all tips whose force is not prescribed go deeper by depth [m]."""
        more = np.zeros(spec.of_hand)
        more[spec.free_fingers] = depth
        command = commanded_offset(spec.effects, len(self.mechanism.names))
        command = command + tip_motions(self.mechanism, spec.planar).command_for_depth(more)
        return spec.replace(effects=replace_command(spec.effects, command))

    def with_squeeze_share(self, spec: GraspSpec, share: float) -> GraspSpec:
        """The grasp with this share of its squeeze, commands of the joints included."""
        offset, k = spec.offset.copy(), spec.of_hand
        offset[:k] *= np.where(offset[:k, 2:] < 0.0, share, 1.0)
        command = share * commanded_offset(spec.effects, len(self.mechanism.names))
        return spec.replace(offset=read_only(offset), effects=replace_command(spec.effects, command))

    def regrip(self, spec: GraspSpec) -> GraspSpec:
        """The grasp, whose springs have changed, with its command found anew where that is to press with a force."""
        command = find_command(spec.effects)
        reach = None if command is None else command.reach
        return spec if reach is None or reach.unit != "N" else apply_grip_force(spec, reach.asked)

    def regrip_shifted(self, spec: GraspSpec, shift: Array) -> GraspSpec | None:
        """The hand closes anew on its object, moved by shift (3,) [m]; None beside a command, another one there."""
        hand, target, laws = self.mechanism.posture.hand, self.mechanism.target, [c.friction for c in spec.contacts]
        if find_command(spec.effects) or target is None or spec.plane is not None or spec.of_hand < spec.n:
            return None
        place = target.placement
        obj = target.moved_to(pin.SE3(place.rotation, place.translation + shift))
        try:
            posture = type(self.mechanism.posture)(hand, close_fingertips(hand, obj, fingers=self.mechanism.fingertips))
            contacts, gaps = detect_tip_contacts(posture, self.mechanism.tips, obj, laws, 1e-3)
        except InputError:
            return None
        positions, frames = np.array([c.position for c in contacts]), np.array([c.rotation for c in contacts])
        made = replace(self.mechanism, target=obj).move_contacts(posture, read_only(positions), read_only(frames))
        made = replace(made, rest_posture=posture.q)
        reference, offset = spec.reference + shift, spec.offset + np.outer(gaps, (0.0, 0.0, 1.0))
        return spec.replace(
            contacts=contacts, positions=made.positions, frames=made.frames, mechanism=made,
            flexibility=made.flexibility(), reference=read_only(reference), offset=read_only(offset),
        )  # fmt: skip

    def move_object_out(self, spec: GraspSpec) -> tuple[str, float, GraspSpec] | None:
        """The words for the object moved out of the link that it begins deepest inside, along the normals there, by how
        much [m], and the grasp that the hand then closes to. None where it begins in none, lies on something, or the
        normals of that link face each other.
        """
        mechanism, depths = self.mechanism, start_link_depths(spec)
        moved = getattr(spec.asked, "move_object", None)
        if not depths or moved is None or spec.of_hand < spec.n:
            return None
        link, depth = next(iter(depths.items()))
        its = [mechanism.report.links[tip] == link for tip in mechanism.fingertips]
        way = mechanism.frames[its, :, 2].sum(axis=0)
        if (size := float(np.linalg.norm(way))) < _MIN_NORMAL_SUM * sum(its):
            return None
        try:
            grasp = moved((depth + OVERLAP_TOLERANCE) / size * way)
        except InputError:
            return None
        return f"the object {format_length(depth)} farther out of {link}", depth, grasp

    @property
    def has_joint_springs(self) -> bool:
        """Whether each joint has a spring that can change on its own: a transmission has none."""
        return not self.mechanism.posture.hand.stiffness.is_transmission

    def with_torque_limits(self, spec: GraspSpec, limits: Array) -> GraspSpec:
        """The same grasp with other torque limits (nv,) [N·m], inf for none; all count as known."""
        names = self.mechanism.names
        hand = self.mechanism.posture.hand.limited(TorqueLimits(read_only(limits), (True,) * len(names), names))
        made = self._with_hand(hand, limits=hand.torques.limits)
        asked = None if spec.asked is None else with_changes(spec.asked, {"state": made.posture})
        return spec.replace(mechanism=made, asked=asked)

    def with_softer_pad(self, contact: int, more: float) -> Any:
        """The mechanism with the pad of a contact's fingertip softer by so much along all axes [m/N]."""
        if contact >= len(self.mechanism.tips):
            return self.mechanism
        hand = self.mechanism.posture.hand
        blocks = hand.pads.blocks.copy()
        blocks[self.mechanism.tips[contact]] += more * np.eye(3)
        return self._with_hand(hand.with_parts(pads=FingertipPads(blocks)))

    def with_stiffness_factor(self, factor: float) -> Any:
        """The mechanism in the same posture, with joints that are so many times as stiff."""
        hand = self.mechanism.posture.hand.scale_stiffness(factor)
        return self._with_hand(hand, compliance_factor=hand.stiffness.compliance_factor)

    def _with_hand(self, hand: HandModel, **changes: Any) -> Any:
        """The mechanism of another hand in the same posture."""
        posture = type(self.mechanism.posture)(hand, self.mechanism.posture.q)
        return replace(self.mechanism, posture=posture, **changes)

    @property
    def object_mass(self) -> float:
        """Mass of the object [kg]; 0 where it is not known."""
        return 0.0 if self.mechanism.target is None else self.mechanism.target.mass

    def with_object_mass(self, mass: float) -> Any:
        """The mechanism holding an object of another mass [kg] in the same way."""
        target = self.mechanism.target
        return self.mechanism if target is None else replace(self.mechanism, target=target.weighing(mass))

    def with_load(self, spec: GraspSpec, load: Array) -> GraspSpec:
        """The grasp under a load (6,) beside the object's weight, about the reference [N, N·m]."""
        target, gravity = self.mechanism.target, self.mechanism.gravity
        whole = total_load(load, spec.reference, target, gravity, spec.positions, spec.plane)
        asked = None if spec.asked is None else with_changes(spec.asked, {"load": None, "wrench": load})
        return replace_load(spec, whole, asked)


def _rebuild_in_posture(before: Any, spec: GraspSpec, posture: HandPosture) -> GraspSpec:
    """The grasp with a `HandMechanism` in another posture, its flexibility and its fingers' weight."""
    k, E = spec.of_hand, spec.flexibility
    made = before.move_contacts(posture, spec.positions[:k], spec.frames[:k])
    if before.variation.has_joint_flexibility(spec):
        E = E.copy()
        E[: 3 * k, : 3 * k] = made.flexibility()[: 3 * k, : 3 * k]
    effects = tuple(
        replace(e, torque=read_only(posture.gravity_torque(made.gravity))) if isinstance(e, FingerWeight) else e
        for e in spec.effects
    )
    return spec.replace(mechanism=made, flexibility=read_only(E), effects=effects, asked=spec.asked)
