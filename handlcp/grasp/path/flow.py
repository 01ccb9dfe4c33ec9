"""Whether a small push grows, and where the object goes then: a flow against a vanishing viscosity."""

from __future__ import annotations

import math

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.linearise import read_place
from handlcp.grasp.path.path_model import (
    PENDING,
    PathReader,
    PathSteps,
    any_slides,
    carries,
    distance,
    motion,
    reach,
    steps_kernel,
    take_step,
)
from handlcp.grasp.path.solve_step import PARTS, SETTLED, StepOptions, damper_share, read_part, read_state
from handlcp.grasp.path.trace import Trace
from handlcp.lcp.kernels.dense import kernel, product

# ----------------------------------------------------------------
# A viscous flow at constant load: where an object goes that no static state holds, and whether it comes to rest.
#
# The object and the joints move against the dampers D / h, in steps of the pseudo-time h (Kelley & Keyes, SIAM J.
# Numer. Anal. 35, 1998): short where the motion is fast, longer and longer towards rest. As h grows the damper
# vanishes, and what is left is a static state. With a viscosity that goes to zero this is the jump of a
# balanced-viscosity solution of a rate-independent system (Mielke, Rossi & Savaré).
#
# Pads are stiff and follow at once, but for one that buckles: where a contact comes to an edge its normal turns by
# more than its pad can follow, and no step has an answer, however short. From there on pads are damped, too.

REST, GONE, CREEPS, MOVES, STUCK = 0, 1, 2, 3, 4
_FIRST, _LEAST = 1.0, 1e-4  # h
_ROUGH = 1e6  # times the tolerance of a static state: where it rests is looked for as closely as any state
_STEP = 0.08  # of the contacts' distances: how far the object moves in one step
_CALM = 1e-6  # of the forces: what the damper takes of an object at rest
_NEAR = 0.01  # how far the static state may be from there
_FAR = 1.5  # times the farthest contact's distance: an object that has moved farther has left
_MOST = 200
_PUSHED = 4  # steps
_GROWN = 0.5  # times the time in which a push grows


@steps_kernel
def flow(m: PathSteps, t: Trace, begin: Array, controls: Array, push: Array, most: float, end: Array) -> int:
    """Write the state in which the object comes to rest (REST), or the last before it leaves: no contact left, or it is
    far away (GONE), or it neither rests nor goes on (CREEPS). STUCK: forces balance the load there, but no static state
    is found; of the object that says nothing. PENDING: see `seek_state`.

    push (6,) : a wrench besides, in the first steps; empty for none. most : of the contacts' distances; an object that
    has moved farther is not followed on (MOVES).
    """
    h, speed, off, buckles, pushed = _FIRST, 0.0, np.inf, False, len(push) > 0
    longest = _longest_step(m.read, begin) if pushed else m.read.sizes.slow
    pulled = pushed or controls[:6].any() or controls[6] != 0.0
    was_loaded, farthest = carries(m.read, begin), _FAR * max(reach(m.read, begin), 1.0)
    found, with_push = np.empty(len(begin)), controls.copy()
    if pushed:
        with_push[:6] += push
    end[:] = begin
    for count in range(_MOST):
        alone = not pushed or count >= _PUSHED
        under, state = controls if alone else with_push, read_state(end, m.read.state)
        status = take_step(
            m, end, under, state.where, state.start, StepOptions(h, _ROUGH, np.zeros((0, 3)), buckles), found
        )
        if status != SETTLED or distance(m.read, end, found) > _STEP:
            h /= 4.0
            if h < _LEAST:
                if alone and m.read.poses.follows:  # else all solvers have been asked for this load already
                    sought = seek_state(t, end, controls, found)
                    if sought == PENDING:
                        return PENDING
                    if sought == SETTLED and distance(m.read, end, found) < _STEP:
                        end[:] = found
                        return REST
                if buckles or not m.read.poses.follows:
                    return CREEPS
                h, buckles = _FIRST, True
            continue
        off, before = resistance(m.read, end, found, h), speed
        speed = distance(m.read, end, found) / h
        end[:] = found
        loaded = carries(m.read, end)
        if not loaded and not pulled and not was_loaded:
            end[:] = begin
            return STUCK  # nothing moves an object on which nothing acts
        gone = distance(m.read, begin, end)
        if not loaded or gone > farthest:
            return GONE
        if gone > most:
            return MOVES
        if off < _CALM and speed <= before and alone:
            state = read_state(end, m.read.state)
            asked = StepOptions(m.read.sizes.slow, 1.0, np.zeros((0, 3)), False)
            settled = take_step(m, end, controls, state.where, state.start, asked, found) == SETTLED
            if settled and distance(m.read, end, found) < _NEAR:
                end[:] = found
                return REST
            if pushed:  # longer steps would lead back to the state that it was pushed out of
                return CREEPS
        h = min(2.0 * h, longest)
    return STUCK if off < _CALM else CREEPS


@kernel
def seek_state(t: Trace, before: Array, controls: Array, row: Array) -> int:
    """Write a state that all methods of a single solve find at the contacts where they are, which is Python's work.
    SETTLED; PENDING: it is written down in the trace as asked for, and the call that needs it is made again once the
    answer is there; else that these find none.
    """
    leg = t.leg[0]
    k = leg.asked
    leg.asked = k + 1
    if k < leg.answered:
        if t.answers[k, 0] != SETTLED:
            return int(t.answers[k, 0])
        row[:] = t.answers[k, 1:]
        return SETTLED
    t.question[: len(before)] = before
    t.question[len(before) :] = controls
    return PENDING


@kernel
def resistance(m: PathReader, a: Array, b: Array, h: float) -> float:
    """What the object's damper takes in a step with h, as a share of the normal forces."""
    forces = read_part(b, m.state, PARTS.forces).reshape(-1, 3)
    return m.sizes.slow / h * damper_share(m.sizes, m.damper, motion(m, a, b), forces)


@kernel
def _longest_step(m: PathReader, row: Array) -> float:
    """The longest step of a flow that begins with a push: no more than half the time in which the push grows to e times
    itself. A longer implicit step leads back to the state that it was pushed out of. Where contacts slide S says more
    growth than there is, and where they are detected on meshes it is too rough to say how much.
    """
    if any_slides(m, row) or m.noise > 0.0:
        return m.sizes.slow
    grows = growth(m, row)  # where it is negative or was not measured, of the least that counts
    return _GROWN / (grows if grows > GROWS else GROWS)


# ----------------------------------------------------------------
# Whether a held object stays where it is: pushed a little, does it return?
#
# Under a small push contacts and fingers follow, and the object meets a wrench that is linear in its motion, S u.
# Moving against dampers, u̇ = S u: the push dies away where every eigenvalue of S has a negative real part, and grows
# where one has not, as in a column that buckles. Newton's method walks through such states. What grows is asked again:
# a small push is made, in the motion that grows, and the object moves as it will (`flow`). A contact that slides may
# stick when it is pushed back, and S does not know that.

# Of the fingers' stiffness: an object that may roll freely stays where it is pushed, which is 0. One whose weight lies
# a hair off the line through two contacts would turn about it, were they points; no fingertip is one.
GROWS = 1e-4


@kernel
def is_measured(m: PathReader, row: Array) -> bool:
    """Whether S is known: not in the state that a path begins with, nor where no force turns."""
    tally, met = read_part(row, m.state, PARTS.tally), read_part(row, m.state, PARTS.met)
    return bool(tally[1] != 0.0 and np.isfinite(met).all())


@kernel
def growth(m: PathReader, row: Array) -> float:
    """How fast a small push grows: the largest real part of S's eigenvalues, over the fingers' stiffness, or `GROWS`
    where it is no larger and that takes no eigenvalues to see. NaN where it was not measured: no force turns.
    """
    if not is_measured(m, row):
        return np.nan
    S = read_part(row, m.state, PARTS.met).reshape(len(m.freedom), -1)
    if shrinks(S, GROWS):
        return GROWS
    return float(np.linalg.eigvals(S.astype(np.complex128)).real.max())


@kernel
def shrinks(S: Array, most: float) -> bool:
    """Whether the symmetric part of S (k, k) has eigenvalues below `most` alone: then those of S have real parts below
    it, too. `most` times the unit matrix less that part then has a Cholesky factor, by more than rounding.
    """
    k, largest = len(S), 0.0
    L = np.zeros((k, k))
    for i in range(k):
        for j in range(k):
            largest = max(largest, abs(S[i, j]))
    for i in range(k):
        for j in range(i + 1):
            total = (most if i == j else 0.0) - 0.5 * (S[i, j] + S[j, i])
            for a in range(j):
                total -= L[i, a] * L[j, a]
            if i != j:
                L[i, j] = total / L[j, j]
            elif total > 1e-12 * largest:
                L[i, i] = np.sqrt(total)
            else:
                return False
    return True


@kernel
def growing_motion(m: PathReader, row: Array) -> Array:
    """(6,) unit motion that grows in a state, world axes, moments over the contacts' distance. Of two opposite motions
    that are as likely, always the same is taken: the one along the object's own axes.
    """
    values, vectors = np.linalg.eig(read_state(row, m.state).met.astype(np.complex128))
    fastest, moves, own, largest = int(np.argmax(values.real)), np.zeros(6), np.zeros(6), 0.0
    for a in range(6):
        for k in range(len(values)):
            moves[a] += vectors[k, fastest].real * m.freedom[k, a]
    axes = m.poses.axes
    if m.poses.follows:
        turned = read_place(m.poses, read_state(row, m.state).where).pose[:9].reshape(3, 3)
        axes = product(turned, axes)
    for a in range(3):
        for b in range(3):
            own[a] += axes[b, a] * moves[b]
            own[3 + a] += axes[b, a] * moves[3 + b]
    most, size = np.abs(own).max(), math.sqrt((moves * moves).sum())
    for a in range(5, -1, -1):
        if abs(own[a]) >= (1.0 - 1e-6) * most:
            largest = own[a]
    return np.asarray(np.sign(largest) / size * moves)
