"""What an iterate's answer is: where its numbers stand in one row, and where it leads, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.path.newton.numbers import Laws, Situation
from handlcp.grasp.path.newton.row_layout import RowLayout
from handlcp.grasp.path.pull import Pull
from handlcp.lcp.kernels.dense import kernel


class Answer(RowLayout):
    """Where the numbers of an answer stand in their row, after whether it passes, its miss and whether it is measured.
    n contacts, nv joints, c force components, k limits that give way, dof : of the object; joints that do more than
    give way with m posts and t tendons, or none of this.
    """

    def __init__(self, n: int, nv: int, c: int, k: int, dof: int, joints: tuple[int, int] | None) -> None:
        m, t = joints or (0, 0)
        modes, rubs = (0, 0) if joints is None else (nv + m + t, nv)
        shapes: dict[str, tuple[int, ...]] = {
            "forces": (n, 3), "motion": (n, 3), "torsion": (n,), "spin": (n,), "torque": (nv,), "change": (nv,),
            "twist": (6,), "centre": (3,), "gives": (k,), "give": (n, 3), "turn": (n,), "slip_memory": (n, 3),
            "kinds": (n,), "start": (2 * c + 9,), "modes": (modes,), "post_friction": (m,), "rubs": (rubs,),
            "drawn": (t,), "tension": (t,), "taut": (t,), "met": (dof, dof),
        }  # fmt: skip
        super().__init__(shapes, begin=3)


class AnswerArrays(NamedTuple):
    """An answer: views into its row, in the order of `Answer`; all as in `Reached`."""

    forces: Array
    motion: Array
    torsion: Array
    spin: Array
    torque: Array
    change: Array
    twist: Array
    centre: Array
    gives: Array
    give: Array
    turn: Array
    slip_memory: Array
    kinds: Array
    start: Array
    modes: Array
    post_friction: Array
    rubs: Array
    drawn: Array
    tension: Array
    taut: Array
    met: Array


@kernel
def read_answer(row: Array, s: Ints) -> AnswerArrays:
    """The parts of a row; s : where they begin."""
    n, dof = s[3] - s[2], 6
    while dof * dof > s[21] - s[20]:
        dof -= 1
    return AnswerArrays(
        row[s[0] : s[1]].reshape(n, 3),
        row[s[1] : s[2]].reshape(n, 3),
        row[s[2] : s[3]],
        row[s[3] : s[4]],
        row[s[4] : s[5]],
        row[s[5] : s[6]],
        row[s[6] : s[7]],
        row[s[7] : s[8]],
        row[s[8] : s[9]],
        row[s[9] : s[10]].reshape(n, 3),
        row[s[10] : s[11]],
        row[s[11] : s[12]].reshape(n, 3),
        row[s[12] : s[13]],
        row[s[13] : s[14]],
        row[s[14] : s[15]],
        row[s[15] : s[16]],
        row[s[16] : s[17]],
        row[s[17] : s[18]],
        row[s[18] : s[19]],
        row[s[19] : s[20]],
        row[s[20] : s[21]].reshape(dof, dof),
    )


class Reached:
    """Where an iterate's answer leads, SI. forces, motion (n, 3), torsion, spin (n,), torque, change (nv,) of the
    joints from the iterate, twist (6,) about centre (3,), gives (k,) motions of limits. give (n, 3), turn (n,),
    slip_memory (n, 3) : as `_end_of_step` has them. start (2c + 9,) : where the next solve may begin: forces in the
    laws' coordinates, twist, centre, and motions at the contacts in these coordinates. rubs : as in `State`.
    """

    __slots__ = ("_parts", "_row")

    def __init__(self, row: Array, parts: dict[str, tuple[slice, tuple[int, ...]]]) -> None:
        self._row, self._parts = row, parts

    def __getattr__(self, name: str) -> Array:
        at, shape = self._parts[name]
        found: Array = self._row[at]
        return found if len(shape) == 1 else found.reshape(shape)

    @property
    def miss(self) -> float:
        """How far it is from the iterate, as `_end_of_step` has it."""
        return float(self._row[1])

    @property
    def kinds(self) -> Ints:
        """(n,) as `contact_states` numbers them."""
        return self._row[self._parts["kinds"][0]].astype(np.int64)

    @property
    def pull(self) -> Pull:
        """What joints, posts and tendons do."""
        return Pull(self.modes.astype(np.int64), self.post_friction, self.drawn, self.tension, self.taut)

    @property
    def met(self) -> Array:
        """(dof, dof) as in `linear_solve`; empty where it was not measured."""
        at, shape = self._parts["met"]
        return self._row[at].reshape(shape) if self._row[2] else np.zeros((0, 0))


class Found(NamedTuple):
    """An answer, SI. forces, motions (c,) : components. twist (6,) : of the object about the contacts' centre. kinds
    (n,) : contact states. gives (k,) : of limits. change, torque (nv,) : of the joints.
    """

    forces: Array
    motions: Array
    twist: Array
    kinds: Ints
    gives: Array
    change: Array
    torque: Array


@kernel
def written(s: Situation, laws: Laws, centre: Array, found: Found, row: Array) -> None:
    """Write an answer into its row."""
    n, r, v, twist = len(s.frames), found.forces, found.motions, found.twist
    forces, torsion = of_contacts(r, n, laws.soft)
    motion, spin = of_contacts(v, n, laws.soft)
    pads, turns, slip_memory, miss = _end_of_step(s, laws.soft, motion, spin, found, centre)
    row[0], row[1], at = 1.0, miss, 3
    for part in (forces.reshape(-1), motion.reshape(-1), torsion, spin, found.torque, found.change, twist, centre):
        at = put(row, at, part)
    for part in (found.gives, pads.reshape(-1), turns, slip_memory.reshape(-1)):
        at = put(row, at, part)
    for i in range(n):
        row[at + i] = found.kinds[i]
    at += n
    for i in range(len(r)):
        row[at + i] = r[i] / laws.scale[i]
    at = put(row, put(row, at + len(r), twist), centre)
    for i in range(len(r)):
        row[at + i] = v[i] * laws.scale[i]


@kernel
def put(row: Array, at: int, values: Array) -> int:
    """Write an array into the row; returns where the next one goes."""
    for k in range(len(values)):
        row[at + k] = values[k]
    return at + len(values)


@kernel
def of_contacts(r: Array, n: int, soft: Ints) -> tuple[Array, Array]:
    """(n, 3) and (n,) from components (c,)."""
    own, turns = np.empty((n, 3)), np.zeros(n)
    for i in range(n):
        for a in range(3):
            own[i, a] = r[3 * i + a]
    for a in range(len(soft)):
        turns[soft[a]] = r[3 * n + a]
    return own, turns


@kernel
def _end_of_step(
    s: Situation, soft: Ints, motion: Array, spin: Array, found: Found, centre: Array
) -> tuple[Array, Array, Array, float]:
    """(give, turn, slip_memory, miss): how far pads are pushed away (n, 3) [m], world axes, and turned (n,) [rad] at
    the end; the slip between the iterate and the end (n, 3); and how far the end is from the iterate, as a share of
    radius (n,) and in radians.

    motion (n, 3), spin (n,) : of the answer, as in `Read`. centre (3,) : of the contacts.
    """
    loads, positions, frames, J = s.loads, s.touch.positions, s.frames, s.elastic.J
    change, twist, base, radius = found.change, found.twist, loads.base, s.radius
    n, nv = len(positions), len(change)
    give, turn, slip_memory = loads.give.copy(), loads.turn.copy(), np.zeros((n, 3))
    omega = twist[3:]
    miss = np.sqrt(omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2)
    u, tip, own = np.empty(3), np.empty(3), np.empty(3)
    for i in range(n):
        x, y, z = positions[i, 0] - centre[0], positions[i, 1] - centre[1], positions[i, 2] - centre[2]
        u[0] = twist[0] + omega[1] * z - omega[2] * y
        u[1] = twist[1] + omega[2] * x - omega[0] * z
        u[2] = twist[2] + omega[0] * y - omega[1] * x
        far, near = 0.0, 0.0
        for a in range(3):
            moves, tip[a] = 0.0, 0.0
            for b in range(3):
                moves += frames[i, b, a] * u[b]
            for j in range(nv):
                tip[a] += J[3 * i + a, j] * change[j]
            relative = motion[i, a] - base[i, a]
            own[a] = moves - tip[a] - relative  # the pad's share
            if a < 2:
                slip_memory[i, a] = relative
            far += moves * moves
            near += (tip[a] + own[a]) ** 2
        miss = max(miss, np.sqrt(max(far, near)) / radius[i])
        for b in range(3):
            for a in range(3):
                give[i, b] += frames[i, b, a] * own[a]
    for a in range(len(soft)):
        i = soft[a]
        slip_memory[i, 2] = spin[i] - s.slipped[i, 2]
        turn[i] -= slip_memory[i, 2]
        for b in range(3):
            turn[i] += frames[i, b, 2] * omega[b]
        for j in range(nv):
            turn[i] -= s.elastic.turning[i, j] * change[j]
    return give, turn, slip_memory, miss
