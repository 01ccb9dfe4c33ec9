"""From a posture and an object, or contacts, to a hand's grasp."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from handlcp.check import Array, array, number, read_only
from handlcp.errors import InputError
from handlcp.grasp import arguments
from handlcp.grasp.contact import Contact
from handlcp.grasp.effects import Effect
from handlcp.grasp.environment import beside
from handlcp.grasp.friction import LAW, LAWS, Coulomb, Friction
from handlcp.hand.command import read_command
from handlcp.hand.detect import touching
from handlcp.hand.grasp import HandGrasp
from handlcp.hand.objects import Object
from handlcp.hand.stiffness import per_name
from handlcp.hand.table import surrounding
from handlcp.hand.told import joints_of
from handlcp.hand.weight import FingerWeight, read_weight, tip_motion

if TYPE_CHECKING:
    from handlcp.hand.state import HandState

__all__ = ["grasp"]


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
    positions, frames, normal = arguments.placed(plane, contacts)
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
        known = joints_of(state, tips, contacts, frames, jacobian, weigh, normal is not None)
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
    made.finger_weight, made.gravity, made.given_gravity = heavy, g if heavy else _WEIGHTLESS, g
    made.gravity_torque = weigh
    return made


_WEIGHTLESS = read_only(np.zeros(3))


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
