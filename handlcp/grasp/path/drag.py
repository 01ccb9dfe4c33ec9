"""Dry friction at the joints in a step of a path: each joint stands still, or moves against its friction.

A joint's spring, driven to q_c, pulls with K (q_c - q). What is left of that for the contacts, τ = K (q_c - q) - f, is
less by friction f, which opposes the motion of the step as friction at a contact does:

    |f| ≤ τ_f,    f = τ_f sign(q - q⁻) where the joint moves.

With what each joint does known, a step is one of joints without friction: one that stands still is rigid, one that
moves is commanded by K⁻¹ f less. Which it is, is found by trying: all that do otherwise than was assumed are assumed
anew; where that goes round in circles, the first of them alone, which ends (Murty, Linear Algebra and its Applications
7, 1974). The memory of a path is where the joints stand, and nothing else.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only

_SAME = 1e-9  # of the friction, or of the motion that its torque makes: less is none
_AT_ONCE = 6  # trials that change all joints that do otherwise
MOST = 60  # trials


class Sprung(NamedTuple):
    """Joints of which some stand still. root (nv, m) : C = root rootᵀ of the others. free (nv, nv) : C itself. drawn
    (nv, nv) : how far the springs of those that stand still, drawn by (nv,), draw the others.
    """

    root: Array
    free: Array
    drawn: Array


class Drag:
    """Of joints with compliance C = root rootᵀ, root (nv, m), and friction (nv,) [N·m]."""

    def __init__(self, root: Array, friction: Array) -> None:
        C = root @ root.T
        self.gives = C.diagonal() > 0.0
        self.friction = np.where(self.gives, friction, 0.0)  # rigid joints stand still anyhow
        self.rubs = self.friction > 0.0
        self.least = _SAME * self.friction * C.diagonal()  # [rad]
        self.K = np.zeros_like(C)
        on = np.ix_(self.gives, self.gives)
        self.K[on] = np.linalg.solve(C[on], np.eye(int(self.gives.sum())))
        self.C, self._root = C, root
        self._known = dict[bytes, Sprung]()

    def sprung(self, moves: Ints) -> Sprung:
        """Where joints move (nv,) ±1, or stand still: 0."""
        still = self.rubs & (moves == 0)
        if (found := self._known.get(still.tobytes())) is None:
            found = self._known[still.tobytes()] = self._sprung(still)
        return found

    def _sprung(self, still: Bools) -> Sprung:
        nv = len(still)
        if not still.any():
            return Sprung(self._root, self.C, np.zeros((nv, nv)))
        on, free, drawn = self.gives & ~still, np.zeros((nv, nv)), np.zeros((nv, nv))
        root = np.zeros((nv, nv))
        if on.any():
            L = np.linalg.cholesky(self.K[np.ix_(on, on)])
            half = np.linalg.solve(L, np.eye(int(on.sum()))).T  # K⁻¹ = half halfᵀ
            root[np.ix_(on, on)] = half
            free[np.ix_(on, on)] = half @ half.T
            drawn[on] = free[on] @ np.where(still, self.K, 0.0)
        return Sprung(np.ascontiguousarray(root), free, drawn)

    def command(self, moves: Ints, commanded: Array, begun: Array, at: Array) -> Array:
        """(nv,) from where joints stand at an iterate to where they are driven as if there were no friction: commanded,
        begun, at (nv,) : where they are commanded to, stood before the step, and stand at the iterate.
        """
        sprung, still = self.sprung(moves), self.rubs & (moves == 0)
        driven = commanded - at + sprung.drawn @ (commanded - begun) - sprung.free @ (self.friction * moves)
        return np.where(still, begun - at, driven)

    def acts(self, moves: Ints, commanded: Array, torque: Array, q: Array) -> Array:
        """(nv,) f [N·m] where the joints have come to q (nv,), with torques (nv,) left for the contacts."""
        left = self.K @ (commanded - q) - torque
        return np.where(moves != 0, self.friction * moves, np.where(self.rubs, left, 0.0))

    def does(self, moves: Ints, f: Array, moved: Array) -> Ints:
        """(nv,) what joints do, ±1 or 0, where they were assumed to do something, and friction f and how far they
        moved in the step (nv,) have come of that.
        """
        beyond = (moves == 0) & (abs(f) > self.friction * (1.0 + _SAME))
        back = moved * moves < -self.least
        return np.where(self.rubs, np.where(beyond, np.sign(f), np.where(back, 0, moves)), 0).astype(np.int64)

    def again(self, count: int, moves: Ints, does: Ints) -> Ints:
        """(nv,) what is assumed next."""
        if count < _AT_ONCE:
            return does
        first = int(np.argmax(does != moves))
        return np.where(np.arange(len(moves)) == first, does, moves)

    def moving(self, f: Array) -> Ints:
        """(nv,) what joints did on which friction f (nv,) acts."""
        return np.where(self.rubs & (abs(f) >= self.friction * (1.0 - _SAME)), np.sign(f), 0).astype(np.int64)

    def ends(self, commanded: Array, begun: Array) -> tuple[Array, Array]:
        """Where joints come to that meet nothing, and f (nv,) there."""
        moves, none = np.zeros(len(begun), dtype=np.int64), np.zeros(len(begun))
        q, f = begun, none
        for count in range(MOST):
            q = begun + self.command(moves, commanded, begun, begun)
            f = self.acts(moves, commanded, none, q)
            does = self.does(moves, f, q - begun)
            if (does == moves).all():
                break
            moves = self.again(count, moves, does)
        return read_only(q), read_only(f)
