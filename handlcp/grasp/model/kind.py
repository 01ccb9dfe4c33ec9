"""Which unknowns a grasp has, and where they stand among its force components."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.lazy import lazy

# ----------------------------------------------------------------
# Products of small vectors and matrices of small blocks, where numpy's own cost ten times as much.


def cross_rows(a: Array, b: Array) -> Array:
    """A × b for (3,) arguments, or (n, 3) ones row by row."""
    if a.ndim == b.ndim == 1:
        (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
        return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    ax, ay, az = a.T
    bx, by, bz = b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def block_diagonal(blocks: Array, n: int) -> Array:
    """(nk, nk) with blocks (m, k, k), m ≤ n, first on its diagonal, or one (k, k) n times."""
    k, each = blocks.shape[-1], np.arange(len(blocks) if blocks.ndim == 3 else n)
    out = np.zeros((n, k, n, k))
    out[each, :, each] = blocks
    return out.reshape(n * k, n * k)


def shifted(twist: Array, arm: Array) -> Array:
    """(6,) the same small motion seen at a point `arm` (3,) away: u' = u + ω × arm."""
    u, v, w, p, q, r = twist.tolist()
    x, y, z = arm.tolist()
    return np.array([u + q * z - r * y, v + r * x - p * z, w + p * y - q * x, p, q, r])


# ----------------------------------------------------------------
# Where the contacts of a grasp are, and what moves them.


MANY = 10  # contacts from which on a solve by elimination is the faster one


@dataclass(frozen=True, eq=False)
class Placement:
    """contacts (n,): of the fingers, then of the environment. positions (n, 3) [m]. frames (n, 3, 3): contact axes in
    columns, world axes. plane (3,): unit normal of a planar scene; None: spatial. fingers: how many contacts, the first
    ones, are the fingers'; None: all. mechanism: what moves the fingers, if anything is known.
    """

    contacts: tuple[Contact, ...]
    positions: Array
    frames: Array
    plane: Array | None
    fingers: int | None
    mechanism: Mechanism | None

    @property
    def n(self) -> int:
        """Contacts."""
        return len(self.contacts)

    @property
    def of_hand(self) -> int:
        """How many contacts are the hand's, at its fingertips or on its links; those of the environment follow."""
        return self.n if self.fingers is None else self.fingers

    @property
    def who(self) -> str:
        """What each of them is called: "finger"; "contact" where a table or links of the hand touch, too."""
        return "contact" if self.of_hand < self.n or self.links else "finger"

    @property
    def links(self) -> dict[str, str]:
        """By the names of contacts that are places on links: the link; {} where fingertips alone touch."""
        return {} if self.mechanism is None else self.mechanism.links

    @property
    def planar(self) -> bool:
        """Whether the scene lies in a plane."""
        return self.plane is not None


# ----------------------------------------------------------------


@dataclass(frozen=True)
class Kind:
    """What decides which unknowns a scene has, whatever its numbers.

    governed (n,): contacts whose force is not prescribed. tangents (n,): how many tangential forces a contact has, 0
    without friction, 1 in a plane, 2, or 3 with the moment of a soft finger; 0 where its force is prescribed.
    planar, flexible : whether the scene lies in a plane, and whether any finger gives way. The index arrays below count
    the c = 3n + k force components: the contacts' x, y, z, then the moments of the k soft contacts.
    """

    governed: tuple[bool, ...]
    tangents: tuple[int, ...]
    planar: bool
    flexible: bool

    @lazy
    def n(self) -> int:
        """Contacts."""
        return len(self.governed)

    @property
    def dof(self) -> int:
        """Unknown components of the object's motion: 6, or 3 in a plane."""
        return 3 if self.planar else 6

    @property
    def many(self) -> bool:
        """Whether a solve that eliminates contact by contact (`lcp/kernels/contact_blocks.py`) is the faster one."""
        return self.n >= MANY and not (self.planar or self.soft) and all(self.governed)

    @lazy
    def soft(self) -> tuple[int, ...]:
        """(k,) contacts that bear a moment about their normal."""
        return tuple(i for i, t in enumerate(self.tangents) if t == 3)

    @lazy
    def rough(self) -> tuple[int, ...]:
        """Contacts with friction but no moment."""
        return tuple(i for i, t in enumerate(self.tangents) if t in (1, 2))

    @lazy
    def components(self) -> int:
        """c, the force components."""
        return 3 * self.n + len(self.soft)

    @lazy
    def contact_components(self) -> Ints:
        """(n, 4) of each contact whose force is unknown: its normal component and its tangential ones, padded by -1."""
        out = np.full((self.n, 4), -1, dtype=np.int64)
        for i, (free, t) in enumerate(zip(self.governed, self.tangents, strict=True)):
            if free:
                moment = [3 * self.n + self.soft.index(i)] if t == 3 else []
                own = [3 * i + 2, 3 * i, 3 * i + 1][: 1 + min(t, 2)] + moment
                out[i, : len(own)] = own
        return out

    @lazy
    def normal_index(self) -> Ints:
        """(m,) unknown normal components."""
        return np.asarray(self.contact_components[np.array(self.governed), 0])

    @lazy
    def tangent_index(self) -> Ints:
        """Unknown tangential components, of `rough` contacts first, then of `soft` ones."""
        own = self.contact_components[[*self.rough, *self.soft], 1:]
        return own[own >= 0]

    @lazy
    def index(self) -> Ints:
        """All unknown components, normal ones first."""
        return np.concatenate([self.normal_index, self.tangent_index])


# A hand in many postures, or a sweep, meets the same few kinds again and again, and each makes its index arrays once
kind_of = lru_cache(maxsize=1024)(Kind)
