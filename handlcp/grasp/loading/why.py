"""Why an object is lost, in one sentence."""

from __future__ import annotations

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.loading.drive import Run
from handlcp.grasp.loading.stage import Controls
from handlcp.grasp.model.spec import GraspSpec

__all__ = ["under_load", "why_lost"]


def why_lost(run: Run, spec: GraspSpec) -> str:
    """From the last state and the failure that ended the run."""
    assert run.failure is not None
    last = run.states[-1]
    open_, sliding = (
        [name for name, kind in zip(spec.names, last.kinds, strict=True) if kind == what]
        for what in ("separated", "sliding")
    )
    how = []
    if sliding:
        how.append(f"{_who(sliding, spec)} {'slide' if len(sliding) > 1 else 'slides'}")
    if open_:
        how.append(f"{_who(open_, spec)} {'have' if len(open_) > 1 else 'has'} let go")
    state = " and ".join(how)
    if run.failure.kind == "runs away":
        moves = _moves(run.failure.motion)
        text = f"the object runs away{moves}: the fingers give way faster than their forces grow"
    elif run.failure.kind == "unstable":
        text = "the object is in balance, but a small push drives it away: the fingers are too soft for their forces"
    elif run.failure.kind == "pushed out":
        text = "the squeeze pushes the object out from between the fingers"
    elif run.failure.kind == "loose":
        text = "no finger holds the object any more"
    elif run.failure.kind == "no balance":
        text = "no forces within friction balance the load in this position"
    else:
        text = "the fingers do not create the forces that would balance the load"
    return f"{text} ({state})" if state else text


def under_load(now: Controls, end: Controls, weight: Array) -> str:
    """Such as ", under 3.1 N of 6.7 N": load and weight (3,) of the object together, and at the end of the stage."""
    forces = [float(np.linalg.norm(c.load[:3] + c.weight * weight)) for c in (now, end)]
    moments = [float(np.linalg.norm(c.load[3:])) for c in (now, end)]
    if max(forces) > 0.0:
        return f", under {words.force(forces[0])} of {words.force(forces[1])}"
    return f", under {' of '.join(words.torques(moments))}" if max(moments) > 0.0 else ""


def _who(names: list[str], spec: GraspSpec) -> str:
    """The names, or that it is all of them."""
    every = "contacts" if spec.n > spec.of_fingers else "fingers"
    return f"all {len(names)} {every}" if len(names) == spec.n > 2 else words.listed(names)


def _moves(twist: Array | None) -> str:
    """Such as " along -z"."""
    if twist is None or not np.isfinite(twist).all() or not abs(twist[:3]).max() > 0.0:
        return ""
    axis = int(abs(twist[:3]).argmax())
    return f" along {'+' if twist[axis] > 0 else '-'}{'xyz'[axis]}"
