"""The arguments of `state.grasp`, and the specification made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from handlcp import words
from handlcp.check import Array, number, per_name, read_only, several, yes_or_no
from handlcp.errors import InputError, NotReached
from handlcp.grasp.assembly.asked import again, as_asked, fastened
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.joint_offset import command_of
from handlcp.grasp.friction import Coulomb, as_law, laws_by_name
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.environment import beside, offset_beside
from handlcp.grasp.model.flexibility import matrix_of
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.asked.closing import Closed, begun_open, closed_by, closing_torques, pulling
from handlcp.hand.asked.load import load_of, point_of
from handlcp.hand.asked.wound import wound
from handlcp.hand.command import commanded, one_command
from handlcp.hand.mechanism import HandMechanism, mechanism_of, own_flexibility
from handlcp.hand.objects.detect import touching
from handlcp.hand.objects.meshes import HOW_TO_MESH, in_memory
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import ask_for_kilograms, ask_for_metres, far_from
from handlcp.hand.objects.table import surrounding
from handlcp.hand.robot.posture import GRAVITY, Posture, read_gravity
from handlcp.hand.sites.sited import by_site, sited
from handlcp.hand.sites.touchers import TIPS
from handlcp.hand.sites.wrap import bending
from handlcp.hand.squeeze import joint_by_joint, overlaps

# ----------------------------------------------------------------
# Which fingertips take part, and where they touch: detected on an object, or given.

DEFAULT = Coulomb(0.6)  # of contacts with an object
TOUCHING = 1e-3  # [m] no farther from the object, a fingertip or a link touches it
CLOSING = 1e-2  # [m] no farther, a link may come to touch while joints close or the load grows


def found_on(
    state: Posture, obj: Object, friction: Any, fingers: Sequence[str] | None, max_gap: float
) -> tuple[tuple[int, ...], tuple[Contact, ...], Array]:
    """Numbers of the fingertips, their contacts with an object, and the signed gaps (k,) [m]. Raises NotReached."""
    tips = state.hand.tip_numbers("fingers", fingers)
    ask_for_metres("target", obj, state.tip_positions)
    ask_for_kilograms("target.mass", obj, state.hand.mass)
    names = [state.hand.fingertips[i] for i in tips]
    if isinstance(friction, Mapping):
        friction = {
            name: as_law(law, f"friction[{name!r}]") for name, law in friction.items()
        }  # of those far away, too
    laws = laws_by_name(
        DEFAULT if friction is None else by_site("friction", friction, state.hand), names, [DEFAULT] * len(names)
    )
    contacts, gaps = touching(state, tips, obj, laws, max_gap)
    return tips, contacts, gaps


def given_by(
    state: Posture, target: Any, friction: Any, fingers: Sequence[str] | None
) -> tuple[tuple[int, ...], tuple[Contact, ...], Array]:
    """Numbers of the fingertips and their contacts, which bear the fingertips' names and just touch."""
    hand = state.hand
    if in_memory(target):
        raise InputError("target", HOW_TO_MESH, repr(target)[:80])
    if friction is not None:
        raise InputError("friction", "None when contacts are given (each Contact has its own)", repr(friction))
    if isinstance(target, Mapping):
        if fingers is None:
            fingers = [name for name in hand.fingertips if name in target]
        per_name("contacts", target, hand.fingertips, "a fingertip")
        tips = hand.tip_numbers("fingers", fingers)
        if missing := [name for name in fingers if name not in target]:
            raise InputError("contacts", f"a Contact for {', '.join(missing)}", f"only {sorted(target)}")
        contacts = validate.contacts(target[name] for name in fingers)
    else:
        given = several(
            "target", target, "an object (Box, Sphere, …), contacts, or a mapping of fingertips to contacts"
        )
        tips, contacts = hand.tip_numbers("fingers", fingers), validate.contacts(given)
    if len(contacts) != len(tips):
        names = ", ".join(hand.fingertips[i] for i in tips)
        raise InputError("contacts", f"{len(tips)}, one for each of {names}", f"{len(contacts)}")
    if not contacts[0].planar:
        far_from("contacts", np.array([c.position for c in contacts]), state.tip_positions[list(tips)])
    named = tuple([c.named(hand.fingertips[i]) for c, i in zip(contacts, tips, strict=True)])
    return tips, named, read_only(np.zeros(len(tips)))


# ----------------------------------------------------------------

_BY_SIZE = {
    "grip_force": ("grip force", "N"), "closing_torque": ("closing torque", "N·m"),
    "joint_offset": ("joint offset", ""),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class HandAsked:
    """The arguments of `state.grasp`, and what `replace` alone can say.

    flexibility : of the fingers, in place of the hand's own; None: that. load : the whole load, in place of wrench and
    weight; None: these. found : contacts and offsets (k, 3) of the fingers as they are, in place of a detection.
    inside : (k,) [m] how far fingertips count as inside the object; None: as detected. bare : the posture of the hand
    itself, where `state` is that of a hand whose fingertips are the places on its links that touch; None: not yet
    looked for, or fingertips alone touch. closed : how it came to touch there; None: it was asked for there.
    """

    state: Posture
    target: Any
    friction: Any = None
    wrench: Any = None
    gravity: Any = GRAVITY
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
    links: Any = TIPS
    closing_torque: Any = None
    hold_object: Any = False
    flexibility: Any = None
    load: Any = None
    found: tuple[tuple[Contact, ...], Array] | None = None
    inside: Array | None = None
    bare: Posture | None = None
    closed: Closed | None = None

    def __post_init__(self) -> None:
        fastened(self)

    def spec(self) -> GraspSpec:
        """See `state.grasp`. Raises NotReached, UnknownName, InputError."""
        made = self.begun()
        closed = made.asked.closed
        if closed is None or closed.wound:
            return made
        tight, stuck = wound(made, closed.torque)
        command = command_of(tight.effects)
        if command is not None:
            closed = replace(closed, command=command.command, against=command.against)
        return tight.replace(asked=replace(made.asked, closed=replace(closed, wound=True, stuck=stuck)))

    def begun(self) -> GraspSpec:
        """The same, with motors that have only begun to turn on where links touch."""
        obj = self.target if isinstance(self.target, Object) else None
        one_command(
            squeeze=self.squeeze, grip_force=self.grip_force, joint_offset=self.joint_offset,
            closing_torque=self.closing_torque,
        )  # fmt: skip
        if self.bare is None and not (isinstance(self.links, str) and self.links == TIPS):
            return self._on_links(obj).begun()
        closed = self._closed(obj)
        offset = self.joint_offset if closed is None else closed.command
        weighed = _weight_given(self.finger_weight)
        tips, contacts, gaps = self._fingers(obj)
        k, around = len(contacts), None if self.environment is None else surrounding(self.environment, obj)
        if around is not None:
            contacts = validate.contacts((*contacts, *around.contacts))
        positions, frames, normal = validate.placed(self.plane, contacts)
        positions, frames, planar = read_only(positions), read_only(frames), normal is not None
        g = read_gravity(self.gravity)
        mechanism = mechanism_of(self.state, tips, positions[:k], frames[:k], obj, g, read_only(np.zeros((k, 3))))
        given = self.flexibility
        E = own_flexibility(mechanism) if given is None else validate.flexibility(matrix_of(given), k, planar)
        if self.found is not None:
            mechanism = replace(mechanism, stand_off=self.found[1])
        elif obj is not None:
            mechanism = _standing_off(mechanism, gaps, planar, self.inside)
        d = offset_beside(self.offset, self.preload, k, np.zeros((0, 3)) if around is None else around.offset).copy()
        d[:k] += mechanism.stand_off
        if around is not None:
            mechanism, E = mechanism.beside(len(around.contacts)), beside(matrix_of(E), around.flexibility)
        point = point_of(self.reference, obj, positions, normal)
        if self.load is None:
            load = load_of(self.wrench, point, obj, g, positions, normal)
        else:
            load = validate.wrench(self.load, normal, validate.lift(positions, point, normal))
        spec = GraspSpec(
            contacts, positions, frames, normal, None if around is None else k, mechanism, load, point, cast(Array, E),
            read_only(d), _weight(self.state, weighed, g),
        )  # fmt: skip
        spec = commanded(as_asked(spec, self.effects), self.squeeze, self.grip_force, offset)
        keeps = yes_or_no("hold_object", self.hold_object)
        return begun_open(spec, closed, keeps).replace(asked=replace(self, closed=closed))

    def harder(self, factor: float) -> tuple[str, str, GraspSpec] | None:
        """What says how hard the hand closes, so many times as much of it in words, and the grasp with that; None: a
        squeeze, which is said by depth, or nothing. Raises InputError, NotReached.
        """
        name = next((name for name in _BY_SIZE if getattr(self, name) is not None), None)
        if name is None:
            return None
        value, (what, unit) = getattr(self, name), _BY_SIZE[name]
        text = f"{words.percent(factor)} of the {what}"
        if isinstance(value, Mapping):
            value = {who: factor * np.asarray(size, dtype=float) for who, size in value.items()}
        else:
            value = factor * np.asarray(value, dtype=float)
        if isinstance(value, np.ndarray) and value.ndim == 0:
            text = f"a {what} of {float(value):.3g} {unit}"
        else:
            text += _from_to(value, unit)
        return what, text, self._anew({name: value})

    def moved(self, shift: Array) -> GraspSpec:
        """The grasp of the object moved by shift (3,) [m]; the hand closes anew. Raises InputError, NotReached."""
        place = self.target.placement
        return self._anew({"target": self.target.moved_to(type(place)(place.rotation, place.translation + shift))})

    def _anew(self, changes: dict[str, Any]) -> GraspSpec:
        """With other arguments, for which the hand closes anew."""
        anew = {} if self.bare is None else {"state": self.bare, "bare": None, "found": None}
        return cast(HandAsked, again(self, {"closed": None, **changes, **anew})).spec()

    def _closed(self, obj: Object | None) -> Closed | None:
        """How the hand has closed, where that was asked for."""
        if self.closed is not None or self.closing_torque is None:
            return self.closed
        if obj is None:
            expected = "None where contacts are given: joint_offset, or grip_force"
            raise InputError("closing_torque", expected, repr(self.closing_torque)[:80])
        way = bending(self.state.hand, self.state.q, obj)
        torque = closing_torques(self.state.hand, way, self.closing_torque)
        return pulling(self.state.hand, self.state.q, None, torque)

    def _on_links(self, obj: Object | None) -> HandAsked:
        """The same asked of the hand whose fingertips are the places that touch."""
        if obj is None:
            expected = '"tips" where contacts are given (they are found on links where an object is given)'
            raise InputError("links", expected, repr(self.links)[:80])
        if self.fingers is not None:
            raise InputError("fingers", "None beside links, which says what touches", repr(self.fingers)[:80])
        ask_for_metres("target", obj, self.state.tip_positions)
        ask_for_kilograms("target.mass", obj, self.state.hand.mass)
        closed, state = None, self.state
        if self._moves_far:
            closed = closed_by(state, obj, self.joint_offset, self.closing_torque)
            state = type(state)(state.hand, closed.q)
        reach = self._reach(CLOSING if self._moves_far else TOUCHING)
        return replace(self, state=sited(state, obj, self.links, reach), bare=self.state, closed=closed)

    def _reach(self, unsaid: float) -> float:
        """[m] How far is still touching; `unsaid` where nothing is asked."""
        return unsaid if self.max_gap is None else number("max_gap", self.max_gap, minimum=0.0)

    @property
    def _moves_far(self) -> bool:
        """Whether joints are commanded, which go on where they meet nothing; other commands press on each contact."""
        return self.joint_offset is not None or self.closing_torque is not None

    def _fingers(self, obj: Object | None) -> tuple[tuple[int, ...], tuple[Contact, ...], Array]:
        """Numbers of the fingertips, their contacts, and their gaps (k,) [m]."""
        if self.found is not None:
            contacts = self.found[0]
            return self.state.hand.tip_numbers("fingers", self.fingers), contacts, np.zeros(len(contacts))
        if obj is None:
            return given_by(self.state, self.target, self.friction, self.fingers)
        reach = self._reach(TOUCHING) if self.bare is None else np.inf  # those farther away were left out
        try:
            return found_on(self.state, obj, self.friction, self.fingers, reach)
        except NotReached as far:
            how = "links= closes an open hand first"
            if self.closing_torque is None:
                how = "hand.close_on(obj) closes the fingers on it where it is, hand.find_grasp(obj) looks for a place"
            expected = f"fingertips within max_gap = {reach * 1e3:g} mm of the object; {how}"
            raise NotReached("fingers", expected, far.gaps) from far


def _from_to(sizes: Any, unit: str) -> str:
    """Of numbers, or of a mapping to them, such as " (4.41 to 7 N)"; "" of none."""
    values = np.ravel(list(sizes.values()) if isinstance(sizes, Mapping) else sizes)
    if not len(values):
        return ""
    least, most = f"{values.min():.3g}", f"{values.max():.3g}"
    size = most if least == most else f"{least} to {most}"
    return f" ({size} {unit})" if unit else f" ({size})"


def _weight_given(value: Any) -> bool | str:
    """False, True or "torques". Raises InputError."""
    if isinstance(value, bool) or (isinstance(value, str) and value == "torques"):
        return value
    raise InputError("finger_weight", 'True, False or "torques"', repr(value))


def _weight(state: Posture, weighed: bool | str, gravity: Array) -> tuple[Effect, ...]:
    """The fingers' own weight, where it was asked for."""
    return (FingerWeight(read_only(state.gravity_torque(gravity)), weighed is True),) if weighed else ()


def _standing_off(mechanism: HandMechanism, gaps: Array, planar: bool, inside: Array | None) -> HandMechanism:
    """With contacts that have these signed gaps (k,) [m]. A fingertip that overlaps the object was squeezed into it as
    `close_on` does it, joint by joint, sideways motion included: see `TipMotions.deeper`. inside : (k,) [m] what counts
    as overlap; None: all but what is left of touching.
    """
    offset = np.outer(gaps, (0.0, 0.0, 1.0))
    if (inside := overlaps(gaps) if inside is None else inside).any():
        tips = joint_by_joint(mechanism, planar)
        offset[:, :2] -= tips.made(tips.deeper(inside))[:, :2]
    return replace(mechanism, stand_off=read_only(offset))
