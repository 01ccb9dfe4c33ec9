"""A grasp at one moment: where everything is, and what acts. A page shows one of them, or turns through many."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution, Loading
from handlcp.grasp.answer.reasons import friction_used

MOST = 150  # steps of a loading that a page keeps


@dataclass(frozen=True, slots=True)
class Snapshot:
    """World axes unless said; n contacts.

    label : when it is. positions (n, 3) [m]. axes (n, 3, 3) : contact axes in columns. forces (n, 3) [N], torsion (n,)
    [N·m] about the normals, slip (n, 2) [m], gap (n,) [m] : contact axes; None of them is NaN. used (n,) : share of the
    friction limit, NaN for none. states (n,) : "sticking", "sliding", "separated"; "" without an answer.
    load (3,) [N], moment (3,) [N·m] : on the object at the point acts_at (3,), weights included. torques (nv,) [N·m],
    q (nv,) : of the joints; None without a hand. object : a pin.SE3, the object's motion from where it was drawn.
    friction (n,) : of the contacts, in words, where there is no answer.
    """

    label: str
    positions: Array
    axes: Array
    forces: Array
    torsion: Array
    slip: Array
    gap: Array
    used: Array
    states: tuple[str, ...]
    load: Array
    moment: Array
    acts_at: Array
    torques: Array | None
    q: Array | None
    object: Any
    friction: tuple[str, ...] = ()


def of_solution(grasp: Grasp, s: GraspSolution, acts_at: Array) -> Snapshot:
    """Squeeze and load at once, about the grasp's posture."""
    scene, held = grasp.scene, s.held
    n, none = scene.n, np.zeros(scene.n)
    torsion = none if s.torsion is None or not held else s.torsion
    forces = s.forces if held else np.zeros((n, 3))
    state = getattr(grasp, "state", None)
    return Snapshot(
        "all at once", scene.positions, grasp.frames, forces, torsion,
        s.slip if held else np.zeros((n, 2)), s.gap if held else none, friction_used(grasp.scene, forces, torsion),
        s.contact_state if held else ("",) * n, scene.force, scene.moment - np.cross(acts_at, scene.force), acts_at,
        getattr(s, "torques", None) if held else None, None if state is None else state.q, pin.SE3.Identity(),
        tuple([f"μ = {c.mu:g}" if c.mu else "frictionless" for c in grasp.contacts]),
    )  # fmt: skip


def steps_shown(loading: Loading) -> list[int]:
    """Numbers of the steps that a page keeps: all, or as many, evenly, with first and last."""
    count = len(loading.steps)
    return sorted(set(np.linspace(0, count - 1, min(count, MOST)).round().astype(int).tolist()))


def at_steps(loading: Loading, acts_at: Array, posture: Any) -> list[Snapshot]:
    """The steps shown. acts_at (3,) : where the load is drawn at the start. posture : the hand's, or None. Slips are
    those since the start.
    """
    steps, used = loading.steps, loading.steps.friction_used
    slid = np.cumsum(np.einsum("mnij,mnj->mni", steps.frames[..., :2], steps.slip), axis=0)
    along = np.einsum("mnij,mni->mnj", steps.frames[..., :2], slid)
    follows, hand = steps.geometry.follows, steps.grasp.spec.mechanism is not None
    reference, found = steps.grasp.spec.reference, []
    for k in steps_shown(loading):
        state, u = steps.states[k], steps.displacement[k]
        R = pin.exp3(u[3:])
        moved = pin.SE3(R, reference + u[:3] - R @ reference)
        at, force = moved.act(acts_at), state.loads.force
        q = None
        if posture is not None:
            q = state.where.q if follows else posture.q
        found.append(Snapshot(
            _when(loading, k), state.look.positions, state.look.frames, state.read.forces, state.read.torsion,
            along[k], steps.gap[k], used[k], state.kinds, force, state.loads.moment - np.cross(at, force), at,
            state.read.torque if hand else None, q, moved,
        ))  # fmt: skip
    return found


def _when(loading: Loading, step: int) -> str:
    """Such as "load, 46 %"."""
    stage, share = int(loading.steps.stage[step]), float(loading.steps.share[step])
    if step == 0:
        return "before anything is loaded"
    return f"{loading.stages[stage]}, {words.percent(share)}"
