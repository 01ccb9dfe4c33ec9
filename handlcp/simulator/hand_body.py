"""`add_hand`: the hand as bodies of MuJoCo, with joints, springs, and tendons along routes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.actuation.route import CYLINDER, Pulley, Route, Site
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.path.state import Stage
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.robot.hand_model import HandModel
from handlcp.robot.kinematics import jacobian_columns
from handlcp.simulator.settings import (
    SimulatorSettings,
    add_element,
    add_shape,
    axes_along,
    format_numbers,
    placement_attributes,
)

_CYLINDER_HALF_LENGTH = 1.0  # [m] half of a cylinder, which MuJoCo wraps as if it had no ends
_BALANCE_TOLERANCE = 1e-9  # of what a pretension asks for
_SITE_RADIUS = 1e-3  # [m] of a site's ball


def add_route(
    root: ET.Element, tendons: ET.Element, bodies: Mapping[int, ET.Element], hand: HandModel, name: str, route: Route
) -> None:
    """Write a tendon, and what it passes on the bodies of the hand. bodies : by number of Pinocchio's joint."""
    tendon, model = add_element(tendons, "spatial", name=name), hand.kinematics.model
    for i, place in enumerate(route.places):
        called = f"{name}, {i + 1}"
        if isinstance(place, Pulley):
            add_element(tendon, "pulley", divisor=place.divisor)
            continue
        frame = model.frames[model.getFrameId(place.link)]
        body, at = bodies[frame.parentJoint], frame.placement  # which the link is part of, and where its frame is in it
        if isinstance(place, Site):
            add_element(body, "site", name=called, pos=at.act(place.point), size=_SITE_RADIUS)
            add_element(tendon, "site", site=called)
            continue
        centre, axis = place.placement
        words = {"type": place.shape, "size": [place.radius]}
        if place.shape == CYLINDER:
            words["size"] = [place.radius, _CYLINDER_HALF_LENGTH]
            words |= placement_attributes(at.rotation @ axes_along(axis), at.act(centre))
        else:
            words |= placement_attributes(np.eye(3), at.act(centre))
        add_shape(body, name=called, **words)
        side = {}
        if place.side is not None:
            add_element(body, "site", name=f"{called}, side", pos=at.act(place.side), size=_SITE_RADIUS)
            side = {"sidesite": f"{called}, side"}
        add_element(tendon, "geom", geom=called, **side)


def has_routes(hand: HandModel) -> bool:
    """Whether tendons of a hand run along routes."""
    return isinstance(hand.stiffness, TendonStiffness) and bool(hand.stiffness.routes)


def route_commands(grasp: HandGrasp, names: tuple[str, ...], arms: Array) -> tuple[Array, Array]:
    """(m,) before and after the hand has closed, of actuators of a hand with routes: of a tendon with one the length L
    at which it hangs loose, T = k (L(q) - L); of one without, how far it is drawn in; of springs at the joints, where
    they are at rest, less what a pretension makes of that. names (m,), arms (m, nv) : of the springs.
    Raises Unsupported for a pretension that no springs at the joints balance.
    """
    mechanism, stiffness = grasp.mechanism, grasp.state.hand.stiffness
    cables = mechanism.joint_model.cables
    assert cables is not None
    assert isinstance(stiffness, TendonStiffness)
    rest = mechanism.rest_posture
    there = cables if cables.elasticity_at is None else cables.elasticity_at(rest)[0]
    preload = there.arms.T @ cables.initial_tension
    bent = np.linalg.lstsq(cables.passive, preload)[0]
    if abs(cables.passive @ bent - preload).max(initial=0.0) > _BALANCE_TOLERANCE * abs(preload).max(initial=0.0):
        raise Unsupported("a pretension that no springs at the joints balance cannot be written")
    loading = grasp.follow(order="squeeze" if find_command(grasp.spec.effects) else [Stage("rest")], steps=8)
    both = []
    for state in (loading.steps.states[0], loading.last):
        drawn = np.linalg.solve(cables.springs, state.pull.drawn)
        sign = [-1.0 if name in stiffness.routes else 1.0 for name in cables.names]
        of_tendons = dict(zip(cables.names, (drawn * sign).tolist(), strict=True))
        both.append([of_tendons.get(name, float(row @ (rest - bent))) for name, row in zip(names, arms, strict=True)])
    return np.array(both[0]), np.array(both[1])


# ----------------------------------------------------------------
# The moving links of a hand as MuJoCo bodies, one body a joint; and their springs.


_MIN_LINK_MASS = 1e-6  # [kg] of a link without <inertial>
_MIN_LINK_INERTIA = 1e-9  # [kg·m²]
_STIFFNESS_ROUNDING = 1e-12  # of the largest stiffness: less is rounding, and no spring
_UNLIMITED_FORCE = 1e6  # [N] of a tendon, in place of none
_JOINT_ARMATURE = 1e-5  # [kg·m²] of every joint: links without inertia would move without limit
# A joint that its friction should hold creeps by (1 - d) / d · f τ / 2I [rad/s], with f the torque that friction bears,
# I the inertia, impedance d and time constant τ. d as near to 1, and τ of as few time steps, as MuJoCo has them
_LEAST_TIME_STEPS = 2.0
_JOINT_FRICTION_IMPEDANCE = (0.9999, 0.9999, 1e-3)


def add_hand(world: ET.Element, hand: HandModel, weighs: bool, settings: SimulatorSettings) -> dict[int, ET.Element]:
    """Bodies of all links that move, by the number of their joint in Pinocchio's model; 0 is the world.

    weighs : whether gravity acts on them.
    """
    model, friction = hand.kinematics.model, dict(zip(hand.joint_names, hand.dry_friction.tolist(), strict=True))
    bodies, springs = {0: world}, dict[str, dict[str, float]]()  # springs of joints beside their actuators
    if (at_zero := hand.stiffness.parallel_spring_torque(np.zeros(hand.nv))) is not None:
        each = zip(hand.joint_names, hand.stiffness.springs_with_rest.tolist(), at_zero.tolist(), strict=True)
        springs = {joint: {"stiffness": k, "springref": -torque / k} for joint, k, torque in each if k}
    for i in range(1, model.njoints):
        at, name = model.jointPlacements[i], model.names[i]
        where = placement_attributes(at.rotation, at.translation) | ({} if weighs else {"gravcomp": 1.0})
        body = bodies[i] = add_element(bodies[model.parents[i]], "body", name=name, **where)
        _add_inertia(body, model.inertias[i])
        kind, axis = mujoco_joint_axis(model, i)
        rubbing: dict[str, Any] = {}
        if rubs := friction.get(name, 0.0):
            rubbing = {"frictionloss": rubs, "solreffriction": (_LEAST_TIME_STEPS * settings.timestep, 1.0)}
            rubbing["solimpfriction"] = _JOINT_FRICTION_IMPEDANCE
        if kind:
            moves = {"type": kind, "axis": axis, "armature": _JOINT_ARMATURE} | rubbing | springs.get(name, {})
            add_element(body, "joint", name=name, **moves)
    return bodies


def spring_command_offset(hand: HandModel, q: Array) -> Array:
    """(nv,) how much farther than to q (nv,) actuators are told to go, to hold such springs there [rad, m]."""
    held = hand.stiffness.parallel_spring_torque(q)
    if held is None:
        return np.zeros(hand.nv)
    K = hand.stiffness.stiffness_matrix - np.diag(hand.stiffness.springs_with_rest)
    return np.asarray(np.linalg.lstsq(K, held)[0])


def movable_joint_names(hand: HandModel) -> tuple[str, ...]:
    """Names of all movable joints, mimic joints included, in the order of rows of the coupling."""
    model = hand.kinematics.model
    moving = [(joint.idx_v, model.names[i]) for i, joint in enumerate(model.joints) if i and joint.nv]
    return tuple([name for _, name in sorted(moving)])


def mujoco_joint_axis(model: Any, i: int) -> tuple[str, Array]:
    """MuJoCo's word for joint i, and its axis (3,) in its own frame; no word for one that does not move."""
    joint = model.joints[i]
    if not joint.nv:
        return "", np.zeros(3)
    data = model.createData()
    own = jacobian_columns(pin.computeJointJacobian(model, data, pin.neutral(model), i))  # in the joint's own frame
    column = own[:, joint.idx_v]
    return ("slide", column[:3]) if np.linalg.norm(column[3:]) < 0.5 else ("hinge", column[3:])


def _add_inertia(body: ET.Element, inertia: Any) -> None:
    mass, I = max(float(inertia.mass), _MIN_LINK_MASS), np.array(inertia.inertia)  # noqa: E741
    least = float(np.linalg.eigvalsh(I)[0])
    if least <= -_MIN_LINK_INERTIA:
        came = f"{body.get('name')!r} with a principal moment of {least:.3g} kg·m²"
        raise InputError("grasp", "links with inertias that a body can have, for MuJoCo", came)
    if least < _MIN_LINK_INERTIA:
        I = I + _MIN_LINK_INERTIA * np.eye(3)  # noqa: E741
    full = (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])
    add_element(body, "inertial", pos=np.array(inertia.lever), mass=mass, fullinertia=full)


# ----------------------------------------------------------------
# Joint springs as position actuators: force = stiffness · (command - position), the command is data of the
# simulation. Springs of a file beside its servos are springs of MuJoCo's joints.
#
# A diagonal stiffness is an actuator at each joint. Any other symmetric matrix is a sum of springs K = Σ k_i a_i
# a_iᵀ, each along a fixed tendon with the moment arms a_i: those of the hand's tendons, or else K's eigenvectors.
# Rigid joints and joints that mimic others are equations.


@dataclass(frozen=True, eq=False)
class SimulatedSprings:
    """m springs over nv joints: names (m,), arms (m, nv), stiffness (m,) [N·m/rad, N/m]; rigid : numbers of the joints
    that give way to nothing. K = armsᵀ diag(stiffness) arms.
    """

    names: tuple[str, ...]
    arms: Array
    stiffness: Array
    rigid: tuple[int, ...]


def add_springs(
    root: ET.Element,
    bodies: Mapping[int, ET.Element],
    hand: HandModel,
    at: Array,
    limited: bool,
    settings: SimulatorSettings,
    least: Mapping[str, float],
) -> SimulatedSprings:
    """Springs, rigid joints and mimic joints of a hand.

    bodies : as `add_hand` returns them. at : (nv,) where rigid joints stand. limited : whether actuators push no harder
    than the torque limits. least : of tendons that go slack, the least force of their actuators [N].
    Raises Unsupported for a compliance that is no stiffness, for limits beside coupled springs, and for tendons that go
    slack and share springs with others.
    """
    springs = _make_springs(hand)
    arms = springs.arms
    single = ((arms == 1.0).sum(axis=1) == 1).all() and (np.count_nonzero(arms, axis=1) == 1).all()
    coupled = len(springs.names) and not single
    limits = hand.torque_limits - (hand.dry_friction - hand.joint_friction)  # drives give what their friction leaves
    if limited and coupled and np.isfinite(limits).any():
        why = "MuJoCo limits a spring's force"
        raise Unsupported(f"torque limits of joints that share springs cannot be written: {why}")
    if missing := [name for name in least if name not in springs.names]:
        raise Unsupported(f"tendons that go slack and share springs cannot be written: {', '.join(missing)}")
    actuators = add_element(root, "actuator")
    tendons = add_element(root, "tendon") if coupled else None
    routes = hand.stiffness.routes if isinstance(hand.stiffness, TendonStiffness) else {}
    for name, arms, k in zip(springs.names, springs.arms, springs.stiffness, strict=True):
        words: dict[str, object] = {"name": name, "kp": k}
        if tendons is not None and name in routes:
            add_route(root, tendons, bodies, hand, name, routes[name])
            words |= {"tendon": name, "forcerange": (-_UNLIMITED_FORCE, 0.0)}  # along the length, which a pull shortens
        elif tendons is not None:
            tendon = add_element(tendons, "fixed", name=name)
            for joint in np.flatnonzero(arms):
                add_element(tendon, "joint", joint=hand.joint_names[joint], coef=arms[joint])
            words["tendon"] = name
        else:
            j = int(np.flatnonzero(arms)[0])
            words["joint"] = hand.joint_names[j]
            if limited and np.isfinite(limits[j]):
                words["forcerange"] = (-limits[j], limits[j])
        if name in least and name not in routes:
            words["forcerange"] = (least[name], _UNLIMITED_FORCE)
        add_element(actuators, "position", **words)
    # Each joint is damped as its own spring would need it, coupled or not
    each = np.einsum("ij,i,ij->j", springs.arms, springs.stiffness, springs.arms)
    own = dict(zip(hand.joint_names, each.tolist(), strict=True))
    for element in root.iter("joint"):
        if (k := own.get(element.get("name", ""), 0.0)) > 0.0 and element.get("type") in ("hinge", "slide"):
            element.attrib.update({word: format_numbers(x) for word, x in settings.critical_damping(k).items()})
    _add_equations(root, hand, springs, at)
    return springs


def _make_springs(hand: HandModel) -> SimulatedSprings:
    K, names = hand.stiffness.stiffness_matrix - np.diag(hand.stiffness.springs_with_rest), hand.joint_names
    rigid = np.isinf(np.diagonal(K))
    free = np.flatnonzero(~rigid)
    K = np.where(np.outer(rigid, rigid) | np.isinf(K), 0.0, K)
    off = K - np.diag(np.diagonal(K))
    if isinstance(hand.stiffness, TendonStiffness):
        cables = hand.stiffness.cables
        passive = K - cables.arms.T @ cables.springs @ cables.arms
        found = _spring_modes(cables.springs, cables.arms, cables.names)
        found += _spring_modes(passive, np.eye(len(names)), names)
    elif not off.any():
        found = [(names[j], np.eye(len(names))[j], K[j, j]) for j in free]
    else:
        found = _spring_modes(K, np.eye(len(names)), names)
    least = _STIFFNESS_ROUNDING * abs(K).max(initial=0.0)
    used = [spring for spring in found if spring[2] > least and np.any(spring[1])]
    arms = np.array([a for _, a, _ in used]).reshape(-1, len(names))
    stiffness, own = np.array([k for _, _, k in used]), tuple([name for name, _, _ in used])
    return SimulatedSprings(own, arms, stiffness, tuple(np.flatnonzero(rigid).tolist()))


def _spring_modes(K: Array, arms: Array, names: tuple[str, ...]) -> list[tuple[str, Array, float]]:
    """Springs that make armsᵀ K arms: one for each row of a diagonal K, else one for each eigenvector."""
    off = K - np.diag(np.diagonal(K))
    if not (abs(off) > _STIFFNESS_ROUNDING * abs(K).max(initial=0.0)).any():
        return [(name, a, float(k)) for name, a, k in zip(names, arms, np.diagonal(K), strict=True)]
    values, vectors = np.linalg.eigh(K)
    return [(f"spring {i + 1}", v @ arms, float(k)) for i, (k, v) in enumerate(zip(values, vectors.T, strict=True))]


def _add_equations(root: ET.Element, hand: HandModel, springs: SimulatedSprings, at: Array) -> None:
    """Rigid joints stand; a joint that mimics another is at offset + factor times where that one is."""
    coupling = hand.kinematics.coupling
    if not springs.rigid and coupling is None:
        return
    equations = add_element(root, "equality")
    for j in springs.rigid:
        name = hand.joint_names[j]
        add_element(equations, "joint", name=name, joint1=name, polycoef=(at[j], 0, 0, 0, 0))
    if coupling is None:
        return
    for name, row, offset in zip(movable_joint_names(hand), coupling, hand.kinematics.offset, strict=True):
        if name not in hand.joint_names:
            j = int(np.argmax(abs(row)))
            polynomial = (offset, row[j], 0.0, 0.0, 0.0)
            add_element(equations, "joint", name=name, joint1=name, joint2=hand.joint_names[j], polycoef=polynomial)
