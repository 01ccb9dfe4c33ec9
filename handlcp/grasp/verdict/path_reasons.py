"""`reached_reasons`: what a followed loading says about holding the object, as the reasons of a verdict."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.failure.failure_mode import find_exceeded_closing
from handlcp.grasp.failure.failure_text import describe_pad_depth
from handlcp.grasp.failure.reason import Reason, make_reason
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.status import SEPARATED, SLIDING
from handlcp.grasp.path.follow import Loading
from handlcp.grasp.path.geometry import RIGID
from handlcp.grasp.path.trajectory import closing_efforts
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solution.verdict import (
    MotionSizes,
    contacts_reason,
    effect_reasons,
    friction_reasons,
    large_motion_reasons,
    load_reasons,
    motion_reason,
    open_reasons,
)
from handlcp.tolerances import NOTICED_SHARE

_NAMED_SLIDE = 1e-4  # of the grasp's size: a contact that slides less on the way and sticks at the end is not named
_LEFT_PLACE_SHARE = 0.15  # of the grasp's size: an object that slides farther has left its place
# Of the load at which the object is lost: if a contact has slid too far only from here on, that is not said
_NEAR_LOSS_SHARE = 0.98
_NEVER_TOUCHED_GAP = 1e-5  # [m] a contact that began farther away and never pressed does not let go
_NAMED_TWIST = 1e-3  # [rad] the same of a soft finger's turn


def lost_reason(path: Loading) -> Reason:
    """Where the object is lost, and why."""
    values = {"stage": path.lost_stage, "share": path.lost_at, "events": [str(e) for e in path.events]}
    case = through = slid = ""
    if (slides := path.slides) is not None and slides.share < _NEAR_LOSS_SHARE * (path.lost_at or 0.0):
        values["slides_at"], case, through = slides.share, "after it slides", path.stages[slides.stage]
        slid = path.slid_too_far
    return make_reason("lost", "decides", values, case, why=path.why, through=through, slid=slid)


def slides_reason(path: Loading) -> Reason:
    """At which load a contact has slid too far, or the object snaps, and how far it goes if it is loaded slowly."""
    gives_way, steps = path.gives_way, path.steps
    assert gives_way is not None  # the caller saw to it
    first = max(int((steps.stage < gives_way.stage).sum()) - 1, 0)  # before the stage
    moved = steps.geometry.between(steps.states[first].where.pose, steps.states[-1].where.pose)
    shift, turn = float(np.linalg.norm(moved[:3])), float(np.linalg.norm(moved[3:]))
    values = {"stage": path.stages[gives_way.stage], "share": gives_way.share, "moved_m": shift, "turned_rad": turn}
    case = "snaps" if gives_way is path.jump else ""
    return make_reason("slides", "decides", values, case, slid="" if case else path.slid_too_far)


def rigid_reasons(spec: GraspSpec) -> Iterator[Reason]:
    """Of contacts that give way in no direction but those of their joints, where the object is lost."""
    k = 3 * spec.of_hand
    E = spec.flexibility[:k, :k]
    if spec.mechanism is None or not E.any() or np.linalg.eigvalsh(E)[0] > RIGID * float(E.diagonal().mean()):
        return
    least = [np.linalg.eigvalsh(E[i : i + 3, i : i + 3])[0] for i in range(0, k, 3)]
    rigid = [name for name, e in zip(spec.names, least, strict=False) if e <= RIGID * float(E.diagonal().mean())]
    yield make_reason("rigid_tips", "warning", case="" if rigid else "together", names=rigid)


def reached_reasons(spec: GraspSpec, scene: Scene, path: Loading) -> Iterator[Reason]:
    """Of a loading whose end is reached: torques and postures at its end, what slid, how far the object moved."""
    last, mechanism = path.last, spec.mechanism
    yield from load_reasons(spec)
    if mechanism is not None:
        before = [*mechanism.report.command_reasons(spec), *place_reasons(spec, path)]
        known = {_reason_key(reason) for reason in before}
        place = (path.state, path.object)
        found = mechanism.report.end_reasons(path.steps.torques[-1], last.yielded, place)
        yield from (r for r in found if _reason_key(r) not in known)
        if (cables := mechanism.joint_model.cables) is not None:
            yield from mechanism.report.tension_reasons(last.pull.tension)
            hangs = [name for name, slack in zip(cables.names, last.pull.slack.tolist(), strict=True) if slack]
            if hangs:
                yield make_reason("slack", "note", {"tendons": hangs})
        yield from mechanism.report.closing_reasons(
            find_exceeded_closing(mechanism, lambda: closing_efforts(path.steps.states))
        )
        if "squeeze" in path.stages:
            closed = np.flatnonzero(path.steps.stage == path.stages.index("squeeze"))
            yield from mechanism.report.pulling_reasons(spec, path.steps.states[closed[-1]].stretched)
        yield from before
    end = path.solution
    if end.held and end.scene is not None:
        yield from effect_reasons(spec.effects, end)
    slid, turned = _slid_distances(path, scene.units.length_unit)
    came = (path.steps.forces[:, :, 2] > 0.0).any(axis=0) | (spec.offset[:, 2] <= _NEVER_TOUCHED_GAP)
    ends = zip(spec.names, last.kinds, came.tolist(), strict=True)
    apart = [n for n, kind, here in ends if kind == SEPARATED and here]
    yield contacts_reason(spec, slid, turned, apart)
    if end.held:
        yield from friction_reasons(spec.names, end.friction_used, last.kinds, " at the end" if slid else "")
    yield motion_reason(path.displacement, scene.force, scene.units.length_unit)
    if slid and slid[past := max(slid, key=lambda name: slid[name])] > _LEFT_PLACE_SHARE * scene.units.length_unit:
        yield make_reason("contacts", "warning", {"finger": past, "slid_m": slid[past]}, "far")
    if (snap := next((e for e in path.events if e.kind == "snaps"), None)) is not None:
        yield make_reason("snaps", "warning", {"stage": snap.stage, "share": snap.share}, event=snap)
    k = spec.of_hand
    if text := describe_pad_depth(last.where.give[:k], last.iterate.frames[:k, :, 2], spec.names):
        yield make_reason("pressed_in", "warning", text=text)
    if end.held:
        yield from () if mechanism is None else mechanism.report.open_reasons(end)
        yield from open_reasons(end.uniqueness)
    if not path.steps.geometry.follows:
        u, size = path.displacement, scene.units.length_unit
        shift, turn = (float(np.linalg.norm(part)) for part in (u[:3], u[3:]))
        squeeze = -float(scene.motions_to_contact_axes(scene.offset)[2 : 3 * scene.n : 3].min(initial=0.0))
        slip = max(slid.values(), default=0.0)
        yield from large_motion_reasons(MotionSizes(max(shift, turn * size), turn, slip, squeeze, size))


def place_reasons(spec: GraspSpec, path: Loading) -> Iterator[Reason]:
    """Of the posture before anything is loaded."""
    first, mechanism = path.steps.states[0].where, spec.mechanism
    if mechanism is not None and path.steps.geometry.follows:
        when = f"before stage {path.stages[0]!r}" if path.stages else "in the given posture"
        yield from mechanism.report.place_reasons(*mechanism.report.place_at(first.q, first.pose), when)


def comparison_reasons(solution: GraspSolution, path: Loading) -> Iterator[Reason]:
    """How far the forces of one solve are from those at the end of the path, where that is worth a word, and the path
    leaves no choice of them.
    """
    if path.solution.uniqueness is not None and not path.solution.uniqueness.forces_determined:
        return
    there, here = path.steps.forces[-1], solution.forces
    size = float(np.linalg.norm(there, axis=1).max(initial=0.0))
    off = np.linalg.norm(there - here, axis=1)
    k = int(off.argmax())
    if size > 0.0 and (share := float(off[k]) / size) > NOTICED_SHARE:
        yield make_reason("followed_forces", "note", {"finger": solution.names[k], "force_error": share}, "differ")


def _reason_key(r: Reason) -> tuple[object, ...]:
    """What tells reasons of two postures apart: with the same key they say the same of both."""
    links = tuple(sorted(str(link["link"]) for link in r.values.get("links", ())))
    return r.code, r.severity, r.values.get("joint"), links


def _slid_distances(path: Loading, size: float) -> tuple[dict[str, float], dict[str, float]]:
    """How far the object slid past each finger [m], and turned on it [rad], in all: of those where it did noticeably,
    or still does at the end.
    """
    steps = path.steps
    slides = np.array([[kind == SLIDING for kind in state.kinds] for state in steps.states])
    way = steps.slid[-1]
    turn: Array = (abs(steps.spin) * slides)[1:].sum(axis=0)
    names, soft = steps.names, steps.torsion.any()
    least = np.where(slides[-1], words.NEGLIGIBLE_LENGTH, _NAMED_SLIDE * size)
    far = {n: float(d) for n, d, some in zip(names, way, least, strict=True) if d > some}
    return far, {n: float(a) for n, a in zip(names, turn, strict=True) if a > _NAMED_TWIST} if soft else {}
