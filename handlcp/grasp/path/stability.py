"""Whether a small push grows, and where the object goes then: a flow against a vanishing viscosity."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.state import Controls, Failure, State
from handlcp.grasp.path.step import Stepper
from handlcp.lcp.kernels.dense import kernel
from handlcp.progress import report_progress

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

REST, GONE, CREEPS, MOVES, STUCK = "rest", "gone", "creeps", "moves", "stuck"
_FIRST, _LEAST = 1.0, 1e-4  # h
_ROUGH = 1e6  # times the tolerance of a static state: where it rests is looked for as closely as any state
_STEP = 0.08  # of the contacts' distances: how far the object moves in one step
_CALM = 1e-6  # of the forces: what the damper takes of an object at rest
_NEAR = 0.01  # how far the static state may be from there
_FAR = 1.5  # times the farthest contact's distance: an object that has moved farther has left
_MOST = 200
_PUSHED = 4  # steps
_GROWN = 0.5  # times the time in which a push grows


def flow(
    stepper: Stepper, state: State, controls: Controls, push: Array | None = None, most: float = np.inf
) -> tuple[State, str]:
    """The state in which the object comes to rest (REST), or the last before it leaves: no contact left, or it is far
    away (GONE), or it neither rests nor goes on (CREEPS). STUCK: forces balance the load there, but no static state is
    found; of the object that says nothing. push (6,) : a wrench besides, in the first
    steps. most : of the contacts' distances; an object that has moved farther is not followed on (MOVES).
    """
    h, start, speed, off, buckles = _FIRST, state, 0.0, np.inf, False
    longest = stepper.slow if push is None else _longest(stepper, state)
    pulled = push is not None or controls.load.any() or bool(controls.weight)
    reach = (
        float(np.sqrt(((state.iterate.positions - state.iterate.reference) ** 2).sum(axis=1)).max()) / stepper.length
    )
    for count in range(_MOST):
        report_progress("the object moves on to another place")
        under = controls if push is None or count >= _PUSHED else controls._replace(load=controls.load + push)
        found = stepper.step(state, under, None, h, _ROUGH, None, buckles)
        if isinstance(found, Failure) or stepper.far(state.where.pose, found.where.pose) > _STEP:
            h /= 4.0
            if h < _LEAST:
                rest = stepper.sought(state, controls) if under is controls else None
                if isinstance(rest, State) and stepper.far(state.where.pose, rest.where.pose) < _STEP:
                    return rest, REST
                if buckles or not stepper.geometry.follows:
                    return state, CREEPS
                h, buckles = _FIRST, True
            continue
        off, before = stepper.resisted(state, found, h), speed
        speed, state = stepper.far(state.where.pose, found.where.pose) / h, found
        if not state.loaded and not pulled and not start.loaded:
            return start, STUCK  # nothing moves an object on which nothing acts
        if not state.loaded or stepper.far(start.where.pose, state.where.pose) > _FAR * max(reach, 1.0):
            return state, GONE
        if stepper.far(start.where.pose, state.where.pose) > most:
            return state, MOVES
        if off < _CALM and speed <= before and under is controls:
            rest = stepper.step(state, controls)
            if isinstance(rest, State) and stepper.far(state.where.pose, rest.where.pose) < _NEAR:
                return rest, REST
            if push is not None:  # longer steps would lead back to the state that it was pushed out of
                return state, CREEPS
        h = min(2.0 * h, longest)
    return state, STUCK if off < _CALM else CREEPS


def _longest(stepper: Stepper, state: State) -> float:
    """The longest step of a flow that begins with a push: no more than half the time in which the push grows to e times
    itself. A longer implicit step leads back to the state that it was pushed out of. Where contacts slide S says more
    growth than there is, and where they are detected on meshes it is too rough to say how much.
    """
    if state.slides or stepper.geometry.noise > 0.0:
        return stepper.slow
    return _GROWN / max(GROWS, growth(state))  # where growth is negative or was not measured, of the least that counts


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


def measured(state: State) -> bool:
    """Whether S is known: not in the state that a path begins with, nor where no force turns."""
    return len(state.met) > 0 and bool(np.isfinite(state.met).all())


def growth(state: State) -> float:
    """How fast a small push grows: the largest real part of S's eigenvalues, over the fingers' stiffness, or `GROWS`
    where it is no larger and that takes no eigenvalues to see. NaN where it was not measured: no force turns.
    """
    if not measured(state):
        return np.nan
    if shrinks(state.met, GROWS):
        return GROWS
    return float(np.linalg.eigvals(state.met).real.max())


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


def growing(state: State, freedom: Array, placement: Array) -> Array:
    """(6,) unit motion that grows, world axes, moments over the contacts' distance. Of two opposite motions that are as
    likely, always the same is taken: the one along the object's own axes (placement (3, 3)).
    """
    values, vectors = np.linalg.eig(state.met)
    motion: Array = np.real(vectors[:, int(values.real.argmax())]) @ freedom
    own = np.concatenate([placement.T @ motion[:3], placement.T @ motion[3:]])
    largest = own[int(np.argmax(abs(own) >= (1.0 - 1e-6) * abs(own).max()))]
    return np.asarray(np.sign(largest) * motion / np.linalg.norm(motion))
