"""A viscous flow at constant load: where an object goes that no static state holds, and whether it comes to rest.

The object and the joints move against the dampers D / h, in steps of the pseudo-time h (Kelley & Keyes, SIAM J. Numer.
Anal. 35, 1998): short where the motion is fast, longer and longer towards rest. As h grows the damper vanishes, and
what is left is a static state. With a viscosity that goes to zero this is the jump of a balanced-viscosity solution of
a rate-independent system (Mielke, Rossi & Savaré).
"""

from __future__ import annotations

import numpy as np

from handlcp.check import Array
from handlcp.grasp.path.program import Controls
from handlcp.grasp.path.state import Failure, State
from handlcp.grasp.path.step import Stepper

REST, GONE, CREEPS, MOVES = "rest", "gone", "creeps", "moves"
_FIRST, _LEAST = 1.0, 1e-4  # h
_ROUGH = 1e6  # times the tolerance of a static state: where it rests is looked for as closely as any state
_STEP = 0.08  # of the contacts' distances: how far the object moves in one step
_CALM = 1e-6  # of the forces: what the damper takes of an object at rest
_NEAR = 0.01  # how far the static state may be from there
_FAR = 1.5  # times the farthest contact's distance: an object that has moved farther has left
_MOST = 200
_PUSHED = 4  # steps


def flow(
    stepper: Stepper, state: State, controls: Controls, push: Array | None = None, most: float = np.inf
) -> tuple[State, str]:
    """The state in which the object comes to rest (REST), or the last before it leaves: no contact left, or it is far
    away (GONE), or it neither rests nor goes on (CREEPS). push (6,) : a wrench besides, in the first steps. most : of
    the contacts' distances; an object that has moved farther is not followed on (MOVES).
    """
    h, start, speed = _FIRST, state, 0.0
    reach = float(np.sqrt(((state.look.positions - state.look.reference) ** 2).sum(axis=1)).max()) / stepper.length
    for count in range(_MOST):
        under = controls if push is None or count >= _PUSHED else controls._replace(load=controls.load + push)
        found = stepper.step(state, under, None, h, _ROUGH)
        if isinstance(found, Failure) or stepper.far(state.where.pose, found.where.pose) > _STEP:
            h /= 4.0
            if h < _LEAST:
                return state, CREEPS
            continue
        off, before = stepper.resisted(state, found, h), speed
        speed, state = stepper.far(state.where.pose, found.where.pose) / h, found
        if not state.loaded or stepper.far(start.where.pose, state.where.pose) > _FAR * max(reach, 1.0):
            return state, GONE
        if stepper.far(start.where.pose, state.where.pose) > most:
            return state, MOVES
        if off < _CALM and speed <= before and under is controls:
            rest = stepper.step(state, controls)
            if isinstance(rest, State) and stepper.far(state.where.pose, rest.where.pose) < _NEAR:
                return rest, REST
            if push is not None:  # longer steps would lead back to what it was pushed out of
                return state, CREEPS
        h = min(2.0 * h, stepper.slow)
    return state, CREEPS
