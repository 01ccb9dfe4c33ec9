"""Drives and shapes of an MJCF file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array
from handlcp.hand.robot.joints import Doubt

# ----------------------------------------------------------------
# What drives the joints of an MJCF model: torque limits from its actuators, couplings from its equalities.

_JOINT, _IN_PARENT, _TENDON = 0, 1, 3  # what an actuator moves
_OF_JOINTS, _WRAPS_JOINT = 2, 1  # an equality of joints; a tendon that is a sum of joint angles

Follows = dict[int, tuple[int, float, float]]  # joint → the joint it follows, factor, offset


def efforts(model: Any, names: list[str]) -> tuple[Array, list[Doubt]]:
    """(joints,) largest torque or force of each joint's actuators [N·m, N]; inf where the file says none. And a doubt
    for each tendon that moves several joints.
    """
    force = np.full(model.njnt, np.inf)
    pulled = dict[str, dict[int, float]]()
    for a in range(model.nu):
        most, what, target = _most(model, a), int(model.actuator_trntype[a]), int(model.actuator_trnid[a, 0])
        if what in (_JOINT, _IN_PARENT):
            arms = {target: 1.0}
        elif what == _TENDON:
            arms = _arms(model, target)
            if len(arms) > 1:
                pulled[model.tendon(target).name or f"tendon {target}"] = arms
        else:
            continue
        for j, arm in arms.items():
            torque = abs(arm) * most
            force[j] = torque if np.isinf(force[j]) else force[j] + torque
    bounded = model.jnt_actfrclimited.astype(bool)
    force[bounded] = np.minimum(force[bounded], abs(model.jnt_actfrcrange[bounded]).max(axis=1))
    return force, _shared(pulled, names) if pulled else []


def _most(model: Any, a: int) -> float:
    """The largest force of an actuator times its gear; inf where none is said."""
    gear = abs(float(model.actuator_gear[a, 0]))
    if model.actuator_forcelimited[a]:
        return gear * float(abs(model.actuator_forcerange[a]).max())
    plain = int(model.actuator_gaintype[a]) == 0 and int(model.actuator_biastype[a]) == 0  # a motor
    if plain and model.actuator_ctrllimited[a]:
        return gear * float(abs(model.actuator_gainprm[a, 0]) * abs(model.actuator_ctrlrange[a]).max())
    return float("inf")


def _arms(model: Any, tendon: int) -> dict[int, float]:
    """Joints of a tendon that is a sum of joint angles, and their coefficients; none for one with a path in space."""
    first = int(model.tendon_adr[tendon])
    wraps = range(first, first + int(model.tendon_num[tendon]))
    return {int(model.wrap_objid[w]): float(model.wrap_prm[w]) for w in wraps if model.wrap_type[w] == _WRAPS_JOINT}


def _shared(pulled: dict[str, dict[int, float]], names: list[str]) -> list[Doubt]:
    """Of tendons that pull several joints each."""
    joints = [names[j] for arms in pulled.values() for j in arms]
    first, arms = next(iter(pulled.items()))
    given = ", ".join(f"{names[j]!r}: {arm:g}" for j, arm in arms.items())
    what = f"one actuator pulls several of them by a tendon ({', '.join(pulled)}); here each has a spring of its own"
    advice = f"joint_stiffness=Tendons(...) with {{{first!r}: {{{given}}}, …}}"
    return [Doubt(", ".join(dict.fromkeys(joints)), what, advice, "serious", "tendon")]


def couplings(model: Any, names: list[str]) -> tuple[Follows, list[Doubt]]:
    """Joints that follow others, and doubts about constraints that are read in part or not at all."""
    follows, doubts = Follows(), list[Doubt]()
    for e in range(model.neq):
        if not model.eq_active0[e]:
            continue
        kind, name = int(model.eq_type[e]), model.eq(e).name or f"equality {e}"
        if kind != _OF_JOINTS or int(model.eq_obj2id[e]) < 0:
            what = f"the constraint {name!r} is left out: only couplings of two joints are read"
            doubts.append(Doubt("hand", what, "an MJCF file that couples joints by <equality><joint>", "serious"))
            continue
        one, two = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        c0, c1, *curved = (float(x) for x in model.eq_data[e, :5])
        at_one, at_two = (float(model.qpos0[model.jnt_qposadr[j]]) for j in (one, two))
        follows[one] = (two, c1, c0 + at_one - c1 * at_two)
        if any(curved):
            what = f"follows {names[two]} along a curve, of which the straight part alone is read"
            doubts.append(Doubt(names[one], what, "a posture near the file's reference posture", "serious"))
    return follows, doubts


# ----------------------------------------------------------------
# Geometry of an MJCF body as URDF elements, and how numbers are written there.

_PLANE, _HFIELD, _SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH = range(8)
_SEEN = 3  # groups of geoms that MuJoCo draws: 0, 1, 2


def add(parent: ET.Element, tag: str, **attributes: Any) -> ET.Element:
    """A new element below `parent`; numbers are written so that the same come back."""
    return ET.SubElement(parent, tag, {name: _written(value) for name, value in attributes.items()})


def placed(element: ET.Element, R: Array, p: Array) -> None:
    """An <origin> from a rotation (3, 3) and a position (3,) [m]."""
    add(element, "origin", xyz=p, rpy=pin.rpy.matrixToRpy(np.array(R)))


def rotation_of(quaternion: Array) -> Array:
    """(3, 3) of a unit quaternion w, x, y, z."""
    w, x, y, z = (float(v) for v in quaternion)
    return np.asarray(pin.Quaternion(w, x, y, z).normalized().toRotationMatrix())


def add_shapes(link: ET.Element, model: Any, body: int) -> list[Doubt]:
    """Write the geoms of a body to its link; returns what of them a URDF cannot say."""
    left_out = list[str]()
    first = int(model.body_geomadr[body])
    for g in range(first, first + int(model.body_geomnum[body])):
        solid = bool(model.geom_contype[g] or model.geom_conaffinity[g])
        if int(model.geom_type[g]) in (_PLANE, _HFIELD):
            continue  # the floor of a scene, no part of a hand
        kinds = [kind for kind, wanted in (("collision", solid), ("visual", _seen(model, g, solid))) if wanted]
        written = [_geom(link, kind, model, g) for kind in kinds]
        if not all(written):
            left_out.append(model.geom(g).name or f"geom {g}")
    if not left_out:
        return []
    what = f"geometry that a URDF cannot say is left out: {', '.join(left_out)}"
    return [Doubt(link.get("name", ""), what, "boxes, balls, cylinders, capsules or mesh files", "minor")]


def _seen(model: Any, g: int, solid: bool) -> bool:
    return not solid or int(model.geom_group[g]) < _SEEN


def _geom(link: ET.Element, kind: str, model: Any, g: int) -> bool:
    """One geom; False where there is no such shape in a URDF."""
    R, p, size = rotation_of(model.geom_quat[g]), model.geom_pos[g], model.geom_size[g]
    shape, colour = int(model.geom_type[g]), _colour(model, g)
    radius, half = float(size[0]), float(size[1])
    if shape == _SPHERE:
        _shape(link, kind, R, p, colour, "sphere", radius=radius)
    elif shape == _BOX:
        _shape(link, kind, R, p, colour, "box", size=2 * size)
    elif shape in (_CYLINDER, _CAPSULE):
        _shape(link, kind, R, p, colour, "cylinder", radius=radius, length=2 * half)
        for end in (half, -half) if shape == _CAPSULE else ():  # a capsule is a cylinder between two balls
            _shape(link, kind, R, p + R[:, 2] * end, colour, "sphere", radius=radius)
    elif shape == _MESH:
        return _mesh(link, kind, model, g, R, p)
    else:
        return False
    return True


def _mesh(link: ET.Element, kind: str, model: Any, g: int, R: Array, p: Array) -> bool:
    """A mesh as it is in its file: MuJoCo moves its vertices to their principal axes, which is undone here."""
    mesh = int(model.geom_dataid[g])
    start = int(model.mesh_pathadr[mesh])
    if start < 0:  # made of numbers in the MJCF file itself
        return False
    file = bytes(model.paths)[start:].split(b"\0", 1)[0].decode()
    moved = rotation_of(model.mesh_quat[mesh])
    R = R @ moved.T
    p = p - R @ model.mesh_pos[mesh]
    _shape(link, kind, R, p, _colour(model, g), "mesh", filename=file, scale=model.mesh_scale[mesh])
    return True


def _shape(link: ET.Element, kind: str, R: Array, p: Array, colour: Array, tag: str, **attributes: Any) -> None:
    element = add(link, kind)
    placed(element, R, p)
    add(add(element, "geometry"), tag, **attributes)
    if kind == "visual":
        add(add(element, "material", name=""), "color", rgba=colour)


def _colour(model: Any, g: int) -> Array:
    material = int(model.geom_matid[g])
    return np.asarray(model.geom_rgba[g] if material < 0 else model.mat_rgba[material], dtype=float)


def _written(value: Any) -> str:
    if isinstance(value, str):
        return value
    return " ".join(repr(float(v)) for v in np.atleast_1d(np.asarray(value, dtype=float)))
