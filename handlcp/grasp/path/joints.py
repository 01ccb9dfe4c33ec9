"""Joints in a step of a path that do more than give way: dry friction holds them, and tendons go slack.

A joint's springs, driven to q_c, pull with K (q_c - q). What is left of that for the contacts, τ, is less by friction
f, which opposes the motion of the step as friction at a contact does,

    |f| ≤ τ_f,    f = τ_f sign(q - q⁻) where the joint moves,

and less by what tendons would push with. Once the hand is closed, its tendons are drawn in by what they are, and pull
with t as far as that is no push:

    0 ≤ t ⟂ s ≥ 0,    t = a + k s,    a = d - k R q,    τ = K (q_c - q) + Rᵀ (t - a) - f.

s is how far a slack tendon hangs through, d what is drawn in [N]. While the hand is driven, its drives keep all tendons
taut: they pull with the least tensions that make its torques.

With what each joint and each tendon does known, a step is one of joints with springs alone: one that stands still is
rigid, one that moves is commanded by K⁻¹ f less, and a slack tendon is a spring less. Which it is, is found by trying:
all that do otherwise than was assumed are assumed anew; where that goes round in circles, the first of them alone,
which ends (Murty, Linear Algebra and its Applications 7, 1974). The memory of a path is where the joints stand and how
far the tendons are drawn in, and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.grasp.model.cables import Cables

_SAME = 1e-9  # of the friction, of the motion that its torque makes, or of the largest tension: less is none
_AT_ONCE = 6  # trials that change all that does otherwise
_MOST = 60  # trials
_LIMP = 1e-5  # of its stiffness: what a joint keeps that no taut tendon and no spring holds


class Sprung(NamedTuple):
    """Joints of which some stand still, and some tendons are slack. K (nv, nv) : their stiffness. root (nv, m) : C =
    root rootᵀ of those that move, free (nv, nv) : C itself. drawn (nv, nv) : how far the springs of those that stand
    still, drawn by (nv,), draw the others. lost (nv, t) : Rᵀ (t - a), from a.
    """

    K: Array
    root: Array
    free: Array
    drawn: Array
    lost: Array


class Task(NamedTuple):
    """Of a step, (nv,) each: where joints are commanded to, and stood before it. drawn (t,) : d of tendons [N]; None
    while the hand is driven.
    """

    commanded: Array
    begun: Array
    drawn: Array | None


class Pull(NamedTuple):
    """What tendons do in a state. drawn (t,) : d [N]. tension (t,) : with which they pull [N], how much harder than at
    first where it is not known how hard that was. taut (t,) : the same as springs that could push, a.
    """

    drawn: Array
    tension: Array
    taut: Array

    @property
    def slack(self) -> Bools:
        """(t,) which of them hang through."""
        return np.asarray(self.tension > self.taut)

    def not_stored(self, cables: Cables | None, deflection: Array) -> float:
        """Energy that springs at joints and tendons have less for tendons that hang slack [J]. deflection (nv,) : of
        the joints from where they are commanded.
        """
        if cables is None or not self.slack.any():
            return 0.0
        k, more = cables.springs, self.tension - self.taut
        pushed = self.taut @ np.linalg.solve(k, self.taut) - self.tension @ np.linalg.solve(k, self.tension)
        return 0.5 * float(pushed + (cables.arms.T @ more) @ deflection)


NO_PULL = Pull(*[read_only(np.zeros(0))] * 3)


class Joints:
    """Of joints with compliance C = root rootᵀ, root (nv, m), friction (nv,) [N·m], and tendons; None: without. posture
    (nv,) : from which the rest of their springs is counted.

    What they do is a vector (nv + t,): of joints ±1, the way they move against friction, or 0; of tendons 1 where they
    are slack, or 0.
    """

    def __init__(self, root: Array, friction: Array, cables: Cables | None, posture: Array) -> None:
        C = root @ root.T
        self.gives = C.diagonal() > 0.0
        self.friction = np.where(self.gives, friction, 0.0)  # rigid joints stand still anyhow
        self.rubs = self.friction > 0.0
        self.least = _SAME * self.friction * C.diagonal()  # [rad]
        self.K = np.zeros_like(C)
        on = np.ix_(self.gives, self.gives)
        self.K[on] = np.linalg.solve(C[on], np.eye(int(self.gives.sum())))
        self.C, self._root, self.nv = C, root, len(friction)
        self.cables = Cables.none(self.nv) if cables is None else cables
        self._pulls = self.cables.springs @ self.cables.arms  # k R
        self._rest = posture + self.cables.rest
        self.slackens = np.isfinite(self.cables.pretension)
        self._known = dict[bytes, Sprung]()

    @property
    def still(self) -> Ints:
        """(nv + t,) all joints stand still, and all tendons are taut."""
        return np.zeros(self.nv + len(self.slackens), dtype=np.int64)

    def solved(
        self, does: Ints, task: Task, at: Array, solve: Callable[[Array, Array], tuple[Any, Array, Array] | None]
    ) -> tuple[Any, Ints] | None:
        """The answer in which joints and tendons do what was assumed of them, at first `does` (nv + t,), and what they
        do. at (nv,) : where joints stand at the iterate. solve : from the root of the joints' compliance and how far
        they are driven (nv,) to an answer, where joints come to (nv,), and the torques that contacts take (nv,).
        None where an assumption has no answer, or none is right.
        """
        for count in range(_MOST):
            found = solve(self.sprung(does).root, self.command(does, task, at))
            if found is None:
                return None
            answer, q, torque = found
            so = self.does(does, task, q, torque)
            if (so == does).all():
                return answer, does
            does = so if count < _AT_ONCE else np.where(np.arange(len(so)) == np.argmax(so != does), so, does)
        return None

    def ends(self, does: Ints, task: Task) -> tuple[Array, Ints]:
        """Where joints come to that meet nothing, and what they do."""
        none = np.zeros(self.nv)

        def solve(_: Array, command: Array) -> tuple[Array, Array, Array]:
            q = task.begun + command
            return q, q, none

        found = self.solved(does, task, task.begun, solve)
        return (task.commanded, self.still) if found is None else found

    def sprung(self, does: Ints) -> Sprung:
        """Where joints and tendons do this."""
        still, slack = self.rubs & (does[: self.nv] == 0), does[self.nv :] == 1
        key = still.tobytes() + slack.tobytes()
        if (found := self._known.get(key)) is None:
            found = self._known[key] = self._sprung(still, slack)
        return found

    def _sprung(self, still: Bools, slack: Bools) -> Sprung:
        nv, K, lost = self.nv, self.K, np.zeros((self.nv, len(slack)))
        if not still.any() and not slack.any():
            return Sprung(K, self._root, self.C, np.zeros((nv, nv)), lost)
        on, free, drawn = self.gives & ~still, np.zeros((nv, nv)), np.zeros((nv, nv))
        if slack.any():
            k, R = self.cables.springs, self.cables.arms
            # t = 0 of the slack ones, s = -k⁻¹ a of these alone; the others lose what springs between tendons take
            lost[:, slack] = -R[slack].T - R[~slack].T @ np.linalg.solve(k[np.ix_(slack, slack)], k[slack][:, ~slack]).T
            K = _held(K + lost @ self._pulls, self.K, on)
        root = np.zeros((nv, nv))
        if on.any():
            L = np.linalg.cholesky(K[np.ix_(on, on)])
            half = np.linalg.solve(L, np.eye(int(on.sum()))).T  # K⁻¹ = half halfᵀ
            root[np.ix_(on, on)] = half
            free[np.ix_(on, on)] = half @ half.T
            drawn[on] = free[on] @ np.where(still, K, 0.0)
        return Sprung(K, np.ascontiguousarray(root), free, drawn, lost)

    def command(self, does: Ints, task: Task, at: Array) -> Array:
        """(nv,) from where joints stand at an iterate, at (nv,), to where they are driven as if there were springs
        alone.
        """
        sprung, moves = self.sprung(does), does[: self.nv]
        kept = self.friction * moves - self._not_pulled(sprung, task)
        driven = task.commanded - at + sprung.drawn @ (task.commanded - task.begun) - sprung.free @ kept
        return np.where(self.rubs & (moves == 0), task.begun - at, driven)

    def _not_pulled(self, sprung: Sprung, task: Task) -> Array:
        """(nv,) Rᵀ (t - a) where the joints stand as commanded."""
        return sprung.lost @ self._taut(task, task.commanded)

    def _taut(self, task: Task, q: Array) -> Array:
        """(t,) a of joints at q (nv,); 0 while the hand is driven."""
        return np.zeros(len(self.slackens)) if task.drawn is None else task.drawn - self._pulls @ q

    def pulls(self, does: Ints, task: Task, q: Array) -> Array:
        """(nv,) with which springs pull at the joints [N·m], tendons as springs and friction included."""
        sprung = self.sprung(does)
        return sprung.K @ (task.commanded - q) + self._not_pulled(sprung, task)

    def rubbing(self, does: Ints, task: Task, q: Array, torque: Array) -> Array:
        """(nv,) f [N·m] where joints have come to q (nv,), with torques (nv,) left for the contacts."""
        moves = does[: self.nv]
        held = np.where(self.rubs, self.pulls(does, task, q) - torque, 0.0)
        return np.where(moves != 0, self.friction * moves, held)

    def does(self, does: Ints, task: Task, q: Array, torque: Array) -> Ints:
        """(nv + t,) what joints and tendons do where they were assumed to do something, and that has come of it;
        arguments as of `rubbing`.
        """
        moves, slack = does[: self.nv], does[self.nv :] == 1
        f, moved = self.rubbing(does, task, q, torque), q - task.begun
        beyond = (moves == 0) & (abs(f) > self.friction * (1.0 + _SAME))
        back = moved * moves < -self.least
        so = np.where(self.rubs, np.where(beyond, np.sign(f), np.where(back, 0, moves)), 0)
        if task.drawn is None:
            return np.append(so, np.zeros(len(slack))).astype(np.int64)
        a = self._taut(task, q)
        t, hangs = self._tensions(a, slack), np.zeros(len(slack))
        if slack.any():
            k = self.cables.springs[np.ix_(slack, slack)]
            hangs[slack] = k.diagonal() * np.linalg.solve(k, -a[slack])  # k s
        least = _SAME * max(float(abs(a).max(initial=0.0)), float(abs(task.drawn).max(initial=0.0)))
        slackens = self.slackens & np.where(slack, hangs >= -least, t < -least)
        return np.append(so, slackens).astype(np.int64)

    def _tensions(self, a: Array, slack: Bools) -> Array:
        """(t,) t of tendons of which some are slack."""
        if not slack.any():
            return a
        k = self.cables.springs
        left = a[~slack] - k[~slack][:, slack] @ np.linalg.solve(k[np.ix_(slack, slack)], a[slack])
        t = np.zeros(len(a))
        t[~slack] = left
        return t

    def moving(self, rubs: Array, pull: Pull) -> Ints:
        """(nv + t,) what joints and tendons did on which friction f (nv,) acts, and which pulled so."""
        moves = np.where(self.rubs & (abs(rubs) >= self.friction * (1.0 - _SAME)), np.sign(rubs), 0)
        return np.append(moves, pull.slack).astype(np.int64)

    def pull(self, does: Ints, task: Task, q: Array) -> Pull:
        """What tendons do where joints have come to q (nv,)."""
        if not len(self.slackens):
            return NO_PULL
        if task.drawn is not None:
            a = self._taut(task, q)
            return Pull(task.drawn, read_only(self._tensions(a, does[self.nv :] == 1)), read_only(a))
        # Rᵀ (t - T₀) is what springs pull with in all, and turns the joints against their own springs
        torque = self.pulls(does, task, q) + self.cables.passive @ (q - self._rest)
        tension = read_only(self.cables.tensions(torque))
        return Pull(read_only(tension + self._pulls @ q), tension, tension)


def _held(K: Array, before: Array, on: Bools) -> Array:
    """K (nv, nv) that leaves no joint without a spring; before (nv, nv) : with all tendons taut. on (nv,) : which."""
    size = np.sqrt(before.diagonal())
    size[size == 0.0] = 1.0
    scaled = (K / np.outer(size, size))[np.ix_(on, on)]
    limp = on.any() and np.linalg.eigvalsh(scaled)[0] < _LIMP
    return K + _LIMP * np.diag(before.diagonal()) if limp else K
