"""A grasp as plain arrays: the one description that effects stamp from and the certifier recomputes from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, read_only, sealed
from handlcp.grasp.friction import Section, limit_set
from handlcp.grasp.model.factoring import MANY_AS_MATRIX, found_in
from handlcp.grasp.model.flexibility import Flexibility, flexible, kept
from handlcp.grasp.model.grasp_matrix import Blocks, Given, Posed, pose
from handlcp.grasp.model.kind import Kind, cross_rows
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.lazy import lazy

_SPATIAL = read_only(np.eye(6))


@flexible
@dataclass(frozen=True)
class Scene:
    """SI arrays of a grasp in the coordinates of its friction laws (`friction.law`), and the same in natural units.

    positions (n, 3) m, frames (n, 3, 3) columns x, y, z (normal, into the object), mu (n,), flexibility (c, c) m/N,
    offset (c,) m, force (3,) N and moment (3,) N·m about the world's origin, plane (3,) unit normal of a planar scene
    or None, kind : its unknowns, fingers : how many contacts, the first ones, are the fingers', the rest being the
    environment's; None: all. prescribed (c,) N forces that are no unknowns; None: there are none.
    scale (c,): size of one unit of each force component in contact axes [N, N·m]; each column of `frames` has that
    length. None: all are 1, and contact axes are the law's. mechanism : what moves the fingers, if anything is known;
    held : (nv,) torque that its joints hold besides that of the contact forces [N·m]; None: none.
    """

    positions: Array
    frames: Array
    mu: Array
    flexibility: Array
    offset: Array
    force: Array
    moment: Array
    plane: Array | None
    kind: Kind
    fingers: int | None = None
    prescribed: Array | None = None
    scale: Array | None = None
    mechanism: Mechanism | None = None
    held: Array | None = None

    def __setstate__(self, state: dict[str, Any]) -> None:
        """After pickling, read-only again."""
        self.__dict__.update(sealed(state))

    # ---- contacts
    @property
    def n(self) -> int:
        """Contacts."""
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
        """Force components: three a contact, and the moment of every soft one."""
        return self.kind.components

    @property
    def governed(self) -> tuple[bool, ...]:
        """(n,) contacts whose force is not prescribed."""
        return self.kind.governed

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
        return any(self.kind.tangents)

    @property
    def anisotropic(self) -> int:
        """How many contacts have tangents of unequal scale."""
        x, y = slice(0, 3 * self.n, 3), slice(1, 3 * self.n, 3)
        return 0 if self.scale is None else int((self.scale[x] != self.scale[y]).sum())

    def limits(self, section: Section) -> Array:
        """(n,) radius of each contact's friction set, or distance of its faces, per newton of normal force [-]."""
        if not self.soft:
            return self.mu * section.share
        shares = [limit_set(section, t).share if t == 3 else section.share for t in self.kind.tangents]
        return np.asarray(self.mu * np.array(shares))

    @property
    def held_torque(self) -> Array:
        """(nv,) `held`, or zeros."""
        if self.held is None:
            return np.zeros(0 if self.mechanism is None else len(self.mechanism.names))
        return self.held

    # ---- between the coordinates of the laws and contact axes
    def physical(self, components: Array) -> Array:
        """(c,) in contact axes, N and N·m, from forces in the laws' coordinates."""
        return components if self.scale is None else components * self.scale

    def lawful(self, components: Array) -> Array:
        """(c,) forces in the laws' coordinates from those in contact axes; motions in contact axes from the laws'."""
        return components if self.scale is None else components / self.scale

    def by_contact(self, torsional: Array) -> Array:
        """(n,) from (k,) of the soft contacts, zero for others."""
        out = np.zeros(self.n)
        out[list(self.soft)] = torsional
        return read_only(out)

    @lazy
    def factor(self) -> Flexibility | None:
        """The flexibility as a factor: as it was given, or found in a matrix of many contacts; None: it is none."""
        E = kept(self)
        if isinstance(E, Flexibility):
            return E
        return None if self.scale is not None or self.soft or self.n < MANY_AS_MATRIX else found_in(E)

    # ---- geometry and natural units
    @lazy
    def freedom(self) -> Array:
        """(dof, 6) components of wrenches and twists: all, or in a plane two forces and the moment about its normal."""
        if self.plane is None:
            return _SPATIAL
        a = self.frames[0][:, 2]
        W = np.zeros((3, 6))
        W[0, :3], W[1, :3], W[2, 3:] = a, cross_rows(self.plane, a), self.plane
        if abs(self.plane[2]) == 1.0:  # the xy plane keeps the user's own axes
            W[0, :3], W[1, :3] = (1, 0, 0), (0, self.plane[2], 0)
        return read_only(W)

    @lazy
    def given(self) -> Given:
        """The arrays that compiled code works on."""
        spin = _NO_SPIN
        if self.soft:
            levers = np.zeros(0) if self.scale is None else self.scale[3 * self.n :]
            spin = (self.frames[list(self.soft)][:, :, 2] * levers[:, None]).T.copy()
        known = _zeros(self.components) if self.prescribed is None else self.prescribed
        return Given(
            self.positions, self.frames, self.flexibility, self.offset, read_only(known), read_only(spin), self.force,
            self.moment, self.freedom,
        )  # fmt: skip

    @lazy
    def _posed(self) -> tuple[Posed, Blocks]:
        return pose(self.given, self.kind.index)

    @property
    def geometry(self) -> Posed:
        """Units, centre, arms, wrench and grasp matrix about the contacts' centre."""
        return self._posed[0]

    @property
    def natural(self) -> Blocks:
        """The blocks of G, E, d and w that the unknowns touch, in natural units (hatted in the model)."""
        return self._posed[1]

    @property
    def units(self) -> Posed:
        """Natural units: force, length and motion of `geometry`, and the centre that twists refer to."""
        return self._posed[0]

    @lazy
    def twist_units(self) -> Array:
        """(dof,) SI size of one natural unit of each component of the object's motion [m or rad]."""
        u, k = self.units, 3 if self.plane is None else 2
        return np.array((u.motion,) * k + (u.motion / u.length,) * (self.dof - k))

    def twist(self, natural: Array) -> Array:
        """(6,) SI twist about the contacts' centre from (dof,) natural components."""
        return np.asarray((natural * self.twist_units) @ self.freedom)

    def natural_twist(self, twist: Array) -> Array:
        """(dof,) natural components of an SI twist (6,) about the contacts' centre."""
        return np.asarray(self.freedom @ twist / self.twist_units)

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


_NO_SPIN = read_only(np.zeros((3, 0)))


@lru_cache(maxsize=256)
def _zeros(count: int) -> Array:
    return read_only(np.zeros(count))
