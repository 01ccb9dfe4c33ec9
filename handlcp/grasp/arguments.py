"""What users pass to `Grasp`, turned into clean arrays; every refusal names the argument."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array, array, number, psd, read_only
from handlcp.errors import InputError
from handlcp.grasp.contact import Contact
from handlcp.grasp.effects import Effect, PrescribedForce
from handlcp.grasp.scene import cross_rows
from handlcp.tolerances import UNIT_NORMAL

__all__ = ["contacts", "effects", "flexibility", "in_plane", "offset", "plane", "wrench"]


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


def plane(value: Any, cs: tuple[Contact, ...], positions: Array, frames: Array) -> Array | None:
    """(3,) unit normal of the scene's plane, or None; contacts must lie in it."""
    if cs[0].planar:
        if value is not None:
            raise InputError("plane", "None for contacts made of 2-vectors (their plane is xy)", repr(value))
        return read_only(np.array([0.0, 0.0, 1.0]))
    if value is None:
        return None
    a = array("plane", value, (3,))
    if abs(np.linalg.norm(a) - 1) > UNIT_NORMAL:
        raise InputError("plane", "a unit vector", f"{a.tolist()}")
    a = read_only(a / np.linalg.norm(a))
    height = positions @ a
    spread = float(abs(positions - positions.mean(0)).max(initial=0.0)) or 1.0
    if np.ptp(height) > 1e-6 * spread:
        raise InputError(
            "plane", "a plane that holds all contact points", f"heights that differ by {np.ptp(height):.3g} m"
        )
    if (tilt := abs(frames[:, :, 2] @ a)).max() > UNIT_NORMAL:
        raise InputError(
            "plane", "a plane that holds all normals", f"normal {int(tilt.argmax())} tilted by {tilt.max():.3g}"
        )
    return a


def in_plane(frames: Array, normal: Array) -> Array:
    """Contact frames turned about their normals until x lies in the plane, on the side of the contact's own x axis."""
    out = np.empty_like(frames)
    for i, R in enumerate(frames):
        x = cross_rows(normal, R[:, 2])
        x = x / np.sqrt(x @ x) * (-1.0 if x @ R[:, 0] < 0 else 1.0)
        out[i] = np.column_stack([x, cross_rows(R[:, 2], x), R[:, 2]])
    return out


def wrench(value: Any, normal: Array | None) -> Array:
    """(6,) force and torque; a planar scene also takes (3,): two forces in the xy plane and the moment."""
    if value is None:
        return read_only(np.zeros(6))
    shapes: tuple[tuple[int, ...], ...] = ((6,),) if normal is None else ((6,), (3,))
    w = array("wrench", value, *shapes)
    if w.shape == (3,):
        if normal is None or abs(normal[2]) != 1.0:
            raise InputError("wrench", "shape (6,) unless the plane is xy", "shape (3,)")
        w = read_only(np.array([w[0], w[1], 0.0, 0.0, 0.0, w[2] * normal[2]]))
    if normal is not None:
        f, m = w[:3], w[3:]
        out = max(abs(float(f @ normal)), float(abs(m - normal * (m @ normal)).max()))
        if out > 1e-9 * float(abs(w).max(initial=0.0)):
            raise InputError("wrench", "forces in the scene's plane and a moment about its normal", w.tolist())
    return w


def flexibility(value: Any, n: int, planar: bool) -> Array:
    """(3n, 3n) from a number, a (3,) diagonal, (n, 3, 3) blocks or the whole matrix; planar: also with 2 for 3."""
    if np.ndim(value) == 0:
        return read_only(np.eye(3 * n) * number("flexibility", value, minimum=0.0))
    shapes: list[tuple[int, ...]] = [(3,), (n, 3, 3), (3 * n, 3 * n)]
    if planar:
        shapes += [(2,), (n, 2, 2), (2 * n, 2 * n)]
    a = array("flexibility", value, *shapes)
    k = 2 if planar and a.shape in ((2,), (n, 2, 2), (2 * n, 2 * n)) else 3
    if a.ndim == 1:
        if (a < 0).any():
            raise InputError("flexibility", "entries ≥ 0", a.tolist())
        a = np.diag(np.tile(a, n))
    elif a.ndim == 3:
        blocks = [psd(f"flexibility[{i}]", b) for i, b in enumerate(a)]
        a = np.zeros((k * n, k * n))
        for i, b in enumerate(blocks):
            a[k * i : k * i + k, k * i : k * i + k] = b
    else:
        a = psd("flexibility", a)
    if k == 2:  # tangent and normal in the plane; nothing acts along y
        keep = np.array([3 * i + j for i in range(n) for j in (0, 2)])
        full = np.zeros((3 * n, 3 * n))
        full[np.ix_(keep, keep)] = a
        a = full
    return read_only(a)


def offset(value: Any, preload: Any, n: int) -> Array:
    """(n, 3) initial motion of the object relative to the tips, the preload's squeeze taken off its normal part."""
    d = np.zeros((n, 3)) if value is None else array("offset", value, (n, 3)).copy()
    d[:, 2] -= number("preload", preload) if np.ndim(preload) == 0 else array("preload", preload, (n,))
    return read_only(d)


def effects(value: Any, n: int) -> tuple[Effect, ...]:
    """Effects asked for by name; each kind once, except prescribed forces, once a contact."""
    try:
        out = (value,) if isinstance(value, Effect) else tuple(value)
    except TypeError:
        out = (value,)
    seen: set[object] = set()
    for k, e in enumerate(out):
        if not isinstance(e, Effect):
            raise InputError(
                f"effects[{k}]", "an effect such as TotalForceBound(50.0) or PrescribedForce(0, (0, 0, 10))", repr(e)
            )
        key: object = type(e)
        if isinstance(e, PrescribedForce):
            if e.contact >= n:
                raise InputError(f"effects[{k}].contact", f"a contact's number from 0 to {n - 1}", e.contact)
            key = e.contact
        if key in seen:
            raise InputError(f"effects[{k}]", "each effect once", f"a second {e!r}")
        seen.add(key)
    return out
