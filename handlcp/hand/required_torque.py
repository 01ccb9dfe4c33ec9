"""`find_required_torque`: which torques hold every load of a brief, with the grip that needs least of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy

from handlcp.actuation.joint_stiffness import Elasticity
from handlcp.actuation.tendon_stiffness import TendonStiffness
from handlcp.check import Array, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.grasp.analysis.required_value import Required, check_tolerance, find_least
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.active_set import solve_without_slip
from handlcp.grasp.derivatives.parameter.joint import with_torque_limits
from handlcp.grasp.design.required_value import (
    LOADING_ORDER,
    ChangedGrasp,
    check_most_force,
    describe_overpressed,
    find_least_value,
    verdict_on,
)
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.path.follow import Loading, follow
from handlcp.grasp.path.trajectory import closing_efforts
from handlcp.grasp.solution.verdict import HELD, Verdict
from handlcp.grasp.verdict.check import STEPS_PER_STAGE
from handlcp.hand.mechanism import hand_mechanism
from handlcp.hand.motor_requirement import LoadCase, RequiredTension, RequiredTorque, read_load_cases
from handlcp.hand.squeeze import apply_command, apply_grip_force

# ----------------------------------------------------------------
# The grip with which all loads hold and the motors need least, found by following every grip that is tried.

_MAX_GRIP_FACTOR = 2.0**8  # times the grip that the search starts from
_GRIP_CHANGES = (0.2, 0.08, 0.03)  # of one finger's grip
_MIN_IMPROVEMENT = 1e-3  # a change that gains less is none


def search_least_grip(trials: GripTrials, starts: list[Array], tolerance: float) -> tuple[GripTrial, GripTrial | None]:
    """The best grip found, and the largest smaller one of the same shape that does not hold; None: less grip holds,
    too, but the motors need no less. Where nothing holds, the first is the grip that gets furthest.

    starts : grips (k,) [N] to go on from, the most promising first; a later one counts only where none before it holds.
    """
    found = (_search_multiple(trials, start, tolerance)[0] for start in starts)
    best = next((one for one in found if one.is_held), None)
    if best is None:
        return _furthest_trial(list(trials.tried.values())), None
    better = _vary_fingers(trials, best)
    least_of_it = _search_multiple(trials, better.force, tolerance)
    return least_of_it if least_of_it[0].need <= better.need else (better, least_of_it[1])


def _furthest_trial(tried: list[GripTrial]) -> GripTrial:
    """Of grips that do not hold, the one that gets furthest, and why no harder one does."""
    found = max(tried, key=lambda one: one.reached_share)
    hard = min([one for one in tried if one.pressed_contact], key=lambda one: float(one.force.max()), default=found)
    if hard is found or found.lost is None:
        return found
    load, why = found.lost
    return replace(found, lost=(load, f"{why}; with {hard.force.max():.4g} N at most {hard.pressed_contact}"))


def _search_multiple(trials: GripTrials, force: Array, tolerance: float) -> tuple[GripTrial, GripTrial | None]:
    """The least multiple of a grip that holds, or else that gets furthest; and the one below, which does not hold."""

    def is_too_much(factor: float) -> bool:
        return trials(factor * force).reached_share < 0.0

    found = find_least(lambda x: trials(x * force).is_held, 1.0, _MAX_GRIP_FACTOR, tolerance, too_much=is_too_much)
    below = None if found.fails is None else trials(found.fails * force)
    if found.value is None:
        assert below is not None  # the start was tried
        return below, None
    return trials(found.value * force), below


def _vary_fingers(trials: GripTrials, best: GripTrial) -> GripTrial:
    """One finger after the other, as long as that helps: with its new grip, all others as they were."""
    for change in _GRIP_CHANGES:
        moved = True
        while moved:
            moved = False
            for finger in range(len(best.force)):
                for factor in (1.0 - change, 1.0 + change):
                    force = best.force.copy()
                    force[finger] *= factor
                    found = trials.find_below(force, (1.0 - _MIN_IMPROVEMENT) * best.need)
                    if found is not None:
                        best, moved = found, True
                        break
    return best


# ----------------------------------------------------------------

_EQUAL_TORQUE_TOLERANCE = 1e-6  # torques that differ by less are the same


@dataclass(frozen=True, slots=True, eq=False)
class GripTrial:
    """One grip that was tried under all loads.

    force (k,) : normal forces commanded at the fingertips [N].
    torque (m, nv) : the largest of each joint under each of m loads, from the first touch to the whole load [N·m].
    squeeze (nv,) : the largest while the hand closes, or what the drive pulls with against dry friction at the joint,
        where that is more.
    need : the largest of both as a share of what is compared; inf where a load is lost.
    lost : that load, and why.
    reached_share : share of that load at which it is lost; below 0 where less grip may hold it: the object is lost as
        the hand closes, or is pressed too hard, or the hand cannot take the posture of the end.
    pressed_contact : the contact that presses too hard, in words; "": none does.
    """

    force: Array
    torque: Array
    squeeze: Array
    need: float
    lost: tuple[str, str] | None = None
    reached_share: float = 1.0
    pressed_contact: str = ""

    @property
    def is_held(self) -> bool:
        """Whether every load holds."""
        return self.lost is None

    @property
    def largest_torque(self) -> Array:
        """The largest torque (nv,) of each joint under any load [N·m]."""
        return np.asarray(self.torque.max(axis=0))

    @property
    def sizing_load(self) -> Ints:
        """(nv,) the load that needs most of each joint; -1: closing the hand does."""
        while_closing = self.squeeze >= (1.0 - _EQUAL_TORQUE_TOLERANCE) * self.largest_torque
        return np.where(while_closing, -1, self.torque.argmax(axis=0))


@dataclass(eq=False)
class GripTrials:
    """All that were tried. share (nv,) : torques that count as much as each other, drive_friction (nv,) : dry friction
    of drives [N·m]. max_forces (n,) : how hard contacts may press [N]. count : how many so far.
    """

    cases: tuple[LoadCase, ...]
    section: Section
    share: Array
    drive_friction: Array
    max_forces: Array
    report: Callable[[int], object]
    tried: dict[bytes, GripTrial] = field(default_factory=dict)
    first: int = 0  # the load that was lost last is the first to be tried
    # Of those that need at least so much, whether or not they hold
    lower_bounds: dict[bytes, float] = field(default_factory=dict)
    count: int = 0

    def __call__(self, force: Array) -> GripTrial:
        """With these grip forces (k,) [N]."""
        key = force.tobytes()
        if key not in self.tried:
            found = self._follow_loads(force, np.inf)
            assert found is not None
            self.tried[key] = found
        return self.tried[key]

    def find_below(self, force: Array, need: float) -> GripTrial | None:
        """The same where every load holds and needs less than this; else None, as soon as that is known."""
        key = force.tobytes()
        if key not in self.tried and not self.lower_bounds.get(key, -np.inf) >= need:
            found = self._follow_loads(force, need)
            if found is None:
                self.lower_bounds[key] = need
            else:
                self.tried[key] = found
        one = self.tried.get(key)
        return one if one is not None and one.need < need else None

    def _follow_loads(self, force: Array, most: float) -> GripTrial | None:
        """Follow the loads with one grip, until one is lost; None: it holds so far, and needs as much as `most`."""
        self.count += 1
        self.report(self.count)
        nv, m = len(self.share), len(self.cases)
        torque, squeeze = np.zeros((m, nv)), np.zeros(nv)
        for k in sorted(range(m), key=lambda k: k != self.first):
            name, spec = self.cases[k]
            path = follow(apply_grip_force(spec, force), self.section, None, LOADING_ORDER, None, STEPS_PER_STAGE, None)
            if not path.in_place:
                self.first = k
                share = path.held_to - (path.lost_stage == LOADING_ORDER[0])
                how = f"not held: {path.sentence}" if path.reached else path.why
                return GripTrial(force, torque, squeeze, np.inf, (name, how), share)
            hard = describe_overpressed(path, self.max_forces)
            if (why := f"not held: {hard}" if hard else _unreachable_end(path)) is not None:  # less grip may do
                self.first = k
                return GripTrial(force, torque, squeeze, np.inf, (name, why), -1.0, hard)
            sizes = abs(path.steps.torques)
            torque[k] = sizes.max(axis=0)
            closing = sizes[path.steps.stage == 0] if path.stages[0] == LOADING_ORDER[0] else sizes[:1]
            squeeze = np.max([squeeze, closing.max(axis=0), closing_torque(self.drive_friction, path)], axis=0)
            if (np.maximum(torque[k], squeeze) / self.share).max() >= most:
                return None
        return GripTrial(force, torque, squeeze, float((np.vstack([torque, squeeze]) / self.share).max()))


def closing_torque(rubs: Array, path: Loading) -> Array:
    """(nv,) the largest torque that closing takes of each drive, but for their dry friction (nv,) [N·m]."""
    return np.asarray(np.maximum(closing_efforts(path.steps.states)[: len(rubs)] - rubs, 0.0))


def _unreachable_end(path: Loading) -> str | None:
    """Why the hand cannot be where the path ends; None: it can, or no grip changes it, as it begins there already."""
    mechanism = path.steps.grasp.spec.mechanism
    if mechanism is None or not path.steps.geometry.follows:
        return None
    for number in (0, -1):
        at = path.steps.states[number].where
        there = mechanism.report.place_at(at.q, at.pose)
        for reason in mechanism.report.place_reasons(*there, "at the end of the loading"):
            if reason.severity == "decides":
                return None if number == 0 else f"not held: {reason.sentence}"
    return None


# ----------------------------------------------------------------
# Contact forces where nothing slips and nothing opens: linear in the grip and in the load.
#
# d = d₀ + D f
#
# with the grip forces f (k,) that are commanded. While all contacts stick, the path of forces from squeeze to load is a
# straight line. Where it stays within friction it is the answer, whatever the order of the loading.


@dataclass(frozen=True, slots=True, eq=False)
class StickingResponse:
    """Forces r = by_grip f + rest in the laws' coordinates (c,), and torques τ = levers r + held (nv,) [N·m].

    scene : without a command. by_grip (c, k) : one column a finger. rest (c,) : without a grip, under the load;
    unloaded (c,) : without the load, too.
    """

    scene: Scene
    by_grip: Array
    rest: Array
    unloaded: Array
    levers: Array
    bias_torque: Array


def sticking_response(spec: GraspSpec, gripped: Callable[[GraspSpec, Array], GraspSpec]) -> StickingResponse:
    """Of this grasp under its load. gripped : the grasp with grip forces (k,) [N]; 0 for none."""
    k = spec.of_hand
    bare = build_scene(gripped(spec, np.zeros(k)))
    shifts = [build_scene(gripped(spec, row)).offset - bare.offset for row in np.eye(k)]
    loads = np.zeros((6, 2 + k))
    loads[:, 0] = bare.geometry.wrench
    r, _ = solve_without_slip(bare, bare.flexibility, np.column_stack([bare.offset, bare.offset, *shifts]), loads)
    mechanism, scale = bare.mechanism, 1.0 if bare.scale is None else bare.scale
    assert mechanism is not None
    levers = mechanism.jacobian_rows(bare.soft).T * scale
    return StickingResponse(bare, r[:, 2:], r[:, 0], r[:, 1], levers, bare.bias_torque_or_zero)


# ----------------------------------------------------------------
# The grip of each finger with which no fingertip slips and the motors need least: a linear program.
#
# least t    with    |τ| ≤ t s,    r within friction,    r_N ≤ most    after the squeeze and under every load
#
# r and τ are linear in the grip forces (above), and s says what counts as much as what: the torque limits, or
# one newton metre for every joint. It knows neither slips nor motions of the hand. So it is where the search for the
# least grip begins, not its answer.

_CONE_FACES = 16  # faces of a friction cone in a tangent plane
_LIMIT_SURFACE_FACES = 64  # faces of a soft finger's limit surface
# Weight of the grip's sum and of its largest: among grips with the same torques the gentlest, evenly
_GRIP_WEIGHT = 1e-6


def minimise_grip(
    states: Sequence[StickingResponse], section: Section, share: Array, pattern: Array, bears: Array
) -> Array | None:
    """Find the least grip with which all fingertips stick: (k,) grip forces [N]; None: there is none.

    states : under each load. share (nv,) : s [N·m]. pattern (k, p) : the grip is a combination ≥ 0 of these columns.
    bears (n,) : the largest normal force at each contact [N].
    """
    p = pattern.shape[1]
    unit = max(float(np.linalg.norm(s.scene.geometry.wrench[:3])) for s in states) or 1.0
    above, most = list[Array](), list[Array]()
    after_squeeze = states[0].by_grip, states[0].unloaded, states[0]
    for by_grip, rest, state in (after_squeeze, *((s.by_grip, s.rest, s) for s in states)):
        at = by_grip @ pattern
        cone = _cone_rows(state.scene, section)
        torque, held = state.levers @ at, state.levers @ rest + state.bias_torque
        above += [np.column_stack([-cone @ at * unit, np.zeros((len(cone), 2))])]
        none = np.zeros(len(share))
        above += [np.column_stack([way * torque * unit, none, -share]) for way in (1.0, -1.0)]
        most += [cone @ rest, -held, held]
        normals = [own[0] for own in state.scene.kind.contact_components]
        some = [k for k, number in enumerate(normals) if number >= 0 and np.isfinite(bears[k])]
        rows = [normals[k] for k in some]
        above.append(np.column_stack([at[rows] * unit, np.zeros((len(rows), 2))]))
        most.append(bears[some] - rest[rows])
    above.append(np.column_stack([pattern, -np.ones(len(pattern)), np.zeros(len(pattern))]))  # the largest of the grip
    most.append(np.zeros(len(pattern)))
    size = max(float(abs(b).max(initial=0.0)) for b in most) or 1.0
    cost = np.append(np.full(p + 1, _GRIP_WEIGHT), 1.0)
    found = scipy.optimize.linprog(
        cost, np.vstack(above), np.concatenate(most), bounds=[(0.0, None)] * (p + 2), method="highs"
    )
    if found.x is None or not found.x[:p].max(initial=0.0) * unit < 1e6 * size:
        return None
    return np.asarray(pattern @ found.x[:p] * unit)


def _cone_rows(scene: Scene, section: Section) -> Array:
    """Rows A with A r ≥ 0 for forces (c,) within friction, on faces inside the cones."""
    rows = list[Array]()
    for own, radius in zip(scene.kind.contact_components, scene.friction_coefficients(section), strict=True):
        if own[0] < 0:
            continue
        ways, inside = _face_normals(int((own >= 0).sum()) - 1)
        for way in ways:
            row = np.zeros(scene.components)
            row[own[0]] = radius * inside
            row[own[1 : 1 + len(way)]] = -way
            rows.append(row)
    return np.array(rows).reshape(-1, scene.components)


def _face_normals(tangents: int) -> tuple[Array, float]:
    """Unit normals of faces in so many tangential directions, and how far inside the unit ball they lie."""
    if tangents == 0:
        return np.zeros((1, 0)), 1.0
    if tangents == 1:
        return np.array([[1.0], [-1.0]]), 1.0
    if tangents == 2:
        angle = 2 * np.pi * np.arange(_CONE_FACES) / _CONE_FACES
        return np.column_stack([np.cos(angle), np.sin(angle)]), float(np.cos(np.pi / _CONE_FACES))
    k = np.arange(_LIMIT_SURFACE_FACES) + 0.5
    height, turn = 1.0 - 2.0 * k / _LIMIT_SURFACE_FACES, np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - height**2)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height]), 0.95


# ----------------------------------------------------------------
# Which motors does a brief take? The torque of each joint, with the grip that needs least, checked before it is said.
#
# Every load of the brief times the safety factor is followed from the first touch: the hand closes without torque
# limits, then the load comes. The grip is searched for with which all of them hold and the largest torque is least.
# What the joints then need, at any time, becomes their torque limits, and `check` has to call every load HELD.

_LIMIT_MARGIN = 1e-6  # of a torque, so that rounding puts none over its limit


def find_required_torque(
    spec: GraspSpec, section: Section, loads: Any, safety: Any, tolerance: Any, progress: Callable[[int], object],
    most_force: Any,
) -> RequiredTorque:  # fmt: skip
    """Find the torques that the joints need, as `HandGrasp.required_torque` documents."""
    near = check_tolerance(tolerance)
    brief, hand = read_load_cases(spec, loads, safety), hand_mechanism(spec)
    known = bool(np.isfinite(hand.limits).all())
    share = hand.limits if known else np.ones(len(hand.names))
    of_drives = hand.posture.hand.dry_friction - hand.posture.hand.joint_friction
    bears = check_most_force(most_force, spec)
    trials = GripTrials(brief, section, share, of_drives, bears, progress)
    best, fails = search_least_grip(trials, start_grips(brief, section, share, bears), near)
    nv = len(hand.names)
    torque, closing, held = np.full((3, nv), np.nan)
    verdicts, tensions = dict[str, Verdict](), None
    if best.is_held:
        closed = {case.name: apply_grip_force(case.spec, best.force) for case in brief}
        paths = [follow(one, section, None, LOADING_ORDER, None, STEPS_PER_STAGE, None) for one in closed.values()]
        seen = [abs(path.steps.torques).max(axis=0) for path in paths]
        torque = np.max([best.largest_torque, *seen], axis=0) * (1.0 + _LIMIT_MARGIN)
        torque = np.maximum(torque, _LIMIT_MARGIN * torque.max(initial=_LIMIT_MARGIN))
        pulled = [closing_torque(of_drives, path) for path in paths]
        closing = np.max([best.squeeze, *pulled], axis=0) * (1.0 + _LIMIT_MARGIN)
        ends = np.max([abs(path.steps.torques[-1]) for path in paths], axis=0) * (1.0 + _LIMIT_MARGIN)
        held = np.minimum(torque, ends)
        tensions = _required_tensions(hand.posture.hand.stiffness, hand.names, paths)
        verdicts = {name: verdict_on(with_torque_limits(one, torque), section) for name, one in closed.items()}
    names = tuple([case.name for case in brief])
    grip = dict(zip(hand.fingertips, best.force.tolist(), strict=True))
    limits = hand.posture.hand.torques
    less = None if fails is None else float(fails.force.max() / best.force.max())
    lost = best.lost or (None if fails is None else fails.lost)
    reasons = {
        name: "; ".join([r.sentence for r in v.reasons if r.severity == "decides"])
        for name, v in verdicts.items()
        if v.word != HELD
    }
    sized = tuple(["squeeze" if k < 0 else names[k] for k in best.sizing_load.tolist()])
    return RequiredTorque(
        hand.names, read_only(torque), read_only(closing), read_only(held), grip, sized, names, read_only(best.torque),
        float(safety), limits.limits, limits.known, {name: v.word for name, v in verdicts.items()}, less, lost, reasons,
        limits.drives, tensions, hand.posture.hand.sliding,
    )  # fmt: skip


def _required_tensions(
    stiffness: Elasticity, joints: Sequence[str], paths: Sequence[Loading]
) -> RequiredTension | None:
    """What tendons pull with along these paths; None without tendons."""
    if not isinstance(stiffness, TendonStiffness) or not paths:
        return None
    every = (1.0 + _LIMIT_MARGIN) * np.concatenate([path.steps.tensions for path in paths])
    least = (1.0 + _LIMIT_MARGIN) * np.array([state.pull.taut for path in paths for state in path.steps.states])
    ends = np.cumsum([len(path.steps.states) for path in paths]) - 1
    drives = stiffness.drives
    own = np.array([False if drives is None else drives.motors[i] is not None for i in range(len(stiffness.names))])
    moved = tuple([joints[j] for j in np.flatnonzero(stiffness.arms[own].any(axis=0)).tolist()])
    most, held = every.max(axis=0, initial=0.0), every[ends].max(axis=0, initial=0.0)
    least = least.min(axis=0)
    return RequiredTension(stiffness.cables.names, read_only(most), read_only(held), read_only(least), moved, drives)


def start_grips(brief: tuple[LoadCase, ...], section: Section, share: Array, bears: Array) -> list[Array]:
    """Grips (k,) [N] to search from, with which nothing slips, by finger and common to all; or of the loads' size."""
    states = [sticking_response(case.spec, apply_grip_force) for case in brief]
    k = brief[0].spec.of_hand
    found = [minimise_grip(states, section, share, pattern, bears) for pattern in (np.eye(k), np.ones((k, 1)))]
    some = [force for force in found if force is not None and force.any()]
    size = max([float(np.linalg.norm(case.spec.wrench[:3])) for case in brief])
    return some or [np.full(k, (size or 1.0) / k)]


# ----------------------------------------------------------------
# How hard must the hand close? The least grip or squeeze, common to all fingers, with which a grasp holds.

_MAX_STICKING_GRIP_FACTOR = 256.0  # the grip with which nothing slips: the most that is tried
_MAX_SQUEEZE, _FIRST_SQUEEZE = 0.05, 1e-3  # [m] of a squeeze


def find_required_grip(spec: GraspSpec, section: Section, tolerance: Any, most_force: Any) -> Required:
    """Find the least grip force that holds, as `HandGrasp.required_grip` documents."""
    k, bears = spec.of_hand, check_most_force(most_force, spec)
    share, any_force = np.ones(len(hand_mechanism(spec).names)), np.full(len(bears), np.inf)
    start = float(start_grips((LoadCase("", spec),), section, share, any_force)[-1].mean())
    changed = ChangedGrasp(lambda force: apply_grip_force(spec, np.full(k, force)), section)
    return find_least_value(changed, start, _MAX_STICKING_GRIP_FACTOR * start, check_tolerance(tolerance), "N", bears)


def find_required_squeeze(spec: GraspSpec, section: Section, tolerance: Any, most_force: Any) -> Required:
    """Find the least squeeze that holds, as `HandGrasp.required_squeeze` documents."""
    bears = check_most_force(most_force, spec)
    changed = ChangedGrasp(lambda depth: apply_command(spec, depth, None, None), section)
    return find_least_value(changed, _FIRST_SQUEEZE, _MAX_SQUEEZE, check_tolerance(tolerance), "m", bears)
