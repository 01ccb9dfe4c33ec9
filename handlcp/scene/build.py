"""`SceneFile`: from the tables of a scene file to its hand, its object and its grasp."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

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
from handlcp.scene.key_types import FileTable
from handlcp.scene.keys import read_tables, read_text_file
from handlcp.scene.scene_tables import SceneTables, check_names, is_by_finger, make_effects, make_law
from handlcp.scene.schema import (
    BoxTable,
    CylinderTable,
    EllipsoidTable,
    GraspTable,
    HandTable,
    MeshTable,
    MotorTable,
    ObjectTable,
    SphereTable,
    SynergiesTable,
    TendonMotorTable,
    TendonsTable,
    YCBTable,
)

# Where the package's own functions name an argument, errors name the key that it came from
HAND_KEYS = {
    **HandTable.keys_by_argument("hand"),
    **TendonsTable.keys_by_argument("hand.tendons", "Tendons."),
    **SynergiesTable.keys_by_argument("hand.synergies", "Synergies."),
    "source": "hand.urdf",
    "path": "hand.urdf",
    "Synergies.S": "hand.synergies.columns",
}
GRASP_KEYS = {
    **HAND_KEYS,
    **GraspTable.keys_by_argument("grasp"),
    "q": "posture.q_rad",
    "q0": "posture.q_rad",
    "obj": "object",
    "target": "object",
    "wrench": "load",
    "contacts": "contact",
}


def make_motors(table: HandTable | TendonsTable, path: str = "hand") -> Any:
    """What [hand] or [hand.tendons] says of motors; None: nothing."""
    if table.motor is not None:
        return _make_motor(table.motor, f"{path}.motor")
    if table.motors is None:
        return None
    return {name: _make_motor(motor, f"{path}.motors.{name}") for name, motor in table.motors.items()}


def _make_motor(table: MotorTable | TendonMotorTable, path: str) -> Motor:
    with translate_arguments(table.keys_by_argument(path, "Motor.")):
        return Motor(**table.arguments())


def make_stiffness(table: HandTable) -> Any:
    """What [hand] says of stiffness."""
    with translate_arguments(HAND_KEYS):
        if (t := table.tendons) is not None:
            return Tendons(**t.arguments("motor") | {"motors": make_motors(t, "hand.tendons")})
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


def build_grasp(scene: SceneTables) -> Grasp:
    """The grasp that a scene file describes."""
    return _build_hand_grasp(scene) if scene.hand is not None else _build_contact_grasp(scene)


def make_hand(scene: SceneTables) -> Hand:
    """The hand of a scene that has one."""
    h = scene.hand
    assert h is not None
    given = h.arguments("name", "urdf", "tendons", "synergies", "motor", "motors", "joint_stiffness")
    if h.package_dirs is not None:
        given["package_dirs"] = [str(scene.folder / folder) for folder in h.package_dirs]
    for name, value in (("joint_stiffness", make_stiffness(h)), ("motors", make_motors(h))):
        if value is not None:
            given[name] = value
    with translate_arguments(HAND_KEYS):
        return example_hand(h.name, **given) if h.name else Hand.from_urdf(scene.folder / (h.urdf or ""), **given)


def make_scene_object(scene: SceneTables) -> Object | None:
    """The object of a scene; None where there is none."""
    return None if scene.object is None else make_object(scene.object, scene.folder)


OBJECT_KINDS: dict[type[Object], type[FileTable]] = {  # a scan is a mesh, too, and stands before it
    Box: BoxTable,
    Sphere: SphereTable,
    Cylinder: CylinderTable,
    Ellipsoid: EllipsoidTable,
    YCB: YCBTable,
    Mesh: MeshTable,
}


def make_object(table: ObjectTable, folder: Path, key: str = "object") -> Object:
    """The object of a table at `key`; files are relative to `folder`. Raises InputError, naming the key."""
    kind: Any = next(kind for kind, its in OBJECT_KINDS.items() if isinstance(table, its))
    given = table.arguments("shape", "position", "rpy")
    if "file" in given:
        given["path"] = folder / given.pop("file")
    placement = pin.SE3(pin.rpy.rpyToMatrix(*table.rpy_rad), np.array(table.position_m))
    own = {"path": f"{key}.file", "placement": f"{key}.position_m"}
    with translate_arguments(table.keys_by_argument(key) | own):
        return cast(Object, kind(placement=placement, **given))


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
        words = g.arguments("gravity", "preload", "flexibility") | {"friction": laws, "environment": around}
        words |= {"wrench": _load_wrench(scene), "gravity": g.gravity_m_per_s2}
        found, preload = None, g.preload_m
        if on_links:  # what is said by contact has to wait until contacts have been found
            found = the_hand.at(q).grasp(obj, **words)
            fingers, preload = found.fingertips, expand_link_values("grasp.preload_m", preload, found.state.hand)
    asked, keys = make_effects(scene.effects, fingers)
    more = {"preload": values_by_finger("grasp.preload_m", preload, fingers, 0.0), "effects": asked}
    with translate_arguments(GRASP_KEYS | keys):
        if found is not None:
            return found.replace(**more) if any(more.values()) else found
        return the_hand.at(q).grasp(obj, **more, **words)


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
        with translate_arguments(e.keys_by_argument(where) | {"environment": where}):
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
