"""`convert_to_urdf`: an MJCF file, MuJoCo's format for robots, as the URDF that says the same.

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

import threading
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array
from handlcp.errors import URDFError, missing_library
from handlcp.read_file import MAX_XML_BYTES, read_bytes
from handlcp.robot.joint import SHARED_LIMIT, Doubt
from handlcp.robot.link_shape import CompiledMesh, quaternion_rotation
from handlcp.robot.mjcf_cable import write_cables
from handlcp.robot.mjcf_scene import find_scene_parts, is_of_scene, tied_bodies
from handlcp.robot.mjcf_shape import (
    DRIVES_TENDON,
    add_element,
    add_origin,
    add_shapes,
    compiled_meshes,
    soft_part_doubts,
)
from handlcp.robot.mjcf_size import check_mjcf_size

_MAX_PARTS = 3000  # that are written, before it is seen which of them are the hand
_UNBOUNDED_RANGE = 1e3  # [m] the range of a slide without one


def convert_to_urdf(
    source: str, path: Path | None, base: str | None = None
) -> tuple[ET.Element, tuple[Doubt, ...], dict[str, CompiledMesh]]:
    """The <robot> that an MJCF text or file describes, what of it a URDF cannot say, and its meshes.

    base : the link that is asked for. Other arguments and errors as of `compile_mjcf`; URDFError for ball joints, too.
    """
    model = compile_mjcf(source, path)
    if (parts := int(model.nbody + model.njnt)) > _MAX_PARTS:
        raise URDFError("source", f"a model of at most {_MAX_PARTS} bodies and joints", f"one with {parts}")
    root, doubts = _UrdfWriter(model, base).write_robot()
    meshes, partial = compiled_meshes(model, path)
    return root, (*doubts, *partial), meshes


def compile_mjcf(source: str, path: Path | None) -> Any:
    """The mujoco.MjModel of an MJCF text or file.

    path : of the file; None: `source` is the text. Raises Unsupported without MuJoCo, URDFError for a file that MuJoCo
    refuses.
    """
    try:
        import mujoco
    except ImportError:
        raise missing_library("no MJCF file is read without MuJoCo", "mujoco") from None
    text = source.encode() if path is None else read_bytes("source", path, "an MJCF file", MAX_XML_BYTES, URDFError)
    check_mjcf_size("source", text, path)
    try:
        read = mujoco.MjModel.from_xml_path if path is not None else mujoco.MjModel.from_xml_string
        with without_mujoco_log():
            return read(source if path is None else str(path))
    except (ValueError, TypeError, RuntimeError, MemoryError, mujoco.FatalError) as error:
        shown = "the XML string" if path is None else repr(str(path))
        came = f"{shown}: {' '.join(str(error).split())}"
        raise URDFError("source", "an MJCF file that MuJoCo compiles", came) from None


class _UrdfWriter:
    """Writes one compiled model."""

    def __init__(self, model: Any, base: str | None) -> None:
        self.model, self.doubts = model, list[Doubt]()
        name = bytes(model.names).split(b"\0", 1)[0].decode(errors="replace") or "hand"
        self.root = ET.Element("robot", name=name, format="mjcf")
        self.bodies = [model.body(i).name or f"body_{i}" for i in range(model.nbody)]
        owners = model.jnt_bodyid
        self.joints = [model.joint(j).name or f"{self.bodies[owners[j]]}_joint_{j}" for j in range(model.njnt)]
        self.scene = find_scene_parts(model, self.bodies, base)
        self.follows, more = read_couplings(model, self.joints, self.scene.bodies)
        sides, self.effort_said, found = read_efforts(model, self.joints, self.follows)
        self.weaker, self.effort = sides.T
        self.reaches = servo_ranges(model)
        self.doubts += [*found, *more, *self.scene.doubts, *soft_part_doubts(model)]

    def write_robot(self) -> tuple[ET.Element, tuple[Doubt, ...]]:
        """Write the whole robot: its element, and what is doubtful about it."""
        for b in range(self.model.nbody):
            if b not in self.scene.bodies:
                self._write_body(b)
        for s, b in enumerate(self.model.site_bodyid.tolist()):
            name = self.model.site(s).name
            if name and name not in self.bodies and b not in self.scene.bodies:
                add_element(self.root, "link", name=name)
                R = quaternion_rotation(self.model.site_quat[s])
                self._add_joint(f"{name}_fixed", "fixed", self.bodies[b], name, R, self.model.site_pos[s])
        write_pins(self.root, self.model, self.bodies, self.scene.bodies)
        self.doubts += write_cables(self.root, self.model, write_servos(self.root, self.model, self.joints))
        return self.root, tuple(self.doubts)

    def _write_body(self, b: int) -> None:
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
            self._write_chain(b, moves, links)
            carrier = links[len(moves) - 1] if moves else name
        link = add_element(self.root, "link", name=name)
        if model.body_mass[b] > 0:
            owner = link if carrier == name else next(e for e in self.root.findall("link") if e.get("name") == carrier)
            inertial = add_element(owner, "inertial")
            place = model.body_ipos[b] - (at if carrier != name else 0.0)
            add_origin(inertial, quaternion_rotation(model.body_iquat[b]), place)
            add_element(inertial, "mass", value=float(model.body_mass[b]))
            xx, yy, zz = model.body_inertia[b].tolist()
            add_element(inertial, "inertia", ixx=xx, ixy=0.0, ixz=0.0, iyy=yy, iyz=0.0, izz=zz)
        if b or not self.scene.has_ground:
            self.doubts += add_shapes(link, model, b)

    def _write_chain(self, b: int, moves: list[int], links: list[str]) -> None:
        """The joints from the parent's link to the body's, and the links between them."""
        model = self.model
        above, R, p = self.bodies[model.body_parentid[b]], quaternion_rotation(model.body_quat[b]), model.body_pos[b]
        here = np.zeros(3)
        for j, link in zip(moves, links, strict=False):
            at, axis, rest = model.jnt_pos[j], model.jnt_axis[j], float(model.qpos0[model.jnt_qposadr[j]])
            p, here = p + R @ (at - here), at
            turned = R @ pin.exp3(-rest * axis) if model.jnt_type[j] == 3 else R
            start = p if model.jnt_type[j] == 3 else p - R @ (axis * rest)
            self._write_joint(j, above, link, turned, start)
            if link != self.bodies[b]:
                add_element(self.root, "link", name=link)
            above, R, p = link, np.eye(3), np.zeros(3)
        if above != self.bodies[b]:
            self._add_joint(f"{self.bodies[b]}_fixed", "fixed", above, self.bodies[b], R, p - here)

    def _write_joint(self, j: int, above: str, below: str, R: Array, p: Array) -> None:
        model, name = self.model, self.joints[j]
        if model.jnt_type[j] == 1:
            raise URDFError("source", "joints of one degree of freedom (hinge, slide)", f"{name!r}, a ball joint")
        bounded, slides = bool(model.jnt_limited[j]), model.jnt_type[j] == 2
        kind = "prismatic" if slides else "revolute" if bounded else "continuous"
        joint = self._add_joint(name, kind, above, below, R, p)
        add_element(joint, "axis", xyz=model.jnt_axis[j])
        # A URDF has no word for an effort that is not known: 0, see `read_joint_facts`
        known = np.isfinite(self.effort[j])
        limit = {"effort": float(self.effort[j]) if known else 0.0, "velocity": 0.0}
        if bounded or slides:
            low, high = model.jnt_range[j] if bounded else (-_UNBOUNDED_RANGE, _UNBOUNDED_RANGE)
            limit |= {"lower": float(low), "upper": float(high)}
        words = {"said": self.effort_said[j], "weaker": float(self.weaker[j])} if known else {}
        add_element(joint, "limit", **limit, **words)
        # What resists the joint itself: friction as a URDF has it, spring, rest and armature in a tag of our own
        dof, spring = int(model.jnt_dofadr[j]), float(np.ravel(model.jnt_stiffness[j])[0])
        rest, armature = float(model.qpos_spring[model.jnt_qposadr[j]]), float(model.dof_armature[dof])
        damping, friction = float(model.dof_damping[dof]), float(model.dof_frictionloss[dof])
        add_element(joint, "dynamics", damping=damping, friction=friction)
        add_element(joint, "passive", stiffness=spring, rest=rest, armature=armature)
        if j in self.reaches:
            low, high = self.reaches[j]
            add_element(joint, "reach", lower=low, upper=high)
        if j in self.follows:
            master, factor, offset = self.follows[j]
            add_element(joint, "mimic", joint=self.joints[master], multiplier=factor, offset=offset)

    def _add_joint(self, name: str, kind: str, above: str, below: str, R: Array, p: Array) -> ET.Element:
        joint = add_element(self.root, "joint", name=name, type=kind)
        add_element(joint, "parent", link=above)
        add_element(joint, "child", link=below)
        add_origin(joint, R, p)
        return joint


# ----------------------------------------------------------------
# What drives the joints of an MJCF model: torque limits and servos from its actuators, couplings from its equalities,
# springs and friction of the joints themselves.

_DRIVES_JOINT, _DRIVES_JOINT_IN_PARENT = 0, 1  # what an actuator moves
_COUPLES_JOINTS, _SUMS_JOINT = 2, 1  # an equality of joints; a tendon that is a sum of joint angles
_CONNECTS_IN_POINT, _CONNECTS_BODIES = 0, 1  # an equality in a point; of bodies, and not of sites
_FIXED_GAIN, _AFFINE_BIAS = 0, 1  # gains and biases of actuators

Followers = dict[int, tuple[int, float, float]]  # joint → the joint it follows, factor, offset

# ---------------------------------------------------------------- How hard actuators pull.


def read_efforts(model: Any, names: list[str], follows: Followers) -> tuple[Array, list[str], list[Doubt]]:
    """(joints, 2) torque or force of each joint's actuators to its smaller and to its larger side [N·m, N], inf where
    the file says none; the word of the file that says it; and doubts about tendons that move several joints, and about
    limits that no joint has on its own.
    """
    ends, said = np.zeros((model.njnt, 2)), [""] * model.njnt  # against and with the joint's axis
    free = np.ones(model.njnt, dtype=bool)
    pulled, limited = dict[str, dict[int, float]](), dict[str, list[int]]()
    for a in range(model.nu):
        own, word = _force_range(model, a)
        arms = _actuator_arms(model, a)
        target = int(model.actuator_trnid[a, 0])
        if int(model.actuator_trntype[a]) == DRIVES_TENDON:
            if model.tendon_actfrclimited[target]:
                own, word = _cut_range(np.sort(own), model.tendon_actfrcrange[target], word)
            if len(arms) > 1:
                pulled[model.tendon(target).name or f"tendon {target}"] = arms
        if np.isfinite(own).any() and any(arms.values()):
            limited[model.actuator(a).name or f"actuator {a}"] = [j for j, arm in arms.items() if arm]
        for j, arm in arms.items():
            ends[j] += np.sort(arm * own) if arm else 0.0
            said[j], free[j] = word, False
    ends[free] = -np.inf, np.inf
    for j in np.flatnonzero(model.jnt_actfrclimited).tolist():
        ends[j], said[j] = _cut_range(ends[j], model.jnt_actfrcrange[j], said[j])
    sides = np.sort(np.maximum(ends * (-1.0, 1.0), 0.0), axis=1)
    doubts = _shared_tendon_doubts(pulled, names) if pulled else []
    return sides, said, [*doubts, *_shared_motor_doubts(limited, names, follows)]


def _cut_range(ends: Array, bounds: Array, word: str) -> tuple[Array, str]:
    """Forces (2,) within bounds (2,), and the word of the file that says them."""
    cut = np.clip(ends, *bounds)
    return cut, "actuatorfrcrange" if (cut != ends).any() else word


def _actuator_arms(model: Any, a: int) -> dict[int, float]:
    """Joints that an actuator moves, and how far its length changes with each, before its gear; none for one that pulls
    along a path in space.
    """
    what, target = int(model.actuator_trntype[a]), int(model.actuator_trnid[a, 0])
    if what in (_DRIVES_JOINT, _DRIVES_JOINT_IN_PARENT):
        return {target: 1.0}
    if what != DRIVES_TENDON:
        return {}
    first = int(model.tendon_adr[target])
    wraps = range(first, first + int(model.tendon_num[target]))
    return {int(model.wrap_objid[w]): float(model.wrap_prm[w]) for w in wraps if model.wrap_type[w] == _SUMS_JOINT}


def _force_range(model: Any, a: int) -> tuple[Array, str]:
    """(2,) the least and the largest force of an actuator times its gear, and the word that says them; ±inf where none
    is said.
    """
    gear = float(model.actuator_gear[a, 0])
    if model.actuator_forcelimited[a]:
        return gear * model.actuator_forcerange[a], "forcerange"
    plain = int(model.actuator_gaintype[a]) == _FIXED_GAIN and int(model.actuator_biastype[a]) == 0  # a motor
    if plain and model.actuator_ctrllimited[a]:
        return gear * model.actuator_gainprm[a, 0] * model.actuator_ctrlrange[a], "ctrlrange of a motor"
    return np.array([-np.inf, np.inf]), ""


def _shared_tendon_doubts(pulled: dict[str, dict[int, float]], names: list[str]) -> list[Doubt]:
    """Of tendons that pull several joints each."""
    joints = [names[j] for arms in pulled.values() for j in arms]
    first, arms = next(iter(pulled.items()))
    given = ", ".join(f"{names[j]!r}: {arm:g}" for j, arm in arms.items())
    what = f"one actuator pulls several of them by a tendon ({', '.join(pulled)}); here each has a spring of its own"
    advice = f"joint_stiffness=Tendons(...) with {{{first!r}: {{{given}}}, …}}"
    return [Doubt(", ".join(dict.fromkeys(joints)), what, advice, "serious", "tendon")]


def _shared_motor_doubts(limited: dict[str, list[int]], names: list[str], follows: Followers) -> list[Doubt]:
    """Of limits that are those of actuators, and of no joint alone: where a joint has several actuators one of which
    moves other joints, too, and where one drives a joint that follows another. limited : actuator → the joints that it
    moves. Where one actuator alone moves several joints, it pulls no harder than the joint asks that asks for most.
    """
    reached = dict[int, list[str]]()
    for actuator, joints in limited.items():
        for j in joints:
            reached.setdefault(j, []).append(actuator)
    mixed = [a for a, joints in limited.items() if len(joints) > 1 and any(len(reached[j]) > 1 for j in joints)]
    found = dict.fromkeys(mixed)
    found |= dict.fromkeys([a for j, those in reached.items() if set(those) & set(mixed) for a in those])
    found |= dict.fromkeys([a for a, joints in limited.items() if any(j in follows for j in joints)])
    if not found:
        return []
    moved = dict.fromkeys([names[_find_leader(follows, j)] for a in found for j in limited[a]])
    what = (
        f"limits of actuators that move several joints, or one that follows another, are read joint by joint "
        f"({words.list_names(list(found))}): what the motors hold is not judged"
    )
    advice = "torque_limits of these joints, as large as the actuators can hold together"
    return [Doubt(", ".join(moved), what, advice, "serious", SHARED_LIMIT)]


# ----------------------------------------------------------------
# Position servos: force = g u + b₀ + b₁ l, so that kp = -b₁, whatever the gain g; l = gear × joint angle or tendon.


def write_servos(root: ET.Element, model: Any, names: list[str]) -> dict[int, float]:
    """Write each that moves joints by fixed arms as a <servo> with kp times the gear squared and the arm of each joint.
    Returns number of the actuator → that kp, of all.
    """
    found = dict[int, float]()
    for a in range(model.nu):
        kp, gear = _read_servo(model, a)
        if kp > 0.0 and int(model.actuator_gaintype[a]) == _FIXED_GAIN:
            found[a] = kp * gear * gear
            if arms := _actuator_arms(model, a):
                servo = add_element(root, "servo", name=model.actuator(a).name or f"actuator {a}", kp=found[a])
                for j, arm in arms.items():
                    add_element(servo, "arm", joint=names[j], per_rad=arm)
    return found


def servo_ranges(model: Any) -> dict[int, tuple[float, float]]:
    """Joint → where its own servo can be told to go [rad, m]."""
    found = dict[int, tuple[float, float]]()
    for a in range(model.nu):
        kp, gear = _read_servo(model, a)
        of_joint = int(model.actuator_trntype[a]) in (_DRIVES_JOINT, _DRIVES_JOINT_IN_PARENT)
        if of_joint and kp > 0.0 and gear and model.actuator_ctrllimited[a]:
            force = float(model.actuator_gainprm[a, 0]) * model.actuator_ctrlrange[a] + model.actuator_biasprm[a, 0]
            low, high = sorted((force / (kp * gear)).tolist())
            found[int(model.actuator_trnid[a, 0])] = (low, high)
    return found


def _read_servo(model: Any, a: int) -> tuple[float, float]:
    """The stiffness kp of an actuator, 0 where it is no position servo, and its gear."""
    is_servo = int(model.actuator_biastype[a]) == _AFFINE_BIAS
    return -float(model.actuator_biasprm[a, 1]) if is_servo else 0.0, float(model.actuator_gear[a, 0])


# ---------------------------------------------------------------- Joints that follow others.


def read_couplings(model: Any, names: list[str], scene: frozenset[int]) -> tuple[Followers, list[Doubt]]:
    """Joints that follow others, also one after the other, and doubts about constraints that are read in part or not at
    all. Where an equality's first joint follows another already, the second one follows the first. scene : bodies that
    are no part of the hand, whose constraints are left out with them.
    """
    follows, doubts = Followers(), list[Doubt]()
    for e in range(model.neq):
        if not model.eq_active0[e] or is_of_scene(model, e, scene):
            continue
        kind, name = int(model.eq_type[e]), model.eq(e).name or f"equality {e}"
        if kind != _COUPLES_JOINTS or int(model.eq_obj2id[e]) < 0:
            what = f"the constraint {name!r} is left out: only couplings of two joints are read"
            doubts.append(Doubt("hand", what, "an MJCF file that couples joints by <equality><joint>", "serious"))
            continue
        one, two = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        c0, c1, *curved = (float(x) for x in model.eq_data[e, :5])
        at_one, at_two = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (one, two))
        offset = c0 + at_one - c1 * at_two
        if one not in follows:
            follows[one] = (two, c1, offset)
        elif two not in follows and c1 and _find_leader(follows, one) != two:
            follows[two] = (one, 1.0 / c1, -offset / c1)
        else:
            what = f"the constraint {name!r} is left out: {names[one]} and {names[two]} are coupled by others already"
            both = f"{names[one]}, {names[two]}"
            doubts.append(Doubt(both, what, "one coupling for each joint", "serious", "coupling"))
        if any(curved):
            what = f"follows {names[two]} along a curve, of which the straight part alone is read"
            doubts.append(Doubt(names[one], what, "a posture near the file's reference posture", "serious"))
    return follows, doubts


def write_pins(root: ET.Element, model: Any, bodies: list[str], scene: frozenset[int]) -> None:
    """Write each constraint that connects two bodies in a point as a <pin>, with the point in the frame of each [m]."""
    for e in range(model.neq):
        own, is_pin = tied_bodies(model, e), int(model.eq_type[e]) == _CONNECTS_IN_POINT and model.eq_active0[e]
        if not is_pin or len(own) != 2 or is_of_scene(model, e, scene):
            continue
        if int(model.eq_objtype[e]) == _CONNECTS_BODIES:
            at, other = model.eq_data[e, :3], model.eq_data[e, 3:6]
        else:
            at, other = (model.site_pos[int(i)] for i in (model.eq_obj1id[e], model.eq_obj2id[e]))
        add_element(root, "pin", link=bodies[own[0]], other=bodies[own[1]], at=at, at_other=other)


def _find_leader(follows: Followers, j: int) -> int:
    """The joint at the end of a chain; the one where it meets itself, if it is a circle."""
    seen = {j}
    while j in follows and (j := follows[j][0]) not in seen:
        seen.add(j)
    return j


# ----------------------------------------------------------------
# MuJoCo without its log: where nobody takes its warnings, it appends them to MUJOCO_LOG.TXT in the working folder.

_LOG_LOCK = threading.Lock()
_open_log_blocks = 0  # how many are open, in all threads
_outer_handler: Any = None  # who took the warnings before the first of them


@contextmanager
def without_mujoco_log() -> Iterator[None]:
    """Around calls of MuJoCo, or a decorator of them: its warnings are dropped, and no file is written. Whoever took
    them before takes them again afterwards. What goes wrong is found by looking at what MuJoCo computes.
    """
    from mujoco import get_mju_user_warning, set_mju_user_warning

    global _open_log_blocks, _outer_handler
    with _LOG_LOCK:
        if _open_log_blocks == 0:
            _outer_handler = get_mju_user_warning()
            set_mju_user_warning(lambda _: None)
        _open_log_blocks += 1
    try:
        yield
    finally:
        with _LOG_LOCK:
            _open_log_blocks -= 1
            if _open_log_blocks == 0:
                set_mju_user_warning(_outer_handler)
