"""Which motors does a brief take? The torque of each joint, with the grip that needs least, checked before it is said.

Every load of the brief times the safety factor is followed from the first touch: the hand closes without torque limits,
then the load comes. The grip is searched for with which all of them hold and the largest torque is least. What the
joints then need, at any time, becomes their torque limits, and `check` has to call every load HELD.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.analysis.required import Required, tolerance_of
from handlcp.grasp.answer.verdict import HELD, Verdict
from handlcp.grasp.assembly.build import build
from handlcp.grasp.design.least import ORDER, Changed, least_value, verdict_on
from handlcp.grasp.design.pressed import most_forces
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.torque_limits import with_limits
from handlcp.grasp.path.follow import Loading
from handlcp.grasp.tangent.solutions import without_slip
from handlcp.grasp.verdict.check import followed_to
from handlcp.hand.command import commanded, gripped
from handlcp.hand.design.motors import Case, RequiredTorque, cases
from handlcp.hand.design.sizes import RequiredTension
from handlcp.hand.design.trials import Trial, Trials, closing_beside, least
from handlcp.hand.elasticity.elasticity import Elasticity
from handlcp.hand.elasticity.tendon_stiffness import TendonStiffness
from handlcp.hand.mechanism import hand_of

# ----------------------------------------------------------------
# Contact forces where nothing slips and nothing opens: linear in the grip and in the load.
#
# d = d₀ + D f
#
# with the grip forces f (k,) that are commanded. While all contacts stick, the path of forces from squeeze to load is a
# straight line. Where it stays within friction it is the answer, whatever the order of the loading.


@dataclass(frozen=True, slots=True, eq=False)
class Sticking:
    """Forces r = by_grip f + rest in the laws' coordinates (c,), and torques τ = levers r + held (nv,) [N·m].

    scene : without a command. by_grip (c, k) : one column a finger. rest (c,) : without a grip, under the load;
    unloaded (c,) : without the load, too.
    """

    scene: Scene
    by_grip: Array
    rest: Array
    unloaded: Array
    levers: Array
    held: Array


def sticking(spec: GraspSpec, gripped: Callable[[GraspSpec, Array], GraspSpec]) -> Sticking:
    """Of this grasp under its load. gripped : the grasp with grip forces (k,) [N]; 0 for none."""
    k = spec.of_hand
    bare = build(gripped(spec, np.zeros(k)))
    shifts = [build(gripped(spec, row)).offset - bare.offset for row in np.eye(k)]
    loads = np.zeros((6, 2 + k))
    loads[:, 0] = bare.geometry.wrench
    r, _ = without_slip(bare, bare.flexibility, np.column_stack([bare.offset, bare.offset, *shifts]), loads)
    mechanism, scale = bare.mechanism, 1.0 if bare.scale is None else bare.scale
    assert mechanism is not None
    return Sticking(bare, r[:, 2:], r[:, 0], r[:, 1], mechanism.rows(bare.soft).T * scale, bare.held_torque)


# ----------------------------------------------------------------
# The grip of each finger with which no fingertip slips and the motors need least: a linear program.
#
# least t    with    |τ| ≤ t s,    r within friction,    r_N ≤ most    after the squeeze and under every load
#
# r and τ are linear in the grip forces (above), and s says what counts as much as what: the torque limits, or
# one newton metre for every joint. It knows neither slips nor motions of the hand. So it is where the search for the
# least grip begins, not its answer.

_DIRECTIONS = 16  # faces of a friction cone in a tangent plane
_BALL = 64  # faces of a soft finger's limit surface
_SMALL = 1e-6  # weight of the grip's sum and of its largest: among grips with the same torques the gentlest, evenly


def least_grip(
    states: Sequence[Sticking], section: Section, share: Array, pattern: Array, bears: Array
) -> Array | None:  # fmt: skip
    """(k,) grip forces [N]; None: with no such grip all fingertips stick.

    states : under each load. share (nv,) : s [N·m]. pattern (k, p) : the grip is a combination ≥ 0 of these columns.
    bears (n,) : the largest normal force at each contact [N].
    """
    from scipy.optimize import linprog  # half a second of import that only this question should pay

    p = pattern.shape[1]
    unit = max(float(np.linalg.norm(s.scene.geometry.wrench[:3])) for s in states) or 1.0
    above, most = list[Array](), list[Array]()
    for by_grip, rest, state in _ends(states):
        at = by_grip @ pattern
        cone = _cone(state.scene, section)
        torque, held = state.levers @ at, state.levers @ rest + state.held
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
    cost = np.append(np.full(p + 1, _SMALL), 1.0)
    found = linprog(cost, np.vstack(above), np.concatenate(most), bounds=[(0.0, None)] * (p + 2), method="highs")
    if found.x is None or not found.x[:p].max(initial=0.0) * unit < 1e6 * size:
        return None
    return np.asarray(pattern @ found.x[:p] * unit)


def _ends(states: Sequence[Sticking]) -> list[tuple[Array, Array, Sticking]]:
    """(by_grip, rest, state) after the squeeze, and under every load."""
    return [(states[0].by_grip, states[0].unloaded, states[0]), *((s.by_grip, s.rest, s) for s in states)]


def _cone(scene: Scene, section: Section) -> Array:
    """Rows A with A r ≥ 0 for forces (c,) within friction, on faces inside the cones."""
    rows = list[Array]()
    for own, radius in zip(scene.kind.contact_components, scene.limits(section), strict=True):
        if own[0] < 0:
            continue
        ways, inside = _faces(int((own >= 0).sum()) - 1)
        for way in ways:
            row = np.zeros(scene.components)
            row[own[0]] = radius * inside
            row[own[1 : 1 + len(way)]] = -way
            rows.append(row)
    return np.array(rows).reshape(-1, scene.components)


def _faces(tangents: int) -> tuple[Array, float]:
    """Unit normals of faces in so many tangential directions, and how far inside the unit ball they lie."""
    if tangents == 0:
        return np.zeros((1, 0)), 1.0
    if tangents == 1:
        return np.array([[1.0], [-1.0]]), 1.0
    if tangents == 2:
        angle = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
        return np.column_stack([np.cos(angle), np.sin(angle)]), float(np.cos(np.pi / _DIRECTIONS))
    k = np.arange(_BALL) + 0.5
    height, turn = 1.0 - 2.0 * k / _BALL, np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - height**2)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height]), 0.95


# ----------------------------------------------------------------

_ROUNDED_UP = 1e-6  # of a torque, so that rounding puts none over its limit


def required_torque(
    spec: GraspSpec, section: Section, loads: Any, safety: Any, tolerance: Any,
    progress: Callable[[int], object] | None = None, most_force: Any = None,
) -> RequiredTorque:  # fmt: skip
    """See `HandGrasp.required_torque`."""
    near = tolerance_of(tolerance)
    brief, hand = cases(spec, loads, safety), hand_of(spec)
    known = bool(np.isfinite(hand.limits).all())
    share = hand.limits if known else np.ones(len(hand.names))
    of_drives = hand.posture.hand.dry_friction - hand.posture.hand.joint_friction
    bears = most_forces(most_force, spec)
    trials = Trials(brief, section, share, of_drives, bears, progress)
    best, fails = least(trials, starts(brief, section, share, bears), near)
    nv = len(hand.names)
    torque, closing, held = np.full((3, nv), np.nan)
    verdicts, tensions = dict[str, Verdict](), None
    if best.holds:
        # What `check` follows has more steps where fewer would end elsewhere, and may see a little more
        paths = [followed_to(gripped(case.spec, best.force), section, ORDER)[0] for case in brief]
        seen = [abs(path.steps.torques).max(axis=0) for path in paths]
        torque = np.max([best.largest, *seen], axis=0) * (1.0 + _ROUNDED_UP)
        torque = np.maximum(torque, _ROUNDED_UP * torque.max(initial=_ROUNDED_UP))
        pulled = [closing_beside(of_drives, path) for path in paths]
        closing = np.max([best.squeeze, *pulled], axis=0) * (1.0 + _ROUNDED_UP)
        held = np.minimum(torque, np.max([abs(path.steps.torques[-1]) for path in paths], axis=0) * (1.0 + _ROUNDED_UP))
        tensions = _tensions(hand.posture.hand.stiffness, hand.names, paths)
        verdicts = {case.name: _judged(case, best, torque, section) for case in brief}
    names = tuple([case.name for case in brief])
    grip = dict(zip(hand.fingertips, best.force.tolist(), strict=True))
    limits = hand.posture.hand.torques
    less = None if fails is None else float(fails.force.max() / best.force.max())
    lost = best.lost or (None if fails is None else fails.lost)
    sized = tuple(["squeeze" if k < 0 else names[k] for k in best.worst.tolist()])
    return RequiredTorque(
        hand.names, read_only(torque), read_only(closing), read_only(held), grip, sized, names,
        read_only(best.torque), float(safety), limits.limits, limits.known,
        {name: v.word for name, v in verdicts.items()}, less, lost,
        {name: _why(v) for name, v in verdicts.items() if v.word != HELD}, limits.drives, tensions,
        hand.posture.hand.sliding,
    )  # fmt: skip


def _tensions(stiffness: Elasticity, joints: Sequence[str], paths: Sequence[Loading]) -> RequiredTension | None:
    """What tendons pull with along these paths; None without tendons."""
    if not isinstance(stiffness, TendonStiffness) or not paths:
        return None
    every = (1.0 + _ROUNDED_UP) * np.concatenate([path.steps.tensions for path in paths])
    least = (1.0 + _ROUNDED_UP) * np.array([state.pull.taut for path in paths for state in path.steps.states])
    ends = np.cumsum([len(path.steps.states) for path in paths]) - 1
    drives = stiffness.drives
    own = np.array([False if drives is None else drives.of[i] is not None for i in range(len(stiffness.names))])
    moved = tuple([joints[j] for j in np.flatnonzero(stiffness.arms[own].any(axis=0)).tolist()])
    return RequiredTension(
        stiffness.cables.names, read_only(every.max(axis=0, initial=0.0)),
        read_only(every[ends].max(axis=0, initial=0.0)), read_only(least.min(axis=0)), moved, drives,
    )  # fmt: skip


def starts(brief: tuple[Case, ...], section: Section, share: Array, bears: Array) -> list[Array]:
    """Grips (k,) [N] to search from: those with which nothing slips, by finger and common to all; and in any case one
    of the size of the loads.
    """
    states = [sticking(case.spec, gripped) for case in brief]
    k = brief[0].spec.of_hand
    found = [least_grip(states, section, share, pattern, bears) for pattern in (np.eye(k), np.ones((k, 1)))]
    some = [force for force in found if force is not None and force.any()]
    size = max([float(np.linalg.norm(case.spec.wrench[:3])) for case in brief])
    return some or [np.full(k, (size or 1.0) / k)]


def _why(verdict: Verdict) -> str:
    """What keeps it from being HELD."""
    return "; ".join([r.sentence for r in verdict.reasons if r.severity == "decides"])


def _judged(case: Case, best: Trial, torque: Array, section: Section) -> Verdict:
    """The grasp with this grip and these motors under one load."""
    return verdict_on(with_limits(gripped(case.spec, best.force), torque), section)


# ----------------------------------------------------------------
# How hard must the hand close? The least grip or squeeze, common to all fingers, with which a grasp holds.

_TIMES = 256.0  # the grip with which nothing slips: the most that is tried
_DEEPEST, _START = 0.05, 1e-3  # [m] of a squeeze


def required_grip(spec: GraspSpec, section: Section, tolerance: Any, most_force: Any) -> Required:
    """See `HandGrasp.required_grip`."""
    k, bears = spec.of_hand, most_forces(most_force, spec)
    share, any_force = np.ones(len(hand_of(spec).names)), np.full(len(bears), np.inf)
    start = float(starts((Case("", spec),), section, share, any_force)[-1].mean())
    changed = Changed(lambda force: gripped(spec, np.full(k, force)), section)
    return least_value(changed, start, _TIMES * start, tolerance_of(tolerance), "N", bears)


def required_squeeze(spec: GraspSpec, section: Section, tolerance: Any, most_force: Any) -> Required:
    """See `HandGrasp.required_squeeze`."""
    bears = most_forces(most_force, spec)
    changed = Changed(lambda depth: commanded(spec, depth, None, None), section)
    return least_value(changed, _START, _DEEPEST, tolerance_of(tolerance), "m", bears)
