"""`Contact`, one contact of a grasp; `Placement`, where all are; `SceneKind`, which of their forces are unknown."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from handlcp.check import Array, Ints, check_array, check_init_call, check_method_calls, check_unit_vector, read_only
from handlcp.contact.friction import Coulomb, FrictionLaw, as_law
from handlcp.errors import InputError
from handlcp.grasp.model.mechanism import Mechanism
from handlcp.lazy_property import lazy_property


@check_init_call()
@check_method_calls
class Contact:
    """A contact of a finger on the object.

    Parameters
    ----------
    position : (3,) contact point [m], world axes; (2,) in a planar scene.
    normal : (3,) unit vector into the object, the way the finger pushes; (2,) in a planar scene. It is
        normalised, and refused where its length is off by 1e-3 or more.
    friction : a coefficient, as `Coulomb(mu)` (None: 0.5), `Frictionless()`, `AnisotropicCoulomb(mu_x, mu_y)` or
        `SoftFinger(mu, mu_torsion)`.
    tangent : direction of the contact's x axis, projected on the tangent plane; chosen deterministically when None
        (`along` of the friction, or the world axis nearest to the tangent plane, the first of equals).
    name : what reports call the finger; "finger 1", "finger 2", … when None.

    The contact frame is R = (x, y, z) with z the normal and y = z × x: Pinocchio's contact convention.
    A contact made of 2-vectors lies in the xy plane, with y = (0, 0, 1) and x in the plane.

    Attributes: position (3,), rotation (3, 3), friction, mu, name, planar, and plain: whether the law is a disc in the
    contact's own axes. Immutable by custom. Raises InputError for wrong shapes, numbers not finite, a normal not of
    unit length, a tangent along the normal.
    """

    __slots__ = ("friction", "mu", "name", "plain", "planar", "position", "rotation")

    position: Array
    rotation: Array
    friction: FrictionLaw
    mu: float
    plain: bool
    planar: bool
    name: str | None

    def __init__(
        self,
        position: Any,
        normal: Any,
        friction: FrictionLaw | float | None = None,
        tangent: Any = None,
        name: str | None = None,
    ) -> None:
        law = Coulomb(0.5) if friction is None else as_law(friction)
        if name is not None and not isinstance(name, str):
            raise InputError("name", "a string", repr(name))
        p = check_array("position", position, (3,), (2,))
        z = check_unit_vector("normal", normal, (3,), (2,))
        if p.shape != z.shape:
            raise InputError("normal", f"as many components as position, {len(p)}", f"{len(z)}")
        planar = p.shape == (2,)
        tangent = law.x_axis if tangent is None else tangent
        x = None if tangent is None else check_array("tangent", tangent, p.shape)
        if planar:
            p, z = np.append(p, 0.0), np.append(z, 0.0)
            x = np.cross((0.0, 0.0, 1.0), z) if x is None else np.append(x, 0.0)
        self._set_arrays(read_only(p), contact_frame(z, x), law, planar, name)

    def _set_arrays(
        self, position: Array, rotation: Array, friction: FrictionLaw, planar: bool, name: str | None
    ) -> None:
        self.position, self.rotation, self.planar, self.name = position, rotation, planar, name
        self.friction, self.mu, self.plain = friction, friction.mu, friction.plain

    @property
    def normal(self) -> Array:
        """(3,) unit vector into the object, world axes."""
        return self.rotation[:, 2]

    @property
    def tangent(self) -> Array:
        """(3,) the contact's x axis, world axes."""
        return self.rotation[:, 0]

    @classmethod
    def from_arrays(
        cls, position: Array, rotation: Array, friction: FrictionLaw, planar: bool = False, name: str | None = None
    ) -> Contact:
        """A contact of arrays that are known to be sound, read-only: position (3,), rotation (3, 3)."""
        made = object.__new__(cls)
        made._set_arrays(position, rotation, friction, planar, name)
        return made

    def with_friction(self, friction: FrictionLaw) -> Contact:
        """The same contact under another law, its axes kept."""
        return self.from_arrays(self.position, self.rotation, friction, self.planar, self.name)

    def with_pose(self, position: Array, rotation: Array) -> Contact:
        """The same contact with these axes elsewhere: (3,), (3, 3), known to be sound."""
        return self.from_arrays(position, rotation, self.friction, self.planar, self.name)

    def with_name(self, name: str) -> Contact:
        """The same contact under another name."""
        if name == self.name:
            return self
        return self.from_arrays(self.position, self.rotation, self.friction, self.planar, name)

    def __repr__(self) -> str:
        name = f"{self.name!r}, " if self.name else ""
        where = f"position={self.position.tolist()}, normal={self.normal.tolist()}"
        return f"Contact({name}{where}, friction={self.friction!r})"


# (6, 3) both ways along x, y and z
AXIS_DIRECTIONS = read_only(np.repeat(np.eye(3), 2, axis=0) * np.tile([[1.0], [-1.0]], (3, 1)) + 0.0)
_IN_PLANE_TOLERANCE = 1e-9


def axis_directions(plane: Array | None) -> Array:
    """(k, 3) both ways along the world's axes; in a planar scene the four in its plane, along axes of the plane where
    those of the world do not lie in it. plane (3,) : its unit normal; None: a spatial scene.
    """
    if plane is None:
        return AXIS_DIRECTIONS
    flat = AXIS_DIRECTIONS[abs(AXIS_DIRECTIONS @ plane) < _IN_PLANE_TOLERANCE]
    if len(flat) == 4:
        return flat
    x, y = contact_frame(plane).T[:2]
    return np.array([x, -x, y, -y])


def contact_frame(normal: Array, tangent: Array | None = None) -> Array:
    """(3, 3) rotation with columns x, y, z for a unit `normal` = z; x is `tangent` projected on the tangent plane."""
    if tangent is None:
        tangent = np.eye(3)[int(np.argmin(np.round(abs(normal), 9)))]
    x = tangent - normal * (normal @ tangent)
    length = float(np.sqrt(x @ x))
    if length <= 1e-6 * float(np.sqrt(tangent @ tangent)):
        got = f"{tangent.tolist()} for normal {normal.tolist()}"
        raise InputError("tangent", "a direction that is not along the normal", got)
    x /= length
    # y = z × x, written out: numpy's cross product costs more than all the rest
    (a, b, c), (d, e, f) = normal, x
    return read_only(np.array([[d, b * f - c * e, a], [e, c * d - a * f, b], [f, a * e - b * d, c]]))


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


def shift_twist(twist: Array, arm: Array) -> Array:
    """(6,) the same small motion seen at a point `arm` (3,) away: u' = u + ω × arm."""
    u, v, w, p, q, r = twist.tolist()
    x, y, z = arm.tolist()
    return np.array([u + q * z - r * y, v + r * x - p * z, w + p * y - q * x, p, q, r])


# ----------------------------------------------------------------
# Where the contacts of a grasp are, and what moves them.


MANY_CONTACTS = 10  # contacts from which on a solve by elimination is the faster one


@dataclass(frozen=True, eq=False)
class Placement:
    """Where contacts are, and what moves them.

    contacts (n,): of the fingers, then of the environment. positions (n, 3) [m]. frames (n, 3, 3): contact axes in
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
        """How many contacts there are."""
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
        return {} if self.mechanism is None else self.mechanism.report.links

    @property
    def planar(self) -> bool:
        """Whether the scene lies in a plane."""
        return self.plane is not None


# ----------------------------------------------------------------
# Which unknowns a grasp has, and where they stand among its force components.


@dataclass(frozen=True)
class SceneKind:
    """What decides which unknowns a scene has, whatever its numbers.

    force_unknown : (n,) contacts whose force is not prescribed.
    tangent_count : (n,) how many tangential forces a contact has, 0 without friction, 1 in a plane, 2, or 3 with the
        moment of a soft finger; 0 where its force is prescribed.
    planar, flexible : whether the scene lies in a plane, and whether any finger gives way.

    The index arrays below count the c = 3n + k force components: the contacts' x, y, z, then the moments of the k soft
    contacts.
    """

    force_unknown: tuple[bool, ...]
    tangent_count: tuple[int, ...]
    planar: bool
    flexible: bool

    @lazy_property
    def n(self) -> int:
        """How many contacts there are."""
        return len(self.force_unknown)

    @property
    def dof(self) -> int:
        """Unknown components of the object's motion: 6, or 3 in a plane."""
        return 3 if self.planar else 6

    @property
    def has_many_contacts(self) -> bool:
        """Whether a solve that eliminates contact by contact (`contact/block_newton.py`) is the faster one."""
        return self.n >= MANY_CONTACTS and not (self.planar or self.soft) and all(self.force_unknown)

    @lazy_property
    def soft(self) -> tuple[int, ...]:
        """(k,) contacts that bear a moment about their normal."""
        return tuple(i for i, t in enumerate(self.tangent_count) if t == 3)

    @lazy_property
    def rough(self) -> tuple[int, ...]:
        """Contacts with friction but no moment."""
        return tuple(i for i, t in enumerate(self.tangent_count) if t in (1, 2))

    @lazy_property
    def components(self) -> int:
        """c, the force components."""
        return 3 * self.n + len(self.soft)

    @lazy_property
    def contact_components(self) -> Ints:
        """(n, 4) of each contact whose force is unknown: its normal component and its tangential ones, padded by -1."""
        out = np.full((self.n, 4), -1, dtype=np.int64)
        for i, (free, t) in enumerate(zip(self.force_unknown, self.tangent_count, strict=True)):
            if free:
                moment = [3 * self.n + self.soft.index(i)] if t == 3 else []
                own = [3 * i + 2, 3 * i, 3 * i + 1][: 1 + min(t, 2)] + moment
                out[i, : len(own)] = own
        return out

    @lazy_property
    def normal_index(self) -> Ints:
        """The force components (m,) that are unknown normal forces."""
        return np.asarray(self.contact_components[np.array(self.force_unknown), 0])

    @lazy_property
    def tangent_index(self) -> Ints:
        """Unknown tangential components, of `rough` contacts first, then of `soft` ones."""
        own = self.contact_components[[*self.rough, *self.soft], 1:]
        return own[own >= 0]

    @lazy_property
    def index(self) -> Ints:
        """All unknown components, normal ones first."""
        return np.concatenate([self.normal_index, self.tangent_index])


# A hand in many postures, or a sweep, meets the same few kinds again and again, and each makes its index arrays once
cached_kind = lru_cache(maxsize=1024)(SceneKind)
