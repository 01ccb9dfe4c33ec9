"""`find_linkage_bars`: bars of linkages: links at the end of a chain of joints whose own end is pinned to another link.

A URDF has no loops. A four-bar gripper is written as two chains whose joints follow one motor: the finger, and a bar
that would be pinned to it. An MJCF file says the pin itself, by a constraint. Of the two links at a pin the bar is the
one that ends there, and the finger goes on.

    pin:   p_a(q) + R_a(q) v = p_b(q) + R_b(q) w    for all q of the motor, with v and w fixed in the two links

With v and w unknown this is linear, and is solved in the sense of least squares over some postures.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import HandLCPError
from handlcp.robot.description import COLLISION, VISUAL, RobotDescription
from handlcp.robot.joint import movable_joints, read_ranges, resolve_mimics
from handlcp.robot.link_shape import read_numbers
from handlcp.robot.link_surface import surface_points

_SAMPLED_POSTURES = 7
_PIN_TOLERANCE = 5e-4  # [m] by which a pin of rounded numbers may be off
_MAX_PIN_DISTANCE = 0.2  # [m] from the joint of a bar to its pin, at most
_MIN_PIN_DISTANCE = 2e-3  # [m] nearer to its joint nothing is a bar
_MIN_LINKAGE_TURN = 0.05  # [rad] a linkage that turns less cannot be told from links that move as one


class _Pin(NamedTuple):
    """Between joint a at the end of a chain and joint b. at_a (3,) : in the frame of a [m]; at_b (3,) : of b."""

    a: int
    b: int
    at_a: Array
    at_b: Array


def find_linkage_bars(description: RobotDescription) -> set[int]:
    """Numbers of the joints that move such bars, each the last of its chain."""
    model = description.model
    inner = {int(model.parents[j]) for j in range(1, model.njoints)}
    ends = [j for j in range(1, model.njoints) if j not in inner and model.joints[j].nv]
    pins = [*_stated_pins(description, ends), *_coupled_pins(description, ends)]
    return {p.a for p in pins if _is_bar_end(description, p, ends)}


def _is_bar_end(description: RobotDescription, found: _Pin, ends: list[int]) -> bool:
    """Whether link a stays closer to the line from its joint to the pin than what joint b moves does to its own."""
    model = description.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    place, at_a, at_b = data.oMi[found.a].act(found.at_a), *(data.oMi[j].translation for j in (found.a, found.b))
    others = [j for j in ends if found.b in model.supports[j]]
    own = _max_distance(_link_points(description, data, found.a), at_a, place)
    return own < max((_max_distance(_link_points(description, data, j), at_b, place) for j in others), default=-np.inf)


def _link_points(description: RobotDescription, data: Any, joint: int) -> Array:
    """(m, 3) on the links that a joint moves itself: of their shapes, else the origins of frames."""
    model = description.model
    names = {f.name for f in model.frames if f.parentJoint == joint and f.type == pin.FrameType.BODY}
    for kind in (COLLISION, VISUAL):
        try:
            parts = description.load_shapes(kind, names & description.readable_links(kind))
        except HandLCPError:
            continue
        surfaces = [(p.frame, surface_points([(p.shape, p.rotation, p.position)], corners=True)) for p in parts]
        placed = [
            points @ data.oMf[i].rotation.T + data.oMf[i].translation for i, points in surfaces if points is not None
        ]
        if placed:
            return np.concatenate(placed)
    return np.array([data.oMf[i].translation for i, f in enumerate(model.frames) if f.parentJoint == joint])


def _max_distance(points: Array, start: Array, end: Array) -> float:
    """The largest distance of points (m, 3) from a line of finite length [m]."""
    way = end - start
    share = np.clip((points - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(points - start - share[:, None] * way, axis=1).max())


# ---------------------------------------------------------------- Pins that a file states.


def _stated_pins(description: RobotDescription, ends: list[int]) -> Iterator[_Pin]:
    """Of <pin> tags, which constraints of an MJCF file become: both links may be the bar."""
    model, root = description.model, description.root
    for tag in () if root is None else root.findall("pin"):
        names = tag.get("link", ""), tag.get("other", "")
        if not all(model.existFrame(name) for name in names):
            continue
        frames = [model.frames[model.getFrameId(name, pin.FrameType.BODY)] for name in names]
        points = [read_numbers(tag.get(word, "0 0 0")) for word in ("at", "at_other")]
        sides = [(int(f.parentJoint), f.placement.act(at)) for f, at in zip(frames, points, strict=True)]
        for (a, at_a), (b, at_b) in (sides, sides[::-1]):
            if a in ends and a != b:
                yield _Pin(a, b, at_a, at_b)


# ---------------------------------------------------------------- Pins of joints that follow one motor.


def _coupled_pins(description: RobotDescription, ends: list[int]) -> Iterator[_Pin]:
    if all(f.mimic is None for f in description.facts):
        return
    model = description.model
    try:
        names = movable_joints(model)
        coupling = resolve_mimics(names, description.facts)
    except HandLCPError:
        return
    lower, upper = read_ranges(names, {f.name: f for f in description.facts}, coupling)
    owner = {model.getJointId(name): int(abs(row).argmax()) for name, row in zip(names, coupling.C, strict=True)}
    moved = {model.getJointId(f.name) for f in description.facts if f.mimic is not None}
    chains = {j: {int(i) for i in model.supports[j] if i and model.joints[i].nv} for j in {*ends, *owner}}
    placed = dict[int, list[Any]]()
    for a in ends:
        for b in owner:
            apart = chains[a] ^ chains[b]
            masters = {owner[j] for j in apart}
            if b in chains[a] or a in chains[b] or len(masters) != 1 or not moved & apart:
                continue
            (k,) = masters
            if k not in placed:
                placed[k] = _sample_placements(model, coupling, k, float(lower[k]), float(upper[k]))
            if (found := _locate_pin([p[a] for p in placed[k]], [p[b] for p in placed[k]])) is not None:
                yield _Pin(a, b, *found)


def _sample_placements(model: Any, coupling: Any, k: int, low: float, high: float) -> list[Any]:
    """Of all joints in some postures of the independent joint k, others at 0."""
    low, high = (low, high) if np.isfinite(low) and np.isfinite(high) and low < high else (-0.5, 0.5)
    data, found = model.createData(), []
    for x in np.linspace(low, high, _SAMPLED_POSTURES):
        q = np.zeros(coupling.C.shape[1])
        q[k] = x
        pin.forwardKinematics(model, data, pin.integrate(model, pin.neutral(model), coupling.C @ q + coupling.offset))
        found.append([pin.SE3(place) for place in data.oMi])
    return found


def _locate_pin(one: list[Any], two: list[Any]) -> tuple[Array, Array] | None:
    """Where a pin is, v (3,) and w (3,), of links with these placements; None: there is none, or they move as one."""
    turned = [pin.log3(a.rotation.T @ b.rotation) for a, b in zip(one, two, strict=True)]
    if max(float(np.linalg.norm(t - turned[0])) for t in turned) < _MIN_LINKAGE_TURN:
        return None
    rows = np.vstack([np.hstack([a.rotation, -b.rotation]) for a, b in zip(one, two, strict=True)])
    apart = np.concatenate([b.translation - a.translation for a, b in zip(one, two, strict=True)])
    v, w = np.split(np.linalg.lstsq(rows, apart)[0], 2)
    off = float(abs(rows @ np.concatenate([v, w]) - apart).max())
    near = max(np.linalg.norm(v), np.linalg.norm(w)) < _MAX_PIN_DISTANCE
    return (v, w) if off < _PIN_TOLERANCE and near and np.linalg.norm(v) > _MIN_PIN_DISTANCE else None
