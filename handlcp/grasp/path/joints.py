"""Joints in a step of a path that do more than give way: dry friction holds them, and tendons rub and go slack.

A joint's springs, driven to q_c, pull with K (q_c - q). What is left of that for the contacts, τ, is less by friction
f, which opposes the motion of the step as friction at a contact does. At a joint it is at most τ_f. Where a tendon
wraps around a post, it takes f of the tension T with which the tendon comes from its drive (capstan):

    T (1 - exp(μθ)) ≤ f ≤ T (1 - exp(-μθ)),    τ -= Dᵀ f,

with D q how much of the tendon is drawn in from beyond. f is at the upper end where that is drawn towards the drive,
and at the lower end where it is drawn away. The next post of the tendon has what is left of T.

Once the hand is closed, its tendons are drawn in by what they are, and pull with t as far as that is no push:

    0 ≤ t ⟂ s ≥ 0,    t = a + k s,    a = d - k R q,    τ = K (q_c - q) + Rᵀ (t - a) - Dᵀ f.

s is how far a slack tendon hangs through, d what is drawn in [N]. While the hand is driven, its drives keep all tendons
taut: they pull with the least tensions that make its torques.

With what each joint, each post and each tendon does known, a step is one of joints with springs alone: what stands
still is rigid, what moves is commanded by K⁻¹ Dᵀ f less, and a slack tendon is a spring less. Which it is, is found by
trying: all that do otherwise than was assumed are assumed anew; where that goes round in circles, the first of them
alone, which ends (Murty, Linear Algebra and its Applications 7, 1974). The memory of a path is where the joints stand
and how far the tendons are drawn in, and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.grasp.model.mechanism import Cables
from handlcp.grasp.path.newton.numbers import NO_TENSION
from handlcp.grasp.path.pull import NO_PULL, Pull, Task
from handlcp.grasp.path.sprung import DEPENDS, Mixed, Sprung, sprung_of

_SAME = 1e-9  # of the friction, of the motion that it makes, or of the largest tension: less is none
_SETTLED = 1e-10  # of the largest tension: friction at posts that changes by no more
_AT_ONCE = 6  # trials that change all that does otherwise
_MOST = 80  # trials


# From the root of the joints' compliance, how far they are driven (nv,), and what tendons pull more as arms change
# (nv, nv), to an answer, where joints come to (nv,), and the torques that contacts take (nv,); None: no answer
Solve = Callable[[Array, Array, Array], tuple[Any, Array, Array] | None]


class Joints:
    """Of joints with compliance C = root rootᵀ, root (nv, m), friction (nv,) [N·m], and tendons; None: without. posture
    (nv,) : from which the rest of their springs is counted.

    What they do is a vector (nv + m + t,): of joints and posts ±1, the way they move against friction, or 0; of tendons
    1 where they are slack, or 0.
    """

    def __init__(self, root: Array, friction: Array, cables: Cables | None, posture: Array) -> None:
        C = root @ root.T
        cables = Cables.without_tendons(len(friction)) if cables is None else cables
        self.gives = C.diagonal() > 0.0
        on, K = np.ix_(self.gives, self.gives), np.zeros_like(C)
        K[on] = np.linalg.solve(C[on], np.eye(int(self.gives.sum())))
        self.nv, self.posts = len(friction), len(cables.arms_beyond)
        self.friction = np.where(self.gives, friction, 0.0)  # rigid joints stand still anyhow
        self._rest = posture + cables.rest
        self.slackens, self._alone = np.isfinite(cables.pretension), np.eye(self.nv)
        self._lie(K, root, C, cables)
        self._whole, self._near = self, (b"", self)
        self._lately = b"", root
        at_rest = cables if cables.elasticity_at is None else cables.elasticity_at(self._rest)[0]
        self._preload = at_rest.arms.T @ cables.initial_tension  # which springs at the joints take up at rest

    def _lie(self, K: Array, root: Array, C: Array, cables: Cables) -> None:
        """What depends on how tendons lie."""
        self.K, self._root, self.C, self.cables = K, root, C, cables
        # Rows along which friction acts, where there is any, and by how much they give way to a unit of it
        self.rows, self.rubs, self._gives_by = self._alone, self.friction > 0.0, C.diagonal()
        if self.posts:
            self.rows = np.concatenate([self._alone, cables.arms_beyond])
            self.rubs = np.append(self.rubs, (cables.wrap_friction > 0.0) & cables.arms_beyond.any(axis=1))
            self._gives_by = ((self.rows @ C) * self.rows).sum(axis=1)
        self._pulls = cables.springs @ cables.arms  # k R
        self._known = dict[bytes, Sprung]()
        self._asked: tuple[Task | None, Array] = None, root  # where springs drive to in a task

    def at(self, q: Array) -> Joints:
        """With the arms of tendons where joints are at q (nv,)."""
        if self.cables.elasticity_at is None:
            return self
        if self._near[0] != q.tobytes():
            (cables, root), made = self.cables.elasticity_at(q), object.__new__(Joints)
            made.__dict__.update(self.__dict__)
            made._lie(cables.passive + cables.arms.T @ cables.springs @ cables.arms, root, root @ root.T, cables)
            self._near = q.tobytes(), made
        return self._near[1]

    @property
    def _routed(self) -> bool:
        """Whether arms are those of a posture."""
        return self._whole is not self

    def _drawn_to(self, commanded: Array) -> Array:
        """(t,) d of tendons that hold joints free of contacts where they are commanded to be (nv,)."""
        assert self.cables.elasticity_at is not None
        if self._lately[0] == commanded.tobytes():
            return self._lately[1]
        there, _ = self.cables.elasticity_at(commanded)
        torque = self.cables.passive @ (commanded - self._rest) + self._preload - there.arms.T @ there.initial_tension
        drawn = np.asarray(there.tensions(torque) + there.springs @ (there.shift + there.arms @ commanded))
        self._lately = commanded.tobytes(), drawn
        return drawn

    def _drawn_in(self, task: Task) -> Array:
        """(t,) d in a step, of tendons along routes."""
        return self._whole._drawn_to(task.commanded) if task.drawn is None else task.drawn

    def _tensed(self, does: Ints, task: Task, at: Array) -> Array:
        """(nv, nv) H = Σ T ∂R/∂q of the tensions with joints at (nv,); empty where arms stay."""
        if self.cables.moment_arm_stiffness is None:
            return NO_TENSION
        a = self._drawn_in(task) - self._drawn(at)
        return self.cables.moment_arm_stiffness(self._tensions(a, does[len(self.rubs) :] == 1))

    def _to(self, task: Task) -> Array:
        """(nv,) where springs that are as stiff as here would drive joints to: where they are commanded to; where arms
        change, K q_c = Rᵀ (d - k (l - R q)) + K_p q₀ - R₀ᵀ T₀.
        """
        if not self._routed:
            return task.commanded
        if self._asked[0] is task:
            return self._asked[1]
        drawn, c = self._drawn_in(task), self.cables
        torque = c.arms.T @ (drawn - c.springs @ c.shift) + c.passive @ self._rest - self._preload
        self._asked = task, np.where(self.gives, self.C @ torque, task.commanded)
        return self._asked[1]

    @property
    def still(self) -> Pull:
        """Nothing moves, and all tendons are taut."""
        return NO_PULL._replace(
            does=np.zeros(len(self.rubs) + len(self.slackens), dtype=np.int64), posts=np.zeros(self.posts)
        )

    def solved(self, begun: Pull, task: Task, at: Array, solve: Solve) -> tuple[Any, Pull] | None:
        """The answer in which joints, posts and tendons do what was assumed of them, at first what they did in `begun`,
        and what they do. at (nv,) : where joints stand at the iterate. None where an assumption has no answer, or none
        is right.
        """
        does, posts, mixed = begun.does, begun.posts, Mixed()
        for count in range(_MOST):
            tensed = self._tensed(does, task, at)
            found = solve(self.sprung(does).root, self.command(does, posts, task, at), tensed)
            if found is None:
                return None
            answer, q, torque = found
            pull = self.pull(does, posts, task, q)
            f = self.rubbing(pull, task, q, torque - tensed @ (q - at) if len(tensed) else torque)
            so, settled = self._does(pull, f, task, q)
            apart = settled - posts
            if (so == does).all():
                if abs(apart).max(initial=0.0) <= _SETTLED * float(abs(pull.tension).max(initial=0.0)):
                    return answer, pull._replace(posts=read_only(f[self.nv :]))
                posts = mixed.next(posts, apart)
                continue
            first = np.arange(len(so)) == np.argmax(so != does)
            does, posts, mixed = so if count < _AT_ONCE else np.where(first, so, does), settled, Mixed()
        return None

    def ends(self, begun: Pull, task: Task) -> tuple[Array, Pull]:
        """Where joints come to that meet nothing, and what they do."""
        none, q = np.zeros(self.nv), task.begun

        def solve(root: Array, command: Array, tensed: Array) -> tuple[Array, Array, Array]:
            if len(tensed):
                command = np.asarray(np.linalg.solve(np.eye(self.nv) - root @ root.T @ tensed, command))
            return q + command, q + command, none

        for _ in range(_MOST):
            last, here = q, self.at(q)
            found = here.solved(begun, task, q, solve)
            if found is None:
                break
            q, pull = found
            if not here._routed or abs(q - last).max() <= _SAME:
                return q, pull
        still = self.still
        return task.commanded, self.at(task.commanded).pull(still.does, still.posts, task, task.commanded)

    def sprung(self, does: Ints) -> Sprung:
        """Where joints, posts and tendons do this."""
        still, slack = self._still(does), does[len(self.rubs) :] == 1
        key = still.tobytes() + slack.tobytes()
        if (found := self._known.get(key)) is None:
            found = self._known[key] = self._sprung_of(still, slack)
        return found

    def _still(self, does: Ints) -> Bools:
        """(nv + m,) what friction holds."""
        return np.asarray(self.rubs & (does[: len(self.rubs)] == 0))

    def _sprung_of(self, still: Bools, slack: Bools) -> Sprung:
        if still.any() or slack.any():
            return sprung_of(self.K, self.gives, self.rows[still], self.cables, slack)
        return Sprung(self.K, self._root, self.C, np.zeros((self.nv, len(slack))))

    def command(self, does: Ints, posts: Array, task: Task, at: Array) -> Array:
        """(nv,) from where joints stand at an iterate, at (nv,), to where they are driven as if there were springs
        alone. posts (m,) : f of those that move.
        """
        left = self.pulls(does, task, task.begun) - self.rows.T @ self._known_friction(does, posts)
        driven = task.begun + self.sprung(does).free @ left
        return np.where(self.gives, driven, task.commanded) - at

    def _known_friction(self, does: Ints, posts: Array) -> Array:
        """(nv + m,) f of what moves; 0 of what stands still."""
        moves = does[: len(self.rubs)]
        return np.append(self.friction * moves[: self.nv], np.where(moves[self.nv :] != 0, posts, 0.0))

    def _taut(self, task: Task, q: Array) -> Array:
        """(t,) a of joints at q (nv,); 0 while the hand is driven."""
        return np.zeros(len(self.slackens)) if task.drawn is None else task.drawn - self._drawn(q)

    def _drawn(self, q: Array) -> Array:
        """(t,) k l of joints at q (nv,) [N]."""
        return self.cables.springs @ self.cables.shift + self._pulls @ q

    def pulls(self, does: Ints, task: Task, q: Array) -> Array:
        """(nv,) with which springs pull at the joints [N·m], tendons as springs and friction included."""
        sprung, to = self.sprung(does), self._to(task)
        return sprung.K @ (to - q) + sprung.lost @ self._taut(task, to)

    def rubbing(self, pull: Pull, task: Task, q: Array, torque: Array) -> Array:
        """(nv + m,) f of joints [N·m] and posts [N] where joints have come to q (nv,), with torques (nv,) left for the
        contacts.
        """
        f, still = self._known_friction(pull.does, pull.posts), self._still(pull.does)
        if still.any():
            held = self.pulls(pull.does, task, q) - torque - self.rows.T @ f
            f[still] = np.linalg.lstsq(self.rows[still].T, held, rcond=DEPENDS)[0]
        return f

    def taken(self, f: Array) -> Array:
        """(nv,) what friction f (nv + m,) takes of the torques [N·m]."""
        return read_only(np.asarray(self.rows.T @ f))

    def _does(self, pull: Pull, f: Array, task: Task, q: Array) -> tuple[Ints, Array]:
        """(nv + m + t,) what joints, posts and tendons do where they were assumed to do what `pull` says, and friction
        f (nv + m,) and q (nv,) have come of that; and f (m,) of the posts that it would then be, of those that move.
        """
        rubs, moves, slack = self.rubs, pull.does[: len(self.rubs)], pull.does[len(self.rubs) :] == 1
        low, high = self._between(pull, f)
        moved = (self.rows @ (q - task.begun)) * moves
        size = np.maximum(high, -low)
        pushed = np.where(f > high + _SAME * size, 1, np.where(f < low - _SAME * size, -1, 0))
        so = np.where(moves == 0, pushed, np.where(moved < -_SAME * size * self._gives_by, 0, moves))
        so = np.where(rubs, so, 0).astype(np.int64)
        posts = np.where(so > 0, high, np.where(so < 0, low, 0.0))[self.nv :]
        return np.append(so, self._slackens(pull, slack, task)).astype(np.int64), posts

    def _between(self, pull: Pull, f: Array) -> tuple[Array, Array]:
        """(nv + m,) between what friction is, f (nv + m,) at the posts before each."""
        low, high = np.append(-self.friction, np.zeros(self.posts)), np.append(self.friction, np.zeros(self.posts))
        left = np.maximum(pull.tension, 0.0)
        for p, (tendon, grip) in enumerate(
            zip(self.cables.post_tendon.tolist(), self.cables.wrap_friction.tolist(), strict=True)
        ):
            T, k = float(left[tendon]), self.nv + p
            low[k], high[k] = T * (1.0 - np.exp(grip)), T * (1.0 - np.exp(-grip))
            left[tendon] = T - min(max(f[k], low[k]), high[k])
        return low, high

    def _slackens(self, pull: Pull, slack: Bools, task: Task) -> Bools:
        """(t,) which tendons go slack where some were assumed to."""
        if task.drawn is None:
            return np.zeros(len(slack), dtype=bool)
        a, hangs = pull.taut, np.zeros(len(slack))
        if slack.any():
            k = self.cables.springs[np.ix_(slack, slack)]
            hangs[slack] = k.diagonal() * np.linalg.solve(k, -a[slack])  # k s
        least = _SAME * max(float(abs(a).max(initial=0.0)), float(abs(task.drawn).max(initial=0.0)))
        return np.asarray(self.slackens & np.where(slack, hangs >= -least, pull.tension < -least))

    def _tensions(self, a: Array, slack: Bools) -> Array:
        """(t,) t of tendons of which some are slack."""
        if not slack.any():
            return a
        k, t = self.cables.springs, np.zeros(len(a))
        t[~slack] = a[~slack] - k[~slack][:, slack] @ np.linalg.solve(k[np.ix_(slack, slack)], a[slack])
        return t

    def pull(self, does: Ints, posts: Array, task: Task, q: Array) -> Pull:
        """What tendons do where joints have come to q (nv,)."""
        if not len(self.slackens):
            return NO_PULL._replace(does=does, posts=posts)
        if task.drawn is not None:
            a = self._taut(task, q)
            tension = self._tensions(a, does[len(self.rubs) :] == 1)
            return Pull(does, posts, task.drawn, read_only(tension), read_only(a))
        # Rᵀ (t - T₀) is what springs pull with in all, and turns the joints against their own springs
        torque = self.pulls(does, task, q) + self.cables.passive @ (q - self._rest)
        torque = torque + self._preload - self.cables.arms.T @ self.cables.initial_tension
        tension = read_only(self.cables.tensions(torque))
        return Pull(does, posts, read_only(tension + self._drawn(q)), tension, tension)
