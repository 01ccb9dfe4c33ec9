"""Tendons along routes as MuJoCo's spatial tendons: sites and round bodies on the links."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp.path.state import Stage
from handlcp.hand.elasticity.places import CYLINDER, Pulley, Site
from handlcp.hand.elasticity.route import Route
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.robot.model import HandModel
from handlcp.simulator.settings import add, add_shape, axes_along, placed

_LONG = 1.0  # [m] half of a cylinder, which MuJoCo wraps as if it had no ends
_BALANCED = 1e-9  # of what a pretension asks for
_SEEN = 1e-3  # [m] of a site's ball


def add_route(
    root: ET.Element, tendons: ET.Element, bodies: Mapping[int, ET.Element], hand: HandModel, name: str, route: Route
) -> None:
    """Write a tendon, and what it passes on the bodies of the hand. bodies : by number of Pinocchio's joint."""
    tendon = add(tendons, "spatial", name=name)
    for i, place in enumerate(route.places):
        called = f"{name}, {i + 1}"
        if isinstance(place, Pulley):
            add(tendon, "pulley", divisor=place.divisor)
            continue
        body, at = _carrier(bodies, hand, place.link)
        if isinstance(place, Site):
            add(body, "site", name=called, pos=at.act(place.point), size=_SEEN)
            add(tendon, "site", site=called)
            continue
        centre, axis = place.placement
        words = {"type": place.shape, "size": [place.radius]}
        if place.shape == CYLINDER:
            words["size"] = [place.radius, _LONG]
            words |= placed(at.rotation @ axes_along(axis), at.act(centre))
        else:
            words |= placed(np.eye(3), at.act(centre))
        add_shape(body, name=called, **words)
        side = {}
        if place.side is not None:
            add(body, "site", name=f"{called}, side", pos=at.act(place.side), size=_SEEN)
            side = {"sidesite": f"{called}, side"}
        add(tendon, "geom", geom=called, **side)


def has_routes(hand: HandModel) -> bool:
    """Whether tendons of a hand run along routes."""
    return isinstance(hand.stiffness, TendonStiffness) and bool(hand.stiffness.routes)


def _carrier(bodies: Mapping[int, ET.Element], hand: HandModel, link: str) -> tuple[ET.Element, pin.SE3]:
    """The body that a link is part of, and where the link's frame is in it."""
    model = hand.kinematics.model
    frame = model.frames[model.getFrameId(link)]
    return bodies[frame.parentJoint], frame.placement


def commands(grasp: HandGrasp, names: tuple[str, ...], arms: Array) -> tuple[Array, Array]:
    """(m,) before and after the hand has closed, of actuators of a hand with routes: of a tendon with one the length L
    at which it hangs loose, T = k (L(q) - L); of one without, how far it is drawn in; of springs at the joints, where
    they are at rest, less what a pretension makes of that. names (m,), arms (m, nv) : of the springs.
    Raises Unsupported for a pretension that no springs at the joints balance.
    """
    mechanism, stiffness = grasp.mechanism, grasp.state.hand.stiffness
    cables = mechanism.cables
    assert cables is not None
    assert isinstance(stiffness, TendonStiffness)
    rest = mechanism.relaxed
    preload = (cables if cables.way is None else cables.way(rest)[0]).arms.T @ cables.begun
    bent = np.linalg.lstsq(cables.passive, preload)[0]
    if abs(cables.passive @ bent - preload).max(initial=0.0) > _BALANCED * abs(preload).max(initial=0.0):
        raise Unsupported("a pretension that no springs at the joints balance cannot be written")
    loading = grasp.follow(order="squeeze" if mechanism.commands(grasp.spec) else [Stage("rest")], steps=8)
    both = []
    for state in (loading.steps.states[0], loading.last):
        drawn = np.linalg.solve(cables.springs, state.pull.drawn)
        sign = [-1.0 if name in stiffness.routes else 1.0 for name in cables.names]
        of_tendons = dict(zip(cables.names, (drawn * sign).tolist(), strict=True))
        both.append([of_tendons.get(name, float(row @ (rest - bent))) for name, row in zip(names, arms, strict=True)])
    return np.array(both[0]), np.array(both[1])
