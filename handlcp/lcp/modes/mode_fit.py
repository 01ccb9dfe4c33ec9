"""`fit_mode`: columns with positive weight, one after the other: the working set of a nonnegative least-squares fit.

An orthonormal basis Q of the columns C, with C = Q T and T upper triangular, grows by one column and shrinks by any.
The weights that fit a target b best are T⁻¹ Qᵀ b. Columns have length one. Loops run along rows of contiguous arrays,
which compilers turn into vector instructions; that is why Q is kept both ways round.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.modes.mode_cones import ModeCones, find_support, write_reach

_DEPENDENCE_TOLERANCE = 1e-11  # what is left of a column beside those there are, below which it adds no direction


class ActiveColumns(NamedTuple):
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
    components: Array
    w: Array


@kernel
def new_active_columns(b: Array) -> ActiveColumns:
    """No column yet; b (R,) is the target."""
    R = len(b)
    k = R + 1
    return ActiveColumns(
        np.zeros(1, np.int64),
        np.zeros(R),
        np.zeros((k, R)),
        np.zeros((R, k)),
        np.zeros((k, k)),
        np.zeros(k),
        b.copy(),
        np.zeros(k),
        np.zeros(k),
        b.copy(),
        np.zeros(k, np.int64),
        np.zeros(k, np.int64),
        np.zeros((k, 4)),
        np.zeros(k),
    )


@kernel
def add_column(a: ActiveColumns) -> bool:
    """Take in `column`, with weight zero. False where it depends on those there are."""
    k, R = a.used[0], len(a.b)
    if k >= R:
        return False
    v = a.Q[k]
    v[:] = a.column
    for c in range(k):
        a.T[k, c] = 0.0
    for _ in range(2):  # once more takes out what rounding left
        _orthogonalise(a, k, v)
        for c in range(k):
            a.T[k, c] += a.w[c]
    size = 0.0
    for i in range(R):
        size += v[i] * v[i]
    size = np.sqrt(size)
    if size < _DEPENDENCE_TOLERANCE:
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
def _orthogonalise(a: ActiveColumns, k: int, v: Array) -> None:
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
def drop_column(a: ActiveColumns, s: int) -> None:
    """Leave column s out; those behind it move up, and rotations make the triangle one again."""
    k, R = a.used[0] - 1, len(a.b)
    a.used[0] = k
    for c in range(s, k):
        a.owner[c], a.kind[c], a.weights[c] = a.owner[c + 1], a.kind[c + 1], a.weights[c + 1]
        for q in range(4):
            a.components[c, q] = a.components[c + 1, q]
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
def fit_weights(a: ActiveColumns) -> None:
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
def write_rest(a: ActiveColumns) -> float:
    """What the columns leave of the target, into `rest`, orthogonal to all of them to rounding; returns its length."""
    k, R = a.used[0], len(a.b)
    a.rest[:] = a.b
    for c in range(k):
        f, row = a.along[c], a.Q[c]
        for i in range(R):
            a.rest[i] -= f * row[i]
    _orthogonalise(a, k, a.rest)
    size = 0.0
    for i in range(R):
        size += a.rest[i] * a.rest[i]
    return float(np.sqrt(size))


# ----------------------------------------------------------------
# Whether forces and motions within one choice of modes satisfy the equations: a nonnegative least-squares fit.
#
#     min |Σ X x + Σ Y y - b|,   x_i, y_i in the cones of contact i's mode
#
# by the active-set method of Lawson and Hanson (Solving Least Squares Problems, 1974, ch. 23), one generator in or
# out at a time. Where something is left, the rest r proves that nothing fits (Farkas): no generator reaches along r,
# and b does.


_FIT_TOLERANCE = 1e-11  # of |b|: what is left may be rounding
_ORTHOGONAL_TOLERANCE = 1e-13  # of |r|: a generator that reaches less far along the rest counts as orthogonal to it
_TIE_FACTOR = 1.0 + 1e-9  # of two that reach equally far the first is taken, whatever rounding says
# A column this short is rounding: the object's own motion makes such slips without any force
_MIN_COLUMN_LENGTH = 1e-11
_MAX_COLUMN_CHANGES = 20  # changes of the active columns, in numbers of equations; a dozen in all is usual


@kernel
def fit_mode(c: ModeCones, codes: Ints, corners: Array, a: ActiveColumns) -> tuple[float, int]:
    """Fit forces and motions of one choice of modes: (what is left, multiply-adds spent).

    What is left is a share of |b|, 0 where it is rounding.
    a : holds generators to begin with, and then those of the fit.
    codes (n,), corners (n, 3, 3) : mode and patch of every contact.
    """
    n, R = len(codes), len(a.b)
    target, of, along = np.sqrt(np.dot(a.b, a.b)), np.zeros((2, 4)), np.zeros((n, 2, 4))
    banned = np.zeros((n, 2), np.bool_)
    spent = _keep_positive(c, a)
    length = write_rest(a)
    for _ in range(_MAX_COLUMN_CHANGES * R):
        if length <= _FIT_TOLERANCE * target:
            break
        write_reach(c, a.rest, along)
        spent += R * (8 * n + 5 * a.used[0])
        best, owner, kind = _ORTHOGONAL_TOLERANCE * length, -1, 0
        for i in range(n):
            values = find_support(c, i, codes[i], corners[i], along[i], of)
            for k in range(2):
                if values[k] > 0.0 and not banned[i, k]:
                    size = _column_length(c, i, k, of[k])
                    value = values[k] / size if size > _MIN_COLUMN_LENGTH else 0.0
                    if value > best * _TIE_FACTOR:
                        best, owner, kind = value, i, k
        if owner < 0:
            break
        find_support(c, owner, codes[owner], corners[owner], along[owner], of)
        _put_column(c, owner, kind, of[kind], a)
        if not add_column(a):
            banned[owner, kind] = True
            continue
        spent += _move_to_best_weights(a)
        before, length = length, write_rest(a)
        if length < before:
            banned[:, :] = False
        else:
            banned[owner, kind] = True  # rounding alone made it look useful
    return length / target if length > _FIT_TOLERANCE * target else 0.0, spent


@kernel
def _column_length(c: ModeCones, i: int, kind: int, of: Array) -> float:
    """Length of the column of a generator (4,) of contact i."""
    total, products = 0.0, c.products[i, kind]
    for q in range(1 + c.tangents[i]):
        t = 0.0
        for p in range(1 + c.tangents[i]):
            t += products[q, p] * of[p]
        total += of[q] * t
    return float(np.sqrt(max(total, 0.0)))


@kernel
def _put_column(c: ModeCones, i: int, kind: int, of: Array, a: ActiveColumns) -> None:
    """Make the generator (4,) of contact i, in a column of length one, the one that may come next."""
    k, columns, total = a.used[0], c.columns, 0.0
    for j in range(len(a.b)):
        value = 0.0
        for q in range(1 + c.tangents[i]):
            value += of[q] * columns[j, i, 4 * kind + q]
        a.column[j] = value
        total += value * value
    if total > 0.0:
        scale = 1.0 / np.sqrt(total)
        for j in range(len(a.b)):
            a.column[j] *= scale
        for q in range(4):
            a.components[k, q] = of[q] * scale
    a.owner[k], a.kind[k] = i, kind


@kernel
def _keep_positive(c: ModeCones, a: ActiveColumns) -> int:
    """Keep of the first generators those of positive weight in the best fit; returns multiply-adds spent."""
    wanted, R = a.used[0], len(a.b)
    a.used[0] = 0
    for s in range(wanted):
        _put_column(c, a.owner[s], a.kind[s], a.components[s], a)
        add_column(a)
    spent = 2 * R * wanted * wanted
    while a.used[0] > 0:
        fit_weights(a)
        worst = 0
        for s in range(a.used[0]):
            if a.fitted[s] < a.fitted[worst]:
                worst = s
        if a.fitted[worst] > 0.0:
            break
        spent += 6 * R * (a.used[0] - worst)
        drop_column(a, worst)
    for s in range(a.used[0]):
        a.weights[s] = a.fitted[s]
    return int(spent)


@kernel
def _move_to_best_weights(a: ActiveColumns) -> int:
    """Move the weights to those that fit best, as far as none becomes negative, and drop what becomes zero, until they
    get there; returns multiply-adds spent.
    """
    R, spent = len(a.b), 0
    while a.used[0] > 0:
        fit_weights(a)
        k = a.used[0]
        spent += k * k + 4 * R
        step, first = 1.0, -1
        for s in range(k):
            if a.fitted[s] <= 0.0:
                share = a.weights[s] / (a.weights[s] - a.fitted[s]) if a.weights[s] > a.fitted[s] else 0.0
                if first < 0 or share * _TIE_FACTOR < step:
                    step, first = share, s
        for s in range(k):
            a.weights[s] += step * (a.fitted[s] - a.weights[s])
        if first < 0:
            break
        spent += 6 * R * (k - first)
        drop_column(a, first)
    return spent


@kernel
def proves_none(c: ModeCones, codes: Ints, corners: Array, rest: Array, b: Array, most: Array, slack: float) -> bool:
    """Whether rest (R,) proves that no forces and motions within `most` (n, 2), of each contact's normal force and of
    its motion, fit: b reaches farther along it than rounding lets all generators together reach. slack : to which share
    of |rest| the equations hold.
    """
    of, along, gain, loss, size = np.zeros((2, 4)), np.zeros((len(codes), 2, 4)), 0.0, 0.0, 0.0
    write_reach(c, rest, along)
    for j in range(len(b)):
        gain += rest[j] * b[j]
        size += rest[j] * rest[j]
    for i in range(len(codes)):
        force, motion = find_support(c, i, codes[i], corners[i], along[i], of)
        # Slips are sums of two generators at 120° at most, or of three at right angles: these are in all at most twice
        # as long as the slip
        loss += max(force, 0.0) * most[i, 0] + 2.0 * max(motion, 0.0) * most[i, 1]
    return bool(gain > 2.0 * (loss + slack * np.sqrt(size)))


@kernel
def write_fit(a: ActiveColumns, x: Array, y: Array) -> None:
    """The fit's forces and motions into x and y (n, 4): normal component, then tangents."""
    x[:, :] = 0.0
    y[:, :] = 0.0
    for s in range(a.used[0]):
        i = a.owner[s]
        for q in range(4):
            if a.kind[s] == 0:
                x[i, q] += a.weights[s] * a.components[s, q]
            else:
                y[i, q] += a.weights[s] * a.components[s, q]
