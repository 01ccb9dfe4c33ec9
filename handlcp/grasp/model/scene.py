"""`Scene`: a grasp compiled to arrays in natural units, its grasp matrix, and the blocks that effects stamp.

The c = 3n + k force components are the contacts' x, y and z and then the moments of the k soft contacts about their
normals (over a lever, so that they are forces).

    w + G r = 0,    v = Gᵀ u + E r + d,    G = [R; skew(p - centre) R | 0; lever n]
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, freeze_arrays, read_only
from handlcp.contact.friction import Section, limit_set
from handlcp.grasp.model.contact import SceneKind, cross_rows
from handlcp.grasp.model.flexibility import (
    MIN_CONTACTS_TO_FACTOR,
    Flexibility,
    find_factor,
    holds_flexibility,
    stored_flexibility,
)
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.lazy_property import lazy_property
from handlcp.lcp.kernels.dense import kernel


class GraspArrays(NamedTuple):
    """A grasp as arrays, SI: positions (n, 3), frames (n, 3, 3), flexibility (c, c), offset (c,), forces (c,) that are
    prescribed, spin (3, k) moments that one of each torsional component stands for, force and moment (3,) of the load
    about the world's origin, freedom (dof, 6) of the object.
    """

    positions: Array
    frames: Array
    flexibility: Array
    offset: Array
    prescribed: Array
    spin: Array
    force: Array
    moment: Array
    freedom: Array


class NaturalBlocks(NamedTuple):
    """In natural units, over the unknown force components, normal ones first: G (dof, m), E (m, m), d (m,); the load
    w (dof,); and full_G (dof, c), G over all components. Prescribed forces are part of w and d.
    """

    G: Array
    full_G: Array
    E: Array
    d: Array
    w: Array


class GraspGeometry(NamedTuple):
    """What makes a grasp free of units: its natural units, and the load and the grasp matrix about its centre.

    force_unit [N], length_unit of levers [m], motion_unit [m].
    centre (3,) : of the contacts [m].
    wrench (6,) : of the load about it [N, N·m].
    grasp_matrix (6, c) : about it.

    Every unit is a norm or a mean (`_natural_units`), so another unit, a turned world or another order of fingers
    changes none of them beyond rounding.
    """

    force_unit: float
    length_unit: float
    motion_unit: float
    centre: Array
    wrench: Array
    grasp_matrix: Array


@kernel
def nondimensionalise(g: GraspArrays, index: Ints) -> tuple[GraspGeometry, NaturalBlocks]:
    """Units, geometry and blocks of a grasp; index (m,): which force components are unknown, normal ones first."""
    posed = compute_geometry(g, matrix_diagonal(g.flexibility))
    return posed, natural_blocks(g, posed, index)


@kernel
def compute_geometry(g: GraspArrays, own: Array) -> GraspGeometry:
    """Units and geometry of a grasp; own (c,): the diagonal of E, all that they see of it."""
    force, length, motion, centre, wrench = _natural_units(g, own)
    grasp_matrix = wrench_map(g.positions, centre, g.frames, g.spin)
    return GraspGeometry(force, length, motion, centre, wrench, grasp_matrix)


@kernel
def matrix_diagonal(E: Array) -> Array:
    """The diagonal (c,) of the flexibility E (c, c)."""
    own = np.empty(len(E))
    for i in range(len(E)):
        own[i] = E[i, i]
    return own


@kernel
def _natural_units(g: GraspArrays, own: Array) -> tuple[float, float, float, Array, Array]:
    """Find the natural units of a grasp: (force, length, motion, centre, wrench).

    The force is the size of the load plus that of the squeeze [N], the length the rms distance of the contacts from
    their centre (3,) [m], the motion force × the mean flexibility [m], the wrench (6,) that of the load about the
    centre [N, N·m].
    """
    positions, offset = g.positions, g.offset
    n = len(positions)
    centre = np.zeros(3)
    for i in range(n):
        for k in range(3):
            centre[k] += positions[i, k] / n
    spread, travel, softness = 0.0, 0.0, 0.0
    for i in range(n):
        for k in range(3):
            spread += (positions[i, k] - centre[k]) ** 2 / n
            if k < 2 or offset[3 * i + k] < 0.0:  # a gap loads nothing, however wide
                travel += offset[3 * i + k] ** 2 / n
            softness += own[3 * i + k] / (3 * n)
    length, away = np.sqrt(spread), np.sqrt(centre[0] ** 2 + centre[1] ** 2 + centre[2] ** 2)
    if length <= 1e-12 * away:  # all at one point: what is left is rounding, no size
        length = away
    if length == 0.0:
        length = 1.0
    wrench, force, moment, load = np.empty(6), g.force, g.moment, 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        wrench[k], wrench[3 + k] = force[k], moment[k] - centre[i] * force[j] + centre[j] * force[i]
        load += wrench[k] ** 2 + (wrench[3 + k] / length) ** 2
    load = np.sqrt(load)
    travel = np.sqrt(travel)
    size = load + (travel / softness if softness > 0.0 else 0.0)
    if size == 0.0:
        size = 1.0
    motion = softness * size
    if motion == 0.0:
        motion = travel if travel > 0.0 else length
    return size, length, motion, centre, wrench


@kernel
def wrench_map(points: Array, centre: Array, frames: Array, spin: Array) -> Array:
    """The grasp matrix G (6, 3n + k) about a centre, whose columns are wrenches of unit force components.

    Columns are [R; skew(a) R] for frames (n, 3, 3) and arms a from the centre (3,) to the points (n, 3), then [0; spin]
    for spin (3, k).
    """
    n, k = len(points), spin.shape[1]
    G = np.empty((6, 3 * n + k))
    for i in range(n):
        ax, ay, az = points[i, 0] - centre[0], points[i, 1] - centre[1], points[i, 2] - centre[2]
        for a in range(3):
            x, y, z = frames[i, 0, a], frames[i, 1, a], frames[i, 2, a]
            c = 3 * i + a
            G[0, c], G[1, c], G[2, c] = x, y, z
            G[3, c], G[4, c], G[5, c] = ay * z - az * y, az * x - ax * z, ax * y - ay * x
    for j in range(k):
        for a in range(3):
            G[a, 3 * n + j], G[3 + a, 3 * n + j] = 0.0, spin[a, j]
    return G


@kernel
def natural_blocks(g: GraspArrays, p: GraspGeometry, index: Ints) -> NaturalBlocks:
    """`freedom` projects G and w on what the object is free to do."""
    freedom, flexibility, offset, given = g.freedom, g.flexibility, g.offset, g.prescribed
    about, wrench = p.grasp_matrix, p.wrench
    dof, columns, m = freedom.shape[0], about.shape[1], len(index)
    full_G, w = np.zeros((dof, columns)), np.zeros(dof)
    for i in range(dof):
        for j in range(6):
            f = freedom[i, j]
            if f != 0.0:
                if j >= 3:
                    f /= p.length_unit
                w[i] += f * wrench[j] / p.force_unit
                for c in range(columns):
                    full_G[i, c] += f * about[j, c]
    G, E, d = np.empty((dof, m)), np.empty((m, m)), np.empty(m)
    stiffness_unit = p.force_unit / p.motion_unit
    for a in range(m):
        d[a] = offset[index[a]] / p.motion_unit
        for i in range(dof):
            G[i, a] = full_G[i, index[a]]
        for b in range(m):
            E[a, b] = flexibility[index[a], index[b]] * stiffness_unit
    for c in range(columns):
        r = given[c] / p.force_unit
        if r != 0.0:
            for i in range(dof):
                w[i] += full_G[i, c] * r
            for a in range(m):
                d[a] += flexibility[index[a], c] * stiffness_unit * r
    return NaturalBlocks(G, full_G, E, d, w)


# ----------------------------------------------------------------
# A grasp as plain arrays: the one description that effects stamp from and the certifier recomputes from.


_SPATIAL_FREEDOM = read_only(np.eye(6))


@holds_flexibility
@dataclass(frozen=True)
class Scene:
    """SI arrays of a grasp in the coordinates of its friction laws (`friction.law`), and the same in natural units.

    positions (n, 3) m, frames (n, 3, 3) columns x, y, z (normal, into the object), mu (n,), flexibility (c, c) m/N,
    offset (c,) m, force (3,) N and moment (3,) N·m about the world's origin, plane (3,) unit normal of a planar scene
    or None, kind : its unknowns, fingers : how many contacts, the first ones, are the fingers', the rest being the
    environment's; None: all. prescribed (c,) N forces that are no unknowns; None: there are none.
    scale (c,): size of one unit of each force component in contact axes [N, N·m]; each column of `frames` has that
    length. None: all are 1, and contact axes are the law's. mechanism : what moves the fingers, if anything is known;
    bias_torque : (nv,) torque that its joints hold besides that of the contact forces [N·m] (MuJoCo's qfrc_bias); None:
    none.
    """

    positions: Array
    frames: Array
    mu: Array
    flexibility: Array
    offset: Array
    force: Array
    moment: Array
    plane: Array | None
    kind: SceneKind
    fingers: int | None = None
    prescribed: Array | None = None
    scale: Array | None = None
    mechanism: Mechanism | None = None
    bias_torque: Array | None = None

    def __setstate__(self, state: dict[str, Any]) -> None:
        """After pickling, read-only again."""
        self.__dict__.update(freeze_arrays(state))

    # ---- contacts
    @property
    def n(self) -> int:
        """How many contacts there are."""
        return len(self.mu)

    @property
    def environment(self) -> int:
        """How many contacts, the last ones, are not fingers'."""
        return 0 if self.fingers is None else self.n - self.fingers

    @property
    def dof(self) -> int:
        """Unknown components of the object's motion: 6, or 3 in a planar scene."""
        return self.kind.dof

    @property
    def components(self) -> int:
        """How many force components there are: three a contact, and the moment of every soft one."""
        return self.kind.components

    @property
    def force_unknown(self) -> tuple[bool, ...]:
        """(n,) contacts whose force is not prescribed."""
        return self.kind.force_unknown

    @property
    def rough(self) -> tuple[int, ...]:
        """Contacts with friction but no moment about the normal, whose force is unknown."""
        return self.kind.rough

    @property
    def soft(self) -> tuple[int, ...]:
        """(k,) contacts that bear a moment about their normal."""
        return self.kind.soft

    @property
    def frictional(self) -> bool:
        """Whether any contact has friction."""
        return any(self.kind.tangent_count)

    @property
    def anisotropic(self) -> int:
        """How many contacts have tangents of unequal scale."""
        x, y = slice(0, 3 * self.n, 3), slice(1, 3 * self.n, 3)
        return 0 if self.scale is None else int((self.scale[x] != self.scale[y]).sum())

    def friction_coefficients(self, section: Section) -> Array:
        """(n,) radius of each contact's friction set per newton of normal force, or distance of its faces [-]."""
        if not self.soft:
            return self.mu * section.share
        shares = [limit_set(section, t).share if t == 3 else section.share for t in self.kind.tangent_count]
        return np.asarray(self.mu * np.array(shares))

    @property
    def bias_torque_or_zero(self) -> Array:
        """The joint torque (nv,) borne beside Jᵀf [N·m]: `bias_torque`, or zeros where there is none."""
        if self.bias_torque is None:
            return np.zeros(0 if self.mechanism is None else len(self.mechanism.names))
        return self.bias_torque

    # ---- between law axes, in which friction laws are balls, and contact axes: r = S r̂ for S = diag(scale)
    #
    # Motions are dual to forces, since the power is the same in both, r·v = r̂·v̂: v̂ = S v. A condition on the forces,
    # A r = b, has rows  = A S.
    def forces_to_contact_axes(self, forces: Array) -> Array:
        """(..., c) forces and moments in contact axes [N, N·m], r = S r̂, from those in law axes [N]."""
        return forces if self.scale is None else forces * self.scale

    def forces_to_law_axes(self, forces: Array) -> Array:
        """(..., c) forces in law axes [N], r̂ = S⁻¹ r, from forces and moments in contact axes [N, N·m]."""
        return forces if self.scale is None else forces / self.scale

    def motions_to_contact_axes(self, motions: Array) -> Array:
        """(c,) motions in contact axes [m, rad], v = S⁻¹ v̂, from those in law axes [m]."""
        return self.forces_to_law_axes(motions)

    def motions_to_law_axes(self, motions: Array) -> Array:
        """(c,) motions in law axes [m], v̂ = S v, from those in contact axes [m, rad]."""
        return self.forces_to_contact_axes(motions)

    def rows_to_law_axes(self, rows: Array) -> Array:
        """(k, c) rows  = A S over forces in law axes, from rows A over those in contact axes: Â r̂ = A r."""
        return self.forces_to_contact_axes(rows)

    def scatter_torsion(self, torsional: Array) -> Array:
        """(n,) from (k,) of the soft contacts, zero for others."""
        out = np.zeros(self.n)
        out[list(self.soft)] = torsional
        return read_only(out)

    @lazy_property
    def factor(self) -> Flexibility | None:
        """The flexibility as a factor, as it was given or found in its matrix, where contacts are eliminated one by
        one (`SceneKind.has_many_contacts`); None: it is none, or they are not.
        """
        if not self.kind.has_many_contacts:
            return None
        E = stored_flexibility(self)
        if isinstance(E, Flexibility):
            return E
        return None if self.scale is not None or self.n < MIN_CONTACTS_TO_FACTOR else find_factor(E)

    # ---- geometry and natural units
    @lazy_property
    def freedom(self) -> Array:
        """(dof, 6) components of wrenches and twists: all, or in a plane two forces and the moment about its normal."""
        if self.plane is None:
            return _SPATIAL_FREEDOM
        a = self.frames[0][:, 2]
        W = np.zeros((3, 6))
        W[0, :3], W[1, :3], W[2, 3:] = a, cross_rows(self.plane, a), self.plane
        if abs(self.plane[2]) == 1.0:  # the xy plane keeps the user's own axes
            W[0, :3], W[1, :3] = (1, 0, 0), (0, self.plane[2], 0)
        return read_only(W)

    @lazy_property
    def arrays(self) -> GraspArrays:
        """The arrays that compiled code works on."""
        return self.arrays_with(self.flexibility)

    def arrays_with(self, flexibility: Array) -> GraspArrays:
        """The same with this matrix in place of the flexibility, such as none where kernels have its factor."""
        spin = _NO_SPIN
        if self.soft:
            levers = np.zeros(0) if self.scale is None else self.scale[3 * self.n :]
            spin = (self.frames[list(self.soft)][:, :, 2] * levers[:, None]).T.copy()
        known = _zeros(self.components) if self.prescribed is None else self.prescribed
        return GraspArrays(
            self.positions, self.frames, flexibility, self.offset, read_only(known), read_only(spin), self.force,
            self.moment, self.freedom,
        )  # fmt: skip

    @lazy_property
    def _geometry_and_blocks(self) -> tuple[GraspGeometry, NaturalBlocks]:
        return nondimensionalise(self.arrays, self.kind.index)

    @property
    def geometry(self) -> GraspGeometry:
        """Units, centre, arms, wrench and grasp matrix about the contacts' centre."""
        return self._geometry_and_blocks[0]

    @property
    def natural(self) -> NaturalBlocks:
        """The blocks of G, E, d and w that the unknowns touch, in natural units (hatted in the model)."""
        return self._geometry_and_blocks[1]

    @property
    def units(self) -> GraspGeometry:
        """The natural units of force, length and motion, and the centre that twists refer to."""
        return self._geometry_and_blocks[0]

    @lazy_property
    def twist_units(self) -> Array:
        """(dof,) SI size of one natural unit of each component of the object's motion [m or rad]."""
        u, k = self.units, 3 if self.plane is None else 2
        return np.array((u.motion_unit,) * k + (u.motion_unit / u.length_unit,) * (self.dof - k))

    def twist(self, natural: Array) -> Array:
        """(6,) SI twist about the contacts' centre from (dof,) natural components."""
        return np.asarray((natural * self.twist_units) @ self.freedom)

    def natural_twist(self, twist: Array) -> Array:
        """(dof,) natural components of an SI twist (6,) about the contacts' centre."""
        return np.asarray(self.freedom @ twist / self.twist_units)

    @lazy_property
    def force_unknown_mask(self) -> Bools:
        """(n,) bool, `force_unknown` as an array."""
        return np.array(self.force_unknown)

    @lazy_property
    def effect_cache(self) -> list[tuple[object, Any]]:
        """What effects made of this scene, with the effect itself: kept so that it is made once (`Effect.present`).

        Threads may both append the same; either is right. Found by identity, also after pickling.
        """
        return []


_NO_SPIN = read_only(np.zeros((3, 0)))


@lru_cache(maxsize=256)
def _zeros(count: int) -> Array:
    return read_only(np.zeros(count))
