"""From a checked scene file to a grasp. Refusals of the package's own functions are given the file's key names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import keyed
from handlcp.grasp import Contact, Environment, Grasp, GraspSolution
from handlcp.grasp.model.limit import by_finger
from handlcp.hand import YCB, Box, Cylinder, Ellipsoid, Hand, Mesh, Object, Sphere, Table, example_hand
from handlcp.hand.sites.sited import by_site
from handlcp.hand.sites.touchers import TIPS
from handlcp.lcp import Auto
from handlcp.scene.drives import HAND, motors, springs
from handlcp.scene.objects import BoxTable, CylinderTable, EllipsoidTable, MeshTable, ObjectTable, SphereTable, YCBTable
from handlcp.scene.reading import checked, text_of
from handlcp.scene.scene_tables import SceneTables, effects_of, is_by_finger, known, law_of


class SceneFile(SceneTables):
    """The tables of a scene file, and the grasp that they describe. Immutable."""

    def build(self) -> Grasp:
        """Build the grasp that the file describes: a `HandGrasp` when there is a [hand], else a `Grasp`.

        Raises InputError, naming the key.
        """
        return build(self)

    def shape(self) -> Object | None:
        """The object, or None where the file has none."""
        return shape(self)

    def solve(self, throw: bool = True) -> GraspSolution:
        """Build and solve as the file says; see `Grasp.solve`."""
        return self.build().solve(self.solve_with.faces, Auto(seed=self.solve_with.seed), throw)


def load(path: Any) -> SceneFile:
    """Read a scene file. Raises SceneFileError for one that is missing, is no TOML, or does not describe a scene."""
    text, file = text_of(path, "a scene file")
    return read(text, file.parent, file.name)


def read(text: str, folder: Any = ".", label: str = "scene") -> SceneFile:
    """Read a scene from a string; relative paths start at `folder`, errors start with `label`."""
    scene = checked(SceneFile, text, label)
    scene._folder = Path(folder)
    return scene


# ----------------------------------------------------------------

# Arguments of the package's functions, and the keys that they come from
OBJECT = {
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
GRASP = HAND | {
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
ENVIRONMENT = {
    "point": "point_m",
    "position": "position_m",
    "normal": "normal",
    "flexibility": "flexibility_m_per_N",
    "max_gap": "max_gap_m",
    "gap": "gap_m",
    "tangent": "tangent",
    "name": "name",
}


def build(scene: SceneTables) -> Grasp:
    """The grasp that a scene file describes."""
    return _by_hand(scene) if scene.hand is not None else _by_contacts(scene)


def hand(scene: SceneTables) -> Hand:
    """The hand of a scene that has one."""
    h = scene.hand
    assert h is not None
    words: dict[str, Any] = {
        "base": h.base,
        "fingertips": h.fingertips,
        "joint_stiffness": springs(h),
        "pad_flexibility": h.pad_flexibility_m_per_N,
        "torque_limits": h.torque_limits_Nm,
        "tip_radius": h.tip_radius_m,
        "package_dirs": None if h.package_dirs is None else [str(scene.folder / d) for d in h.package_dirs],
        "motors": motors(h),
        "joint_friction": h.joint_friction_Nm,
    }
    given = {name: value for name, value in words.items() if value is not None}
    with keyed(HAND):
        return example_hand(h.name, **given) if h.name else Hand.from_urdf(scene.folder / (h.urdf or ""), **given)


def shape(scene: SceneTables) -> Object | None:
    """The object of a scene; None where there is none."""
    return None if scene.object is None else object_of(scene.object, scene.folder)


def object_of(table: ObjectTable, folder: Path, key: str = "object") -> Object:
    """The object of a table at `key`; files are relative to `folder`. Raises InputError, naming the key."""
    placement = pin.SE3(pin.rpy.rpyToMatrix(*table.rpy_rad), np.array(table.position_m))
    weight: dict[str, Any] = {"mass": table.mass_kg, "density": table.density_kg_per_m3}
    with keyed({argument: f"{key}.{name}" for argument, name in OBJECT.items()}):
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


def _by_hand(scene: SceneTables) -> Grasp:
    the_hand, obj, g, posture = hand(scene), shape(scene), scene.grasp, scene.posture
    assert obj is not None
    around = _environment(scene, obj)
    on_links = g.links != TIPS
    with keyed(GRASP):
        q = _posture(the_hand, posture.q_rad)
        if posture.close and not on_links:
            with keyed({"squeeze": "posture.squeeze_m"}):
                q = the_hand.close_on(obj, q, fingers=g.fingers, squeeze=posture.squeeze_m)
        elif posture.close and g.closing_torque_Nm is None and g.joint_offset_rad is None:
            q = the_hand.close_on(obj, q, wrap=True)
        fingers = the_hand.fingertips if g.fingers is None else tuple(g.fingers)
        given: Any = g.friction
        laws = {f: law_of(v) for f, v in given.items()} if is_by_finger(given) else law_of(given)
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
            found = the_hand.at(q).grasp(obj, laws, _wrench(scene), g.gravity_m_per_s2, **words)
            fingers, preload = found.fingertips, by_site("grasp.preload_m", preload, found.state.hand)
    asked, keys = effects_of(scene.effects, fingers)
    more = {"preload": by_finger("grasp.preload_m", preload, fingers, 0.0), "effects": asked}
    with keyed(GRASP | keys):
        if found is not None:
            return found.replace(**more) if any(more.values()) else found
        return the_hand.at(q).grasp(obj, laws, _wrench(scene), g.gravity_m_per_s2, **more, **words)


def _by_contacts(scene: SceneTables) -> Grasp:
    g, tables, contacts = scene.grasp, scene.contact, []
    names = tuple(c.name or f"finger {i + 1}" for i, c in enumerate(tables))
    laws: Any = g.friction if is_by_finger(g.friction) else dict.fromkeys(names, g.friction)
    known("grasp.friction", laws, names)
    for i, c in enumerate(tables):
        law = laws.get(names[i], 0.6) if c.friction is None else c.friction
        with keyed({"position": f"contact[{i}].position_m"}, f"contact[{i}]."):
            contacts.append(Contact(c.position_m, c.normal, law_of(law, f"contact[{i}].friction"), c.tangent, c.name))
    wrench, reference = _wrench(scene), np.array([0.0, 0.0, 0.0] if g.reference_m is None else g.reference_m)
    obj = shape(scene)
    around = _environment(scene, obj)
    if obj is not None and obj.mass > 0:
        if g.reference_m is None:
            reference = obj.center_of_mass
        weight = obj.mass * np.array(g.gravity_m_per_s2)
        wrench = wrench + np.concatenate([weight, np.cross(obj.center_of_mass - reference, weight)])
    asked, keys = effects_of(scene.effects, names)
    with keyed(GRASP | keys):
        return Grasp(
            contacts,
            wrench,
            flexibility=g.flexibility_m_per_N or 0.0,
            reference=reference,
            plane=g.plane,
            preload=by_finger("grasp.preload_m", g.preload_m, names, 0.0),
            effects=asked,
            environment=around,
        )


def _environment(scene: SceneTables, obj: Object | None) -> list[Environment] | None:
    """What the object touches besides the fingers; None: nothing."""
    parts = []
    for i, e in enumerate(scene.environment):
        where, law = f"environment[{i}]", law_of(e.friction, f"environment[{i}].friction")
        with keyed({a: f"{where}.{key}" for a, key in ENVIRONMENT.items()} | {"environment": where}):
            if e.point_m is None:
                contact = Contact(e.position_m, e.normal, law, e.tangent, e.name)
                parts.append(Environment([contact], e.flexibility_m_per_N, e.gap_m))
            else:
                assert obj is not None
                table = Table(e.point_m, e.normal, law, e.flexibility_m_per_N, e.max_gap_m, e.name or "table")
                parts.append(table.under(obj))
    return parts or None


def _posture(the_hand: Hand, q: Any) -> Any:
    """A table of some joints is completed with the neutral posture."""
    if not isinstance(q, dict):
        return the_hand.neutral if q is None else q
    known("posture.q_rad", q, the_hand.joint_names)
    return dict(zip(the_hand.joint_names, the_hand.neutral.tolist(), strict=True)) | q


def _wrench(scene: SceneTables) -> Array:
    return np.array([*scene.load.force_N, *scene.load.torque_Nm])
