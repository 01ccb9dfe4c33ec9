"""Whether forces and motions within one choice of modes satisfy the equations: a nonnegative least-squares fit.

    min |Σ X x + Σ Y y - b|,   x_i, y_i in the cones of contact i's mode

by the active-set method of Lawson and Hanson (Solving Least Squares Problems, 1974, ch. 23), one generator in or out at
a time. Where something is left, the rest r proves that nothing fits (Farkas): no generator reaches along r, and b does.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Ints
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.modes.active_columns import Active, add, drop, put_rest, put_weights
from handlcp.lcp.modes.generators import Cones, reach, support

_FITS = 1e-11  # of |b|: what is left may be rounding
_REACHES = 1e-13  # of |r|: a generator that reaches less far along the rest counts as orthogonal to it
_FURTHER = 1.0 + 1e-9  # of two that reach equally far the first is taken, whatever rounding says
_TINY = 1e-11  # a column this short is rounding: the object's own motion makes such slips without any force
_MOST = 20  # changes of the active columns, in numbers of equations; a dozen in all is usual


@kernel
def fit(c: Cones, codes: Ints, corners: Array, a: Active) -> tuple[float, int]:
    """(what is left, of |b|, 0 where it is rounding; multiply-adds spent). `a` holds generators to begin with, and then
    those of the fit.

    codes (n,), corners (n, 3, 3) : mode and patch of every contact.
    """
    n, R = len(codes), len(a.b)
    target, of, along = np.sqrt(np.dot(a.b, a.b)), np.zeros((2, 4)), np.zeros((n, 2, 4))
    banned = np.zeros((n, 2), np.bool_)
    spent = _begin(c, a)
    length = put_rest(a)
    for _ in range(_MOST * R):
        if length <= _FITS * target:
            break
        reach(c, a.rest, along)
        spent += R * (8 * n + 5 * a.used[0])
        best, owner, kind = _REACHES * length, -1, 0
        for i in range(n):
            values = support(c, i, codes[i], corners[i], along[i], of)
            for k in range(2):
                if values[k] > 0.0 and not banned[i, k]:
                    size = _size(c, i, k, of[k])
                    value = values[k] / size if size > _TINY else 0.0
                    if value > best * _FURTHER:
                        best, owner, kind = value, i, k
        if owner < 0:
            break
        support(c, owner, codes[owner], corners[owner], along[owner], of)
        _put_column(c, owner, kind, of[kind], a)
        if not add(a):
            banned[owner, kind] = True
            continue
        spent += _settle(a)
        before, length = length, put_rest(a)
        if length < before:
            banned[:, :] = False
        else:
            banned[owner, kind] = True  # rounding alone made it look useful
    return length / target if length > _FITS * target else 0.0, spent


@kernel
def _size(c: Cones, i: int, kind: int, of: Array) -> float:
    """Length of the column of a generator (4,) of contact i."""
    total, products = 0.0, c.products[i, kind]
    for q in range(1 + c.tangents[i]):
        t = 0.0
        for p in range(1 + c.tangents[i]):
            t += products[q, p] * of[p]
        total += of[q] * t
    return float(np.sqrt(max(total, 0.0)))


@kernel
def _put_column(c: Cones, i: int, kind: int, of: Array, a: Active) -> None:
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
            a.of[k, q] = of[q] * scale
    a.owner[k], a.kind[k] = i, kind


@kernel
def _begin(c: Cones, a: Active) -> int:
    """Keep of the generators to begin with those whose weights are positive in the best fit; the most negative goes
    first. Returns multiply-adds spent.
    """
    wanted, R = a.used[0], len(a.b)
    a.used[0] = 0
    for s in range(wanted):
        _put_column(c, a.owner[s], a.kind[s], a.of[s], a)
        add(a)
    spent = 2 * R * wanted * wanted
    while a.used[0] > 0:
        put_weights(a)
        worst = 0
        for s in range(a.used[0]):
            if a.fitted[s] < a.fitted[worst]:
                worst = s
        if a.fitted[worst] > 0.0:
            break
        spent += 6 * R * (a.used[0] - worst)
        drop(a, worst)
    for s in range(a.used[0]):
        a.weights[s] = a.fitted[s]
    return int(spent)


@kernel
def _settle(a: Active) -> int:
    """Move the weights to those that fit best, as far as none becomes negative, and drop what becomes zero, until they
    get there; returns multiply-adds spent.
    """
    R, spent = len(a.b), 0
    while a.used[0] > 0:
        put_weights(a)
        k = a.used[0]
        spent += k * k + 4 * R
        step, first = 1.0, -1
        for s in range(k):
            if a.fitted[s] <= 0.0:
                share = a.weights[s] / (a.weights[s] - a.fitted[s]) if a.weights[s] > a.fitted[s] else 0.0
                if first < 0 or share * _FURTHER < step:
                    step, first = share, s
        for s in range(k):
            a.weights[s] += step * (a.fitted[s] - a.weights[s])
        if first < 0:
            break
        spent += 6 * R * (k - first)
        drop(a, first)
    return spent


@kernel
def proves_none(c: Cones, codes: Ints, corners: Array, rest: Array, b: Array, most: Array, slack: float) -> bool:
    """Whether rest (R,) proves that no forces and motions within `most` (n, 2), of each contact's normal force and of
    its motion, fit: b reaches farther along it than rounding lets all generators together reach. slack : to which share
    of |rest| the equations hold.
    """
    of, along, gain, loss, size = np.zeros((2, 4)), np.zeros((len(codes), 2, 4)), 0.0, 0.0, 0.0
    reach(c, rest, along)
    for j in range(len(b)):
        gain += rest[j] * b[j]
        size += rest[j] * rest[j]
    for i in range(len(codes)):
        force, motion = support(c, i, codes[i], corners[i], along[i], of)
        # Slips are sums of two generators at 120° at most, or of three at right angles: these are in all at most twice
        # as long as the slip
        loss += max(force, 0.0) * most[i, 0] + 2.0 * max(motion, 0.0) * most[i, 1]
    return bool(gain > 2.0 * (loss + slack * np.sqrt(size)))


@kernel
def put_parts(a: Active, x: Array, y: Array) -> None:
    """The fit's forces and motions into x and y (n, 4): normal component, then tangents."""
    x[:, :] = 0.0
    y[:, :] = 0.0
    for s in range(a.used[0]):
        i = a.owner[s]
        for q in range(4):
            if a.kind[s] == 0:
                x[i, q] += a.weights[s] * a.of[s, q]
            else:
                y[i, q] += a.weights[s] * a.of[s, q]
