"""Columns with positive weight, one after the other: the working set of a nonnegative least-squares fit.

An orthonormal basis Q of the columns C, with C = Q T and T upper triangular, grows by one column and shrinks by any.
The weights that fit a target b best are T⁻¹ Qᵀ b. Columns have length one. Loops run along rows of contiguous arrays,
which compilers turn into vector instructions; that is why Q is kept both ways round.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel

_DEPENDENT = 1e-11  # what is left of a column beside those there are, below which it adds no direction


class Active(NamedTuple):
    """At most R columns of R rows; the first `used[0]` of each array are in use.

    column (R,) : the one that may come next. Q (R + 1, R) : one basis vector a row; QT (R, R + 1) : the same, a column.
    T (R + 1, R + 1) : column k of the triangle in row k. along (R + 1,) : Qᵀ b. b (R,) : the target. weights, fitted
    (R + 1,) : what the fit has, and what would fit best. rest (R,) : what is left of b. owner, kind (R + 1,), of
    (R + 1, 4) : what each column stands for; the caller's. w (R + 1,) : scratch.
    """

    used: Ints
    column: Array
    Q: Array
    QT: Array
    T: Array
    along: Array
    b: Array
    weights: Array
    fitted: Array
    rest: Array
    owner: Ints
    kind: Ints
    of: Array
    w: Array


@kernel
def new_active(b: Array) -> Active:
    """No column yet; b (R,) is the target."""
    R = len(b)
    k = R + 1
    return Active(
        np.zeros(1, np.int64), np.zeros(R), np.zeros((k, R)), np.zeros((R, k)), np.zeros((k, k)), np.zeros(k), b.copy(),
        np.zeros(k), np.zeros(k), b.copy(), np.zeros(k, np.int64), np.zeros(k, np.int64), np.zeros((k, 4)), np.zeros(k),
    )  # fmt: skip


@kernel
def add(a: Active) -> bool:
    """Take in `column`, with weight zero. False where it depends on those there are."""
    k, R = a.used[0], len(a.b)
    if k >= R:
        return False
    v = a.Q[k]
    v[:] = a.column
    for c in range(k):
        a.T[k, c] = 0.0
    for _ in range(2):  # once more takes out what rounding left
        _project(a, k, v)
        for c in range(k):
            a.T[k, c] += a.w[c]
    size = 0.0
    for i in range(R):
        size += v[i] * v[i]
    size = np.sqrt(size)
    if size < _DEPENDENT:
        return False
    t = 0.0
    for i in range(R):
        v[i] /= size
        a.QT[i, k] = v[i]
        t += v[i] * a.b[i]
    a.T[k, k], a.along[k], a.weights[k] = size, t, 0.0
    a.used[0] = k + 1
    return True


@kernel
def _project(a: Active, k: int, v: Array) -> None:
    """Take the first k basis vectors out of v (R,), in place; how much there was of each goes to w."""
    R, w = len(v), a.w
    w[:k] = 0.0
    for i in range(R):
        f, row = v[i], a.QT[i]
        for c in range(k):
            w[c] += f * row[c]
    for c in range(k):
        f, row = w[c], a.Q[c]
        for i in range(R):
            v[i] -= f * row[i]


@kernel
def drop(a: Active, s: int) -> None:
    """Leave column s out; those behind it move up, and rotations make the triangle one again."""
    k, R = a.used[0] - 1, len(a.b)
    a.used[0] = k
    for c in range(s, k):
        a.owner[c], a.kind[c], a.weights[c] = a.owner[c + 1], a.kind[c + 1], a.weights[c + 1]
        for q in range(4):
            a.of[c, q] = a.of[c + 1, q]
        for q in range(c + 2):
            a.T[c, q] = a.T[c + 1, q]
    for c in range(s, k):
        x, y = a.T[c, c], a.T[c, c + 1]
        size = np.hypot(x, y)
        x, y = x / size, y / size
        for q in range(c, k):
            up, down = a.T[q, c], a.T[q, c + 1]
            a.T[q, c], a.T[q, c + 1] = x * up + y * down, x * down - y * up
        up, down = a.along[c], a.along[c + 1]
        a.along[c], a.along[c + 1] = x * up + y * down, x * down - y * up
        one, two = a.Q[c], a.Q[c + 1]
        for i in range(R):
            up, down = one[i], two[i]
            one[i], two[i] = x * up + y * down, x * down - y * up
    for c in range(s, k):
        for i in range(R):
            a.QT[i, c] = a.Q[c, i]


@kernel
def put_weights(a: Active) -> None:
    """The weights that fit best, whatever their signs, into `fitted`."""
    k = a.used[0]
    a.fitted[:k] = a.along[:k]
    for s in range(k - 1, -1, -1):
        row = a.T[s]
        a.fitted[s] /= row[s]
        f = a.fitted[s]
        for c in range(s):
            a.fitted[c] -= f * row[c]


@kernel
def put_rest(a: Active) -> float:
    """What the columns leave of the target, into `rest`, orthogonal to all of them to rounding; returns its length."""
    k, R = a.used[0], len(a.b)
    a.rest[:] = a.b
    for c in range(k):
        f, row = a.along[c], a.Q[c]
        for i in range(R):
            a.rest[i] -= f * row[i]
    _project(a, k, a.rest)
    size = 0.0
    for i in range(R):
        size += a.rest[i] * a.rest[i]
    return float(np.sqrt(size))
