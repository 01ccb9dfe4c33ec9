"""`contacts`, `wrench`, `effects`: what users pass to `Grasp`, turned into clean arrays, or refused by name."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array, check_array, check_number, check_psd, check_unit_vector, count_dimensions, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.contact import Contact, Placement, block_diagonal, cross_rows
from handlcp.grasp.model.effect import Effect
from handlcp.tolerances import UNIT_NORMAL_TOLERANCE

WRENCH_EXPECTED = "force [N], then torque [N·m]: finite numbers"


def contacts(value: Any) -> tuple[Contact, ...]:
    """At least one Contact."""
    if isinstance(value, Contact):
        value = (value,)
    try:
        out = tuple(value)
    except TypeError:
        raise InputError("contacts", "a sequence of Contact", repr(value)) from None
    for k, c in enumerate(out):
        if not isinstance(c, Contact):
            raise InputError(f"contacts[{k}]", "a Contact", repr(c))
    if not out:
        raise InputError("contacts", "at least one Contact", "none")
    if len({c.planar for c in out}) > 1:
        raise InputError("contacts", "all planar (2-vectors) or all spatial (3-vectors)", "a mixture")
    return out


def positions_and_frames(value: Any, cs: tuple[Contact, ...]) -> tuple[Array, Array, Array | None]:
    """Positions (n, 3), frames (n, 3, 3) and the normal (3,) of the plane that is asked for; None: spatial.

    In a plane frames are turned about their normals until x lies in it, on the side of the contact's own x axis.
    """
    positions, frames = np.array([c.position for c in cs]), np.array([c.rotation for c in cs])
    if (normal := plane(value, cs, positions, frames)) is not None:
        z = frames[:, :, 2]
        x = cross_rows(normal, z)
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        x[(x * frames[:, :, 0]).sum(axis=1) < 0] *= -1.0
        frames = np.stack([x, cross_rows(z, x), z], axis=2)
    return positions, frames, normal


def plane(value: Any, cs: tuple[Contact, ...], positions: Array, frames: Array) -> Array | None:
    """(3,) unit normal of the scene's plane, or None; contacts must lie in it."""
    if cs[0].planar:
        if value is not None:
            raise InputError("plane", "None for contacts made of 2-vectors (their plane is xy)", repr(value))
        return read_only(np.array([0.0, 0.0, 1.0]))
    if value is None:
        return None
    a = check_unit_vector("plane", value, (3,))
    height = positions @ a
    if np.ptp(height) > _flat_height(positions):
        got = f"heights that differ by {np.ptp(height):.3g} m"
        raise InputError("plane", "a plane that holds all contact points", got)
    if (tilt := abs(frames[:, :, 2] @ a)).max() > UNIT_NORMAL_TOLERANCE:
        got = f"normal {int(tilt.argmax())} tilted by {tilt.max():.3g}"
        raise InputError("plane", "a plane that holds all normals", got)
    return a


def reference(value: Any, normal: Array | None, positions: Array) -> Array:
    """(3,) point; a planar scene in xy also takes (2,), a point of the plane that holds the contacts."""
    flat = normal is not None and abs(normal[2]) == 1.0
    point = check_array("reference", value, (3,), *([(2,)] if flat else []))
    return point if point.shape == (3,) else read_only(np.append(point, positions[0, 2]))


def height_above(positions: Array, point: Array, normal: Array | None) -> float:
    """Height of the plane that holds the contacts above a point [m], along its normal; 0 in a spatial scene."""
    if normal is None:
        return 0.0
    height = float((positions.mean(0) - point) @ normal)
    return height if abs(height) > _flat_height(positions) else 0.0


def _flat_height(positions: Array) -> float:
    """Heights that count as none [m]."""
    return 1e-6 * (float(abs(positions - positions.mean(0)).max(initial=0.0)) or 1.0)


def wrench(value: Any, normal: Array | None, lift: float = 0.0, argument: str = "wrench") -> Array:
    """(6,) force and torque; a planar scene also takes (3,): two forces in the xy plane and the moment.

    lift [m]: how far above the reference, along the normal, a planar scene's forces act. A force f then has the moment
    lift · normal × f about the reference, besides the one about the normal.
    """
    if value is None:
        return read_only(np.zeros(6))
    shapes: tuple[tuple[int, ...], ...] = ((6,),) if normal is None else ((6,), (3,))
    w = check_array(argument, value, *shapes, what=WRENCH_EXPECTED)
    if w.shape == (3,):
        if normal is None or abs(normal[2]) != 1.0:
            raise InputError(argument, "shape (6,) unless the plane is xy", "shape (3,)")
        f = np.array([w[0], w[1], 0.0])
        w = read_only(np.append(f, lift * cross_rows(normal, f) + w[2] * normal))
    if normal is not None:
        f, m = w[:3], w[3:]
        tilt = m - normal * (m @ normal) - lift * cross_rows(normal, f)
        if max(abs(float(f @ normal)), float(abs(tilt).max())) > 1e-9 * float(abs(w).max(initial=0.0)):
            where = f" that lies {lift:.3g} m above the reference (or a reference in it)" if lift else ""
            expected = f"forces in the plane of the contacts{where} and a moment about its normal"
            raise InputError(argument, expected, w.tolist())
    return w


def flexibility(value: Any, n: int, planar: bool) -> Array:
    """(3n, 3n) from a number, a (3,) diagonal, (n, 3, 3) blocks or the whole matrix; planar: also with 2 for 3."""
    if count_dimensions(value) == 0:
        return read_only(np.eye(3 * n) * check_number("flexibility", value, minimum=0.0))
    flat = [(2,), (n, 2, 2), (2 * n, 2 * n)] if planar else []
    a = check_array("flexibility", value, (3,), (n, 3, 3), (3 * n, 3 * n), *flat)
    E = check_psd("flexibility", a) if a.ndim == 2 else block_diagonal(blocks("flexibility", a), n)
    if a.shape in flat:  # tangent and normal in the plane; nothing acts along y
        for axis in (0, 1):
            E = np.insert(E, np.arange(1, 2 * n, 2), 0.0, axis)
    return read_only(E)


def blocks(argument: str, a: Array) -> Array:
    """(k, k) from its diagonal (k,), entries ≥ 0; or blocks (n, k, k) as they are, symmetric positive semidefinite."""
    if a.ndim == 1:
        if (a < 0).any():
            raise InputError(argument, "entries ≥ 0", a.tolist())
        return np.diag(a)
    return np.array([check_psd(f"{argument}[{i}]", block) for i, block in enumerate(a)]).reshape(a.shape)


def offset(value: Any, preload: Any, n: int) -> Array:
    """(n, 3) initial motion of the object relative to the tips, the preload's squeeze taken off its normal part."""
    d = np.zeros((n, 3)) if value is None else check_array("offset", value, (n, 3)).copy()
    one = count_dimensions(preload) == 0
    d[:, 2] -= check_number("preload", preload) if one else check_array("preload", preload, (n,))
    return read_only(d)


def effects(value: Any, at: Placement) -> tuple[Effect, ...]:
    """Effects asked for by name, each kind once (some kinds once a contact), that fit the grasp and one another."""
    try:
        out = (value,) if isinstance(value, Effect) else tuple(value)
    except TypeError:
        out = (value,)
    seen: set[object] = set()
    for k, e in enumerate(out):
        if not isinstance(e, Effect):
            expected = "an effect such as TotalForceBound(50.0) or PrescribedForce(0, (0, 0, 10))"
            raise InputError(f"effects[{k}]", expected, repr(e))
        if e.key in seen:
            raise InputError(f"effects[{k}]", "each effect once", f"a second {e!r}")
        seen.add(e.key)
    for k, e in enumerate(out):
        if e.needs_joints and at.mechanism is None:
            expected = "an effect that needs no joints; a hand knows its own: hand.at(q).grasp(..., effects=[...])"
            raise InputError(f"effects[{k}]", expected, repr(e))
        e.check(f"effects[{k}]", at, out)
    return out


def frames(value: Any, n: int) -> Array:
    """(n, 3, 3) rotations, columns x, y, z."""
    R = check_array("frames", value, (n, 3, 3))
    miss = float(abs(R.transpose(0, 2, 1) @ R - np.eye(3)).max())
    if miss > UNIT_NORMAL_TOLERANCE or (np.linalg.det(R) < 0).any():
        got = f"RᵀR off by {miss:.3g}, or a mirror"
        raise InputError("frames", "rotations, columns x, y and z of unit length", got)
    return R


def move_contacts(contacts: tuple[Contact, ...], positions: Array, frames: Array) -> tuple[Contact, ...]:
    """The contacts, at other places."""
    placed = zip(contacts, positions, frames, strict=True)
    return tuple([c.with_pose(read_only(p.copy()), read_only(R.copy())) for c, p, R in placed])
