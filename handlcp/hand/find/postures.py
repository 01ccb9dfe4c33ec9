"""Postures and placements from elsewhere: arrays, a dictionary, the YAML of GraspGen, the arrays of DexGraspBench."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from handlcp.check import Array, check_array, check_call, check_number, count_dimensions
from handlcp.errors import InputError
from handlcp.geometry.object import read_placement
from handlcp.read_file import MAX_ARRAY_BYTES, MAX_YAML_BYTES, parse_yaml, read_arrays, read_text

_WHICH = "pregrasp", "grasp", "squeeze"
_UNIT = 1e-3  # a quaternion's length differs from 1 by no more


class GivenPosture(NamedTuple):
    """q : positions of the joints for `hand.at(q)` [rad, m]: by joint name where names are known, else (nv,).
    placement : of the object in the hand's base frame, for `obj.moved_to(placement)`. name : of the grasp in its file,
    or "".
    """

    q: Any
    placement: Any
    name: str = ""


@check_call()
def read_postures(source: Any, joints: Sequence[str] | None = None, which: str = "grasp") -> list[GivenPosture]:
    """Grasps that something else has found: of each the posture of the hand and the placement of the object.

    source : one of
        (q, placement) : q (nv,) or (n, nv); placement as in `Object`, or (7,), or n of these.
        a mapping with `q` and `placement`, which are these, or the path of an .npz file of such arrays.
        a mapping of DexGraspBench, or the path of an .npz file of its arrays: `grasp_qpos` (or another of `which`),
            (7 + nv,) or (n, 7 + nv), pose of the hand's base and then its joints; `obj_pose` (7,) or (n, 7). Both poses
            are those of the world; the object's scale is not read: `Mesh(scale=…)` takes it. Its own .npy files are
            pickles, which can run anything and are not read. Of a file that you made yourself,
            `np.load(file, allow_pickle=True).item()` is the mapping.
        a mapping of GraspGen and Isaac, or the path of its .yaml file: `grasps`, each with `position` (3,) and
            `orientation` {w, xyz} of the gripper in the object's frame, and `cspace_position` by joint name
            (`pregrasp_cspace_position` for "pregrasp").
        Poses of seven numbers are x, y, z [m], then the quaternion w, x, y, z.
    joints : names of the joints in the order of the array's columns, which is seldom that of `hand.joint_names`; None:
        they stay arrays.
    which : "pregrasp", "grasp" or "squeeze".

    `hand.at(p.q).grasp(obj.moved_to(p.placement), links="all", closing_torque=…)` is the grasp of each. What the base
    frame is, files do not say: it has to be that of the hand's URDF.

    Raises InputError for keys that are missing, for another shape, and for files that cannot be read; Unsupported for
    YAML without PyYAML (pip install pyyaml).
    """
    if which not in _WHICH:
        raise InputError("which", '"pregrasp", "grasp" or "squeeze"', repr(which)[:80])
    data = _read(Path(source)) if isinstance(source, (str, Path)) else source
    if isinstance(data, Mapping):
        if "grasps" in data:
            return list(_of_graspgen(data["grasps"], which))
        if f"{which}_qpos" in data or "obj_pose" in data:
            return _of_dexgraspbench(data, joints, which)
        _has(data, ("q", "placement"), "source")
        data = data["q"], data["placement"]
    if not (isinstance(data, tuple) and len(data) == 2):
        raise InputError("source", "(q, placement), a mapping, or the path of a .npz or .yaml file", _shown(source))
    q = _numbers("q", data[0])
    rows, given = np.atleast_2d(q), data[1]
    if q.ndim == 2 and not isinstance(given, Sequence | np.ndarray):
        raise InputError("placement", f"{len(rows)}, one for each posture", _shown(given))
    each = list(given) if q.ndim == 2 else [given]
    if len(each) != len(rows):
        raise InputError("placement", f"{len(rows)}, one for each posture", len(each))
    return [GivenPosture(_named(row, joints), _placed(one)) for row, one in zip(rows, each, strict=True)]


def _of_dexgraspbench(data: Mapping[str, Any], joints: Sequence[str] | None, which: str) -> list[GivenPosture]:
    key = f"{which}_qpos"
    _has(data, (key, "obj_pose"), "source")
    hands, objects = np.atleast_2d(_numbers(key, data[key])), np.atleast_2d(_numbers("obj_pose", data["obj_pose"]))
    if hands.shape[1] <= 7:
        raise InputError(key, "(7 + nv,), a pose and then joints", hands.shape)
    if objects.shape not in {(1, 7), (len(hands), 7)}:
        raise InputError("obj_pose", f"(7,) or ({len(hands)}, 7)", objects.shape)
    objects = np.broadcast_to(objects, (len(hands), 7))
    return [
        GivenPosture(_named(row[7:], joints), _pose(key, row[:7]).actInv(_pose("obj_pose", one)))
        for row, one in zip(hands, objects, strict=True)
    ]


def _of_graspgen(grasps: Any, which: str) -> Iterator[GivenPosture]:
    key = "cspace_position" if which == "grasp" else f"{which}_cspace_position"
    if not isinstance(grasps, Mapping):
        raise InputError("grasps", "a mapping by name", _shown(grasps))
    if not grasps:
        raise InputError("grasps", "at least one grasp", "none")
    for name, one in grasps.items():
        where = f"grasps[{name!r}]"
        _has(one, ("position", "orientation", key), where)
        _has(one["orientation"], ("w", "xyz"), f"{where}['orientation']")
        _has(one[key], (), f"{where}[{key!r}]")
        turn = [one["orientation"]["w"], *_numbers(f"{where} xyz", one["orientation"]["xyz"])]
        pose = _pose(where, np.concatenate([_numbers(f"{where} position", one["position"]), _numbers(where, turn)]))
        at = {str(j): check_number(f"{where}[{key!r}][{j!r}]", v) for j, v in one[key].items()}
        yield GivenPosture(at, pose.inverse(), str(name))


# ----------------------------------------------------------------


def _has(data: Any, keys: Sequence[str], where: str) -> None:
    """Raises InputError for anything but a mapping with these keys."""
    if not isinstance(data, Mapping):
        raise InputError(where, f"a mapping{' with ' if keys else ''}{', '.join(keys)}", _shown(data))
    if missing := [key for key in keys if key not in data]:
        there = ", ".join(map(str, list(data)[:12])) or "nothing"
        raise InputError(where, f"the keys {', '.join(keys)}", f"{there}: {', '.join(missing)} missing")


def _numbers(name: str, value: Any) -> Array:
    if isinstance(value, np.ndarray) and value.dtype.kind not in "iuf":
        raise InputError(name, "numbers", f"an array of {value.dtype}")
    try:
        found = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(name, "numbers", _shown(value)) from None
    if found.ndim not in (1, 2) or not found.size or not np.isfinite(found).all():
        raise InputError(name, "finite numbers, (k,) or (n, k)", f"shape {found.shape}")
    return found


def _shown(value: Any) -> str:
    """A number or a word as it is, of anything larger its kind: its text may be without end."""
    return repr(value)[:80] if isinstance(value, str | int | float | None) else f"a {type(value).__name__}"


def _named(row: Array, joints: Sequence[str] | None) -> Any:
    if joints is None:
        return row.copy()
    if len(joints) != len(row):
        raise InputError("joints", f"{len(row)} names, one a column", len(joints))
    return dict(zip(joints, row.tolist(), strict=True))


def _placed(value: Any) -> Any:
    """As `Object` takes it, or of seven numbers."""
    if not isinstance(value, pin.SE3) and count_dimensions(value) == 1 and len(value) == 7:
        return _pose("placement", _numbers("placement", value))
    return read_placement(value)


def _pose(name: str, numbers: Array) -> Any:
    x, y, z, w, a, b, c = check_array(name, numbers, (7,))
    length = float(np.linalg.norm([w, a, b, c]))
    if abs(length - 1.0) > _UNIT:
        raise InputError(name, "a pose x, y, z, and a quaternion w, x, y, z of length 1", f"one of length {length:.4g}")
    turn = pin.Quaternion(w / length, a / length, b / length, c / length)
    return pin.SE3(turn.toRotationMatrix(), np.array([x, y, z]))


# ---------------------------------------------------------------- Files.

_ARRAYS, _YAML = (".npy", ".npz"), (".yaml", ".yml")


def _read(path: Path) -> Any:
    """What a file holds. Raises InputError, Unsupported."""
    kind = path.suffix.lower()
    if kind not in (*_ARRAYS, *_YAML):
        raise InputError("source", "a .npz or .yaml file", str(path))
    if kind in _YAML:
        return parse_yaml("source", read_text("source", path, "a YAML file", MAX_YAML_BYTES), repr(str(path)))
    found = read_arrays("source", path, "an .npz file of arrays", MAX_ARRAY_BYTES)
    if "" in found:
        raise InputError(
            "source", "an .npz file of arrays by name", f"{str(path)!r}, one array of shape {found[''].shape}"
        )
    return found
