"""`GraspRequest`: the arguments of `state.grasp`, and the specification made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.check import Array, check_array, check_flag, check_keys, check_number, check_sequence, read_only
from handlcp.contact.friction import Coulomb, as_law, laws_by_name
from handlcp.errors import InputError, NotReached
from handlcp.geometry.contact_detection import detect_tip_contacts
from handlcp.geometry.link_contacts import TIPS_ONLY, expand_link_values, touch_with_links
from handlcp.geometry.mesh import MESH_ADVICE, is_mesh_in_memory
from handlcp.geometry.object import Object, choose_reference, total_load
from handlcp.geometry.shape import check_contact_metres, check_object_kilograms, check_object_metres
from handlcp.geometry.table import read_environment
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.effects.joint_torque import FingerWeight
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import MANY_CONTACTS, Contact
from handlcp.grasp.model.flexibility import Flexibility, flexibility_matrix
from handlcp.grasp.model.request import (
    GraspSpec,
    Request,
    environment_of,
    hand_offset,
    join_contacts,
    join_flexibilities,
    join_offsets,
    replace_friction,
    to_spec,
    with_changes,
)
from handlcp.hand.closing import bending_rates
from handlcp.hand.mechanism import HandMechanism, hand_mechanism, make_hand_mechanism
from handlcp.hand.squeeze import (
    COMMAND_ARGUMENTS,
    apply_command,
    overlap_depths,
    tip_motions_by_joint,
)
from handlcp.hand.torque_closing import (
    ClosedPosture,
    close_by_torque,
    command_closing_torque,
    follow_torque_closing,
    read_closing_torques,
    start_open,
)
from handlcp.robot.hand_model import DEFAULT_GRAVITY, HandPosture, read_gravity

DEFAULT_FRICTION = Coulomb(0.6)  # of contacts with an object
MAX_TOUCHING_GAP = 1e-3  # [m] no farther from the object, a fingertip or a link touches it
MAX_CLOSING_GAP = 1e-2  # [m] no farther, a link may come to touch while joints close or the load grows

_COMMAND_UNITS = {
    "grip_force": ("grip force", "N"),
    "closing_torque": ("closing torque", "N·m"),
    "joint_offset": ("joint offset", ""),
}
_WEIGHT_ARGUMENTS = ("object", "mass", "gravity")
_LOAD_ARGUMENTS = frozenset({"wrench", "load", "mass", "gravity"})  # come once the hand has closed
_CONTACT_ARGUMENTS = ("object", "fingers", "max_gap", "links")  # what makes the fingertips look for the object anew

FingerContacts = tuple[tuple[int, ...], tuple[Contact, ...], Array]


@dataclass(frozen=True, eq=False)
class GraspRequest(Request):
    """The arguments of `state.grasp`, and what `replace` alone can say.

    flexibility : of the fingers, in place of the hand's own; None: that. load : the whole load, in place of wrench and
    weight; None: these. found : contacts and offsets (k, 3) of the fingers as they are, in place of a detection.
    inside : (k,) [m] how far fingertips count as inside the object; None: as detected. bare : the posture of the hand
    itself, where `state` is that of a hand whose fingertips are the places on its links that touch; None: not yet
    looked for, or fingertips alone touch. closed : how it came to touch there; None: it was asked for there.
    """

    state: HandPosture
    target: Any
    friction: Any = None
    wrench: Any = None
    gravity: Any = DEFAULT_GRAVITY
    preload: Any = 0.0
    offset: Any = None
    reference: Any = None
    fingers: Any = None
    max_gap: Any = None
    effects: Any = ()
    finger_weight: Any = False
    plane: Any = None
    squeeze: Any = None
    grip_force: Any = None
    joint_offset: Any = None
    environment: Any = None
    links: Any = TIPS_ONLY
    closing_torque: Any = None
    hold_object: Any = False
    flexibility: Any = None
    load: Any = None
    found: tuple[tuple[Contact, ...], Array] | None = None
    inside: Array | None = None
    bare: HandPosture | None = None
    closed: ClosedPosture | None = None

    def spec(self) -> GraspSpec:
        """The specification that these arguments make. Raises NotReached, UnknownName, InputError."""
        made = self.spec_at_touch()
        closed = made.asked.closed
        if closed is None or closed.is_command_final:
            return made
        tight, stuck = follow_torque_closing(made, closed.torque)
        command = find_command(tight.effects)
        if command is not None:
            closed = replace(closed, command=command.command, against=command.friction_offset)
        return tight.replace(asked=replace(made.asked, closed=replace(closed, is_command_final=True, stuck=stuck)))

    def spec_at_touch(self) -> GraspSpec:
        """The same, with motors that have only begun to turn on where links touch."""
        obj = self.target if isinstance(self.target, Object) else None
        if len(said := [name for name in COMMAND_ARGUMENTS if getattr(self, name) is not None]) > 1:
            expected = f"at most one of {', '.join(COMMAND_ARGUMENTS[:-1])} and {COMMAND_ARGUMENTS[-1]}"
            raise InputError(said[1], expected, " and ".join(said))
        if self.bare is None and not (isinstance(self.links, str) and self.links == TIPS_ONLY):
            return self._with_link_contacts(obj).spec_at_touch()
        closed = self._find_closing(obj)
        offset = self.joint_offset if closed is None else closed.command
        weighed = self.finger_weight
        if not (isinstance(weighed, bool) or (isinstance(weighed, str) and weighed == "torques")):
            raise InputError("finger_weight", 'True, False or "torques"', repr(weighed))
        tips, contacts, gaps = self._finger_contacts(obj)
        k, around = len(contacts), None if self.environment is None else read_environment(self.environment, obj)
        contacts = join_contacts(contacts, around)
        positions, frames, normal = validate.positions_and_frames(self.plane, contacts)
        positions, frames, planar = read_only(positions), read_only(frames), normal is not None
        g = read_gravity(self.gravity)
        mechanism = make_hand_mechanism(self.state, tips, positions[:k], frames[:k], obj, g)
        if self.flexibility is not None:
            E: Any = validate.flexibility(flexibility_matrix(self.flexibility), k, planar)
        elif k >= MANY_CONTACTS:  # solves are faster with the factor
            E = Flexibility.from_factor(mechanism.flexibility_factor())
        else:
            E = mechanism.flexibility()
        if self.found is not None:
            mechanism = replace(mechanism, stand_off=self.found[1])
        elif obj is not None:
            mechanism = _with_gaps(mechanism, gaps, planar, self.inside)
        d = join_offsets(self.offset, self.preload, k, around).copy()
        d[:k] += mechanism.stand_off
        if around is not None:
            mechanism = mechanism.with_environment(len(around.contacts))
            E = join_flexibilities(flexibility_matrix(E), around.flexibility)
        point = choose_reference(self.reference, obj, positions, normal)
        if self.load is None:
            load = total_load(self.wrench, point, obj, g, positions, normal)
        else:
            load = validate.wrench(self.load, normal, validate.height_above(positions, point, normal))
        weight = (FingerWeight(read_only(self.state.gravity_torque(g)), weighed is True),) if weighed else ()
        spec = GraspSpec(
            contacts, positions, frames, normal, None if around is None else k, mechanism, load, point, E,
            read_only(d), weight,
        )  # fmt: skip
        spec = apply_command(to_spec(spec, self.effects), self.squeeze, self.grip_force, offset)
        keeps = check_flag("hold_object", self.hold_object)
        return start_open(spec, closed, keeps).replace(asked=replace(self, closed=closed))

    @classmethod
    def from_spec(cls, spec: GraspSpec) -> Self:
        """Arguments that make a grasp of which its specification alone is known: its contacts stay where they are."""
        mechanism = hand_mechanism(spec)
        k, tips = spec.of_hand, mechanism.fingertips
        weight = next((e for e in spec.effects if isinstance(e, FingerWeight)), None)
        command = find_command(spec.effects)
        offset, E = hand_offset(spec.offset, k).copy(), spec.flexibility[: 3 * k, : 3 * k]
        offset[:k] -= mechanism.stand_off
        own = replace(mechanism, jacobian=mechanism.jacobian[: 3 * k])
        contacts, target = spec.contacts[:k], mechanism.target
        laws = None if target is None else {tip: c.friction for tip, c in zip(tips, contacts, strict=True)}
        closed = None
        if command is not None:
            closed = ClosedPosture(mechanism.posture.q, command.opened, command.command, command.friction_offset)
        return cls(
            mechanism.posture, target or dict(zip(tips, contacts, strict=True)), laws, gravity=mechanism.gravity,
            offset=offset, reference=spec.reference, fingers=tips, effects=[e for e in spec.effects if e.by_name],
            finger_weight=False if weight is None else True if weight.sags else "torques",
            plane=None if contacts[0].planar else spec.plane, environment=environment_of(spec),
            joint_offset=None if command is None else command.command,
            hold_object=command is not None and command.keeps,
            closed=closed,
            flexibility=None if np.allclose(E, own.flexibility(), rtol=1e-12, atol=0.0) else E, load=spec.wrench,
            found=(contacts, mechanism.stand_off),
        )  # fmt: skip

    def with_values(self, spec: GraspSpec, given: dict[str, Any]) -> Self:
        changes = self._change_load(spec, given)
        if set(given) == {"load"}:
            return with_changes(self, changes)
        moved = any(name in given for name in _CONTACT_ARGUMENTS)
        commanded = any(name in given for name in COMMAND_ARGUMENTS)
        if commanded:  # one takes the place of another
            changes = dict.fromkeys(COMMAND_ARGUMENTS) | {"closed": None} | changes
        if moved:
            changes["found"] = None
        if self.bare is not None and (moved or commanded):  # the hand closes anew
            changes |= {"state": self.bare, "bare": None, "closed": None, "found": None}
        closed = changes.get("closed", self.closed)
        if closed is not None and closed.torque is not None and not set(given) <= _LOAD_ARGUMENTS:
            hand = hand_mechanism(spec).posture.hand
            changes["closed"] = command_closing_torque(hand, closed.q, closed.opened, closed.torque)
        changes["target"] = self._change_target(spec, given)
        changes |= self._change_friction(spec, changes)
        return with_changes(self, {name: x for name, x in changes.items() if name not in ("object", "mass")})

    def _change_load(self, spec: GraspSpec, given: dict[str, Any]) -> dict[str, Any]:
        """The changes with what they say of the load: a wrench is the whole of it; a load, and a weight, are parts."""
        weighing = [name for name in _WEIGHT_ARGUMENTS if name in given]
        if "wrench" in given and "load" in given:
            besides = "load is what comes besides the weight"
            expected = f"None beside load: wrench is the whole load, weight included; {besides}"
            raise InputError("wrench", expected, repr(given["wrench"])[:80])
        if "wrench" in given and weighing:
            expected = f"None beside {weighing[0]}: it is the whole load, weight included (load= is besides the weight)"
            raise InputError("wrench", expected, repr(given["wrench"])[:80])
        if "wrench" in given:
            return given | {"load": given["wrench"], "wrench": None}
        if "load" in given:
            shapes = ((6,),) if spec.plane is None else ((6,), (3,))
            wrench = check_array("load", given["load"], *shapes, what=validate.WRENCH_EXPECTED)
            return given | {"load": None, "wrench": wrench}
        if weighing and self.load is not None:
            return given | {"load": None, "wrench": spec.wrench - hand_mechanism(spec).weight_of_object(spec.reference)}
        return dict(given)

    def _change_target(self, spec: GraspSpec, given: dict[str, Any]) -> Any:
        """The object, or the contacts by fingertip where these are chosen anew."""
        target = given.get("object", self.target)
        if "mass" in given:
            if not isinstance(target, Object):
                expected = "None where contacts are given: they have no weight, and wrench says the load"
                raise InputError("mass", expected, repr(given["mass"])[:80])
            return target.weighing(given["mass"])
        if isinstance(target, (Object, Mapping)) or "object" in given or not {"fingers", "friction"} & set(given):
            return target
        # A sequence; the environment's come last
        return dict(zip(hand_mechanism(spec).fingertips, spec.contacts, strict=False))

    def _change_friction(self, spec: GraspSpec, changes: dict[str, Any]) -> dict[str, Any]:
        """What friction becomes; fingers that a mapping does not name keep theirs."""
        mechanism, target = hand_mechanism(spec), changes["target"]
        names = mechanism.fingertips
        old = [c.friction for c in spec.contacts[: len(names)]]
        hand = mechanism.posture.hand
        here = {hand.fingertips[i] for i in hand.tip_numbers("fingers", changes.get("fingers", self.fingers))}
        if "friction" not in changes:
            if "object" in changes and not isinstance(target, Object):
                return {"friction": None}  # contacts bring their own
            if isinstance(self.friction, Mapping):
                left_out = set(hand.fingertips) - here
                return {"friction": {name: law for name, law in self.friction.items() if name not in left_out}}
            return {}
        asked_for = changes["friction"]
        found = changes.get("found", self.found)
        if found is None and (isinstance(target, Object) or "object" in changes):
            if isinstance(asked_for, Mapping) and isinstance(self.target, Object):
                links = mechanism.report.links  # what is said of a link is said of all its contacts
                kept = [name for name in names if name in here and links.get(name) not in asked_for]
                laws = dict(zip(names, old, strict=True))
                return {"friction": {name: laws[name] for name in kept} | dict(asked_for)}
            return {}
        pairs = zip(spec.contacts, laws_by_name(asked_for, names, old), strict=False)
        contacts = tuple([replace_friction(c, law) for c, law in pairs])
        if found is not None:
            turned = [new.rotation.T @ c.rotation for new, c in zip(contacts, found[0], strict=True)]
            stand_off = read_only(np.array([R @ d for R, d in zip(turned, found[1], strict=True)]))
            return {"friction": None, "found": (contacts, stand_off)}
        return {"friction": None, "target": dict(target) | dict(zip(names, contacts, strict=True))}

    def whole_load(self, spec: GraspSpec) -> Any:
        if self.load is not None:
            return self.load
        mechanism = hand_mechanism(spec)
        return total_load(self.wrench, spec.reference, mechanism.target, mechanism.gravity, spec.positions, spec.plane)

    def scale_command(self, factor: float) -> tuple[str, str, GraspSpec] | None:
        """So many times the command in words, and the grasp with it; None: a squeeze, said by depth, or no command."""
        name = next((name for name in _COMMAND_UNITS if getattr(self, name) is not None), None)
        if name is None:
            return None
        value, (what, unit) = getattr(self, name), _COMMAND_UNITS[name]
        text = f"{words.format_percent(factor)} of the {what}"
        if isinstance(value, Mapping):
            value = {who: factor * np.asarray(size, dtype=float) for who, size in value.items()}
        else:
            value = factor * np.asarray(value, dtype=float)
        if isinstance(value, np.ndarray) and value.ndim == 0:
            text = f"a {what} of {float(value):.3g} {unit}"
        else:
            text += _format_range(value, unit)
        return what, text, self._rebuild_with({name: value})

    def move_object(self, shift: Array) -> GraspSpec:
        """The grasp of the object moved by shift (3,) [m]; the hand closes anew. Raises InputError, NotReached."""
        place = self.target.placement
        moved = self.target.moved_to(type(place)(place.rotation, place.translation + shift))
        return self._rebuild_with({"target": moved})

    def _rebuild_with(self, changes: dict[str, Any]) -> GraspSpec:
        """With other arguments, for which the hand closes anew."""
        anew = {} if self.bare is None else {"state": self.bare, "bare": None, "found": None}
        return with_changes(self, {"closed": None, **changes, **anew}).spec()

    def _find_closing(self, obj: Object | None) -> ClosedPosture | None:
        """How the hand has closed, where that was asked for."""
        if self.closed is not None or self.closing_torque is None:
            return self.closed
        if obj is None:
            expected = "None where contacts are given: joint_offset, or grip_force"
            raise InputError("closing_torque", expected, repr(self.closing_torque)[:80])
        way = bending_rates(self.state.hand, self.state.q, obj)
        torque = read_closing_torques(self.state.hand, way, self.closing_torque)
        return command_closing_torque(self.state.hand, self.state.q, None, torque)

    def _with_link_contacts(self, obj: Object | None) -> GraspRequest:
        """The same asked of the hand whose fingertips are the places that touch."""
        if obj is None:
            expected = '"tips" where contacts are given (they are found on links where an object is given)'
            raise InputError("links", expected, repr(self.links)[:80])
        if self.fingers is not None:
            raise InputError("fingers", "None beside links, which says what touches", repr(self.fingers)[:80])
        check_object_metres("target", obj, self.state.tip_positions)
        check_object_kilograms("target.mass", obj, self.state.hand.mass)
        closed, state = None, self.state
        if self._has_joint_command:
            closed = close_by_torque(state, obj, self.joint_offset, self.closing_torque)
            state = type(state)(state.hand, closed.q)
        reach = self._touch_distance(MAX_CLOSING_GAP if self._has_joint_command else MAX_TOUCHING_GAP)
        return replace(self, state=touch_with_links(state, obj, self.links, reach), bare=self.state, closed=closed)

    def _touch_distance(self, unsaid: float) -> float:
        """[m] How far is still touching; `unsaid` where nothing is asked."""
        return unsaid if self.max_gap is None else check_number("max_gap", self.max_gap, minimum=0.0)

    @property
    def _has_joint_command(self) -> bool:
        """Whether joints are commanded, which go on where they meet nothing; other commands press on each contact."""
        return self.joint_offset is not None or self.closing_torque is not None

    def _finger_contacts(self, obj: Object | None) -> FingerContacts:
        """Numbers of the fingertips, their contacts, and their signed gaps (k,) [m]. Raises NotReached."""
        hand, friction = self.state.hand, self.friction
        if self.found is not None:
            contacts = self.found[0]
            return hand.tip_numbers("fingers", self.fingers), contacts, np.zeros(len(contacts))
        if obj is None:
            return self._read_contacts()
        # Of links, those farther away were left out
        reach = self._touch_distance(MAX_TOUCHING_GAP) if self.bare is None else np.inf
        tips = hand.tip_numbers("fingers", self.fingers)
        check_object_metres("target", obj, self.state.tip_positions)
        check_object_kilograms("target.mass", obj, hand.mass)
        names = [hand.fingertips[i] for i in tips]
        if isinstance(friction, Mapping):  # checked of those far away, too
            friction = {name: as_law(law, f"friction[{name!r}]") for name, law in friction.items()}
        given = DEFAULT_FRICTION if friction is None else expand_link_values("friction", friction, hand)
        laws = laws_by_name(given, names, [DEFAULT_FRICTION] * len(names))
        try:
            contacts, gaps = detect_tip_contacts(self.state, tips, obj, laws, reach)
        except NotReached as far:
            how = "links= closes an open hand first"
            if self.closing_torque is None:
                how = "hand.close_on(obj) closes the fingers on it where it is, hand.find_grasp(obj) looks for a place"
            expected = f"fingertips within max_gap = {reach * 1e3:g} mm of the object; {how}"
            raise NotReached("fingers", expected, far.gaps) from far
        return tips, contacts, gaps

    def _read_contacts(self) -> FingerContacts:
        """The same of contacts that were given, which bear the fingertips' names and just touch."""
        hand, target, fingers = self.state.hand, self.target, self.fingers
        if is_mesh_in_memory(target):
            raise InputError("target", MESH_ADVICE, repr(target)[:80])
        if self.friction is not None:
            raise InputError("friction", "None when contacts are given (each Contact has its own)", repr(self.friction))
        if isinstance(target, Mapping):
            if fingers is None:
                fingers = [name for name in hand.fingertips if name in target]
            check_keys("contacts", target, hand.fingertips, "a fingertip")
            tips = hand.tip_numbers("fingers", fingers)
            if missing := [name for name in fingers if name not in target]:
                raise InputError("contacts", f"a Contact for {', '.join(missing)}", f"only {sorted(target)}")
            contacts = validate.contacts(target[name] for name in fingers)
        else:
            expected = "an object (Box, Sphere, …), contacts, or a mapping of fingertips to contacts"
            given = check_sequence("target", target, expected)
            tips, contacts = hand.tip_numbers("fingers", fingers), validate.contacts(given)
        if len(contacts) != len(tips):
            names = ", ".join(hand.fingertips[i] for i in tips)
            raise InputError("contacts", f"{len(tips)}, one for each of {names}", f"{len(contacts)}")
        if not contacts[0].planar:
            where = np.array([c.position for c in contacts])
            check_contact_metres("contacts", where, self.state.tip_positions[list(tips)])
        named = tuple([c.with_name(hand.fingertips[i]) for c, i in zip(contacts, tips, strict=True)])
        return tips, named, read_only(np.zeros(len(tips)))


def _format_range(sizes: Any, unit: str) -> str:
    """Of numbers, or of a mapping to them, such as " (4.41 to 7 N)"; "" of none."""
    values = np.ravel(list(sizes.values()) if isinstance(sizes, Mapping) else sizes)
    if not len(values):
        return ""
    least, most = f"{values.min():.3g}", f"{values.max():.3g}"
    size = most if least == most else f"{least} to {most}"
    return f" ({size} {unit})" if unit else f" ({size})"


def _with_gaps(mechanism: HandMechanism, gaps: Array, planar: bool, inside: Array | None) -> HandMechanism:
    """With contacts that have these signed gaps (k,) [m]. A fingertip that overlaps the object was squeezed into it as
    `close_on` does it, joint by joint, sideways motion included: see `TipMotions.command_for_depth`. inside : (k,) [m]
    what counts as overlap; None: all but what is left of touching.
    """
    offset = np.outer(gaps, (0.0, 0.0, 1.0))
    if (inside := overlap_depths(gaps) if inside is None else inside).any():
        tips = tip_motions_by_joint(mechanism, planar)
        offset[:, :2] -= tips.tip_displacements(tips.command_for_depth(inside))[:, :2]
    return replace(mechanism, stand_off=read_only(offset))
