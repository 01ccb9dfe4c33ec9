"""From what was asked to the arrays of a scene, in the coordinates of its friction laws (`friction.law`).

    r = S r̂,    R̂ = R S,  Ê = S E S,  d̂ = S d,  v̂ = S v

Balance, compatibility and power look the same in r̂ and v̂ as they do in r and v, so that solvers, certifier and search
know one friction law: a ball. Where S = 1, in nearly all scenes, nothing is done.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.model.contact import Contact, Placement, cached_kind, cross_rows
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.flexibility import Flexibility, flexibility_matrix, stored_flexibility
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.tolerances import MAX_LEVER

FlexibilityInput = Array | Flexibility  # as it was given


def build_scene(spec: GraspSpec) -> Scene:
    """The scene of a grasp, what its effects add included."""
    contacts, planar = spec.contacts, spec.plane is not None
    known = {i: f for e in spec.effects for i, f in e.prescribed().items()} if spec.effects else {}
    governed = tuple([i not in known for i in range(len(contacts))])
    mu = np.array([c.mu for c in contacts])
    scale: Array | None = None
    plain = all([c.plain for c in contacts])
    if plain:
        tangent_count = tuple([0 if c.mu == 0.0 else 1 if planar else 2 for c in contacts])
    elif planar:
        tangent_count = tuple([int(c.mu > 0.0) for c in contacts])
        along = [c.rotation.T @ R[:, 0] for c, R in zip(contacts, spec.frames, strict=True)]
        laws = [(c.friction, x, y) for c, (x, y, _) in zip(contacts, along, strict=True)]
        mu = np.array([law.mu if law.plain else law.toward(float(x), float(y)) for law, x, y in laws])
    else:
        tangent_count = tuple([0 if c.mu == 0.0 else 3 if c.friction.lever > 0.0 else 2 for c in contacts])
    if known:
        tangent_count = tuple([t if free else 0 for t, free in zip(tangent_count, governed, strict=True)])
    soft = tuple([i for i, t in enumerate(tangent_count) if t == 3]) if 3 in tangent_count else ()
    if soft:
        _check_levers(spec, soft)
    E, d = _add_torsion(spec, soft)
    bias_torque: Array | None = None
    if spec.effects:
        # A factor stays one where effects add nothing to it
        if not isinstance(E, Flexibility) or any([e.added_flexibility(spec, soft) is not None for e in spec.effects]):
            E = add_flexibility(spec.effects, spec, soft, flexibility_matrix(E))
        d = add_offset(spec.effects, spec, soft, d)
        torques = [torque for e in spec.effects if (torque := e.added_torque()) is not None]
        bias_torque = sum(torques[1:], torques[0]) if torques else None
    if spec.mechanism is not None and (springs := spec.mechanism.parallel_spring_torque()) is not None:
        bias_torque = springs if bias_torque is None else bias_torque + springs
    frames = spec.frames
    if not planar and not plain and (scale := _law_scales(contacts, soft)) is not None:
        rows = scale[: 3 * len(contacts)].reshape(-1, 3)
        frames, E, d = frames * rows[:, None, :], flexibility_matrix(E) * scale[:, None] * scale, d * scale
    given = None
    if known:
        given = np.zeros(len(d))
        for i, force in known.items():
            given[3 * i : 3 * i + 3] = force if scale is None else force / scale[3 * i : 3 * i + 3]
    force, E = spec.wrench[:3], E if isinstance(E, Flexibility) else read_only(E)
    return Scene(
        spec.positions,
        read_only(frames),
        read_only(mu),
        cast(Array, E),
        read_only(d),
        force,
        read_only(spec.wrench[3:] + cross_rows(spec.reference, force)),
        spec.plane,
        cached_kind(governed, tangent_count, planar, bool(E.any())),
        spec.fingers,
        given,
        scale,
        spec.mechanism,
        bias_torque,
    )


def add_flexibility(effects: tuple[Effect, ...], at: Placement, soft: tuple[int, ...], E: Array) -> Array:
    """(c, c) flexibility with what effects add to E [m/N]; soft : contacts that bear a moment."""
    return _sum_added(at, E, [e.added_flexibility(at, soft) for e in effects])


def add_offset(effects: tuple[Effect, ...], at: Placement, soft: tuple[int, ...], d: Array) -> Array:
    """(c,) offset with what effects add to d [m, rad]; soft : contacts that bear a moment."""
    return _sum_added(at, d, [e.added_offset(at, soft) for e in effects])


def _sum_added(at: Placement, total: Array, added: list[Array | None]) -> Array:
    """The sum; in a plane without what acts or moves across it, where no force is and no gap opens."""
    for more in added:
        if more is not None and more.any():
            if at.planar:
                within = np.where(np.arange(len(more)) % 3 == 1, 0.0, 1.0)
                more = more * (within if more.ndim == 1 else np.outer(within, within))
            total = total + more
    return total


def _check_levers(spec: GraspSpec, soft: tuple[int, ...]) -> None:
    """Raises InputError for a lever far beyond the size of the grasp; contacts at one point have no size."""
    arms = spec.positions - spec.positions.mean(axis=0)
    size = float(np.sqrt((arms**2).sum(axis=1).mean()))
    longest = max([spec.contacts[i].friction.lever for i in soft])
    if size > 1e-12 * float(abs(spec.positions).max()) and longest > MAX_LEVER * size:
        expected = f"mu_torsion / mu up to {MAX_LEVER:g} times the size of the grasp, {MAX_LEVER * size:.3g} m"
        raise InputError("SoftFinger.mu_torsion", expected, f"{longest:.3g} m")


def _add_torsion(spec: GraspSpec, soft: tuple[int, ...]) -> tuple[FlexibilityInput, Array]:
    """Flexibility (c, c) and offset (c,) of the points and of the turns about the normals of the soft contacts: pads
    turn, and joints turn the fingertip under its moment. Where E is zero, joints are taken as rigid in torsion, too.
    """
    d = spec.offset.reshape(-1)
    if not soft:
        return stored_flexibility(spec), d
    n = len(d)
    E = np.zeros((n + len(soft), n + len(soft)))
    if spec.mechanism is not None and spec.flexibility.any():
        E += spec.mechanism.contact_compliance(spec.mechanism.jacobian_rows(soft))
    E[:n, :n] = spec.flexibility
    for at, i in enumerate(soft, n):
        E[at, at] += spec.contacts[i].friction.pad_torsion
    return E, np.append(d, np.zeros(len(soft)))


def _law_scales(contacts: tuple[Contact, ...], soft: tuple[int, ...]) -> Array | None:
    """(c,) diagonal of S; None: all one."""
    rows = np.ones((len(contacts), 3))
    for row, c in zip(rows, contacts, strict=True):
        row[:2] = c.friction.scale
    scale = np.append(rows.ravel(), [contacts[i].friction.lever for i in soft])
    return None if not soft and (scale == 1.0).all() else read_only(scale)
