"""Where an answer stands: its contacts' states and motions, and the equations that its changes obey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.sensitivity.answer import Answer
from handlcp.grasp.sensitivity.change import Change
from handlcp.grasp.sensitivity.rows import active_rows
from handlcp.grasp.verify.contact_states import States

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
