"""Steps in one posture, compiled: contacts, normals and levers stay, so that every step is one small contact problem.

With x = (r, u, s), forces, motion of the object and motions of limits that give way, in natural units,

    v = E r + Gᵀ u + Aᵀ s + d,    0 = G r + w - (u - u⁻) / h,    0 ≤ s ⟂ b - A r ≥ 0

and the laws of contact and friction between r and v, where d holds the gaps and, along the tangents, how far contacts
have slipped until the step begins: v_T is the slip of the step. These slips are all that one step passes to the next.
h is so large that the damper bears nothing, except where the object leaves: there the force of the damper says by how
much the load is too large.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.verify.contact_state import SEPARATED, SLIDING, STICKING
from handlcp.lcp.kernels.contact_newton import (
    ContactArrays,
    clip_open_pairs,
    row_scales,
    run_contact_newton,
    run_newton_first,
    solve_sticking,
)
from handlcp.lcp.kernels.dense import kernel, multiply_add
from handlcp.tolerances import SOLVE_TOLERANCE

FREE, STICKS, SLIDES = SEPARATED, STICKING, SLIDING  # of contacts; a limit that gives way is 1, another one 0
_SLOW = 1e-10  # 1 / h
_HELD = 1e-9  # of the largest force: what the damper may take of a state that is held
_EXACT = SOLVE_TOLERANCE * 1e-2
_UNDAMPED, _NEARLY = 10, 1e-4  # Newton steps without a damper; of the forces, beyond which they are not worth trying
_ROWS = 6  # of an extrapolation
_BELOW, _ABOVE = 1e-9, 1e-6  # of a limit: where a state is held, and where none is


class Still(NamedTuple):
    """problem : M, and room for q. base (N,) : of q, without slips, load and damper. load (dof,) : that grows.
    contacts (n, 4), m, dof, round (n,) : as in `still_of`. bare : the problem without the damper.
    """

    problem: ContactArrays
    bare: ContactArrays
    base: Array
    load: Array
    contacts: Ints
    round: Ints
    m: int
    dof: int


@kernel
def still_of(
    E: Array, G: Array, A: Array, contacts: Ints, round_: Ints, mu: Array, faces: int, normals: Array, gap: Array,
    carried: Array, room: Array, load: Array,
) -> Still:  # fmt: skip
    """E (m, m), G (dof, m), A (k, m). contacts (n, 4) : the normal unknown of each contact and its tangents, padded by
    -1; round (n,) : whether its friction set is. mu (n,), faces, normals : of the sets, as in `projection`. gap (m,) :
    d of normals. carried, load (dof,) : that stays, and that grows. room (k,) : b.
    """
    m, dof, k, n = len(E), len(G), len(A), len(contacts)
    size = m + dof + k
    M, q, role = np.zeros((size, size)), np.zeros(size), np.zeros(size, np.int64)
    M[:m, :m] = E
    for i in range(m):
        for a in range(dof):
            M[i, m + a] = M[m + a, i] = G[a, i]
        for b in range(k):
            M[i, m + dof + b], M[m + dof + b, i] = A[b, i], -A[b, i]
    q[:m], q[m : m + dof], q[m + dof :] = gap, carried, room
    role[m + dof :] = 1
    blocks, limits, count = np.empty((n, 4), np.int64), np.empty(n), 0
    for i in range(n):
        if contacts[i, 0] < 0:
            continue
        role[contacts[i, 0]] = 1
        if contacts[i, 1] >= 0:
            blocks[count], limits[count] = contacts[i], mu[i]
            count += 1
            for a in range(1, 4):
                if contacts[i, a] >= 0:
                    role[contacts[i, a]] = 2
    blocks, limits = blocks[:count].copy(), limits[:count].copy()
    rho, now = row_scales(M, blocks), np.zeros(size)
    bare = ContactArrays(M.copy(), now, role, rho, blocks, limits, faces, normals)
    for a in range(m, m + dof):
        M[a, a] = -_SLOW
    problem = ContactArrays(M, now, role, rho, blocks, limits, faces, normals)
    return Still(problem, bare, q, load.copy(), contacts, round_, m, dof)


@kernel
def euler(g: Still, x: Array, z: Array, start: Array, factor: float, cold: bool, out: Array) -> tuple[int, float]:
    """Write the state under factor · load, one step from x (N,) with slips z (m,), into out (N,). start (N,) : where
    the solve begins, unless `cold`, where all contacts stick. Returns (2: held, 1: the damper takes more than it may,
    0: no answer; and where it is 1, by how much the factor is too large, NaN where that is not known).
    """
    p, m, dof = g.problem, g.m, g.dof
    q = p.q
    q[:] = g.base
    for i in range(m):
        if p.role[i] == 2:
            q[i] = -z[i]
    for a in range(dof):
        q[m + a] += factor * g.load[a] + _SLOW * x[m + a]
    if cold:
        out[:] = 0.0
        solve_sticking(p, q > 0.0, np.zeros(len(p.blocks), np.bool_), out)
    else:
        out[:] = start
    best, _, r = run_newton_first(p, out, cold, _EXACT)
    if not r <= SOLVE_TOLERANCE:
        return 0, np.nan
    out[:] = best
    clip_open_pairs(p, out)
    square, work, largest = 0.0, 0.0, 0.0
    for i in range(m):
        largest = max(largest, abs(out[i]))
    for a in range(dof):
        taken = _SLOW * (out[m + a] - x[m + a])
        square += taken * taken
        work += taken * g.load[a]
    off = r * max(1.0, np.max(np.abs(out)))  # absolute: where motions are huge, an imbalance is no smaller
    if max(np.sqrt(square), off) <= _HELD * max(largest, 1e-300):
        return 2, 0.0
    if np.sqrt(square) <= _NEARLY * largest:
        for a in range(dof):
            q[m + a] -= _SLOW * x[m + a]
        other = out.copy()
        _, r = run_contact_newton(g.bare, other, _UNDAMPED, _EXACT)
        if r * max(1.0, np.max(np.abs(other))) <= _HELD * largest:
            out[:] = other
            clip_open_pairs(p, out)
            return 2, 0.0
        for a in range(dof):
            q[m + a] += _SLOW * x[m + a]
    return 1, square / work if work > 0.0 else np.nan


@kernel
def viscous(g: Still, x: Array, z: Array, factor: float, slow: float, out: Array) -> bool:
    """As `euler`, with a damper of stiffness `slow`; whether there is an answer."""
    p, m, dof = g.problem, g.m, g.dof
    p.q[:] = g.base
    for i in range(m):
        if p.role[i] == 2:
            p.q[i] = -z[i]
    for a in range(dof):
        p.q[m + a] += factor * g.load[a] + slow * x[m + a]
        p.M[m + a, m + a] = -slow
    out[:] = x
    best, _, r = run_newton_first(p, out, False, _EXACT)
    if not r <= SOLVE_TOLERANCE:
        solve_sticking(p, p.q > 0.0, np.zeros(len(p.blocks), np.bool_), out)
        best, _, r = run_newton_first(p, out, True, _EXACT)
    for a in range(dof):
        p.M[m + a, m + a] = -_SLOW
    out[:] = best
    clip_open_pairs(p, out)
    return bool(r <= SOLVE_TOLERANCE)


@kernel
def along(g: Still, x: Array, out: Array, z: Array, slip: Array) -> None:
    """Write v (N,) of a step that ends at `out` into slip: gaps, slips, what limits leave. z (m,) : at its start."""
    p = g.problem
    multiply_add(p.M, out, g.base, slip)
    for i in range(g.m):
        if p.role[i] == 2:
            slip[i] -= z[i]


@kernel
def kinds_of(g: Still, out: Array, slip: Array, kinds: Ints) -> None:
    """Write what contacts and limits do (n + k,) in a step with this end and these v."""
    p, n = g.problem, len(g.contacts)
    block = 0
    for i in range(n):
        j = g.contacts[i, 0]
        if j < 0:
            kinds[i] = FREE
            continue
        b = block
        block += 1 if g.contacts[i, 1] >= 0 else 0
        if out[j] <= p.rho[j] * slip[j] or out[j] <= 0.0:
            kinds[i] = FREE
            continue
        kinds[i] = STICKS
        if g.contacts[i, 1] >= 0:
            slides = _slid(g, i, slip) > 1e-12 * p.limits[b] * out[j] and _room(g, i, b, out) <= 1e-8 * out[j]
            kinds[i] = SLIDES if slides else STICKS
    first = g.m + g.dof
    for q in range(len(out) - first):
        kinds[n + q] = 1 if out[first + q] > p.rho[first + q] * slip[first + q] else 0


@kernel
def _slid(g: Still, i: int, slip: Array) -> float:
    """How far a contact slips, in units of force."""
    total, rho = 0.0, g.problem.rho
    for a in range(1, 4):
        j = g.contacts[i, a]
        if j >= 0:
            total += (rho[j] * slip[j]) ** 2
    return float(np.sqrt(total))


@kernel
def _room(g: Still, i: int, b: int, out: Array) -> float:
    """How far a contact's force is from its friction."""
    p, used, tangents = g.problem, 0.0, 0
    for a in range(1, 4):
        j = g.contacts[i, a]
        if j >= 0:
            used += out[j] * out[j]
            tangents += 1
    used = np.sqrt(used)
    radius = p.limits[b] * out[g.contacts[i, 0]]
    if p.faces > 2 and tangents == 2:
        t = np.arctan2(out[g.contacts[i, 2]], out[g.contacts[i, 1]])
        step = 2.0 * np.pi / p.faces
        used *= np.cos(t - np.round(t / step) * step)
    elif p.faces == 2 and tangents > 1:
        used = abs(out[g.contacts[i, 1]])
    elif p.faces > 2 and tangents == 3:
        used = -np.inf
        for f in range(len(p.normals)):
            reach = 0.0
            for a in range(3):
                reach += p.normals[f, a] * out[g.contacts[i, 1 + a]]
            used = max(used, reach)
    return float(radius - used)


@kernel
def margins_of(g: Still, kinds: Ints, out: Array, slip: Array, margin: Array) -> None:
    """Write how far each contact and limit (n + k,) is from ceasing to do what `kinds` says; below 0: how far beyond.
    A contact that slides is asked whether it opens.
    """
    p, n, block = g.problem, len(g.contacts), 0
    for i in range(n):
        j = g.contacts[i, 0]
        margin[i] = np.inf
        if j < 0:
            continue
        b = block
        block += 1 if g.contacts[i, 1] >= 0 else 0
        pressed = out[j] if out[j] > p.rho[j] * slip[j] else -p.rho[j] * slip[j]
        margin[i] = -pressed if kinds[i] == FREE else pressed
        if kinds[i] == STICKS and g.contacts[i, 1] >= 0 and pressed > 0.0:
            room, slid = _room(g, i, b, out), _slid(g, i, slip)
            margin[i] = min(pressed, room if room > 1e-9 * out[j] else -slid)
    first = g.m + g.dof
    for q in range(len(out) - first):
        gives = out[first + q] - p.rho[first + q] * slip[first + q]
        margin[n + q] = gives if kinds[n + q] == 1 else -gives


@kernel
def lost_at(
    g: Still, x: Array, z: Array, from_: float, factor: float, too_much: float, start: Array, out: Array
) -> float:
    """The load factor beyond which no step from x is held, and the state just below it in `out`; NaN where it is not
    found. Seen from another x it may differ. factor : one that is not held, too large by too_much; start (N,) : the
    state there, which the damper holds.
    """
    there, below = start.copy(), start.copy()
    for _ in range(8):
        end = factor - too_much
        if not end > from_ * (1.0 + _BELOW) or not too_much >= 0.0:
            return np.nan
        if factor <= (1.0 + 4.0 * _ABOVE) * end:
            under = end - _BELOW * abs(end)
            held, _ = euler(g, x, z, x, under, False, out)
            if held != 2:
                held, _ = euler(g, x, z, there, under, False, out)
            return end if held == 2 else np.nan
        factor = end * (1.0 + _ABOVE)
        held, too_much = euler(g, x, z, there, factor, False, below)
        if held != 1:
            return np.nan
        there[:] = below
    return np.nan


@kernel
def finer(
    g: Still, x: Array, z: Array, factor: float, size: float, kinds: Ints, first: Array, tolerance: float, out: Array,
    slips: Array,
) -> tuple[int, int]:  # fmt: skip
    """A step of this size in which no contact changes its state: taken as 1, 2, 3 ... smaller steps, extrapolated to
    infinitely many. Writes its end into out (N,) and the slips there into slips (m,). first (N,) : the end of one step.
    Returns (1: done, 0: not accurate, -1: something changes in it; rows taken).
    """
    N, m = len(x), g.m
    table, last = np.empty((_ROWS, N + m)), np.empty((_ROWS, N + m))
    at, begun, now, slip = x.copy(), z.copy(), np.empty(N), np.empty(N)
    own = np.empty(len(kinds), np.int64)
    for row in range(_ROWS):
        at[:], begun[:] = x, z
        for k in range(row + 1):
            part = (k + 1.0) / (row + 1.0)
            guess = x + part * (first - x) if k == 0 or row == 0 else at + (first - x) / (row + 1.0)
            held, _ = euler(g, at, begun, guess, factor + part * size, False, now)
            if held != 2:
                return -1, row + 1
            along(g, at, now, begun, slip)
            kinds_of(g, now, slip, own)
            for i in range(len(kinds)):
                if own[i] != kinds[i]:
                    return -1, row + 1
            slipped(g, slip, kinds, begun)
            at[:] = now
        table[0, :N], table[0, N:] = at, begun
        for k in range(row):  # Aitken and Neville
            table[k + 1] = table[k] + (table[k] - last[k]) / ((row + 1.0) / (row - k) - 1.0)
        if row > 0:
            off, largest = 0.0, 0.0
            for i in range(m):
                largest = max(largest, abs(table[row, i]))
                off = max(off, abs(table[row, i] - table[row - 1, i]))
            if off <= tolerance * largest:
                out[:], slips[:] = table[row, :N], table[row, N:]
                return 1, row + 1
        last[:] = table
    return 0, _ROWS


@kernel
def slipped(g: Still, slip: Array, kinds: Ints, z: Array) -> None:
    """Add the slips of a step to z (m,); what sticks has none."""
    for i in range(len(g.contacts)):
        if kinds[i] != STICKS:
            for a in range(1, 4):
                j = g.contacts[i, a]
                if j >= 0:
                    z[j] += slip[j]
