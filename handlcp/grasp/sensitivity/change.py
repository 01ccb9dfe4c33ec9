"""What parameters change in the laws of a grasp while forces and motion stay, and what an answer does about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.rows import active_rows
from handlcp.grasp.verify.contact_states import States

# ----------------------------------------------------------------
# Where an answer stands: its contacts' states and motions, and the equations that its changes obey.

CONSISTENT = 1e-8  # of a right-hand side: what is missed by less is met


@dataclass(frozen=True, eq=False)
class Stand:
    """G (6, c) : grasp matrix about the reference, v (c,) : motions, both in the coordinates of the friction laws.
    states : of the contacts. edge (n,) : 1 where a contact's next state depends on the change.
    """

    answer: Answer
    G: Array
    v: Array
    states: States
    edge: Ints

    def equations(self, states: States, limits: Array) -> tuple[Array, Array]:
        """(A, B) of `rows.active_rows` with these states; limits (m, c) : rows of those that give way."""
        answer, s = self.answer, self.answer.scene
        return active_rows(
            self.G, answer.tangent, s.given.freedom, s.kind.contact_components, states, answer.friction.limits, limits,
            answer.sizes,
        )  # fmt: skip

    def right_hand_sides(self, change: Change) -> Array:
        """(c + dof + n + m, p) in natural units, as `active_rows` orders them; m limits are reached."""
        answer = self.answer
        force, motion = answer.sizes[0], answer.sizes[1]
        push = answer.lawful[2 : 3 * answer.scene.n : 3]
        parts = [
            change.motion / motion,
            answer.scene.given.freedom @ change.balance / answer.balance_sizes[:, None],
            change.friction * (push / force)[:, None],
        ]
        reached = answer.yielding
        if len(reached.at):  # δb_s - δA r: limits of forces depend on no parameter
            room = abs(reached.joints) @ change.torque_limits - reached.joints @ change.torque
            parts.append(room / reached.sizes[:, None])
        return np.concatenate(parts)

    def motion(self, x: Array) -> Array:
        """(6, p) of the object about the reference, SI, from x (c + dof + m, p) in natural units."""
        s = self.answer.scene
        return np.asarray(s.given.freedom.T @ (x[s.components : s.components + s.dof] * s.twist_units[:, None]))

    def moved(self, x: Array, limits: Array) -> Array:
        """(c, p) of V x, SI, in the laws' coordinates; limits (m, c) : rows of those that give way in x."""
        answer, s = self.answer, self.answer.scene
        moved = self.G.T @ self.motion(x) + answer.tangent @ (x[: s.components] * answer.sizes[0])
        if len(limits):
            moved = moved + limits.T @ (x[s.components + s.dof :] * answer.sizes[1])
        return np.asarray(moved)


def solved(A: Array, b: Array, rank: float) -> tuple[Array, Array]:
    """(x, N): the smallest x (k, p) with A x = b, NaN in columns without one, and what spans A's null space (k, j)."""
    U, s, Vt = np.linalg.svd(A)
    count = int((s > rank * s[0]).sum())
    x = Vt[:count].T @ ((U[:, :count].T @ b) / s[:count, None])
    size = np.maximum(abs(b).max(axis=0, initial=0.0), 1e-300)
    x[:, abs(U[:, count:].T @ b).max(axis=0, initial=0.0) > CONSISTENT * size] = np.nan
    return x, Vt[count:].T


# ----------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Change:
    """By p parameters, SI, each (…, p). Contacts' motions in the coordinates of the friction laws.

    motion (c, p) : δv, of the object relative to the tips [m]. balance (6, p) : δb, of the wrench that is left over,
    about the reference. friction (n, p) : δμ of the coefficients of the sections (`Scene.limits`) [-].
    torque (nv, p) : of what the joints hold [N·m].
    torque_limits (nv, p) : of the joints' limits [N·m]. deeper : what comes on top where fingertips go deeper into an
    object that they just touch; None: nothing does.
    """

    motion: Array
    balance: Array
    friction: Array
    torque: Array
    torque_limits: Array
    deeper: Deeper | None = None

    def toward(self, direction: Array) -> Change:
        """(…, 1) along a direction (p,)."""
        straight = _of([(part @ direction)[:, None] for part in self._parts])
        if self.deeper is None:
            return straight
        return replace(straight, deeper=self.deeper.by(self.deeper.rates @ direction[:, None])).ahead

    @property
    def ahead(self) -> Change:
        """Of parameters that grow, one at a time."""
        if self.deeper is None:
            return self
        depth = np.maximum(self.deeper.rates, 0.0)
        pairs = zip(self._parts, self.deeper.change._parts, strict=True)
        return _of([part + more @ depth for part, more in pairs])

    def some(self, which: Bools) -> Change:
        """Of these (p,) of the parameters."""
        return _of([part[:, which] for part in self._parts])

    def bent_at(self, touches: Bools) -> Change:
        """Where only these (t,) of the fingertips in `deeper` just touch: the others are inside already, and what takes
        them deeper counts on both sides.
        """
        if self.deeper is None:
            return self
        rates, more = self.deeper.rates, self.deeper.change._parts
        already = np.where(touches[:, None], 0.0, rates)
        straight = [part + of @ already for part, of in zip(self._parts, more, strict=True)]
        left = Deeper(self.deeper.contacts[touches], rates[touches], self.deeper.change.some(touches))
        return replace(_of(straight), deeper=left if touches.any() else None)

    @property
    def _parts(self) -> tuple[Array, ...]:
        return self.motion, self.balance, self.friction, self.torque, self.torque_limits


def _of(parts: Sequence[Array]) -> Change:
    motion, balance, friction, torque, torque_limits = parts
    return Change(motion, balance, friction, torque, torque_limits)


@dataclass(frozen=True, eq=False)
class Deeper:
    """Fingertips that just touch the object they were detected on. One that goes deeper counts as squeezed, and its
    joints take it sideways; one that leaves a gap does not.

    contacts (t,) : their numbers. rates (t, p) : how fast p parameters take them deeper [m]. change : by depth
    (…, t) [1/m].
    """

    contacts: Ints
    rates: Array
    change: Change

    def by(self, rates: Array) -> Deeper:
        """With other parameters."""
        return replace(self, rates=rates)


def no_change(answer: Answer, p: int) -> Change:
    """Of p parameters that change nothing: a place to write to."""
    scene, nv = answer.scene, answer.rows.shape[1]
    sizes = (scene.components, 6, scene.n, nv, nv)
    return _of([np.zeros((size, p)) for size in sizes])


def in_plane(answer: Answer, change: Change) -> Change:
    """In a planar scene nothing moves across the plane."""
    if answer.spec.planar:
        change.motion[1 : 3 * answer.scene.n : 3] = 0.0
    return change


class Rates(NamedTuple):
    """What p parameters do to an answer, SI, each (…, p). forces (c, p) in contact axes, moments of soft contacts last;
    motion (6, p) of the object about the reference; slip (c, p) of v, contact axes. NaN where it is not determined.
    """

    forces: Array
    motion: Array
    slip: Array
