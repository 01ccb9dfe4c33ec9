"""A hand's grasp made again with some of its arguments changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from handlcp.check import array, read_only
from handlcp.errors import InputError
from handlcp.grasp.assembly.asked import again, environment_of, of_hand_alone, rubbed, said, under
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.effects.joint_offset import command_of
from handlcp.grasp.friction import laws_by_name
from handlcp.grasp.model import validate
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.asked.asked import HandAsked
from handlcp.hand.asked.closing import Closed, pulling
from handlcp.hand.asked.load import load_of, weight_of
from handlcp.hand.command import COMMANDS
from handlcp.hand.mechanism import HandMechanism, finger_flexibility
from handlcp.hand.objects.object import Object

_WEIGH = ("object", "mass", "gravity")
_LOADS = frozenset({"wrench", "load", "mass", "gravity"})  # come once the hand has closed
_PLACE = ("object", "fingers", "max_gap", "links")  # what makes the fingertips look for the object anew


def hand_remade(spec: GraspSpec, given: dict[str, Any]) -> GraspSpec:
    """See `HandGrasp.replace`. Raises InputError, NotReached, UnknownName."""
    given = said(given)
    if not given:
        return spec
    mechanism = spec.mechanism
    assert isinstance(mechanism, HandMechanism)
    asked = spec.asked if isinstance(spec.asked, HandAsked) else _asked_of(spec, mechanism)
    changes = _load(asked, spec, mechanism, given)
    if set(given) == {"load"}:  # all else stays as it is, and is shared
        under_it: HandAsked = again(asked, changes)
        whole = load_of(
            under_it.wrench, spec.reference, mechanism.target, mechanism.gravity, spec.positions, spec.plane
        )  # fmt: skip
        return under(spec, whole, under_it)
    if any(name in given for name in COMMANDS):  # one takes the place of another
        changes = dict.fromkeys(COMMANDS) | {"closed": None} | changes
    if any(name in given for name in _PLACE):
        changes["found"] = None
    if asked.bare is not None and any(name in given for name in (*_PLACE, *COMMANDS)):  # the hand closes anew
        changes |= {"state": asked.bare, "bare": None, "closed": None, "found": None}
    closed = changes.get("closed", asked.closed)
    if closed is not None and closed.torque is not None and not set(given) <= _LOADS:
        changes["closed"] = pulling(mechanism.posture.hand, closed.q, closed.opened, closed.torque)
    changes["target"] = _target(asked, spec, mechanism, given)
    changes |= _friction(asked, spec, mechanism, changes)
    made: HandAsked = again(asked, {name: x for name, x in changes.items() if name not in ("object", "mass")})
    return under(spec, made.load, made) if set(given) == {"wrench"} else made.spec()


def _load(asked: HandAsked, spec: GraspSpec, mechanism: HandMechanism, given: dict[str, Any]) -> dict[str, Any]:
    """The changes with what they say of the load: a wrench is the whole of it; a load, and a weight, are parts."""
    weighing = [name for name in _WEIGH if name in given]
    if "wrench" in given and "load" in given:
        expected = "None beside load: wrench is the whole load, weight included; load is what comes besides the weight"
        raise InputError("wrench", expected, repr(given["wrench"])[:80])
    if "wrench" in given and weighing:
        expected = f"None beside {weighing[0]}: it is the whole load, weight included (load= is besides the weight)"
        raise InputError("wrench", expected, repr(given["wrench"])[:80])
    if "wrench" in given:
        return given | {"load": given["wrench"], "wrench": None}
    if "load" in given:
        shapes = ((6,),) if spec.plane is None else ((6,), (3,))
        return given | {"load": None, "wrench": array("load", given["load"], *shapes, what=validate.WRENCH)}
    if weighing and asked.load is not None:
        own = weight_of(mechanism.target, mechanism.gravity, spec.reference)
        return given | {"load": None, "wrench": spec.wrench - own}
    return dict(given)


def _target(asked: HandAsked, spec: GraspSpec, mechanism: HandMechanism, given: dict[str, Any]) -> Any:
    """The object, or the contacts by fingertip where these are chosen anew."""
    target = given.get("object", asked.target)
    if "mass" in given:
        if not isinstance(target, Object):
            expected = "None where contacts are given: they have no weight, and wrench says the load"
            raise InputError("mass", expected, repr(given["mass"])[:80])
        return target.weighing(given["mass"])
    if isinstance(target, (Object, Mapping)) or "object" in given or not {"fingers", "friction"} & set(given):
        return target
    return dict(zip(mechanism.fingertips, spec.contacts, strict=False))  # a sequence; the environment's come last


def _friction(asked: HandAsked, spec: GraspSpec, mechanism: HandMechanism, changes: dict[str, Any]) -> dict[str, Any]:
    """What friction becomes; fingers that a mapping does not name keep theirs."""
    target, names = changes["target"], mechanism.fingertips
    old = [c.friction for c in spec.contacts[: len(names)]]
    hand = mechanism.posture.hand
    here = {hand.fingertips[i] for i in hand.tip_numbers("fingers", changes.get("fingers", asked.fingers))}
    if "friction" not in changes:
        if "object" in changes and not isinstance(target, Object):
            return {"friction": None}  # contacts bring their own
        if isinstance(asked.friction, Mapping):
            left_out = set(hand.fingertips) - here
            return {"friction": {name: law for name, law in asked.friction.items() if name not in left_out}}
        return {}
    asked_for = changes["friction"]
    found = changes.get("found", asked.found)
    if found is None and (isinstance(target, Object) or "object" in changes):
        if isinstance(asked_for, Mapping) and isinstance(asked.target, Object):
            links = mechanism.links  # what is said of a link is said of all its contacts
            kept = {n: law for n, law in zip(names, old, strict=True) if n in here and links.get(n) not in asked_for}
            return {"friction": kept | dict(asked_for)}
        return {}
    laws = laws_by_name(asked_for, names, old)
    contacts = tuple([rubbed(c, law) for c, law in zip(spec.contacts, laws, strict=False)])
    if found is not None:
        turned = [new.rotation.T @ c.rotation for new, c in zip(contacts, found[0], strict=True)]
        stand_off = read_only(np.array([R @ d for R, d in zip(turned, found[1], strict=True)]))
        return {"friction": None, "found": (contacts, stand_off)}
    return {"friction": None, "target": dict(target) | dict(zip(names, contacts, strict=True))}


def _asked_of(spec: GraspSpec, mechanism: HandMechanism) -> HandAsked:
    """Arguments that make a grasp of which a specification alone is known: its contacts stay where they are."""
    k, tips = spec.of_hand, mechanism.fingertips
    weight = next((e for e in spec.effects if isinstance(e, FingerWeight)), None)
    command = command_of(spec.effects)
    offset, E = of_hand_alone(spec.offset, k).copy(), spec.flexibility[: 3 * k, : 3 * k]
    offset[:k] -= mechanism.stand_off
    own = replace(mechanism, jacobian=mechanism.jacobian[: 3 * k])
    contacts, target = spec.contacts[:k], mechanism.target
    laws = None if target is None else {tip: c.friction for tip, c in zip(tips, contacts, strict=True)}
    return HandAsked(
        mechanism.posture, target or dict(zip(tips, contacts, strict=True)), laws, gravity=mechanism.gravity,
        offset=offset, reference=spec.reference, fingers=tips, effects=[e for e in spec.effects if e.by_name],
        finger_weight=False if weight is None else True if weight.sags else "torques",
        plane=None if contacts[0].planar else spec.plane, environment=environment_of(spec),
        joint_offset=None if command is None else command.command,
        hold_object=command is not None and command.keeps,
        closed=None if command is None else Closed.by(mechanism.posture.q, command),
        flexibility=None if np.allclose(E, finger_flexibility(own), rtol=1e-12, atol=0.0) else E, load=spec.wrench,
        found=(contacts, mechanism.stand_off),
    )  # fmt: skip
