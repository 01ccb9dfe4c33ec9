"""What [hand] says of springs, tendons, synergies and motors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.actuation import Motor, Synergies, Tendons
from handlcp.check import Array, check_array
from handlcp.errors import translate_arguments
from handlcp.geometry import YCB, Box, Cylinder, Ellipsoid, Mesh, Object, Sphere, Table
from handlcp.geometry.link_contacts import TIPS_ONLY, expand_link_values
from handlcp.grasp import Contact, Environment, Grasp, GraspSolution
from handlcp.grasp.model.effect import values_by_finger
from handlcp.hand import Hand, example_hand
from handlcp.lcp import Auto
from handlcp.scene.keys import read_tables, read_text_file
from handlcp.scene.scene_tables import SceneTables, check_names, is_by_finger, make_effects, make_law
from handlcp.scene.schema import (
    BoxTable,
    CylinderTable,
    EllipsoidTable,
    HandTable,
    MeshTable,
    MotorTable,
    ObjectTable,
    SphereTable,
    TendonMotorTable,
    TendonsTable,
    YCBTable,
)

# Arguments of `Hand.from_urdf`, and the keys that they come from
HAND_KEYS = {
    "source": "hand.urdf",
    "path": "hand.urdf",
    "name": "hand.name",
    "base": "hand.base",
    "fingertips": "hand.fingertips",
    "joint_stiffness": "hand.joint_stiffness_Nm_per_rad",
    "pad_flexibility": "hand.pad_flexibility_m_per_N",
    "Tendons.moment_arms": "hand.tendons.moment_arms_m",
    "Tendons.stiffness": "hand.tendons.stiffness_N_per_m",
    "Tendons.passive": "hand.tendons.passive_Nm_per_rad",
    "Tendons.pretension": "hand.tendons.pretension_N",
    "Tendons.limits": "hand.tendons.limits_N",
    "Tendons.friction": "hand.tendons.friction",
    "Tendons.motors": "hand.tendons.motors",
    "Synergies.S": "hand.synergies.columns",
    "Synergies.stiffness": "hand.synergies.stiffness_Nm_per_rad",
    "Synergies.joint_stiffness": "hand.synergies.joint_stiffness_Nm_per_rad",
    "torque_limits": "hand.torque_limits_Nm",
    "tip_radius": "hand.tip_radius_m",
    "package_dirs": "hand.package_dirs",
    "motors": "hand.motors",
    "joint_friction": "hand.joint_friction_Nm",
}
_COMMON_MOTOR_KEYS = {
    "continuous": "continuous_Nm",
    "peak": "peak_Nm",
    "efficiency": "efficiency",
    "thermal_time": "thermal_time_s",
}
_JOINT_MOTOR_KEYS = _COMMON_MOTOR_KEYS | {
    "holding": "holding_Nm",
    "friction": "friction_Nm",
    "reduction": "reduction",
    "stiffness": "stiffness_Nm_per_rad",
}
_TENDON_MOTOR_KEYS = _COMMON_MOTOR_KEYS | {
    "holding": "holding_N",
    "friction": "friction_N",
    "reduction": "reduction_N_per_Nm",
}


def make_motors(table: HandTable | TendonsTable, path: str = "hand") -> Any:
    """What [hand] or [hand.tendons] says of motors; None: nothing."""
    if table.motor is not None:
        return _make_motor(table.motor, f"{path}.motor")
    if table.motors is None:
        return None
    return {name: _make_motor(motor, f"{path}.motors.{name}") for name, motor in table.motors.items()}


def _make_motor(table: MotorTable | TendonMotorTable, path: str) -> Motor:
    own = _JOINT_MOTOR_KEYS if isinstance(table, MotorTable) else _TENDON_MOTOR_KEYS
    with translate_arguments({f"Motor.{argument}": f"{path}.{key}" for argument, key in own.items()}):
        return Motor(**{argument: getattr(table, key) for argument, key in own.items()})


def make_stiffness(table: HandTable) -> Any:
    """What [hand] says of stiffness."""
    with translate_arguments(HAND_KEYS):
        if (t := table.tendons) is not None:
            forces = t.pretension_N, t.limits_N, t.friction, make_motors(t, "hand.tendons")
            return Tendons(t.moment_arms_m, t.stiffness_N_per_m, t.passive_Nm_per_rad, *forces)
        if (s := table.synergies) is not None:
            columns: Any = s.columns
            if not isinstance(columns, dict):  # written one by one
                columns = check_array("Synergies.S", columns, (-1, -1)).T
            return Synergies(columns, s.stiffness_Nm_per_rad, s.joint_stiffness_Nm_per_rad)
    return table.joint_stiffness_Nm_per_rad


# ----------------------------------------------------------------
# From a checked scene file to a grasp. Refusals of the package's own functions are given the file's key names.


class SceneFile(SceneTables):
    """The tables of a scene file, and the grasp that they describe. Immutable."""

    def build(self) -> Grasp:
        """Build the grasp that the file describes: a `HandGrasp` when there is a [hand], else a `Grasp`.

        Raises InputError, naming the key.
        """
        return build_grasp(self)

    def shape(self) -> Object | None:
        """The object, or None where the file has none."""
        return make_scene_object(self)

    def solve(self, throw: bool = True) -> GraspSolution:
        """Build and solve as the file says; see `Grasp.solve`."""
        return self.build().solve(self.solve_with.faces, Auto(seed=self.solve_with.seed), throw)


def load(path: Any) -> SceneFile:
    """Read a scene file. Raises SceneFileError for one that is missing, is no TOML, or does not describe a scene."""
    text, file = read_text_file(path, "a scene file")
    return read(text, file.parent, file.name)


def read(text: str, folder: Any = ".", label: str = "scene") -> SceneFile:
    """Read a scene from a string; relative paths start at `folder`, errors start with `label`."""
    scene = read_tables(SceneFile, text, label)
    scene._folder = Path(folder)
    return scene


# ----------------------------------------------------------------

# Arguments of the package's functions, and the keys that they come from
OBJECT_KEYS = {
    "size": "size_m",
    "radius": "radius_m",
    "length": "length_m",
    "radii": "radii_m",
    "path": "file",
    "scale": "scale",
    "mass": "mass_kg",
    "density": "density_kg_per_m3",
    "placement": "position_m",
    "name": "name",
}
GRASP_KEYS = HAND_KEYS | {
    "q": "posture.q_rad",
    "q0": "posture.q_rad",
    "obj": "object",
    "friction": "grasp.friction",
    "gravity": "grasp.gravity_m_per_s2",
    "preload": "grasp.preload_m",
    "fingers": "grasp.fingers",
    "squeeze": "grasp.squeeze_m",
    "grip_force": "grasp.grip_force_N",
    "joint_offset": "grasp.joint_offset_rad",
    "closing_torque": "grasp.closing_torque_Nm",
    "hold_object": "grasp.hold_object",
    "links": "grasp.links",
    "target": "object",
    "max_gap": "grasp.max_gap_m",
    "reference": "grasp.reference_m",
    "plane": "grasp.plane",
    "flexibility": "grasp.flexibility_m_per_N",
    "wrench": "load",
    "contacts": "contact",
}
ENVIRONMENT_KEYS = {
    "point": "point_m",
    "position": "position_m",
    "normal": "normal",
    "flexibility": "flexibility_m_per_N",
    "max_gap": "max_gap_m",
    "gap": "gap_m",
    "tangent": "tangent",
    "name": "name",
}


def build_grasp(scene: SceneTables) -> Grasp:
    """The grasp that a scene file describes."""
    return _build_hand_grasp(scene) if scene.hand is not None else _build_contact_grasp(scene)


def make_hand(scene: SceneTables) -> Hand:
    """The hand of a scene that has one."""
    h = scene.hand
    assert h is not None
    words: dict[str, Any] = {
        "base": h.base,
        "fingertips": h.fingertips,
        "joint_stiffness": make_stiffness(h),
        "pad_flexibility": h.pad_flexibility_m_per_N,
        "torque_limits": h.torque_limits_Nm,
        "tip_radius": h.tip_radius_m,
        "package_dirs": None if h.package_dirs is None else [str(scene.folder / d) for d in h.package_dirs],
        "motors": make_motors(h),
        "joint_friction": h.joint_friction_Nm,
    }
    given = {name: value for name, value in words.items() if value is not None}
    with translate_arguments(HAND_KEYS):
        return example_hand(h.name, **given) if h.name else Hand.from_urdf(scene.folder / (h.urdf or ""), **given)


def make_scene_object(scene: SceneTables) -> Object | None:
    """The object of a scene; None where there is none."""
    return None if scene.object is None else make_object(scene.object, scene.folder)


def make_object(table: ObjectTable, folder: Path, key: str = "object") -> Object:
    """The object of a table at `key`; files are relative to `folder`. Raises InputError, naming the key."""
    placement = pin.SE3(pin.rpy.rpyToMatrix(*table.rpy_rad), np.array(table.position_m))
    weight: dict[str, Any] = {"mass": table.mass_kg, "density": table.density_kg_per_m3}
    with translate_arguments({argument: f"{key}.{name}" for argument, name in OBJECT_KEYS.items()}):
        match table:
            case BoxTable():
                return Box(table.size_m, placement, **weight)
            case SphereTable():
                return Sphere(table.radius_m, placement, **weight)
            case CylinderTable():
                return Cylinder(table.radius_m, table.length_m, placement, **weight)
            case EllipsoidTable():
                return Ellipsoid(table.radii_m, placement, **weight)
            case MeshTable():
                return Mesh(folder / table.file, table.scale, placement, **weight)
            case YCBTable():
                return YCB(table.name, placement, **weight)


def _build_hand_grasp(scene: SceneTables) -> Grasp:
    the_hand, obj, g, posture = make_hand(scene), make_scene_object(scene), scene.grasp, scene.posture
    assert obj is not None
    around = _make_environment(scene, obj)
    on_links = g.links != TIPS_ONLY
    with translate_arguments(GRASP_KEYS):
        q = _complete_posture(the_hand, posture.q_rad)
        if posture.close and not on_links:
            with translate_arguments({"squeeze": "posture.squeeze_m"}):
                q = the_hand.close_on(obj, q, fingers=g.fingers, squeeze=posture.squeeze_m)
        elif posture.close and g.closing_torque_Nm is None and g.joint_offset_rad is None:
            q = the_hand.close_on(obj, q, wrap=True)
        fingers = the_hand.fingertips if g.fingers is None else tuple(g.fingers)
        given: Any = g.friction
        laws = {f: make_law(v) for f, v in given.items()} if is_by_finger(given) else make_law(given)
        words: dict[str, Any] = {
            "reference": g.reference_m,
            "fingers": g.fingers,
            "max_gap": g.max_gap_m,
            "finger_weight": g.finger_weight,
            "plane": g.plane,
            "squeeze": g.squeeze_m,
            "grip_force": g.grip_force_N,
            "joint_offset": g.joint_offset_rad,
            "closing_torque": g.closing_torque_Nm,
            "hold_object": g.hold_object,
            "links": g.links,
            "environment": around,
        }
        found, preload = None, g.preload_m
        if on_links:  # what is said by contact has to wait until contacts have been found
            found = the_hand.at(q).grasp(obj, laws, _load_wrench(scene), g.gravity_m_per_s2, **words)
            fingers, preload = found.fingertips, expand_link_values("grasp.preload_m", preload, found.state.hand)
    asked, keys = make_effects(scene.effects, fingers)
    more = {"preload": values_by_finger("grasp.preload_m", preload, fingers, 0.0), "effects": asked}
    with translate_arguments(GRASP_KEYS | keys):
        if found is not None:
            return found.replace(**more) if any(more.values()) else found
        return the_hand.at(q).grasp(obj, laws, _load_wrench(scene), g.gravity_m_per_s2, **more, **words)


def _build_contact_grasp(scene: SceneTables) -> Grasp:
    g, tables, contacts = scene.grasp, scene.contact, []
    names = tuple(c.name or f"finger {i + 1}" for i, c in enumerate(tables))
    laws: Any = g.friction if is_by_finger(g.friction) else dict.fromkeys(names, g.friction)
    check_names("grasp.friction", laws, names)
    for i, c in enumerate(tables):
        law = laws.get(names[i], 0.6) if c.friction is None else c.friction
        with translate_arguments({"position": f"contact[{i}].position_m"}, f"contact[{i}]."):
            contacts.append(Contact(c.position_m, c.normal, make_law(law, f"contact[{i}].friction"), c.tangent, c.name))
    wrench, reference = _load_wrench(scene), np.array([0.0, 0.0, 0.0] if g.reference_m is None else g.reference_m)
    obj = make_scene_object(scene)
    around = _make_environment(scene, obj)
    if obj is not None and obj.mass > 0:
        if g.reference_m is None:
            reference = obj.center_of_mass
        weight = obj.mass * np.array(g.gravity_m_per_s2)
        wrench = wrench + np.concatenate([weight, np.cross(obj.center_of_mass - reference, weight)])
    asked, keys = make_effects(scene.effects, names)
    with translate_arguments(GRASP_KEYS | keys):
        return Grasp(
            contacts,
            wrench,
            flexibility=g.flexibility_m_per_N or 0.0,
            reference=reference,
            plane=g.plane,
            preload=values_by_finger("grasp.preload_m", g.preload_m, names, 0.0),
            effects=asked,
            environment=around,
        )


def _make_environment(scene: SceneTables, obj: Object | None) -> list[Environment] | None:
    """What the object touches besides the fingers; None: nothing."""
    parts = []
    for i, e in enumerate(scene.environment):
        where, law = f"environment[{i}]", make_law(e.friction, f"environment[{i}].friction")
        with translate_arguments({a: f"{where}.{key}" for a, key in ENVIRONMENT_KEYS.items()} | {"environment": where}):
            if e.point_m is None:
                contact = Contact(e.position_m, e.normal, law, e.tangent, e.name)
                parts.append(Environment([contact], e.flexibility_m_per_N, e.gap_m))
            else:
                assert obj is not None
                table = Table(e.point_m, e.normal, law, e.flexibility_m_per_N, e.max_gap_m, e.name or "table")
                parts.append(table.under(obj))
    return parts or None


def _complete_posture(the_hand: Hand, q: Any) -> Any:
    """A table of some joints is completed with the neutral posture."""
    if not isinstance(q, dict):
        return the_hand.neutral if q is None else q
    check_names("posture.q_rad", q, the_hand.joint_names)
    return dict(zip(the_hand.joint_names, the_hand.neutral.tolist(), strict=True)) | q


def _load_wrench(scene: SceneTables) -> Array:
    return np.array([*scene.load.force_N, *scene.load.torque_Nm])
