"""`to_mujoco`: a hand's grasp as MJCF: the same joints, springs, pads, friction, supports and load."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handlcp.check import Array, check_call, read_only
from handlcp.errors import Unsupported
from handlcp.geometry.contact_detection import nearest_proximity
from handlcp.grasp import Grasp, TorqueSaturation
from handlcp.grasp.effects.joint_offset import find_command
from handlcp.grasp.model.contact import cross_rows
from handlcp.hand import HandGrasp
from handlcp.hand.squeeze import tip_motions_by_joint
from handlcp.robot.hand_model import HandPosture
from handlcp.robot.mjcf import without_mujoco_log
from handlcp.simulator.hand_body import (
    SimulatedSprings,
    add_hand,
    add_springs,
    has_routes,
    movable_joint_names,
    route_commands,
    spring_command_offset,
)
from handlcp.simulator.object_body import (
    LOADED_POINT_NAME,
    OBJECT_NAME,
    add_corner,
    add_object,
    add_supports,
    add_tip,
    check_point_contact,
)
from handlcp.simulator.settings import (
    SimulatorSettings,
    add_element,
    check_writable,
    friction_attributes,
    import_mujoco,
    require_hand_grasp,
)

# ----------------------------------------------------------------
# Where a simulation starts, what the hand is told, and what the object carries.


@dataclass(frozen=True, eq=False)
class SimulatorState:
    """What the MJCF of `to_mujoco` leaves open. Immutable.

    positions : of all movable joints of the hand where the grasp begins, by name [rad, m]: where its fingertips touch,
        or where it begins to close.
    before, after : commands of the actuators at the start and with all of the squeeze, by name [rad, m].
    least : the least forces of those that only pull, likewise, of tendons: (before, after) [N]; a tendon's force counts
    from that with which its actuator holds the joints where they are commanded.
    mass : [kg] of the object's weight; the mass with which it moves is another.
    weighing : bodies of the hand whose weight bends its joints, by name; none where the grasp leaves it out.
    wrench : (6,) force [N] and torque [N·m] on the object besides its weight, world axes. The force acts at the
        point of the object that the grasp's reference is at the start, and moves with it; the torque keeps its axes.
    keeps : whether something else keeps the object in place until the hand has closed.
    """

    positions: Mapping[str, float]
    before: Mapping[str, float]
    after: Mapping[str, float]
    mass: float
    weighing: tuple[str, ...]
    wrench: Array
    keeps: bool = False
    least: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def put(self, model: Any, data: Any, squeeze: float = 1.0, load: float = 1.0) -> None:
        """Put a simulation at its start, with these shares of squeeze, and of weight and load.

        model, data : mujoco.MjModel and MjData of the MJCF. The share of the weight is kept in the model.
        """
        mujoco = import_mujoco()
        mujoco.mj_resetData(model, data)
        for name, value in self.positions.items():
            data.qpos[model.jnt_qposadr[model.joint(name).id]] = value
        self.drive(model, data, squeeze, load)
        with without_mujoco_log():
            mujoco.mj_forward(model, data)

    def drive(
        self, model: Any, data: Any, squeeze: float, load: float, wrench: Array | None = None, sag: float = 1.0
    ) -> None:
        """Set the shares of squeeze, and of weight and load, while a simulation runs.

        wrench : (6,) instead of the state's own; all of it. sag : share of the weight of the hand's own links.
        """
        for name, start in self.before.items():
            data.ctrl[model.actuator(name).id] = start + squeeze * (self.after[name] - start)
        for name, (first, last) in self.least.items():
            model.actuator_forcerange[model.actuator(name).id, 0] = first + squeeze * (last - first)
        for name in self.weighing:
            model.body_gravcomp[model.body(name).id] = 1.0 - sag
        body = model.body(OBJECT_NAME).id
        model.body_gravcomp[body] = 1.0 - load * self.mass / model.body_mass[body]
        data.xfrc_applied[model.body(LOADED_POINT_NAME).id] = load * self.wrench if wrench is None else np.array(wrench)


# ----------------------------------------------------------------
# Where a simulation starts: the fingertips touch, and whatever overlap the posture has is still to be closed.

_TOUCH_TOLERANCE = 1e-6  # [m] an overlap up to this is what is left of touching
_OPENING_TOLERANCE = 1e-9  # [m] what is opened ends as near as this
_MAX_START_OVERLAP = 1e-5  # [m] an overlap up to this that joints cannot open is begun with: pads give way more
_MAX_OPENING_STEPS = 30


def least_tendon_forces(grasp: HandGrasp) -> dict[str, tuple[float, float]]:
    """The least forces of actuators of tendons that may go slack, before and after the hand has closed [N]: an actuator
    that holds the joints where they are commanded, where its tendon pulls with a, pulls with a + F ≥ 0.
    """
    cables = grasp.mechanism.joint_model.cables
    if cables is None or not np.isfinite(cables.pretension).any() or has_routes(grasp.state.hand):
        return {}
    states = grasp.follow(order="squeeze").steps.states if find_command(grasp.spec.effects) else ()
    found = dict[str, tuple[float, float]]()
    for i in np.flatnonzero(np.isfinite(cables.pretension)).tolist():
        first = after = float(cables.pretension[i])
        if states:
            commanded = grasp.state.q + states[-1].controls.command
            after = float((states[-1].pull.drawn - cables.springs @ (cables.arms @ commanded))[i])
        found[cables.names[i]] = -first, -after
    return found


def make_start_state(
    grasp: HandGrasp, springs: SimulatedSprings, least: Mapping[str, tuple[float, float]]
) -> SimulatorState:
    """Posture, commands and load. least : as in `SimulatorState`. Raises Unsupported where tips overlap the object and
    joints cannot open them, and for rigid joints that would have to move.
    """
    hand, q = grasp.state.hand, grasp.state.q
    kinematics, gravity = hand.kinematics, grasp.mechanism.gravity
    command = find_command(grasp.spec.effects)
    offset = grasp.joint_offset if command is None else command.motor_offset
    start = _open_posture(grasp) if command is None or command.opened is None else command.opened
    for j in springs.rigid:
        if offset[j] or start[j] != q[j]:
            raise Unsupported(f"joint {hand.joint_names[j]!r} is rigid: it cannot be commanded beyond where it stands")
    held, weighing = np.zeros(len(q)), tuple[str, ...]()
    if grasp.finger_weight == "torques":  # the posture has sagged already
        held = hand.stiffness.deflection(kinematics.gravity_torque(q, gravity))
    elif grasp.finger_weight:
        weighing = tuple(kinematics.model.names)[1:]
    full = start if kinematics.coupling is None else kinematics.coupling @ start + kinematics.offset
    before = springs.arms @ (start + held + spring_command_offset(hand, start))
    after = springs.arms @ (q + held + offset + spring_command_offset(hand, q + offset))
    if has_routes(hand):
        before, after = route_commands(grasp, springs.names, springs.arms)
    obj, spec = grasp.target, grasp.spec
    assert obj is not None
    weight = obj.mass * gravity
    moment = cross_rows(obj.center_of_mass - spec.reference, weight)
    return SimulatorState(
        positions=dict(zip(movable_joint_names(hand), full.tolist(), strict=True)),
        before=dict(zip(springs.names, before.tolist(), strict=True)),
        after=dict(zip(springs.names, after.tolist(), strict=True)),
        mass=float(obj.mass),
        weighing=weighing,
        wrench=read_only(spec.wrench - np.append(weight, moment)),
        keeps=command is not None and command.keeps,
        least=least,
    )


def _open_posture(grasp: HandGrasp) -> Array:
    """(nv,) the posture, with fingers that overlap the object opened until they touch it, joint by joint."""
    posture: HandPosture = grasp.state
    mechanism, obj = grasp.mechanism, grasp.target
    assert obj is not None
    k, tips = len(mechanism.tips), mechanism.tips
    inside = np.zeros(k)
    for turn in range(_MAX_OPENING_STEPS):
        shapes = [posture.hand.tip_shapes(i) for i in tips]
        places, turns = posture.tip_positions[list(tips)], posture.tip_rotations[list(tips)]
        near = [nearest_proximity(s, p, R, obj) for s, p, R in zip(shapes, places, turns, strict=True)]
        gaps = np.array([n.gap for n in near])
        inside = np.where(gaps < -_TOUCH_TOLERANCE if not turn else inside != 0.0, -gaps, 0.0)
        if abs(inside).max(initial=0.0) <= _OPENING_TOLERANCE:
            return posture.q
        positions, normals = np.array([n.position for n in near]), np.array([n.normal for n in near])
        frames = grasp.frames[:k].copy()
        frames[:, :, 2] = normals  # tangents do not matter: only depths along normals are asked for
        moved = mechanism.move_contacts(posture, positions, frames)
        closed = tip_motions_by_joint(moved, grasp.spec.planar).command_for_depth(inside)
        posture = HandPosture(posture.hand, posture.q - closed)
    if inside.max() <= _MAX_START_OVERLAP:
        return posture.q
    name, depth = grasp.fingertips[int(np.argmax(inside))], 1e3 * float(inside.max())
    raise Unsupported(f"fingertip {name!r} starts {depth:.3g} mm inside the object, and its joints cannot open it")


# ----------------------------------------------------------------


@check_call()
def to_mujoco(grasp: Grasp, settings: SimulatorSettings | None = None) -> tuple[str, SimulatorState]:
    """The same grasp for MuJoCo: MJCF, and the state to start from.

        model = mujoco.MjModel.from_xml_string(xml)
        data = mujoco.MjData(model)
        state.put(model, data)

    grasp : of a hand around an object. settings : what statics does not have; None: those that make it quasi-static.

    Joints are driven by position actuators, whose stiffness is that of the joints; pads are sprung slides; fingertips
    touch the object, the object touches its supports, and nothing else touches anything. Joints have no stops, as in
    the grasp. MuJoCo itself is not needed to write this.

    Raises InputError; Unsupported, by name, for what MuJoCo cannot have exactly: preloads and offsets that no joint
    makes, contacts given one by one, meshes that are not convex, anisotropic friction, prescribed and bounded forces,
    tendons that rub on posts, soft wrists and surfaces, pads that turn, fingertips that touch along a line or on a
    patch.
    """
    hand_grasp, settings = require_hand_grasp(grasp), SimulatorSettings() if settings is None else settings
    check_writable(hand_grasp)
    spec, mechanism, hand, obj = hand_grasp.spec, hand_grasp.mechanism, hand_grasp.state.hand, hand_grasp.target
    assert obj is not None
    root = _make_root(settings, mechanism.gravity)
    world = add_element(root, "worldbody")
    bodies = add_hand(world, hand, bool(hand_grasp.finger_weight), settings)
    tips = list[tuple[str, ...]]()
    for tip in mechanism.tips:
        check_point_contact(hand_grasp.state, tip, obj)
        tips.append(add_tip(root, bodies[hand.tips.places[tip].joint], hand, tip, obj, settings))
    body = add_object(root, world, obj, spec, settings)
    corners = [add_corner(body, hand_grasp.state, tip, obj) for tip in mechanism.tips]
    touching = [(ours, corner or OBJECT_NAME) for ours, corner in zip(tips, corners, strict=True)]
    touching += [((ground,), foot) for ground, foot in add_supports(world, body, spec, obj, settings)]
    pairs = add_element(root, "contact")
    for i, ((ours, other), contact) in enumerate(zip(touching, spec.contacts, strict=True)):
        words = friction_attributes(spec.names[i], contact.friction)
        words |= {} if i < spec.of_hand else _impedance_attributes(settings.support_impedance)
        for one in ours:
            add_element(pairs, "pair", name=one, geom1=one, geom2=other, **words)
    limited, least = any(isinstance(e, TorqueSaturation) for e in spec.effects), least_tendon_forces(hand_grasp)
    at_last = {name: after for name, (_, after) in least.items()}
    springs = add_springs(root, bodies, hand, hand_grasp.state.q, limited, settings, at_last)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode"), make_start_state(hand_grasp, springs, least)


# The solver stops where its cost falls by less. That of an unbalanced force on friction is its square, a hundred
# thousandth of that: with 1e-14 some 3e-4 N are left over, which push a contact that slides along for minutes
_SOLVER_TOLERANCE = 1e-18


def _make_root(settings: SimulatorSettings, gravity: Array) -> ET.Element:
    """The settings that make it quasi-static."""
    root = ET.Element("mujoco", model="handlcp")
    add_element(root, "compiler", angle="radian", autolimits="true", balanceinertia="true")
    statics = {"timestep": settings.timestep, "gravity": gravity, "cone": "elliptic", "integrator": "implicitfast"}
    solver = {"solver": "Newton", "iterations": "100", "jacobian": "dense", "tolerance": _SOLVER_TOLERANCE}
    distances = {"ccd_tolerance": 1e-9, "ccd_iterations": "100"}
    add_element(root, "option", **statics, impratio=settings.friction_impedance, **solver, **distances)
    default, overlap, slip = add_element(root, "default"), (settings.contact_time, 1.0), (settings.friction_time, 1.0)
    stiff, equal = (_impedance_attributes(x) for x in (settings.impedance, settings.support_impedance))
    add_element(default, "pair", solref=overlap, solreffriction=slip, **stiff)
    add_element(default, "equality", solref=overlap, **equal)
    return root


def _impedance_attributes(impedance: float) -> dict[str, tuple[float, ...]]:
    return {"solimp": (impedance, impedance, 1e-3)}
