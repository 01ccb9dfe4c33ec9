"""A hand that closes with all the torque it has: the hardest grip with which no joint is beyond its limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.grasp import Loading, Verdict
from handlcp.grasp.failure.failure_mode import (
    EQUILIBRIUM,
    OBJECT,
    UNDECIDED,
    FailureMode,
    StateLimits,
    find_binding,
    limit_shares,
    state_limits,
)
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.path.state import Outcome, State
from handlcp.hand import HandGrasp
from handlcp.lazy import lazy
from handlcp.robot.hand_model import HandModel

_SQUEEZE, _ALL = ("squeeze",), ("squeeze", "load")
_BEYOND = 1.25  # times the grip that small motions ask for: how far a path goes that looks for a limit
_ROUNDS = 4  # of paths, each from where the one before has led
_SHORT = 0.999  # of the last grip with which the object rests, where it is lost before a joint gives out
_WITHIN = 1e-7  # relative, by which the torque at the end stays below its limit
_AT = 1e-3  # relative: joints that are as near to their limits bind, too


@dataclass(frozen=True, eq=False)
class Closed:
    """A grasp that is closed as hard as its joints can.

    grasp : as it is commanded then. path : how it is squeezed and loaded. binds : what gives out with a harder grip.
    says : the same in words.
    """

    grasp: HandGrasp
    path: Loading
    binds: tuple[FailureMode, ...]
    says: str

    @lazy
    def verdict(self) -> Verdict:
        """The word of `check()` on the grasp."""
        return self.grasp.check()


def ask_for_limits(hand: HandModel) -> None:
    """Raises InputError unless the torque of every joint is limited."""
    unknown = [
        name for name, most in zip(hand.joint_names, hand.torques.peak_limits, strict=True) if not np.isfinite(most)
    ]
    if unknown:
        expected = "a hand with a torque limit for each joint: hand.replace(torque_limits=...)"
        raise InputError("hand", expected, f"none for {', '.join(unknown)}")


def closed(grasp: HandGrasp, force: Array, share: float) -> Closed:
    """Close a grasp with the largest multiple of these grip forces that its joints can make.

    force (k,) : of the fingers [N]. share : of a torque limit that `force` needs where motions are small; there torques
    are proportional to the grip, and hand and object are followed from there.
    """
    limits, factor = state_limits(grasp.spec, nominal=grasp.state.q), 1.0 / share
    ends, lost = tuple[FailureMode, ...](), None
    for _ in range(_ROUNDS):
        path = grasp.replace(grip_force=_BEYOND * factor * force).follow(order=_SQUEEZE)
        within, ends = _within(limits, path)
        factor *= _BEYOND * within
        if ends or not path.reached:
            lost = path
            break
    if not ends:
        factor *= _SHORT
    for _ in range(_ROUNDS):
        made = grasp.replace(grip_force=factor * force)
        path = made.follow(order=_ALL)
        most = _most(limits, path.last)
        if most <= 1.0:
            break
        factor *= (1.0 - _WITHIN) / most
    if ends:
        return Closed(made, path, ends, describe_failures(ends, grasp.spec))
    if lost is None or lost.outcome is Outcome.GAVE_UP:
        return Closed(made, path, (FailureMode(UNDECIDED, OBJECT),), "a harder grip was not followed to its end")
    why = lost.why.partition(": ")[2] or lost.why
    return Closed(made, path, (FailureMode(EQUILIBRIUM, OBJECT),), f"a harder grip is not held: {why}")


def _within(limits: StateLimits, path: Loading) -> tuple[float, tuple[FailureMode, ...]]:
    """The share of the squeeze up to which no joint is beyond a limit, and what is at one; () where none is."""
    states, shares = path.steps.states, path.steps.share
    most = np.array([_most(limits, state) for state in states])
    over = np.flatnonzero(most > 1.0)
    if not len(over):
        return float(shares[-1]), ()
    k = int(over[0])
    if k == 0:
        return 0.0, _gives_out(limits, states[0])
    part = (1.0 - most[k - 1]) / (most[k] - most[k - 1])
    return float(shares[k - 1] + part * (shares[k] - shares[k - 1])), _gives_out(limits, states[k])


def _most(limits: StateLimits, state: State) -> float:
    """The largest share of a joint limit that is used in a state; 0 where none is known."""
    return float(np.nanmax(limit_shares(limits, state.efforts, state.where.q), initial=0.0))


def _gives_out(limits: StateLimits, state: State) -> tuple[FailureMode, ...]:
    return find_binding(limits, state.efforts, state.where.q, near=_AT)
