"""From a posture and an object, or contacts, to a hand's grasp."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

from handlcp.check import Array, array, number, per_name, read_only
from handlcp.errors import InputError
from handlcp.grasp.assembly.asked import as_asked
from handlcp.grasp.effects import Effect
from handlcp.grasp.effects.finger_weight import FingerWeight
from handlcp.grasp.friction import Coulomb, FrictionLaw, law_words
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.environment import beside
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import cross_rows
from handlcp.hand.command import commanded, standing_off
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.mechanism import finger_flexibility, mechanism_of
from handlcp.hand.objects.detect import touching
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.table import surrounding
from handlcp.hand.robot.posture import Posture

__all__ = ["WeightGiven", "make_grasp"]

_GRAVITY = (0.0, 0.0, -9.81)
_DOWN = array("gravity", _GRAVITY, (3,))

WeightGiven: TypeAlias = bool | Literal["torques"]


def make_grasp(
    state: Posture,
    target: Any,
    friction: Any = None,
    wrench: Any = None,
    gravity: Any = _GRAVITY,
    preload: Any = 0.0,
    *,
    offset: Any = None,
    reference: Any = None,
    fingers: Sequence[str] | None = None,
    max_gap: Any = 1e-3,
    effects: Iterable[Any] = (),
    finger_weight: WeightGiven = False,
    plane: Any = None,
    squeeze: Any = None,
    grip_force: Any = None,
    joint_offset: Any = None,
    environment: Any = None,
) -> HandGrasp:
    """The grasp of an object by a hand in a posture; as a method, `state.grasp(target, …)`.

    target : an object (Box, Sphere, Cylinder, Ellipsoid, Mesh): contacts, normals and gaps are detected. A fingertip
        that overlaps the object counts as squeezed by as much from a posture that touches. Or contacts, a sequence with
        one for each finger, or a mapping by fingertip name: each moves rigidly with its fingertip, and is taken as
        touching.
    friction : of all contacts with an object, or a mapping by fingertip name; None: Coulomb(0.6). Contacts bring
        their own.
    wrench : (6,) force [N] and torque [N·m] about `reference` on the object, besides its weight; None: none.
    gravity : (3,) [m/s²], world axes; weighs the object at its centre of mass, and the fingers when asked to.
    preload : [m] a number or (n,), squeeze of the normals whether or not the joints can make it: `out_of_reach` of the
        grasp says what they cannot. offset : (n, 3) [m], contact axes, as in `Grasp`. Both come beside a command.
    reference : (3,) [m], of wrench and object motion; None: the object's centre of mass, the origin for contacts.
    fingers : the fingertips that take part, in this order; None: all (those a mapping of contacts names).
    max_gap : [m] the farthest a fingertip may be from the object and still count as touching.
    effects, plane : as in `Grasp`; `TorqueSaturation()` lets joints at their limit yield, `GeometricStiffness()`
        lets the forces turn their own levers.
    finger_weight : True: the fingers' own weight is in the torques and in the elastic balance. The posture is then
        the one commanded: the joints sag from it by K⁻¹ g(q), and the tips with them, before the object is loaded.
        "torques": in the torques alone, for a posture that is measured: it has sagged already, and no offset applies.
    squeeze, grip_force, joint_offset : how hard the hand closes, at most one of them. Each commands the joints beyond
        the posture, by δq, which adds -J δq to the offsets; `out_of_reach` of the grasp says what joints cannot make.
        squeeze : [m] how much deeper than touching the tips are commanded along the normals, by the smallest δq, a gap
        or an overlap included: as `close_on` with that squeeze, the posture staying. A number ≥ 0, (n,), or a
        mapping by fingertip name (others: 0).
        grip_force : [N] normal force with which each tip would press on an object that stays where it is, and where it
        does not slip; otherwise likewise.
        joint_offset : (nv,) or a mapping by joint name (others: 0) [rad, m], δq itself.
    environment : a `Table`, an `Environment`, or several: what the object touches besides the fingers. Those contacts
        come last; friction, preload and offset above are the fingers', n of them.

    Raises NotReached (naming each finger and its gap, or a table), UnknownName, InputError.
    """
    weighed, obj = _weight_given(finger_weight), target if isinstance(target, Object) else None
    if obj is None:
        tips, contacts = _given(state, target, fingers, friction)
    else:
        tips = state.hand.tip_numbers("fingers", fingers)
        laws = _frictions(friction, [state.hand.fingertips[i] for i in tips])
        contacts, gaps = touching(state, tips, obj, laws, number("max_gap", max_gap, minimum=0.0))
    k, around = len(contacts), None if environment is None else surrounding(environment, obj)
    if around is not None:
        contacts = validate.contacts((*contacts, *around.contacts))
    positions, frames, normal = validate.placed(plane, contacts)
    positions, frames = read_only(positions), read_only(frames)
    g = _DOWN if gravity is _GRAVITY else array("gravity", gravity, (3,))
    mechanism = mechanism_of(state, tips, positions[:k], frames[:k], obj, g, read_only(np.zeros((k, 3))))
    flexibility, shift = finger_flexibility(mechanism), validate.offset(offset, preload, k)
    if obj is not None:
        mechanism = standing_off(mechanism, gaps, normal is not None)
        shift = shift + mechanism.stand_off
    if around is not None:
        mechanism = mechanism.beside(len(around.contacts))
        flexibility, shift = beside(flexibility, around.flexibility), np.concatenate([shift, around.offset])
    load, point = _load(wrench, reference, obj, g, positions, normal)
    spec = GraspSpec(
        contacts, positions, frames, normal, None if around is None else k, mechanism, load, point, flexibility,
        read_only(shift), _weight(state, weighed, g),
    )  # fmt: skip
    return HandGrasp(commanded(as_asked(spec, effects), squeeze, grip_force, joint_offset))


def _weight_given(value: Any) -> WeightGiven:
    """False, True or "torques". Raises InputError."""
    if isinstance(value, bool) or (isinstance(value, str) and value == "torques"):
        return True if value is True else "torques" if value else False
    raise InputError("finger_weight", 'True, False or "torques"', repr(value))


def _frictions(friction: Any, names: list[str]) -> list[FrictionLaw]:
    laws: list[Any] = [Coulomb(0.6) if friction is None else friction] * len(names)
    if isinstance(friction, Mapping):
        laws = [per_name("friction", friction, names, "a fingertip").get(name, Coulomb(0.6)) for name in names]
    for name, law in zip(names, laws, strict=True):
        if not isinstance(law, FrictionLaw):
            where = f"friction[{name!r}]" if isinstance(friction, Mapping) else "friction"
            raise InputError(where, f"{law_words()}, or a mapping of fingertips to them", repr(law))
    return laws


def _given(state: Posture, target: Any, fingers: Any, friction: Any) -> tuple[tuple[int, ...], tuple[Contact, ...]]:
    """Fingertips and their contacts, which bear the fingertips' names."""
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
        contacts = validate.contacts(target[name] for name in fingers)
    elif not isinstance(target, Iterable) or isinstance(target, (str, bytes)):
        expected = "an object (Box, Sphere, …), contacts, or a mapping of fingertips to contacts"
        raise InputError("target", expected, repr(target))
    else:
        tips, contacts = hand.tip_numbers("fingers", fingers), validate.contacts(target)
    if len(contacts) != len(tips):
        names = ", ".join(hand.fingertips[i] for i in tips)
        raise InputError("contacts", f"{len(tips)}, one for each of {names}", f"{len(contacts)}")
    return tips, tuple([c.named(hand.fingertips[i]) for c, i in zip(contacts, tips, strict=True)])


def _load(
    wrench: Any, reference: Any, obj: Object | None, gravity: Array, positions: Array, normal: Array | None
) -> tuple[Array, Array]:
    """(6,) the wrench on the object, its weight at its centre of mass included; and the point (3,) that it is about."""
    if reference is None:
        point = read_only(np.zeros(3)) if obj is None else obj.center_of_mass
    else:
        point = validate.reference(reference, normal, positions)
    load = validate.wrench(wrench, normal, validate.lift(positions, point, normal))
    if obj is None or obj.mass == 0.0:
        return load, point
    weight = obj.mass * gravity
    if normal is not None and abs(float(weight @ normal)) > 1e-9 * float(abs(weight).max()):
        raise InputError("gravity", "gravity in the plane of a planar scene", gravity.tolist())
    if weight.any() and (off := validate.lift(positions, obj.center_of_mass, normal)):
        expected = "an object whose centre of mass lies in the plane of a planar scene"
        raise InputError("target", expected, f"one {abs(off):.3g} m off it")
    return read_only(load + np.append(weight, cross_rows(obj.center_of_mass - point, weight))), point


def _weight(state: Posture, weighed: WeightGiven, gravity: Array) -> tuple[Effect, ...]:
    """The fingers' own weight, where it was asked for."""
    return (FingerWeight(read_only(state.gravity_torque(gravity)), weighed is True),) if weighed else ()
