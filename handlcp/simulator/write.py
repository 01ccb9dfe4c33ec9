"""A hand's grasp as MJCF: the same joints, springs, pads, friction, supports and load."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import Unsupported
from handlcp.grasp import Grasp, TorqueSaturation
from handlcp.grasp.model.vectors import cross_rows
from handlcp.hand import HandGrasp
from handlcp.hand.objects.detect import nearest
from handlcp.simulator.fingertips import Pad, add_tip, round_shape
from handlcp.simulator.hand_tree import add_hand, full_names
from handlcp.simulator.object_body import OBJECT, add_object
from handlcp.simulator.refusals import check_writable, friction_words, of_a_hand
from handlcp.simulator.settings import SimulatorSettings
from handlcp.simulator.springs import Springs, add_springs
from handlcp.simulator.state import SimulatorState
from handlcp.simulator.supports import add_supports
from handlcp.simulator.words import add

__all__ = ["to_mujoco"]

_APART = 1e-9  # [m] overlaps below this are rounding


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
    soft wrists and surfaces, pads that turn, fingertips of several shapes, flat fingertips on flat faces.
    """
    hand_grasp, settings = of_a_hand(grasp), SimulatorSettings() if settings is None else settings
    places = _detected(hand_grasp)
    check_writable(hand_grasp, places.gaps)
    spec, mechanism, hand, obj = hand_grasp.spec, hand_grasp.mechanism, hand_grasp.state.hand, hand_grasp.target
    assert obj is not None
    root = _frame(settings, mechanism.gravity)
    world = add(root, "worldbody")
    bodies = add_hand(world, hand, bool(hand_grasp.finger_weight))
    pads, pairs = list[Pad](), list[tuple[str, str, str]]()
    for name, tip in zip(spec.names, mechanism.tips, strict=False):
        parent = hand.kinematics.model.frames[hand.tips.frames[tip]].parentJoint
        geom, pad, shape = add_tip(root, bodies[parent], hand, tip, settings)
        if not (round_shape(shape.geometry) or round_shape(obj.geometry)):
            raise Unsupported(
                f"fingertip {name!r} and the object may touch in more than one point: give it a tip_radius"
            )
        pads.append(pad)
        pairs.append((name, geom, OBJECT))
    body = add_object(root, world, obj, spec, settings)
    supports = add_supports(world, body, spec, obj, settings)
    pairs += [(s.name, s.ground, s.ours) for s in supports]
    touching = add(root, "contact")
    for i, ((name, one, other), contact) in enumerate(zip(pairs, spec.contacts, strict=True)):
        stiff = {} if i < spec.of_fingers else _stiffness(settings.support_impedance)
        add(touching, "pair", name=name, geom1=one, geom2=other, **friction_words(name, contact.friction), **stiff)
    limited = any(isinstance(e, TorqueSaturation) for e in spec.effects)
    springs = add_springs(root, hand, hand_grasp.state.q, limited, settings)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode"), _state(hand_grasp, springs, pads, places)


@dataclass(frozen=True, eq=False)
class _Places:
    """Gaps (k,) and normals (k, 3) between fingertips and object, as detected."""

    gaps: Array
    normals: Array


def _detected(grasp: HandGrasp) -> _Places:
    at, obj, tips = grasp.state, grasp.target, grasp.mechanism.tips
    assert obj is not None
    found = [nearest(at.hand.tip_shapes(i), at.tip_positions[i], at.tip_rotations[i], obj) for i in tips]
    return _Places(np.array([p.gap for p in found]), np.array([p.normal for p in found]))


def _frame(settings: SimulatorSettings, gravity: Array) -> ET.Element:
    """The settings that make it quasi-static."""
    root = ET.Element("mujoco", model="handlcp")
    add(root, "compiler", angle="radian", autolimits="true", balanceinertia="true")
    option = add(
        root, "option", timestep=settings.timestep, gravity=gravity, cone="elliptic", integrator="Euler",
        impratio=settings.friction_impedance, solver="Newton", iterations="100", tolerance=1e-10, ccd_tolerance=1e-9,
        ccd_iterations="100",
    )  # fmt: skip
    add(option, "flag", eulerdamp="disable")  # else friction would be computed with other accelerations
    stiff = _stiffness(settings.impedance)
    times = {"solref": (settings.contact_time, 1.0), "solreffriction": (settings.friction_time, 1.0)}
    default = add(root, "default")
    add(default, "pair", **times, **stiff)
    add(default, "equality", solref=(settings.contact_time, 1.0), **_stiffness(settings.support_impedance))
    return root


def _stiffness(impedance: float) -> dict[str, tuple[float, ...]]:
    return {"solimp": (impedance, impedance, 1e-3)}


def _state(grasp: HandGrasp, springs: Springs, pads: list[Pad], places: _Places) -> SimulatorState:
    """Where it starts. Raises Unsupported where that cannot be."""
    hand, q, offset = grasp.state.hand, grasp.state.q, grasp.joint_offset
    kinematics, gravity = hand.kinematics, grasp.mechanism.gravity
    for j in springs.rigid:
        if offset[j]:
            raise Unsupported(f"joint {hand.joint_names[j]!r} is rigid: it cannot be commanded beyond where it stands")
    command, weighing = np.array(q), tuple(kinematics.model.names)[1:] if grasp.finger_weight is True else ()
    if grasp.finger_weight == "torques":  # the posture has sagged already
        command = q + hand.stiffness.deflection(kinematics.gravity_torque(q, gravity))
    full = q if kinematics.coupling is None else kinematics.coupling @ q + kinematics.offset
    before, after = springs.arms @ command, springs.arms @ (command + offset)
    obj, spec = grasp.target, grasp.spec
    assert obj is not None
    weight = obj.mass * gravity
    moment = cross_rows(obj.center_of_mass - spec.reference, weight)
    return SimulatorState(
        dict(zip(full_names(hand), full.tolist(), strict=True)), _retreat(grasp, pads, places),
        dict(zip(springs.names, before.tolist(), strict=True)), dict(zip(springs.names, after.tolist(), strict=True)),
        weighing, read_only(spec.wrench - np.append(weight, moment)),
    )  # fmt: skip


def _retreat(grasp: HandGrasp, pads: list[Pad], places: _Places) -> dict[str, float]:
    """How far pads start pushed back by an object that they overlap. Raises Unsupported for one that is rigid there."""
    found = dict[str, float]()
    for name, tip, pad, gap, normal in zip(
        grasp.fingertips, grasp.mechanism.tips, pads, places.gaps, places.normals, strict=True
    ):
        if gap < -_APART:
            back = grasp.state.tip_rotations[tip].T @ normal * gap
            along = pad.axes @ back
            if np.linalg.norm(pad.axes.T @ along - back) > _APART:
                raise Unsupported(
                    f"fingertip {name!r} starts {-gap * 1e3:.3g} mm inside the object, and its pad does not give way: "
                    "start from touching and squeeze with joint_offset"
                )
            found |= dict(zip(pad.names, along.tolist(), strict=True))
    return found
