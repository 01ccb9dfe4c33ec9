"""An MJCF file, MuJoCo's format for robots, as the URDF that says the same.

MuJoCo compiles the file, so that its defaults, angles, includes and meshes mean here what they mean there; the compiled
model is written link by link. A free joint at the root is left out: the hand stands where the file puts it. What of the
file is no hand is left out and said (`mjcf_scene.py`).

| MJCF | URDF |
| --- | --- |
| body, site | link; a site is fixed to its body's link |
| hinge, slide | revolute or continuous, prismatic; several of one body in a row of links |
| forcerange of an actuator, actuatorfrcrange of a joint | effort |
| position actuator, of a joint or a tendon of joints | servo, a tag of our own: kp and arms |
| position actuator of a tendon along a path in space | cable, a tag of our own: kp, force and path |
| frictionloss | dynamics |
| stiffness, springref, armature of a joint | passive, a tag of our own |
| equality of two joints | mimic |
| connect of two bodies | pin, a tag of our own, for what is a fingertip |
| geom that collides | collision, and visual in the groups 0 to 2 |
| geom that doesn't collide | visual |
| mesh | mesh, with its compiled corners beside the URDF |
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.errors import URDFError
from handlcp.extras import missing
from handlcp.hand.robot.joints import Doubt
from handlcp.hand.robot.source.mjcf_cables import write_cables
from handlcp.hand.robot.source.mjcf_drives import couplings, efforts, reaches, write_passive, write_pins, write_servos
from handlcp.hand.robot.source.mjcf_meshes import compiled_meshes
from handlcp.hand.robot.source.mjcf_parts import add, add_shapes, placed, soft_parts
from handlcp.hand.robot.source.mjcf_scene import scene_parts
from handlcp.hand.robot.source.mjcf_size import check_size
from handlcp.hand.robot.source.mujoco_log import without_mujoco_log
from handlcp.hand.robot.source.part import CompiledMesh, rotation_of
from handlcp.read_file import MOST_XML, read_bytes

_MOST_PARTS = 3000  # that are written, before it is seen which of them are the hand
_UNBOUNDED = 1e3  # [m] the range of a slide without one


def urdf_of_mjcf(
    source: str, path: Path | None, base: str | None = None
) -> tuple[ET.Element, tuple[Doubt, ...], dict[str, CompiledMesh]]:
    """The <robot> that an MJCF text or file describes, what of it a URDF cannot say, and its meshes.

    base : the link that is asked for. Other arguments and errors as of `compiled`; URDFError for ball joints, too.
    """
    model = compiled(source, path)
    if (parts := int(model.nbody + model.njnt)) > _MOST_PARTS:
        raise URDFError("source", f"a model of at most {_MOST_PARTS} bodies and joints", f"one with {parts}")
    root, doubts = _Writer(model, base).robot()
    meshes, partial = compiled_meshes(model, path)
    return root, (*doubts, *partial), meshes


def compiled(source: str, path: Path | None) -> Any:
    """The mujoco.MjModel of an MJCF text or file.

    path : of the file; None: `source` is the text. Raises Unsupported without MuJoCo, URDFError for a file that MuJoCo
    refuses.
    """
    try:
        import mujoco
    except ImportError:
        raise missing("no MJCF file is read without MuJoCo", "mujoco") from None
    text = source.encode() if path is None else read_bytes("source", path, "an MJCF file", MOST_XML, URDFError)
    check_size("source", text, path)
    try:
        read = mujoco.MjModel.from_xml_path if path is not None else mujoco.MjModel.from_xml_string
        with without_mujoco_log():
            return read(source if path is None else str(path))
    except (ValueError, TypeError, RuntimeError, MemoryError, mujoco.FatalError) as error:
        shown = "the XML string" if path is None else repr(str(path))
        raise URDFError(
            "source", "an MJCF file that MuJoCo compiles", f"{shown}: {' '.join(str(error).split())}"
        ) from None


class _Writer:
    """Writes one compiled model."""

    def __init__(self, model: Any, base: str | None) -> None:
        self.model, self.doubts = model, list[Doubt]()
        self.root = ET.Element("robot", name=_model_name(model), format="mjcf")
        self.bodies = [model.body(i).name or f"body_{i}" for i in range(model.nbody)]
        owners = model.jnt_bodyid
        self.joints = [model.joint(j).name or f"{self.bodies[owners[j]]}_joint_{j}" for j in range(model.njnt)]
        self.scene = scene_parts(model, self.bodies, base)
        self.follows, more = couplings(model, self.joints, self.scene.bodies)
        sides, self.effort_said, found = efforts(model, self.joints, self.follows)
        self.weaker, self.effort = sides.T
        self.reaches = reaches(model)
        self.doubts += [*found, *more, *self.scene.said, *soft_parts(model)]

    def robot(self) -> tuple[ET.Element, tuple[Doubt, ...]]:
        """Everything."""
        for b in range(self.model.nbody):
            if b not in self.scene.bodies:
                self._body(b)
        for s in range(self.model.nsite):
            if int(self.model.site_bodyid[s]) not in self.scene.bodies:
                self._site(s)
        write_pins(self.root, self.model, self.bodies, self.scene.bodies)
        servos = write_servos(self.root, self.model, self.joints)
        self.doubts += write_cables(self.root, self.model, servos)
        return self.root, tuple(self.doubts)

    def _body(self, b: int) -> None:
        model, name = self.model, self.bodies[b]
        moves = [j for j in range(model.njnt) if model.jnt_bodyid[j] == b and model.jnt_type[j] != 0]
        at = model.jnt_pos[moves[-1]] if moves else np.zeros(3)  # where the link's frame is, in the body's
        carrier = name
        if b:
            links = [f"{name}/{self.joints[j]}" for j in moves]
            if not at.any():
                links[-1:] = [name]  # the last joint moves the body itself
            else:
                links.append(name)
            self._chain(b, moves, links)
            carrier = links[len(moves) - 1] if moves else name
        link = add(self.root, "link", name=name)
        if model.body_mass[b] > 0:
            owner = link if carrier == name else next(e for e in self.root.findall("link") if e.get("name") == carrier)
            self._inertia(owner, b, at if carrier != name else np.zeros(3))
        if b or not self.scene.ground:
            self.doubts += add_shapes(link, model, b)

    def _chain(self, b: int, moves: list[int], links: list[str]) -> None:
        """The joints from the parent's link to the body's, and the links between them."""
        model = self.model
        above, R, p = self.bodies[model.body_parentid[b]], rotation_of(model.body_quat[b]), model.body_pos[b]
        here = np.zeros(3)
        for j, link in zip(moves, links, strict=False):
            at, axis, rest = model.jnt_pos[j], model.jnt_axis[j], float(model.qpos0[model.jnt_qposadr[j]])
            p, here = p + R @ (at - here), at
            turned = R @ pin.exp3(-rest * axis) if model.jnt_type[j] == 3 else R
            start = p if model.jnt_type[j] == 3 else p - R @ (axis * rest)
            self._joint(j, above, link, turned, start)
            if link != self.bodies[b]:
                add(self.root, "link", name=link)
            above, R, p = link, np.eye(3), np.zeros(3)
        if above != self.bodies[b]:
            self._fixed(self.bodies[b], above, R, p - here)

    def _joint(self, j: int, above: str, below: str, R: Array, p: Array) -> None:
        model, name = self.model, self.joints[j]
        if model.jnt_type[j] == 1:
            raise URDFError("source", "joints of one degree of freedom (hinge, slide)", f"{name!r}, a ball joint")
        bounded, slides = bool(model.jnt_limited[j]), model.jnt_type[j] == 2
        kind = "prismatic" if slides else "revolute" if bounded else "continuous"
        joint = add(self.root, "joint", name=name, type=kind)
        add(joint, "parent", link=above)
        add(joint, "child", link=below)
        placed(joint, R, p)
        add(joint, "axis", xyz=model.jnt_axis[j])
        known = np.isfinite(self.effort[j])  # a URDF has no word for an effort that is not known: 0, see `joint_facts`
        limit = {"effort": float(self.effort[j]) if known else 0.0, "velocity": 0.0}
        if bounded or slides:
            low, high = model.jnt_range[j] if bounded else (-_UNBOUNDED, _UNBOUNDED)
            limit |= {"lower": float(low), "upper": float(high)}
        words = {"said": self.effort_said[j], "weaker": float(self.weaker[j])} if known else {}
        add(joint, "limit", **limit, **words)
        write_passive(joint, model, j)
        if j in self.reaches:
            low, high = self.reaches[j]
            add(joint, "reach", lower=low, upper=high)
        if j in self.follows:
            master, factor, offset = self.follows[j]
            add(joint, "mimic", joint=self.joints[master], multiplier=factor, offset=offset)

    def _fixed(self, name: str, above: str, R: Array, p: Array) -> None:
        joint = add(self.root, "joint", name=f"{name}_fixed", type="fixed")
        add(joint, "parent", link=above)
        add(joint, "child", link=name)
        placed(joint, R, p)

    def _site(self, s: int) -> None:
        name = self.model.site(s).name
        if name and name not in self.bodies:
            add(self.root, "link", name=name)
            above = self.bodies[self.model.site_bodyid[s]]
            self._fixed(name, above, rotation_of(self.model.site_quat[s]), self.model.site_pos[s])

    def _inertia(self, link: ET.Element, b: int, shift: Array) -> None:
        model = self.model
        inertial = add(link, "inertial")
        placed(inertial, rotation_of(model.body_iquat[b]), model.body_ipos[b] - shift)
        add(inertial, "mass", value=float(model.body_mass[b]))
        xx, yy, zz = (float(x) for x in model.body_inertia[b])
        add(inertial, "inertia", ixx=xx, ixy=0.0, ixz=0.0, iyy=yy, iyz=0.0, izz=zz)


def _model_name(model: Any) -> str:
    return bytes(model.names).split(b"\0", 1)[0].decode(errors="replace") or "hand"
