"""Tendons along routes that the servos of an MJCF file draw in: written beside its joints, and made a hand's.

    K = K_p + Rᵀ k R,    k = kp gear²,    t ≤ gear · forcerange

with R of the route in a posture and K_p of the springs at the joints. MuJoCo's tendons push where their actuator does;
these pull, as cables do. A tag of our own has them in the <robot> that the file becomes:

    <cable name kp limit> <site link point/> <around link centre axis radius shape side/> <pulley divisor/> … </cable>
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.hand.elasticity.places import Around, Pulley, Site
from handlcp.hand.elasticity.route import Route
from handlcp.hand.elasticity.stiffness import HOW_STIFF
from handlcp.hand.elasticity.tendon_stiffness import RoutedStiffness, TendonStiffness
from handlcp.hand.elasticity.tendons import Tendons
from handlcp.hand.robot.kinematics import Kinematics
from handlcp.hand.robot.source.mjcf_parts import add
from handlcp.hand.robot.source.passive import passive_springs

TAG = "cable"


class Cable(NamedTuple):
    """A tendon of a file. kp [N/m] : with the gear of its servos. limit [N] : which these pull with at most."""

    name: str
    kp: float
    limit: float
    route: Route


def write_cable(root: ET.Element, cable: Cable) -> None:
    """As the tag."""
    element = add(root, TAG, name=cable.name, kp=cable.kp, limit=cable.limit)
    for place in cable.route.places:
        if isinstance(place, Pulley):
            add(element, "pulley", divisor=place.divisor)
        elif isinstance(place, Site):
            add(element, "site", link=place.link, point=place.point)
        else:
            (centre, axis), side = place.placement, {} if place.side is None else {"side": place.side}
            add(element, "around", link=place.link, centre=centre, axis=axis, radius=place.radius, shape=place.shape,
                **side)  # fmt: skip


def cables_of(root: ET.Element) -> tuple[Cable, ...]:
    """The cables of a robot, those that pass links that were cut off left out."""
    links, found = {link.get("name") for link in root.findall("link")}, list[Cable]()
    for element in root.findall(TAG):
        if all(place.get("link", "") in links for place in element if place.tag != "pulley"):
            kp, limit = (float(element.get(word, 0.0)) for word in ("kp", "limit"))
            found.append(Cable(element.get("name", ""), kp, limit, Route([_place(place) for place in element])))
    return tuple(found)


def _place(element: ET.Element) -> Site | Around | Pulley:
    link = element.get("link", "")
    if element.tag == "pulley":
        return Pulley(float(element.get("divisor", 1.0)))
    if element.tag == "site":
        return Site(link, _point(element, "point"))
    placement, side = (_point(element, "centre"), _point(element, "axis")), element.get("side")
    radius, shape = float(element.get("radius", 0.0)), element.get("shape", "")
    return Around(link, placement, radius, shape, None if side is None else _point(element, "side"))


def _point(element: ET.Element, word: str) -> Array:
    return np.array([float(x) for x in element.get(word, "").split()])


def cable_stiffness(cables: Sequence[Cable], kinematics: Kinematics) -> TendonStiffness:
    """Of a hand that these and the springs at its joints move. Raises InputError where they leave a joint loose."""
    routes: dict[str, Any] = {c.name: c.route for c in cables}
    springs, limits = {c.name: c.kp for c in cables}, {c.name: c.limit for c in cables}
    tendons = Tendons(routes, springs, passive_springs(kinematics), limits=limits)
    try:
        made = tendons.for_joints(kinematics.joint_names, kinematics)
    except InputError as error:
        if error.argument != "Tendons.passive":
            raise
        advice = "Tendons(hl.tendon_routes(...), ..., passive=...), as those of the file leave joints loose"
        raise InputError("joint_stiffness", f"{HOW_STIFF}, or {advice}", error.got) from None
    assert isinstance(made, RoutedStiffness)  # along routes
    return made.as_stated()
