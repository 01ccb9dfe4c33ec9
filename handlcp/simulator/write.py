"""A hand's grasp as MJCF: the same joints, springs, pads, friction, supports and load."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from handlcp.check import Array
from handlcp.errors import Unsupported
from handlcp.grasp import Grasp, TorqueSaturation
from handlcp.simulator.mjcf.fingertips import add_tip, round_shape
from handlcp.simulator.mjcf.hand_tree import add_hand
from handlcp.simulator.mjcf.object_body import OBJECT, add_object
from handlcp.simulator.mjcf.settings import SimulatorSettings
from handlcp.simulator.mjcf.springs import add_springs
from handlcp.simulator.mjcf.supports import add_supports
from handlcp.simulator.mjcf.words import add
from handlcp.simulator.refusals import check_writable, friction_words, of_a_hand
from handlcp.simulator.start import starting_state
from handlcp.simulator.state import SimulatorState


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
    check_writable(hand_grasp)
    spec, mechanism, hand, obj = hand_grasp.spec, hand_grasp.mechanism, hand_grasp.state.hand, hand_grasp.target
    assert obj is not None
    root = _frame(settings, mechanism.gravity)
    world = add(root, "worldbody")
    bodies = add_hand(world, hand, bool(hand_grasp.finger_weight))
    pairs = list[tuple[str, str, str]]()
    for name, tip in zip(spec.names, mechanism.tips, strict=False):
        parent = hand.kinematics.model.frames[hand.tips.frames[tip]].parentJoint
        geom, shape = add_tip(root, bodies[parent], hand, tip, settings)
        if not (round_shape(shape.geometry) or round_shape(obj.geometry)):
            raise Unsupported(
                f"fingertip {name!r} and the object may touch in more than one point: give it a tip_radius"
            )
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
    return ET.tostring(root, encoding="unicode"), starting_state(hand_grasp, springs)


def _frame(settings: SimulatorSettings, gravity: Array) -> ET.Element:
    """The settings that make it quasi-static."""
    root = ET.Element("mujoco", model="handlcp")
    add(root, "compiler", angle="radian", autolimits="true", balanceinertia="true")
    add(
        root, "option", timestep=settings.timestep, gravity=gravity, cone="elliptic",
        integrator="implicitfast", impratio=settings.friction_impedance, solver="Newton", iterations="100",
        jacobian="dense", tolerance=1e-14, ccd_tolerance=1e-9, ccd_iterations="100",
    )  # fmt: skip
    stiff = _stiffness(settings.impedance)
    times = {"solref": (settings.contact_time, 1.0), "solreffriction": (settings.friction_time, 1.0)}
    default = add(root, "default")
    add(default, "pair", **times, **stiff)
    add(default, "equality", solref=(settings.contact_time, 1.0), **_stiffness(settings.support_impedance))
    return root


def _stiffness(impedance: float) -> dict[str, tuple[float, ...]]:
    return {"solimp": (impedance, impedance, 1e-3)}
