"""`write_cables`: tendons of an MJCF file as cables along routes; and the springs at joints that it states.

    K_p = Cᵀ diag(k) C,    τ = Cᵀ k (C q + c - θ)

with k and rest angle θ of each joint, and the coupling q_full = C q + c of joints that follow others.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.actuation.joint_stiffness import STIFFNESS_EXPECTED
from handlcp.actuation.route import CYLINDER, SPHERE, Around, Pulley, Route, Site
from handlcp.actuation.tendon_stiffness import RoutedStiffness, TendonStiffness
from handlcp.actuation.transmission import Tendons
from handlcp.check import Array
from handlcp.errors import InputError, Unsupported
from handlcp.robot.joint import Doubt
from handlcp.robot.kinematics import Kinematics
from handlcp.robot.link_shape import quaternion_rotation, read_numbers
from handlcp.robot.mjcf_shape import DRIVES_TENDON, add_element


def passive_stiffness(kinematics: Kinematics) -> Array:
    """(nv, nv) K_p [N·m/rad] of the springs at joints that the file states."""
    k, C = _spring_constants(kinematics)[0], kinematics.all_joints.C
    return np.asarray(C.T @ (k[:, None] * C))


def rest_angles(kinematics: Kinematics) -> Array:
    """Where the springs of each independent joint, and of those that follow it, pull with nothing in all, (nv,) [rad,
    m].

    It is 0 without springs.
    """
    (k, rest), coupling = _spring_constants(kinematics), kinematics.all_joints
    stiff = passive_stiffness(kinematics).diagonal()
    at_zero = coupling.C.T @ (k * (coupling.offset - rest))
    return np.asarray(-at_zero / np.where(stiff > 0.0, stiff, 1.0))


def spring_preload(kinematics: Kinematics) -> Array:
    """(nv,) τ [N·m] with which springs pull in the middle of the ranges; without ends, in the neutral posture."""
    (k, rest), coupling = _spring_constants(kinematics), kinematics.all_joints
    bounded = np.isfinite(kinematics.lower) & np.isfinite(kinematics.upper)
    ends = np.where(bounded, [kinematics.lower, kinematics.upper], kinematics.neutral)
    return np.asarray(coupling.C.T @ (k * (coupling.C @ ends.mean(axis=0) + coupling.offset - rest)))


def _spring_constants(kinematics: Kinematics) -> tuple[Array, Array]:
    """(joints,) stiffness [N·m/rad] and rest angle [rad] of all movable joints."""
    stated = {f.name: f.properties for f in kinematics.facts}
    every = [stated[name] for name in kinematics.movable]
    return np.array([s.stiffness for s in every]), np.array([s.rest for s in every])


# ----------------------------------------------------------------
# Tendons along routes that the servos of an MJCF file draw in: written beside its joints, and made a hand's.
#
#     K = K_p + Rᵀ k R,    k = kp gear²,    t ≤ gear · forcerange
#
# with R of the route in a posture and K_p of the springs at the joints. MuJoCo's tendons push where their actuator
# does; these pull, as cables do. A tag of our own has them in the <robot> that the file becomes:
#
#     <cable name kp limit> <site link point/> <around link centre axis radius shape side/> <pulley divisor/> … </cable>

CABLE_TAG = "cable"


class FileCable(NamedTuple):
    """A tendon of a file. kp [N/m] : with the gear of its servos. limit [N] : which these pull with at most."""

    name: str
    kp: float
    limit: float
    route: Route


def write_cable(root: ET.Element, cable: FileCable) -> None:
    """Write a cable as a tag of the robot."""
    element = add_element(root, CABLE_TAG, name=cable.name, kp=cable.kp, limit=cable.limit)
    for place in cable.route.places:
        if isinstance(place, Pulley):
            add_element(element, "pulley", divisor=place.divisor)
        elif isinstance(place, Site):
            add_element(element, "site", link=place.link, point=place.point)
        else:
            (centre, axis), side = place.placement, {} if place.side is None else {"side": place.side}
            where, size = {"centre": centre, "axis": axis}, {"radius": place.radius, "shape": place.shape}
            add_element(element, "around", link=place.link, **where, **size, **side)


def read_cables(root: ET.Element) -> tuple[FileCable, ...]:
    """The cables of a robot, those that pass links that were cut off left out."""
    links, found = {link.get("name") for link in root.findall("link")}, list[FileCable]()
    for element in root.findall(CABLE_TAG):
        if all(place.get("link", "") in links for place in element if place.tag != "pulley"):
            kp, limit = (float(element.get(word, 0.0)) for word in ("kp", "limit"))
            route = Route([_read_place(place) for place in element])
            found.append(FileCable(element.get("name", ""), kp, limit, route))
    return tuple(found)


def _read_place(element: ET.Element) -> Site | Around | Pulley:
    link = element.get("link", "")
    if element.tag == "pulley":
        return Pulley(float(element.get("divisor", 1.0)))
    if element.tag == "site":
        return Site(link, read_numbers(element.get("point", "")))
    placement, side = tuple(read_numbers(element.get(word, "")) for word in ("centre", "axis")), element.get("side")
    radius, shape = float(element.get("radius", 0.0)), element.get("shape", "")
    return Around(link, placement, radius, shape, None if side is None else read_numbers(side))


def make_cable_stiffness(cables: Sequence[FileCable], kinematics: Kinematics) -> TendonStiffness:
    """Of a hand that these and the springs at its joints move. Raises InputError where they leave a joint loose."""
    routes: dict[str, Any] = {c.name: c.route for c in cables}
    springs, limits = {c.name: c.kp for c in cables}, {c.name: c.limit for c in cables}
    tendons = Tendons(routes, springs, passive_stiffness(kinematics), limits=limits)
    try:
        made = tendons.for_joints(kinematics.joint_names, kinematics)
    except InputError as error:
        if error.argument != "Tendons.passive":
            raise
        advice = "Tendons(hl.tendon_routes(...), ..., passive=...), as those of the file leave joints loose"
        raise InputError("joint_stiffness", f"{STIFFNESS_EXPECTED}, or {advice}", error.got) from None
    assert isinstance(made, RoutedStiffness)  # along routes
    return made.as_from_file()


# ----------------------------------------------------------------
# The spatial tendons of an MJCF model as routes: sites, side sites, cylinders, spheres and pulleys.
#
# Points are in the frames of bodies, and the link of a body, named as in `handlcp.robot.mjcf`, has the same
# frame.
# Source: MuJoCo's XML reference, tendon/spatial, and the fields of mjModel named `tendon_` and `wrap_`.

_WRAP_JOINT, _WRAP_PULLEY, _WRAP_SITE, _WRAP_SPHERE, _WRAP_CYLINDER = 1, 2, 3, 4, 5  # mjtWrap: what a tendon passes


def read_routes(model: Any) -> tuple[dict[str, Route], dict[str, str]]:
    """Tendon name → route of each spatial tendon of a compiled mujoco.MjModel; and tendon name → why one is not read.

    Tendons that are sums of joint angles are left out: they have no path.
    """
    read, refused = dict[str, Route](), dict[str, str]()
    for t in range(model.ntendon):
        first, name = int(model.tendon_adr[t]), model.tendon(t).name or f"tendon {t}"
        places = range(first, first + int(model.tendon_num[t]))
        if any(model.wrap_type[w] == _WRAP_JOINT for w in places):
            continue
        try:
            read[name] = Route([_read_wrap(model, w) for w in places])
        except (InputError, Unsupported) as error:
            refused[name] = str(error)
    return read, refused


def _read_wrap(model: Any, w: int) -> Site | Around | Pulley:
    """One of the places. Raises InputError, Unsupported."""
    kind, item = int(model.wrap_type[w]), int(model.wrap_objid[w])
    if kind == _WRAP_PULLEY:
        return Pulley(float(model.wrap_prm[w]))
    if kind == _WRAP_SITE:
        return Site(_body_link(model, model.site_bodyid[item]), model.site_pos[item])
    if kind not in (_WRAP_SPHERE, _WRAP_CYLINDER):
        raise Unsupported(f"a place of MuJoCo's type {kind}: sites, spheres, cylinders and pulleys are read")
    body = int(model.geom_bodyid[item])
    at = pin.SE3(quaternion_rotation(model.geom_quat[item]), model.geom_pos[item])
    shape = SPHERE if kind == _WRAP_SPHERE else CYLINDER
    site, side = int(model.wrap_prm[w]), None
    if site >= 0:
        if int(model.site_bodyid[site]) != body:
            name, link = _item_label(model.site(site), "site"), _body_link(model, body)
            raise Unsupported(f"{name} is the side site of a geom on {link!r}, and on another body")
        side = model.site_pos[site]
    try:
        return Around(_body_link(model, body), at, float(model.geom_size[item, 0]), shape, side)
    except Unsupported:
        geom = _item_label(model.geom(item), "geom")
        raise Unsupported(f"{geom}: its side site is inside, and the tendon with it") from None


def _body_link(model: Any, body: int) -> str:
    """The link of a body, by the name that our reader gives it."""
    return str(model.body(int(body)).name or f"body_{int(body)}")


def _item_label(item: Any, kind: str) -> str:
    return f"{kind} {item.name!r}" if item.name else f"{kind} {item.id}"


# ----------------------------------------------------------------
# Tendons along a path in space that servos of an MJCF model draw in, and springs of tendons, which are left out.

ROUTE_TOPIC = "route"  # what a doubt is about that a hand with tendons is free of
SERVO_TOPIC = "servo"  # what one is about that says why a servo is not read
_TENDONS_ADVICE = "joint_stiffness=Tendons(hl.tendon_routes(...), ...)"
_SIGN_ADVICE = "; a pull shortens: forcerange below 0 for a gear above 0, above 0 for a gear below 0"


def write_cables(root: ET.Element, model: Any, servos: dict[int, float]) -> Iterator[Doubt]:
    """Write each tendon with its servos' kp and the force that they pull with; a doubt for each reason why some
    cannot be had, or for those that are had, where the hand has other springs.

    servos : number of the actuator → kp [N/m, N·m/rad], of all position actuators.
    """
    drawn = defaultdict[int, list[int]](list)
    read, refused = read_routes(model)
    for a in servos:
        if int(model.actuator_trntype[a]) == DRIVES_TENDON:
            drawn[int(model.actuator_trnid[a, 0])].append(a)
    names = {t: model.tendon(t).name or f"tendon {t}" for t in range(model.ntendon)}
    spatial = {t: actuators for t, actuators in drawn.items() if names[t] in read or names[t] in refused}
    alone = sum(len(actuators) for actuators in spatial.values()) == len(servos)
    found = defaultdict[tuple[str, str, str], list[str]](list)
    for t, actuators in spatial.items():
        limit, about = 0.0, SERVO_TOPIC  # [N] : the forces along the tendon that shorten it
        for a in actuators:
            ends = float(model.actuator_gear[a, 0]) * model.actuator_forcerange[a]
            limit += -float(min(ends)) if model.actuator_forcelimited[a] else np.inf
        if not alone:
            why = ", beside servos of joints: their kp is not read"
        elif names[t] in refused:
            why = f", which is not read: {refused[names[t]]}"
        elif limit <= 0.0:
            why = " and only push, which no cable does: they are left out"
        else:
            why, about = "; here each joint has a spring of its own", ROUTE_TOPIC
            write_cable(root, FileCable(names[t], sum(servos[a] for a in actuators), limit, read[names[t]]))
        advice = _TENDONS_ADVICE + (_SIGN_ADVICE if limit <= 0.0 else "")
        found[why, about, advice] += [model.actuator(a).name or f"actuator {a}" for a in actuators]
    for (why, about, advice), who in found.items():
        what = f"servos ({words.list_names(who)}) act on tendons along a path in space{why}"
        yield Doubt("hand", what, advice, "minor", about)
    yield from _tendon_property_doubts(model, names)


def _tendon_property_doubts(model: Any, names: dict[int, str]) -> Iterator[Doubt]:
    """Of what tendons have of their own, which is left out: springs, dry friction, ranges of their length."""
    rubbing = [names[t] for t in names if float(model.tendon_frictionloss[t]) > 0.0]
    ranged = [names[t] for t in names if model.tendon_limited[t]]
    for those, what, advice, about in (
        (rubbing, "dry friction of their own (frictionloss)", "Tendons(friction=...), or joint_friction", "friction"),
        (ranged, "a range of their own, at whose ends they would stop", "ranges of joints that keep it", "range"),
    ):
        if those:
            said = f"of tendons ({words.list_names(those)}) {what} is left out"
            yield Doubt("hand", said, advice, "minor", about)
    for t in names:
        if (k := float(np.ravel(model.tendon_stiffness[t])[0])) > 0.0:
            what = f"the tendon {names[t]!r} has a spring of its own of {k:g}, which is left out"
            yield Doubt("hand", what, "joint_stiffness with what that spring adds", "minor", "stiffness")
