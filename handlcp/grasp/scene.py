"""A grasp as plain arrays: the one description that effects stamp from and the certifier recomputes from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints, nothing, read_only, sealed
from handlcp.grasp.natural import resolve, resolve_soft, wrench_map
from handlcp.grasp.units import GraspUnits
from handlcp.lazy import lazy

__all__ = ["Natural", "Scene", "cross_rows", "shifted"]


@dataclass(frozen=True)
class Scene:
    """SI arrays of a grasp in the coordinates of its friction laws (`friction`), and the same in natural units.

    positions (n, 3) m, frames (n, 3, 3) columns x, y, z (normal, into the object), mu (n,), flexibility (c, c) m/N in
    contact axes, offset (n, 3) m in contact axes, force (3,) N and moment (3,) N·m about the world's origin,
    plane (3,) unit normal of a planar scene or None, governed (n,) bool: contacts whose force is not prescribed,
    fingers: how many contacts, the first ones, are the fingers', the rest being the environment's; None: all.
    soft (k,): contacts that bear a moment about their normal, too; there are c = 3n + k force components, the contacts'
    x, y, z and then those moments. scale (c,): what a component of one means in contact axes [N, N·m]; a column of
    frames is as long as its own. None: all are 1, and contact axes are the law's. spin (k,): what offset is for the
    moments, m; None: zero.
    """

    positions: Array
    frames: Array
    mu: Array
    flexibility: Array
    offset: Array
    force: Array
    moment: Array
    plane: Array | None
    governed: tuple[bool, ...]
    fingers: int | None = None
    soft: tuple[int, ...] = ()
    scale: Array | None = None
    spin: Array | None = None

    def __setstate__(self, state: dict[str, Any]) -> None:
        """After pickling, read-only again."""
        self.__dict__.update(sealed(state))

    @property
    def n(self) -> int:
        """Contacts."""
        return len(self.mu)

    @property
    def environment(self) -> int:
        """How many contacts, the last ones, are not fingers'."""
        return 0 if self.fingers is None else self.n - self.fingers

    @lazy
    def _resolved(self) -> tuple[GraspUnits, Array, Array, Natural]:
        freedom = _SPATIAL if self.freedom is None else self.freedom
        if self.soft:
            force, length, motion, centre, arms, wrench, blocks = resolve_soft(
                self.positions, self.frames, self.flexibility, self.offset, self.force, self.moment, freedom,
                np.concatenate([self.normal_index, self.tangent_index]), self.spin_axes, self.every_offset,
            )  # fmt: skip
            return GraspUnits(force, length, motion, centre), arms, wrench, Natural(*blocks, len(self.normal_index))
        index = _index(self.governed, self.rough, self.tangents)
        force, length, motion, centre, arms, wrench, blocks = resolve(
            self.positions, self.frames, self.flexibility, self.offset, self.force, self.moment, freedom, index
        )
        return GraspUnits(force, length, motion, centre), arms, wrench, Natural(*blocks, len(self.normal_index))

    @property
    def units(self) -> GraspUnits:
        """Natural units."""
        return self._resolved[0]

    @property
    def arms(self) -> Array:
        """(n, 3) contact points from the contacts' centre [m]."""
        return self._resolved[1]

    @property
    def wrench(self) -> Array:
        """(6,) the world's wrench on the object about the contacts' centre [N, N·m]."""
        return self._resolved[2]

    @lazy
    def grasp_matrix(self) -> Array:
        """(6, c) force components to the wrench about the contacts' centre: columns [R; skew(p - c) R] (model, G)."""
        G = wrench_map(self.arms, self.frames)
        return np.hstack([G, np.vstack([0.0 * self.spin_axes, self.spin_axes])]) if self.soft else G

    @property
    def levers(self) -> Array:
        """(k,) what makes moments of the torsional components, of soft contacts [m]."""
        return nothing() if self.scale is None else self.scale[3 * self.n :]

    @lazy
    def spin_axes(self) -> Array:
        """(3, k) moments that one of each torsional component stands for: lever times normal [m]."""
        return (self.frames[list(self.soft)][:, :, 2] * self.levers[:, None]).T

    @property
    def every_offset(self) -> Array:
        """(c,) offset of all components [m]."""
        spin = np.zeros(len(self.soft)) if self.spin is None else self.spin
        return np.append(self.offset.ravel(), spin)

    @property
    def components(self) -> int:
        """Force components: three a contact, and the moment of every soft one."""
        return 3 * self.n + len(self.soft)

    def physical(self, forces: Array) -> Array:
        """(n, 3) forces in contact axes from those in the laws' coordinates; a motion is divided by the same scale."""
        return forces if self.scale is None else forces * self.scale[: 3 * self.n].reshape(-1, 3)

    def lawful(self, forces: Array) -> Array:
        """(n, 3) forces in the laws' coordinates from those in contact axes."""
        return forces if self.scale is None else forces / self.scale[: 3 * self.n].reshape(-1, 3)

    def lawful_at(self, contact: int, force: Array) -> Array:
        """(3,) the same for one contact's force."""
        return force if self.scale is None else force / self.scale[3 * contact : 3 * contact + 3]

    @property
    def natural(self) -> Natural:
        """The blocks of G, E, d and w that the unknowns touch, in natural units (hatted in the model)."""
        return self._resolved[3]

    # ---- the object's freedom: 6 unknowns, or 3 in a plane
    @lazy
    def freedom(self) -> Array | None:
        """(3, 6) components of wrenches and twists in a planar scene: two forces, the moment about the normal."""
        if self.plane is None:
            return None
        a = self.frames[0][:, 2]
        W = np.zeros((3, 6))
        W[0, :3], W[1, :3], W[2, 3:] = a, cross_rows(self.plane, a), self.plane
        if abs(self.plane[2]) == 1.0:  # the xy plane keeps the user's own axes
            W[0, :3], W[1, :3] = (1, 0, 0), (0, self.plane[2], 0)
        return read_only(W)

    @property
    def dof(self) -> int:
        """Unknown components of the object's motion: 6, or 3 in a planar scene."""
        return 6 if self.plane is None else 3

    # ---- which of the 3n force components are unknown
    @property
    def normal_index(self) -> Ints:
        """(n_N,) entries of the stacked (x, y, z) forces that are unknown normal forces."""
        return _normal_index(self.governed)

    @lazy
    def flexible(self) -> bool:
        """Whether any finger gives way under load."""
        return bool(self.flexibility.any())

    @lazy
    def rough(self) -> tuple[int, ...]:
        """Contacts with friction whose force is unknown, soft ones apart."""
        found = tuple(i for i, mu in enumerate(self.mu.tolist()) if mu > 0 and self.governed[i])
        return tuple(i for i in found if i not in self.soft) if self.soft else found

    @property
    def frictional(self) -> bool:
        """Whether any contact has friction."""
        return bool(self.rough or self.soft)

    @property
    def rough_rows(self) -> Ints:
        """(k,) for each contact with friction, which of the unknown normal forces is its own."""
        return _rough_rows(self.governed, self.rough)

    @property
    def soft_rows(self) -> Ints:
        """(k,) the same for each soft contact."""
        return _rough_rows(self.governed, self.soft)

    @property
    def tangents(self) -> int:
        """Tangential unknowns per contact with friction: 2, or 1 in a planar scene."""
        return 2 if self.plane is None else 1

    @property
    def tangent_index(self) -> Ints:
        """(n_T,) entries of the stacked force components that are unknown tangential forces: x and y of contacts with
        friction, then x, y and moment of the soft ones.
        """
        hard = _tangent_index(self.rough, self.tangents)
        return np.concatenate([hard, self.soft_index.ravel()]) if self.soft else hard

    @lazy
    def soft_index(self) -> Ints:
        """(k, 3) entries of the soft contacts' x, y and moment."""
        at, k = 3 * np.array(self.soft, dtype=np.int64), len(self.soft)
        return np.column_stack([at, at + 1, 3 * self.n + np.arange(k)])

    @property
    def tangential_offset(self) -> Array:
        """(tangents of `rough`,) d along them, natural units."""
        return self.natural.d[self.natural.split :][: self.tangents * len(self.rough)]

    @property
    def soft_offset(self) -> Array:
        """(3 k,) d along x, y and about the normal of the soft contacts, natural units."""
        return self.natural.d[self.natural.split + self.tangents * len(self.rough) :]

    @property
    def anisotropic(self) -> int:
        """How many contacts have tangents of unequal scale."""
        if self.scale is None:
            return 0
        rows = self.scale[: 3 * self.n].reshape(-1, 3)
        return int((rows[:, 0] != rows[:, 1]).sum())

    @lazy
    def governed_mask(self) -> Bools:
        """(n,) bool, `governed` as an array."""
        return np.array(self.governed)

    @lazy
    def made(self) -> list[tuple[object, Any]]:
        """What effects made of this scene, with the effect itself: kept so that it is made once (`Effect.present`).

        Threads may both append the same; either is right. Found by identity, also after pickling.
        """
        return []

    # ---- natural units
    @lazy
    def twist_units(self) -> Array:
        """(dof,) SI size of one natural unit of each component of the object's motion [m or rad]."""
        u, k = self.units, 3 if self.plane is None else 2
        return np.array((u.motion,) * k + (u.motion / u.length,) * (self.dof - k))

    def size(self, measure: str) -> float | Array:
        """SI size of one natural unit of a "force", "motion", "twist" or "wrench"."""
        u, k = self.units, 3 if self.plane is None else 2
        if measure == "force":
            return u.force
        if measure == "motion":
            return u.motion
        if measure == "twist":
            return self.twist_units
        return np.array([u.force] * k + [u.force * u.length] * (self.dof - k))

    def twist(self, natural: Array) -> Array:
        """(6,) SI twist about the contacts' centre from (dof,) natural components."""
        u = natural * self.twist_units
        return u if self.freedom is None else u @ self.freedom


@dataclass(frozen=True, slots=True)
class Natural:
    """G (dof, k), E (k, k), d (k,) over the k = n_N + n_T unknown force components, normals first; w (dof,);
    every (dof, c) G of all components; `split` = n_N.
    """

    G: Array
    every: Array
    E: Array
    d: Array
    w: Array
    split: int


_SPATIAL = read_only(np.eye(6))


# Index arrays depend on the pattern of contacts alone: a hand in many postures meets the same few again and again
@lru_cache(maxsize=1024)
def _normal_index(governed: tuple[bool, ...]) -> Ints:
    return np.array([3 * i + 2 for i, g in enumerate(governed) if g], dtype=np.int64)


@lru_cache(maxsize=1024)
def _tangent_index(rough: tuple[int, ...], tangents: int) -> Ints:
    return np.array([3 * i + k for i in rough for k in range(tangents)], dtype=np.int64)


@lru_cache(maxsize=1024)
def _rough_rows(governed: tuple[bool, ...], rough: tuple[int, ...]) -> Ints:
    place = {i: row for row, i in enumerate(i for i, g in enumerate(governed) if g)}
    return np.array([place[i] for i in rough], dtype=np.int64)


@lru_cache(maxsize=1024)
def _index(governed: tuple[bool, ...], rough: tuple[int, ...], tangents: int) -> Ints:
    return np.concatenate([_normal_index(governed), _tangent_index(rough, tangents)])


def cross_rows(a: Array, b: Array) -> Array:
    """A × b for (3,) arguments, or (n, 3) ones row by row; numpy's own costs ten times as much on arrays this small."""
    if a.ndim == b.ndim == 1:
        (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
        return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    ax, ay, az = a.T
    bx, by, bz = b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def shifted(twist: Array, arm: Array) -> Array:
    """(6,) the same small motion seen at a point `arm` (3,) away: u' = u + ω × arm."""
    u, v, w, p, q, r = twist.tolist()
    x, y, z = arm.tolist()
    return np.array([u + q * z - r * y, v + r * x - p * z, w + p * y - q * x, p, q, r])
