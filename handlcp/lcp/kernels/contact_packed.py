"""A contact problem as two rows of numbers, and solving it in one call.

Every array of a tuple that Python hands to compiled code is looked at by itself: for `Contacts` that takes longer than
one of Newton's steps, for two rows hardly anything.
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.lcp.kernels.contact_rows import Contacts, in_order
from handlcp.lcp.kernels.contact_run import contact_run, hold
from handlcp.lcp.kernels.dense import kernel


@kernel
def packed(
    M: Array, q: Array, role: Ints, blocks: Ints, order: Ints, limits: Array, faces: int, normals: Array
) -> tuple[Array, Ints]:
    """(numbers, whole numbers) of the problem with its unknowns in this order: M, q, ρ, limits and normals, one after
    the other; how many unknowns and blocks there are, faces, then order, roles and blocks.
    """
    p, n, k = in_order(M, q, role, blocks, order, limits, faces, normals), len(q), len(blocks)
    numbers, whole = np.empty(n * n + 2 * n + k + normals.size), np.empty(3 + 2 * n + 4 * k, np.int64)
    at = 0
    for part in (p.M.reshape(-1), p.q, p.rho, p.limits, np.ascontiguousarray(normals).reshape(-1)):
        numbers[at : at + len(part)] = part
        at += len(part)
    whole[0], whole[1], whole[2] = n, k, faces
    whole[3 : 3 + n], whole[3 + n : 3 + 2 * n], whole[3 + 2 * n :] = order, p.role, p.blocks.reshape(-1)
    return numbers, whole


@kernel
def opened(numbers: Array, whole: Ints) -> Contacts:
    """The problem, as views of its numbers."""
    n, k = whole[0], whole[1]
    a = n * n
    b = a + n
    c = b + n
    d = c + k
    M, normals = numbers[:a].reshape(n, n), numbers[d:].reshape((len(numbers) - d) // 3, 3)
    role, blocks = whole[3 + n : 3 + 2 * n], whole[3 + 2 * n :].reshape(k, 4)
    return Contacts(M, numbers[a:b], role, numbers[b:c], blocks, numbers[c:d], whole[2], normals)


@kernel
def solve_packed(
    numbers: Array, whole: Ints, x: Array, cold: bool, seed: int, most: int, polish: bool, tolerance: float
) -> tuple[int, int, float]:
    """`contact_run` on x (n,) in the problem's own order."""
    n = len(x)
    order, y = whole[3 : 3 + n], np.empty(n)
    for i in range(n):
        y[i] = 0.0 if cold else x[order[i]]
    taken, newton, r = contact_run(opened(numbers, whole), y, cold, seed, most, polish, tolerance)
    for i in range(n):
        x[order[i]] = y[i]
    return taken, newton, r


@kernel
def hold_packed(numbers: Array, whole: Ints, apart: Bools, slippery: Bools, x: Array) -> None:
    """`hold`, with apart and x (n,) in the problem's own order."""
    n = len(x)
    order, y, open_ = whole[3 : 3 + n], np.empty(n), np.empty(n, np.bool_)
    for i in range(n):
        open_[i] = apart[order[i]]
    hold(opened(numbers, whole), open_, slippery, y)
    for i in range(n):
        x[order[i]] = y[i]
