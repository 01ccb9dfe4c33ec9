"""`PageFrames`: a grasp at one moment, or at many, as the viewer of a page reads it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp import words
from handlcp.check import Array
from handlcp.grasp import Grasp, GraspSolution, Loading
from handlcp.grasp.model.status import (
    SEPARATED,
    SLIDING,
    STICKING,
    UNKNOWN,
    ContactStatus,
    contact_statuses,
    contact_words,
    shown_statuses,
)
from handlcp.grasp.solution.verdict import friction_used
from handlcp.viz.picture.content import MAX_ARROW_LENGTH, MIN_DRAWN_MOMENT
from handlcp.viz.picture.overlay import nice_number

# ----------------------------------------------------------------
# A grasp at one moment: where everything is, and what acts. A page shows one of them, or turns through many.

MAX_FRAMES = 150  # steps of a loading that a page keeps


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A grasp with n contacts at one moment, in world axes unless said otherwise.

    label : when it is.
    positions (n, 3) : of the contacts [m].
    axes (n, 3, 3) : contact axes in columns.
    forces (n, 3) : on the object [N], contact axes; never NaN.
    torsion (n,) : moments about the normals [N·m]; never NaN.
    slip (n, 2) : of the object along the tangents [m]; never NaN.
    gap (n,) : along the normals [m]; never NaN.
    friction_share (n,) : share of the friction limit; NaN for none.
    statuses (n,) : STICKING, SLIDING or SEPARATED; UNKNOWN without an answer.
    load (3,), moment (3,) : on the object [N, N·m] at the point acts_at (3,) [m], weights included.
    torques (nv,) : of the joints [N·m]; None without a hand.
    q (nv,) : posture of the joints [rad, m]; None without a hand.
    object : a pin.SE3, the object's motion from where it was drawn.
    slide_length (n,) : how far the object has slid past each contact, the length of its way [m].
    friction_text (n,) : of the contacts, in words, where there is no answer.
    """

    label: str
    positions: Array
    axes: Array
    forces: Array
    torsion: Array
    slip: Array
    gap: Array
    friction_share: Array
    statuses: tuple[ContactStatus, ...]
    load: Array
    moment: Array
    acts_at: Array
    torques: Array | None
    q: Array | None
    object: Any
    slide_length: Array
    friction_text: tuple[str, ...] = ()


def snapshot_of_solution(grasp: Grasp, s: GraspSolution, acts_at: Array) -> Snapshot:
    """The snapshot of one solve: squeeze and load at once, in the grasp's posture.

    acts_at (3,) : the point at which the load is drawn [m], world axes.
    """
    scene, held = grasp.scene, s.held
    n, none = scene.n, np.zeros(scene.n)
    torsion = none if s.torsion is None or not held else s.torsion
    forces = s.forces if held else np.zeros((n, 3))
    state = getattr(grasp, "state", None)
    slip = s.slip if held else np.zeros((n, 2))
    statuses = contact_statuses(s.contact_state) if held else (UNKNOWN,) * n
    return Snapshot(
        label="all at once",
        positions=scene.positions,
        axes=grasp.frames,
        forces=forces,
        torsion=torsion,
        slip=slip,
        gap=s.gap if held else none,
        friction_share=friction_used(grasp.scene, forces, torsion),
        statuses=statuses,
        load=scene.force,
        moment=scene.moment - np.cross(acts_at, scene.force),
        acts_at=acts_at,
        torques=getattr(s, "torques", None) if held else None,
        q=None if state is None else state.q,
        object=pin.SE3.Identity(),
        slide_length=np.hypot(*slip.T) * [status == SLIDING for status in statuses],
        friction_text=tuple([f"μ = {c.mu:g}" if c.mu else "frictionless" for c in grasp.contacts]),
    )


def choose_steps(loading: Loading) -> list[int]:
    """Numbers of the steps that a page keeps: all, or as many, evenly, with first and last."""
    count = len(loading.steps)
    return sorted(set(np.linspace(0, count - 1, min(count, MAX_FRAMES)).round().astype(int).tolist()))


def snapshots_of_loading(loading: Loading, acts_at: Array, posture: Any) -> list[Snapshot]:
    """Snapshots of the steps of a loading that a page keeps, with the slips since the start.

    acts_at (3,) : the point at which the load is drawn at the start [m], world axes; it moves with the object.
    posture : of the hand at the start; None without a hand.
    """
    steps, used = loading.steps, loading.steps.friction_used
    follows, hand = steps.geometry.follows, steps.grasp.spec.mechanism is not None
    reference, found = steps.grasp.spec.reference, []
    for k in choose_steps(loading):
        state, u = steps.states[k], steps.displacement[k]
        R = pin.exp3(u[3:])
        moved = pin.SE3(R, reference + u[:3] - R @ reference)
        at, force = moved.act(acts_at), state.loads.force
        stage = f"{loading.stages[int(steps.stage[k])]}, {words.format_percent(float(steps.share[k]))}"
        q = None if posture is None else state.where.q if follows else posture.q
        found.append(
            Snapshot(
                label=stage if k else "before anything is loaded",
                positions=state.iterate.positions,
                axes=state.iterate.frames,
                forces=state.read.forces,
                torsion=state.read.torsion,
                slip=steps.slid_from[k],
                gap=steps.gap[k],
                friction_share=used[k],
                statuses=shown_statuses(state.kinds),
                load=force,
                moment=state.loads.moment - np.cross(at, force),
                acts_at=at,
                torques=state.read.torque if hand else None,
                q=q,
                object=moved,
                slide_length=steps.slid[k],
            )
        )
    return found


# ----------------------------------------------------------------

_STATUS_WORDS = {STICKING: "sticks", SLIDING: "slides", SEPARATED: "open"}


class PageFrames:
    """All frames in the same units and to the same scales.

    per_newton : length of a force arrow [m/N]. slip_factor : by how much slips are magnified; 0: nothing slides.
    largest_slide : how far the object slides past a contact in all [m], as `check` says it: at the end of the
    loading, if there is one.
    """

    def __init__(self, shown: Sequence[Snapshot], grasp: Grasp) -> None:
        state, size = getattr(grasp, "state", None), grasp.scene.units.length_unit
        self.shown = shown
        self._kinematics: Any = None if state is None else state.hand.kinematics
        strongest = max(float(np.linalg.norm(s.forces, axis=1).max(initial=0.0)) for s in shown)
        # A load that nothing balances is often far larger than the forces of the steps
        loads = max(
            (0.6 if s.statuses[0] != UNKNOWN or len(shown) == 1 else 0.25) * float(np.linalg.norm(s.load))
            for s in shown
        )
        self.per_newton = MAX_ARROW_LENGTH * size / (max(strongest, loads) or 1.0)
        slips = [float(np.hypot(*s.slip[i])) for s in shown for i, now in enumerate(s.statuses) if now == SLIDING]
        largest = max(slips, default=0.0)
        self.largest_slide = float(shown[-1].slide_length.max(initial=0.0))
        self.slip_factor = nice_number(0.45 * size / largest) if largest > words.NEGLIGIBLE_LENGTH else 0.0
        self.has_moments = any((abs(s.torsion) > MIN_DRAWN_MOMENT).any() for s in shown)
        self._slip_unit = words.choose_length_unit([x for s in shown for x in s.slide_length.tolist()])
        self._gap_unit = words.choose_length_unit([x for s in shown for x in s.gap.tolist()])
        self._data: Any = None if state is None else state.hand.kinematics.model.createData()

    @property
    def columns(self) -> list[str]:
        """Headings of the table of contacts."""
        moment = ["moment\nmN·m"] if self.has_moments else []
        slip, gap = f"slip\n{self._slip_unit.name}", f"gap\n{self._gap_unit.name}"
        return ["contact", "state", "normal\nN", "friction\nN", *moment, "of\nlimit", slip, gap]

    def to_list(self) -> list[dict[str, Any]]:
        """The data of all frames, one dictionary for each snapshot."""
        return [self._frame_data(s) for s in self.shown]

    def _frame_data(self, s: Snapshot) -> dict[str, Any]:
        size, torque, poses = float(np.linalg.norm(s.load)), float(np.linalg.norm(s.moment)), None
        if s.q is not None:  # of all joints of the model, the base first
            pin.forwardKinematics(self._kinematics.model, self._data, self._kinematics.configuration(s.q))
            poses = [_pose_data(m) for m in self._data.oMi]
        turns = torque > MIN_DRAWN_MOMENT
        says = [words.format_force(size)] * (size > 0.0) + [words.format_torque(torque)] * turns
        return {
            "label": s.label,
            "joints": poses,
            "object": _pose_data(s.object),
            "contacts": [self._contact_data(s, i) for i in range(len(s.positions))],
            "load": {
                "at": s.acts_at,
                "force": s.load,
                "moment": s.moment if turns else np.zeros(3),
                "says": " and ".join(says),
            },
            "torques": s.torques,
        }

    def _contact_data(self, s: Snapshot, i: int) -> dict[str, Any]:
        moment = float(s.torsion[i])
        R = s.axes[i]
        return {
            "at": s.positions[i],
            "axes": R.T,
            "state": status_word(s.statuses[i]),
            "force": R @ s.forces[i],
            "normal": float(s.forces[i, 2]),
            "moment": moment if abs(moment) > MIN_DRAWN_MOMENT else 0.0,
            "slip": R[:, :2] @ s.slip[i],
            "says": self._contact_text(s, i),
            "row": self._table_row(s, i),
        }

    def _contact_text(self, s: Snapshot, i: int) -> str:
        """Below the contact's name in the picture."""
        status, moment = s.statuses[i], abs(float(s.torsion[i]))
        if status == UNKNOWN:
            return s.friction_text[i]
        if status == SEPARATED:
            gap = float(s.gap[i])
            return f"open, {words.format_length(gap)}" if gap > words.NEGLIGIBLE_LENGTH else "open"
        turned = f", {words.format_torque(moment)}" if moment > MIN_DRAWN_MOMENT else ""
        x, y, normal = s.forces[i].tolist()
        return f"{words.format_contact_force(normal, float(np.hypot(x, y)))}{turned}, {_STATUS_WORDS[status]}"

    def _table_row(self, s: Snapshot, i: int) -> list[str]:
        """Of the table of contacts, without the name."""
        x, y, z = s.forces[i].tolist()
        moment = [_format_number(1e3 * float(s.torsion[i]))] if self.has_moments else []
        slip, gap = self._slip_unit(float(s.slide_length[i])), self._gap_unit(float(s.gap[i]))
        if s.statuses[i] == UNKNOWN:
            return ["–"] * (6 + len(moment))
        normal, friction = _format_number(z), _format_number(float(np.hypot(x, y)))
        share = words.format_percent(float(s.friction_share[i]))
        return [_STATUS_WORDS[s.statuses[i]], normal, friction, *moment, share, slip, gap]


def status_word(status: ContactStatus) -> str:
    """The word by which the viewer knows a status; "" for UNKNOWN."""
    return "" if status == UNKNOWN else contact_words((status,))[0]


def _pose_data(m: Any) -> list[float]:
    """x, y, z [m] and the quaternion x, y, z, w of a pin.SE3."""
    return [float(x) for x in pin.SE3ToXYZQUAT(m)]


def _format_number(value: float) -> str:
    """Three digits that matter, as few as two decimals."""
    value = 0.0 if abs(value) < 5e-4 else value
    return f"{value:.3f}" if abs(value) < 10 else f"{value:.2f}" if abs(value) < 100 else f"{value:.1f}"
