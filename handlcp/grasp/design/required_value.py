"""`required_stiffness`, `find_least_value`: the least number with which a grasp holds, judged by `check`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, NumbersByName, check_number
from handlcp.contact.friction import Section
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.analysis.required_value import (
    Required,
    check_tolerance,
    find_least,
    required_friction,
    required_preload,
)
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.active_set import solve_without_slip
from handlcp.grasp.derivatives.parameter import find_parameter
from handlcp.grasp.derivatives.parameter.contact import with_friction
from handlcp.grasp.failure.failure_mode import MOTION, OBJECT, FailureMode, find_exceeded, is_exceeded, state_limits
from handlcp.grasp.failure.failure_text import describe_failures, describe_torque_excess
from handlcp.grasp.model.contact import cross_rows
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.path.follow import Loading, follow
from handlcp.grasp.solution.verdict import HELD, Verdict
from handlcp.grasp.solve.solve_spec import solve_spec
from handlcp.grasp.verdict.check import STEPS_PER_STAGE, judge_grasp
from handlcp.lcp import Auto
from handlcp.progress import track_progress
from handlcp.record import Record
from handlcp.words import wrap_text

MOST_FORCE_ARGUMENT = "most_force"
_MOST_FORCES = NumbersByName("contact", above=0.0, rest=np.inf)


def check_most_force(value: Any, spec: GraspSpec) -> Array:
    """(n,) the largest normal force that the object bears at each contact [N]. value : a number, one for each contact,
    or a mapping by name, others any; None: any everywhere. Raises InputError, UnknownName.
    """
    if value is None:
        return np.full(len(spec.names), np.inf)
    return _MOST_FORCES.read(MOST_FORCE_ARGUMENT, value, spec.names)


def describe_overpressed(path: Loading, most: Array) -> str:
    """Which contact presses harder than it may (n,) [N], and how hard, on the way; "" where none does."""
    largest = path.steps.forces[:, :, 2].max(axis=0, initial=0.0)
    over = is_exceeded(largest / most)
    if not over.any():
        return ""
    k = int(np.argmax(largest / most))
    name = path.steps.grasp.spec.names[k]
    return f"{name} presses with {largest[k]:.4g} N, and the object bears {most[k]:.4g} N there"


# ----------------------------------------------------------------
# Whether a changed grasp holds when it is squeezed, then loaded: the least value of a change with which it does.

LOADING_ORDER = ("squeeze", "load")
_MAX_HALVINGS = 8
_QUICK_CHAIN = Auto(search_seconds=0.0)


@dataclass(eq=False)
class ChangedGrasp:
    """A grasp whose one number is changed, and what became of it under loading. make : the grasp with that number.
    stays : whether an object that snaps to another place does not count as held. paths : by number, in the order tried.
    """

    make: Callable[[float], GraspSpec]
    section: Section
    stays: bool = False
    paths: dict[float, Loading] = field(default_factory=dict)

    def path(self, x: float) -> Loading:
        """The loading with this number, as `check` follows it. Raises Unsupported."""
        if x not in self.paths:
            self.paths[x] = follow(self.make(x), self.section, None, LOADING_ORDER, None, STEPS_PER_STAGE, None)
        return self.paths[x]

    def is_held(self, x: float) -> bool:
        """Whether the end is reached."""
        path = self.path(x)
        return path.in_place and not (self.stays and has_snapped(path))

    def is_too_much(self, x: float) -> bool:
        """Whether the object is lost before the load comes."""
        path = self.path(x)
        return not path.reached and path.lost_stage == LOADING_ORDER[0]


@track_progress("looking for the least value")
def find_least_value(
    changed: ChangedGrasp, start: float, most: float, tolerance: float, unit: str, bears: Array | None = None
) -> Required:
    """The least number with which the grasp holds to the end of its loading, to a relative tolerance, and what `check`
    says of it.
    start : near it, > 0. bears (n,) : how hard contacts may press on the way [N]; None: as hard as they do.
    """
    found = _search_least(changed, start, most, tolerance, unit)
    return found if bears is None or found.value is None else _limit_force(changed, found, bears)


def _search_least(changed: ChangedGrasp, start: float, most: float, tolerance: float, unit: str) -> Required:
    found = find_least(changed.is_held, start, most=most, tolerance=tolerance, too_much=changed.is_too_much)
    found = replace(found, unit=unit)
    value = found.value
    if value is None:
        return replace(found, hint="" if found.fails is None else changed.path(found.fails).why)
    return replace(found, verdict=verdict_on(changed.make(value), changed.section).word)


def _limit_force(changed: ChangedGrasp, found: Required, bears: Array) -> Required:
    """The same where no contact presses too hard. More presses harder, so that else only numbers between the one that
    holds and the one that does not are looked at.
    """
    assert found.value is not None
    low, high, checked = found.fails or 0.0, found.value, list(found.checked)
    if not describe_overpressed(changed.path(high), bears):
        return found
    for _ in range(_MAX_HALVINGS):
        middle = 0.5 * (low + high)
        held = changed.is_held(middle)
        hard = held and bool(describe_overpressed(changed.path(middle), bears))
        checked.append((middle, held and not hard))
        if held and not hard:
            verdict = verdict_on(changed.make(middle), changed.section).word
            return replace(found, value=middle, fails=low, checked=tuple(checked), verdict=verdict)
        low, high = (low, middle) if hard else (middle, high)
    hint = f"with {high:.4g} {found.unit} {describe_overpressed(changed.path(high), bears)}"
    if found.fails is not None:
        hint = f"with less than {high:.4g} {found.unit} the object is not held, and {hint}"
    return replace(found, value=None, fails=low, checked=tuple(checked), hint=hint, verdict="")


def has_snapped(path: Loading) -> bool:
    """Whether the object leaves its place on the way, and comes to rest elsewhere."""
    return any(e.kind == "snaps" for e in path.events)


def verdict_on(spec: GraspSpec, section: Section) -> Verdict:
    """What `check` says of a grasp, without advice."""
    solution = solve_spec(spec, section, _QUICK_CHAIN, proof=False)
    return judge_grasp(spec, build_scene(spec), section, LOADING_ORDER, solution)


# ----------------------------------------------------------------
# Least friction and least preload: found by single solves, then judged as `check` does, by following the loading.

_SEARCH_START_SHARE = 1e-3  # of the largest value tried: where the search starts that single solves say needs nothing


def confirm_required_friction(spec: GraspSpec, section: Section, tolerance: float) -> Required:
    """Find the least friction that holds and what `check` says of it, as `Grasp.required_friction` documents."""
    found, own = required_friction(spec, section, tolerance), {c.mu for c in spec.contacts if c.mu > 0.0}
    return _confirm_required(found, lambda mu: with_friction(spec, mu), section, own.pop() if len(own) == 1 else None)


def confirm_required_preload(spec: GraspSpec, section: Section, tolerance: float) -> Required:
    """Find the least preload that holds and what `check` says of it, as `Grasp.required_preload` documents."""
    found = required_preload(spec, section, tolerance)
    return _confirm_required(found, spec.with_squeeze, section, None)


@track_progress("looking for the least value")
def _confirm_required(
    found: Required, make: Callable[[float], GraspSpec], section: Section, own: float | None
) -> Required:
    """The same with what `check` says of it. Where contacts move as the hand does, what `check` says counts: unless
    the grasp holds at the value, and not below, it is searched for anew from there, by following.

    own : the value that the grasp has. Where the one found is less, and the object is held after it has gone to another
    place, which it does not with its own, the least is searched for that keeps it where it is: from its own value.
    """
    if found.value is None:
        return found
    changed, start = ChangedGrasp(make, section), found.value or _SEARCH_START_SHARE * found.limit
    try:
        there = changed.path(found.value)
    except Unsupported:  # such as known forces
        return found
    now = changed.path(own) if own is not None and own > found.value else there
    if own is not None and has_snapped(there) and not (now.in_place and has_snapped(now)):
        changed.stays, start = True, max(own, found.value)
    agrees = changed.is_held(found.value) and (found.fails is None or not changed.is_held(found.fails))
    if agrees or not there.steps.geometry.follows:
        return replace(
            found, verdict=verdict_on(make(found.value), section).word, hint=_note_more_loses(own, there, now)
        )
    again = find_least_value(changed, start, found.limit, found.tolerance, found.unit)
    again = replace(again, checked=(*found.checked, *again.checked))
    if not (changed.stays and there.held):
        if again.value is None:
            return again
        return replace(again, hint=_note_more_loses(own, changed.path(again.value), now))
    elsewhere = f"with {found.value:.4g} it snaps to another place, and is held there"
    return replace(again, hint="; ".join([text for text in (again.hint, elsewhere) if text]))


def _note_more_loses(own: float | None, there: Loading, now: Loading) -> str:
    """Of a grasp that holds with less than its own value, and not with that; "" of others."""
    if now is there or now.held or not there.held:
        return ""
    return f"with its own {own:.4g} the grasp does not hold: more is not always better"


# ----------------------------------------------------------------
# How stiff must the joints be, so that the object moves no further than allowed while weight and load come?
#
# One factor on the stiffness of all joints. Pads stay as they are, and no stiffness of the joints takes away what they
# alone let the object move.


_MAX_STIFFNESS_FACTOR = 256.0


@dataclass(frozen=True, slots=True)
class RequiredStiffness(Record):
    """The least stiffness of the joints with which the object moves no further than allowed.

    factor : on the stiffness of every joint (of the fingers where no joints are known), with which the grasp holds
        within its torque limits and the object moves no further; below 1 where softer joints will do. None: none found.
    fails : the largest factor tried below it with which it does not, None where every smaller one holds.
    motion : allowed [m]. moved : with this factor, from the end of the squeeze to the whole load [m]; where none was
        found, with the stiffest joints that still hold the object, NaN: none do.
    pads : what is left with rigid joints, where nothing slips [m].
    verdict : what `check()` says of the grasp with this factor. why : why `fails` is not enough, or why none was found.
    """

    entries = ("factor", "fails", "motion_m", "moved_m", "pads_m", "verdict", "why")

    factor: float | None
    fails: float | None
    motion: float
    moved: float
    pads: float
    verdict: str
    why: str

    @property
    def pads_share(self) -> float:
        """What the pads alone let the object move, as a share of what is allowed; above 1 no joints are enough."""
        return self.pads / self.motion

    def __str__(self) -> str:
        allowed, moved = words.format_lengths((self.motion, self.moved))
        if self.factor is None:
            none = "no stiffness of the joints found that keeps the object within"
            return wrap_text(f"{none} {allowed}: {self.why}", "  ")
        less = "" if self.fails is None else f"; with × {self.fails:.4g} {self.why}"
        called = "" if self.verdict == HELD else f"{self.verdict}, as check() says of this: "
        text = f"{called}joints × {self.factor:.4g} as stiff let the object move {moved} of {allowed} allowed{less}"
        return wrap_text(f"{text}; the pads alone make {words.format_percent(self.pads_share)} of it", "  ")


@track_progress("looking for the least stiffness")
def required_stiffness(spec: GraspSpec, section: Section, motion: Any, tolerance: Any) -> RequiredStiffness:
    """Find the stiffness that keeps the object's motion within a bound, as `Grasp.required_stiffness` documents."""
    allowed, near = check_number("motion", motion, above=0.0), check_tolerance(tolerance)

    def scale_stiffness(factor: float) -> GraspSpec:
        if (found := find_parameter("stiffness").scaled(spec, factor)) is None:
            raise InputError("flexibility", "that of joints, whose stiffness can be changed", "one that is not theirs")
        return found

    changed, pads = ChangedGrasp(scale_stiffness, section), _pad_motion(spec)

    def enough(factor: float) -> bool:
        path = changed.path(factor)
        return path.in_place and not _exceeded_joints(path) and _load_motion(path) <= allowed

    def too_much(factor: float) -> bool:
        return changed.is_too_much(factor) or bool(_exceeded_joints(changed.path(factor)))

    found = find_least(enough, 1.0, _MAX_STIFFNESS_FACTOR, near, floor=1.0 / _MAX_STIFFNESS_FACTOR, too_much=too_much)
    if (value := found.value) is not None:
        moved, below, why = _load_motion(changed.path(value)), found.fails, ""
        if below is not None:
            path, why = changed.path(below), "the object is lost"
            if path.in_place:
                why = _describe_torque_excess(path) or describe_failures([FailureMode(MOTION, OBJECT)])
        verdict = verdict_on(scale_stiffness(value), section).word
        return RequiredStiffness(value, below, allowed, moved, pads, verdict, why)
    held = {x: path for x, path in changed.paths.items() if path.in_place and not _exceeded_joints(path)}
    moved = _load_motion(held[max(held)]) if held else np.nan
    return RequiredStiffness(None, None, allowed, moved, pads, "", _explain_failure(changed, held, allowed, pads))


def _explain_failure(changed: ChangedGrasp, held: dict[float, Loading], allowed: float, pads: float) -> str:
    if pads > allowed:
        motion = f"{words.format_length(pads)}, {words.format_percent(pads / allowed)} of that"
        return f"the pads alone let it move {motion}; stiffer pads help, or more of them"
    if held:
        moved = words.format_length(_load_motion(held[max(held)]))
        return f"with joints × {max(held):.4g} as stiff it still moves {moved}"
    lost = [path for path in changed.paths.values() if not path.in_place]
    if lost:
        return lost[-1].why
    return f"{_describe_torque_excess(next(reversed(changed.paths.values())))}, however stiff the joints are"


def _exceeded_joints(path: Loading) -> tuple[FailureMode, ...]:
    """The joints that need more than their torque limits at the end."""
    spec = path.steps.grasp.spec
    return () if spec.mechanism is None else find_exceeded(state_limits(spec), path.last.efforts)


def _describe_torque_excess(path: Loading) -> str:
    """Which joints these are, in words; "" where there is none."""
    found = _exceeded_joints(path)
    return describe_torque_excess([c.who for c in found], path.steps.grasp.spec) if found else ""


def _load_motion(path: Loading) -> float:
    """How far the reference point is at the end from where it was when the load began [m]."""
    steps = path.steps
    begun = int((steps.stage == 0).sum()) if path.stages[0] == LOADING_ORDER[0] else 1  # weight and load come after it
    u = steps.displacement
    return float(np.linalg.norm(u[-1, :3] - u[max(begun - 1, 0), :3]))


def _pad_motion(spec: GraspSpec) -> float:
    """How far the load moves the reference point where only pads and the environment give way and nothing slips [m]."""
    scene, mechanism = build_scene(spec), spec.mechanism
    E = scene.flexibility.copy()
    if mechanism is None:
        k = 3 * spec.of_hand
        E[:k] = E[:, :k] = 0.0
    else:
        joints = mechanism.contact_compliance(mechanism.jacobian_rows(scene.soft))
        E -= joints if scene.scale is None else joints * np.outer(scene.scale, scene.scale)
    still, load = np.zeros((scene.components, 1)), scene.geometry.wrench[:, None]
    twist = solve_without_slip(scene, E, still, load)[1][:, 0]
    arm: Array = spec.reference - scene.geometry.centre
    return float(np.linalg.norm(twist[:3] + cross_rows(twist[3:], arm)))
