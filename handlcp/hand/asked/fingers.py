"""Which fingertips take part, and where they touch: detected on an object, or given."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from handlcp.check import Array, number, per_name, read_only
from handlcp.errors import InputError
from handlcp.grasp.friction import Coulomb, laws_by_name
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact
from handlcp.hand.objects.detect import touching
from handlcp.hand.objects.meshes import HOW_TO_MESH, in_memory
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import ask_for_metres, far_from
from handlcp.hand.robot.posture import Posture

DEFAULT = Coulomb(0.6)  # of contacts with an object


def found_on(
    state: Posture, obj: Object, friction: Any, fingers: Sequence[str] | None, max_gap: Any
) -> tuple[tuple[int, ...], tuple[Contact, ...], Array]:
    """Numbers of the fingertips, their contacts with an object, and the signed gaps (k,) [m]. Raises NotReached."""
    tips = state.hand.tip_numbers("fingers", fingers)
    ask_for_metres("target", obj, state.tip_positions)
    names = [state.hand.fingertips[i] for i in tips]
    laws = laws_by_name(DEFAULT if friction is None else friction, names, [DEFAULT] * len(names))
    contacts, gaps = touching(state, tips, obj, laws, number("max_gap", max_gap, minimum=0.0))
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
    elif not isinstance(target, Iterable) or isinstance(target, (str, bytes)):
        expected = "an object (Box, Sphere, …), contacts, or a mapping of fingertips to contacts"
        raise InputError("target", expected, repr(target))
    else:
        tips, contacts = hand.tip_numbers("fingers", fingers), validate.contacts(target)
    if len(contacts) != len(tips):
        names = ", ".join(hand.fingertips[i] for i in tips)
        raise InputError("contacts", f"{len(tips)}, one for each of {names}", f"{len(contacts)}")
    if not contacts[0].planar:
        far_from("contacts", np.array([c.position for c in contacts]), state.tip_positions[list(tips)])
    named = tuple([c.named(hand.fingertips[i]) for c, i in zip(contacts, tips, strict=True)])
    return tips, named, read_only(np.zeros(len(tips)))
