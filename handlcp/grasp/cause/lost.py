"""Why an object is lost, in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.cause.wording import called
from handlcp.grasp.model.spec import GraspSpec

# How a loading fails
RUNS_AWAY, UNSTABLE, PUSHED_OUT, LOOSE, NO_BALANCE, NO_FORCES = (
    "runs away", "unstable", "pushed out", "loose", "no balance", "no forces"
)  # fmt: skip
_SENTENCES = {
    RUNS_AWAY: "the object runs away{}: the fingers give way faster than their forces grow",
    UNSTABLE: "the object is in balance, but a small push{} drives it away: the fingers are too soft for their forces",
    PUSHED_OUT: "the squeeze pushes the object out from between the fingers",
    LOOSE: "no finger holds the object any more",
    NO_BALANCE: "no forces within friction balance the load in this position",
    NO_FORCES: "the fingers do not create the forces that would balance the load",
}


def why_lost(how: str, spec: GraspSpec, kinds: Sequence[str], motion: Array | None = None) -> str:
    """How the loading fails, one of the above, and what the contacts last did: kinds (n,) "separated", "sticking",
    "sliding". motion (6,) : in which the object runs away, or a small push grows; None: not known.
    """
    open_, sliding = (
        [name for name, kind in zip(spec.names, kinds, strict=True) if kind == what]
        for what in ("separated", "sliding")
    )
    state = []
    if sliding:
        state.append(f"{called(sliding, spec)} {'slide' if len(sliding) > 1 else 'slides'}")
    if open_:
        state.append(f"{called(open_, spec)} {'have' if len(open_) > 1 else 'has'} let go")
    text = _SENTENCES[how if how in _SENTENCES else NO_FORCES].format("" if motion is None else moves(motion))
    return f"{text} ({' and '.join(state)})" if state else text


def under_load(now: Array, end: Array) -> str:
    """Such as ", under 3.1 N of 6.7 N": load and weight (6,) of the object together [N, N·m], and at the end of the
    stage; "" without any.
    """
    forces = [float(np.linalg.norm(w[:3])) for w in (now, end)]
    moments = [float(np.linalg.norm(w[3:])) for w in (now, end)]
    if max(forces) > 0.0:
        return f", under {words.force(forces[0])} of {words.force(forces[1])}"
    return f", under {' of '.join(words.torques(moments))}" if max(moments) > 0.0 else ""


def moves(twist: Array) -> str:
    """Such as " along -z", of a motion (6,); "" for one that only turns."""
    if not np.isfinite(twist).all() or not abs(twist[:3]).max() > 0.0:
        return ""
    axis = int(abs(twist[:3]).argmax())
    return f" along {'+' if twist[axis] > 0 else '-'}{'xyz'[axis]}"
