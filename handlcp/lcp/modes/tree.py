"""All choices of contact modes at once: a tree, whose branches are cut off where no force and motion fits them.

At each node some contacts have a mode, the others any. `fit` asks whether anything fits; if not, a proof of that
is checked, and nothing below is visited. If so, the contact that misses its law by most is given each of its modes in
turn, or its patch is split. Where all laws hold, there is an answer.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.kernels.projection import nearest
from handlcp.lcp.modes.active_columns import Active, new_active
from handlcp.lcp.modes.equations import Whole, put_free, reduced
from handlcp.lcp.modes.fit import fit, proves_none, put_parts
from handlcp.lcp.modes.generators import (
    ANY,
    OPEN,
    SLIDES,
    STUCK,
    TOUCHES,
    Cones,
    first_patch,
    parts,
    patches,
    split,
)

EXHAUSTED, CANDIDATE, SPENT = 0, 1, 2  # why `advance` returned
_MORE = 1.0 + 1e-6  # of two that miss it equally the first is taken, whatever rounding says
_HOLDS = 1e-9  # of the largest force and motion: a contact's law holds
_FINEST = 14  # splits of an arc, after which it is 1e-4 rad wide; of a triangle half as many


class Tree(NamedTuple):
    """Nodes still to visit, the last one first. For each node: codes (k, n), corners (k, n, 3, 3) and splits (k, n) of
    the contacts; and generators to begin its fit with, warm (k, R + 1, 6): owner or -1, kind, components.

    counts (5,) : nodes still to visit, nodes visited, candidates that end their branch, fits without a proof,
    multiply-adds spent.
    """

    codes: Ints
    corners: Array
    splits: Ints
    warm: Array
    counts: Ints


class Node(NamedTuple):
    """One node, as it is visited: codes (n,), corners (n, 3, 3) and splits (n,) of the contacts; forces and motions
    that fit it, x and y (n, 4), normal component first, and the free unknowns u (f,).
    """

    codes: Ints
    corners: Array
    splits: Ints
    x: Array
    y: Array
    u: Array


class Claim(NamedTuple):
    """Within which bounds "none" is claimed, as in `proves_none`: most (n, 2), and slack of the equations."""

    most: Array
    slack: float


@kernel
def new_tree(w: Whole) -> Tree:
    """The tree with its root: every contact may do anything."""
    n, R = len(w.tangents), len(w.q)
    room = 2
    for i in range(n):
        room += 3 + patches(w.tangents[i]) + (4 * _FINEST if w.tangents[i] > 1 else 0)
    tree = Tree(
        np.zeros((room, n), np.int64), np.zeros((room, n, 3, 3)), np.zeros((room, n), np.int64),
        np.full((room, R + 1, 6), -1.0), np.zeros(5, np.int64),
    )  # fmt: skip
    tree.counts[0] = 1
    return tree


@kernel
def new_node(w: Whole) -> Node:
    """Arrays for one node."""
    n = len(w.tangents)
    return Node(
        np.zeros(n, np.int64), np.zeros((n, 3, 3)), np.zeros(n, np.int64), np.zeros((n, 4)), np.zeros((n, 4)),
        np.zeros(w.F.shape[1]),
    )  # fmt: skip


@kernel
def advance(t: Tree, w: Whole, normals: Array, claim: Claim, work: int, node: Node) -> int:
    """Visit nodes until `work` multiply-adds are spent, none is left, or there is a candidate, in the node's x, y, u.

    normals : as in `ContactProblem`.
    """
    end = t.counts[4] + work
    codes, corners = node.codes, node.corners
    while t.counts[0] > 0:
        if t.counts[4] >= end:
            return SPENT
        at = t.counts[0] - 1
        codes[:], corners[:, :, :], node.splits[:] = t.codes[at], t.corners[at], t.splits[at]
        asked = reduced(w, codes)
        c, a = asked.cones, new_active(asked.b)
        _warm(t, at, a)
        t.counts[0], t.counts[1] = at, t.counts[1] + 1
        left, spent = fit(c, codes, corners, a)
        t.counts[4] += spent + (2 * len(asked.taken) + 2) * (len(asked.b) + len(asked.taken)) * asked.top.shape[1]
        if left > 0.0 and proves_none(c, codes, corners, a.rest, asked.b, claim.most, claim.slack):
            continue
        put_parts(a, node.x, node.y)
        put_free(w, asked, codes, node.x, node.y, node.u)
        worst, decided = _worst(c, node, normals), True
        if worst < 0:  # there may be another answer below
            worst = _undecided(c, node)
        else:
            decided = node.splits[worst] % 4 == 0 and not bool(np.any((codes == ANY) | (codes == TOUCHES)))
        if worst >= 0:
            _branch(t, c, a, node, worst)
        else:
            t.counts[2] += 1
        if decided:
            return CANDIDATE
    return EXHAUSTED


@kernel
def _warm(t: Tree, at: int, a: Active) -> None:
    """Begin with the generators of the node above, but those of the contact that was branched on."""
    k = 0
    for s in range(t.warm.shape[1]):
        if t.warm[at, s, 0] >= 0.0 and k < len(a.b):
            a.owner[k], a.kind[k] = int(t.warm[at, s, 0]), int(t.warm[at, s, 1])
            a.of[k, :] = t.warm[at, s, 2:]
            k += 1
    a.used[0] = k


@kernel
def _worst(c: Cones, node: Node, normals: Array) -> int:
    """The contact that misses its law by most among those that can be branched on; -1: none, or all laws hold."""
    codes, corners, splits, x, y, _ = node
    size = 1.0
    for i in range(len(codes)):
        for q in range(4):
            size = max(size, abs(x[i, q]), abs(y[i, q]))
    worst, most = -1, _HOLDS * size
    for i in range(len(codes)):
        d = c.tangents[i]
        finest = _FINEST // 2 if d == 3 else _FINEST
        if codes[i] == OPEN or codes[i] == STUCK:
            continue
        if codes[i] == SLIDES and (splits[i] >= finest or parts(corners[i], d, c.faces) == 0):
            continue
        miss = _miss(c, i, normals, x[i], y[i])
        if miss > most * _MORE:
            worst, most = i, miss
    return worst


@kernel
def _undecided(c: Cones, node: Node) -> int:
    """A contact whose mode is not decided, or not its face; -1: none. Arcs have no last one."""
    found = -1
    for i in range(len(node.codes)):
        sliding = node.codes[i] == SLIDES and c.faces > 0 and parts(node.corners[i], c.tangents[i], c.faces) > 0
        if node.codes[i] == ANY or node.codes[i] == TOUCHES or sliding:
            found = i
    return found


@kernel
def _miss(c: Cones, i: int, normals: Array, x: Array, y: Array) -> float:
    """By how much force x (4,) and motion y (4,) miss the law of contact i (the natural residual)."""
    d, s, P, D = c.tangents[i], np.zeros(3), np.zeros(3), np.zeros((3, 4))
    miss = abs(min(x[0], y[0]))
    if d > 0:
        for k in range(d):
            s[k] = x[1 + k] - y[1 + k]
        nearest(s, d, c.limits[i] * max(x[0], 0.0), 0.0, c.faces, normals, P, D)
        for k in range(d):
            miss = max(miss, abs(x[1 + k] - P[k]))
    return float(miss)


@kernel
def _branch(t: Tree, c: Cones, a: Active, node: Node, i: int) -> None:
    """Put the nodes below this one, in which contact i has each of its modes or patches, the likeliest last."""
    codes, corners, _, x, y, _ = node
    d = c.tangents[i]
    if codes[i] == SLIDES:
        for k in range(parts(corners[i], d, c.faces)):
            at = _put(t, a, node, i)
            split(corners[i], k, d, c.faces, t.corners[at, i])
            t.splits[at, i] += 1
        return
    if codes[i] == TOUCHES:
        for k in range(patches(d)):
            at = _put(t, a, node, i)
            t.codes[at, i] = SLIDES
            first_patch(k, d, c.faces, t.corners[at, i])
        at = _put(t, a, node, i)
        t.codes[at, i] = STUCK
        return
    force, motion = 0.0, 0.0
    for q in range(4):
        force, motion = max(force, abs(x[i, q])), max(motion, abs(y[i, q]))
    for k in range(2):
        at = _put(t, a, node, i)
        t.codes[at, i] = OPEN if (k == 0) == (force > motion) else STUCK if d == 0 else TOUCHES


@kernel
def _put(t: Tree, a: Active, node: Node, i: int) -> int:
    """One more node, as the one that is visited; returns its place."""
    at = t.counts[0]
    t.codes[at], t.corners[at], t.splits[at] = node.codes, node.corners, node.splits
    t.warm[at, :, 0] = -1.0
    for s in range(a.used[0]):
        if a.owner[s] != i:
            t.warm[at, s, 0], t.warm[at, s, 1] = a.owner[s], a.kind[s]
            t.warm[at, s, 2:] = a.of[s]
    t.counts[0] = at + 1
    return int(at)
