"""`PathModel`: what a path reads of its grasp, and what it reads of a state: how near contacts are to a change, how far
they slid, the error of a step, what is over a limit.

A path is written once. Where all of a grasp is known in closed form it is one compiled call; where its user brings
something in Python (a geometry, an effect with limits), the same functions run as Python, and what brings it
(`PathModel.own`) takes the place of the functions that it has.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.model.status import SEPARATED, SLIDING, STICKING, PathStatus
from handlcp.grasp.path.joint_system import (
    JOINT_ROUNDING,
    MAX_MODE_TRIALS,
    begin_trial,
    joint_springs,
    joints_of_task,
    move_free_joints,
    read_joint_state,
)
from handlcp.grasp.path.linearise import (
    Placed,
    Poses,
    linearise,
    new_contacts,
    place_between,
    placed_contacts,
    pose_difference,
    pose_displacement,
    read_place,
    slip_between,
)
from handlcp.grasp.path.solve_step import (
    PARTS,
    SETTLED,
    Sizes,
    StateArrays,
    StepModel,
    StepOptions,
    is_loaded,
    joint_task,
    largest_change,
    pose_distance,
    preload_offsets,
    read_part,
    read_state,
    rubbing,
    solve_step,
    write_tendons,
)
from handlcp.lcp.compiler.kernel import Kernel
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import OVER_LIMIT_TOLERANCE

F = TypeVar("F", bound=Callable[..., Any])

OPEN, STICKS, SLIDES = float(SEPARATED), float(STICKING), float(SLIDING)
_AT_LIMIT = 1e-10  # of a contact's friction: with no more left it is at its limit
PENDING = -2  # what a search for a state returns that Python is to make: the call is made again with its answer
_NO_FORCES = int(PathStatus.NO_FORCES)


class ModelKernel(Kernel):
    """A kernel whose first argument is a path's model: compiled, unless that brings something in Python."""

    def __call__(self, model: PathModel | PathSteps, *args: Any) -> Any:
        """Run it, or what the model has in its place."""
        if model.own is None:
            return self.interpret(model, *args) if self.is_inner else self.run(model, *args)
        own = getattr(model.own, self.function.__name__, None)
        return self.function(model, *args) if own is None else own(*args)


class _StepsKernel(ModelKernel):
    """One of `PathSteps`, which Python has none of: Python calls it as Python."""

    is_inner = True


def model_kernel(function: F) -> F:
    """Compile a function of a `PathModel`, as `kernel` does."""
    return cast(F, ModelKernel(function))


def steps_kernel(function: F) -> F:
    """Compile a function of `PathSteps`, as `kernel` does."""
    return cast(F, _StepsKernel(function))


class FrictionArrays(NamedTuple):
    """Of contacts. coefficients (n,); lever (n,) : 1 / e of soft ones [1/m], 0 of others; soft (k,) : which those are;
    scale (c,) : of the laws' coordinates; faces : 0 of round sets; flat (f, 2), soft_flat (g, 3) : normals of the
    faces.
    """

    coefficients: Array
    lever: Array
    soft: Ints
    scale: Array
    faces: int
    flat: Array
    soft_flat: Array


class LimitArrays(NamedTuple):
    """As in `StateLimits`. inverse_efforts (nv + t,), lower, upper, inverse_spans (nv,), motion (2,)."""

    inverse_efforts: Array
    lower: Array
    upper: Array
    inverse_spans: Array
    motion: Array


class PathReader(NamedTuple):
    """What is read of the states of a path. state : where the parts of a state's row begin. damper (6,) : as in
    `StepModel`. freedom (dof, 6) : as in `Laws`. limits : torques, tensions and ranges that are watched. near : gaps up
    to this are none [m]. max_slip (n,) [m]. springs (2, nv) : torque of springs beside drives at q = 0, and its rate.
    noise : of the geometry.
    """

    poses: Poses
    state: Ints
    sizes: Sizes
    damper: Array
    friction: FrictionArrays
    freedom: Array
    limits: LimitArrays
    near: float
    max_slip: Array
    springs: Array
    noise: float


class PathModel(NamedTuple):
    """A grasp as a path is given it. own : what is Python of it; None: nothing. step : a `StepModel`, all that compiled
    steps read; None: they are Python.
    """

    own: Any
    step: Any
    read: PathReader


class PathSteps(NamedTuple):
    """The same within compiled code, where each function would be handed hundreds of numbers anew, of all arrays of a
    step: steps (1,) : a list, which is handed on as one.
    """

    own: Any
    steps: list[Any]
    read: PathReader


# ----------------------------------------------------------------
# Steps: what a model may have its own way of.


@steps_kernel
def take_step(
    m: PathSteps, before: Array, controls: Array, guess: Array, start: Array, asked: StepOptions, row: Array
) -> int:
    """Write the state under other controls, as `solve_step`."""
    return solve_step(m.steps[0], before, controls, guess, start, asked, row)


@steps_kernel
def move_unloaded(m: PathSteps, before: Array, controls: Array, row: Array) -> int:
    """Write a state in which no contact carries anything and nothing pulls the object: fingers go where they are
    commanded, and the object stays. What overlaps by no more than just touches presses nothing: the forces of so little
    would be those of rounding. As `solve_step` returns it.
    """
    s, poses = m.steps[0], m.read.poses
    pulls = controls[8] == 0.0 and controls[6] != 0.0 and s.weight.any()
    if pulls or controls[:6].any() or s.rules.laws.sags != 0.0 or not poses.follows:
        return _NO_FORCES
    old, end = read_state(before, m.read.state), read_state(row, m.read.state)
    n = len(old.kinds)
    row[:] = 0.0
    was, stood, at = read_place(poses, old.where), read_place(poses, old.at), read_place(poses, end.where)
    at.q[:], at.pose[:] = s.posture + controls[9:], was.pose
    if s.rubs and not _move_joints(s, old, was.q, controls, at.q, end):
        return _NO_FORCES
    contacts = new_contacts(s.geometry)
    contacts.frames[:] = old.frames
    linearise(s.geometry, end.where, contacts)
    now = placed_contacts(contacts)
    earlier = Placed(old.positions, old.frames, old.axes, old.places, old.slips)
    slipped = slip_between(s.geometry, earlier, now, stood, at, old.slip_memory)
    offsets = preload_offsets(s.preloads, controls[7], old.controls[7])
    end.base[:] = slipped + offsets
    for i in range(n):
        end.base[i, 2] = contacts.touch.gap[i] + offsets[i, 2]
        if end.base[i, 2] < -s.preloads.touches:
            return _NO_FORCES
    end.at[:], end.since[:], end.motion[:] = end.where, slipped[:, 2], end.base
    end.positions[:], end.frames[:], end.axes[:] = now.positions, now.frames, now.axes
    end.places[:], end.slips[:], end.controls[:] = now.places, now.slips, controls
    end.spin[:] = slipped[:, 2]
    end.torque[:] = contacts.elastic.gravity
    return SETTLED


@kernel
def _move_joints(s: StepModel, old: StateArrays, begun: Array, controls: Array, q: Array, end: StateArrays) -> bool:
    """Write where joints that rub come to (nv,), commanded to q and from begun (nv,), and what they do there; whether
    their tendons can run there.
    """
    modes, friction, last, rests = old.modes.astype(np.int64), old.post_friction.copy(), begun.copy(), False
    here, step, fits = joints_of_task(joint_task(s, old, begun, controls, modes, friction, last))
    trial = begin_trial(here, modes, friction)
    for _ in range(MAX_MODE_TRIALS):
        free, settled = move_free_joints(here, step, trial, last)
        rests = settled and (len(here.arm_rates) == 0 or largest_change(free, last) <= JOINT_ROUNDING)
        if rests or not (settled and fits):
            break
        last[:] = free
        here, step, fits = joints_of_task(joint_task(s, old, begun, controls, modes, friction, last))
        trial = begin_trial(here, modes, friction)
    if rests:
        q[:] = free
    else:
        here, step, fits = joints_of_task(joint_task(s, old, begun, controls, modes, friction, q))
        trial = begin_trial(here, np.zeros(len(modes), np.int64), np.zeros(len(friction)))
        read_joint_state(here, joint_springs(here, trial), step, trial, q, np.zeros(len(q)))
    end.modes[:], end.post_friction[:] = trial.modes, trial.post_friction
    write_tendons(trial.drawn, trial.tension, trial.taut, end)
    rubbing(here, trial, end.rubs)
    return fits


# ----------------------------------------------------------------
# What a state says.


@kernel
def motion(m: PathReader, a: Array, b: Array) -> Array:
    """(6,) of the object from state a to state b: of its reference point [m], and turned [rad]."""
    before, after = read_part(a, m.state, PARTS.where), read_part(b, m.state, PARTS.where)
    return pose_difference(m.poses, read_place(m.poses, before).pose, read_place(m.poses, after).pose)


@kernel
def distance(m: PathReader, a: Array, b: Array) -> float:
    """How far the object is apart in two states, as a share of the contacts' distances from their centre."""
    return pose_distance(m.sizes.length, motion(m, a, b))


@kernel
def reach(m: PathReader, row: Array) -> float:
    """The farthest contact's distance from the reference, as a share of the same."""
    positions, farthest = read_part(row, m.state, PARTS.positions), 0.0
    moved = pose_displacement(m.poses, read_place(m.poses, read_part(row, m.state, PARTS.at)).pose)
    for i in range(len(m.max_slip)):
        square = 0.0
        for a in range(3):
            square += (positions[3 * i + a] - m.poses.reference[a] - (moved[a] if m.poses.follows else 0.0)) ** 2
        farthest = max(farthest, square)
    return math.sqrt(farthest) / m.sizes.length


@kernel
def largest_force(m: PathReader, row: Array) -> float:
    """Of all components [N]."""
    largest = 0.0
    for x in read_part(row, m.state, PARTS.forces):
        largest = max(largest, abs(x))
    return largest


@kernel
def any_slides(m: PathReader, row: Array) -> bool:
    """Whether a contact slides."""
    return bool((read_part(row, m.state, PARTS.kinds) == SLIDES).any())


@kernel
def carries(m: PathReader, row: Array) -> bool:
    """Whether a contact carries anything."""
    return is_loaded(read_part(row, m.state, PARTS.kinds))


@kernel
def slip_lengths(m: PathReader, state: Array, row: Array) -> Array:
    """(n,) how far contacts slid while they pressed in the step from a state to another one [m]. Of the way of one that
    opens in it counts as much as its normal force takes to fall to zero, if it falls as evenly as the gap grows.
    """
    forces, motion = read_part(state, m.state, PARTS.forces), read_part(row, m.state, PARTS.motion)
    kinds = read_part(row, m.state, PARTS.kinds)
    out = np.zeros(len(kinds))
    for i in range(len(out)):
        slid, pressed = math.hypot(motion[3 * i], motion[3 * i + 1]), forces[3 * i + 2]
        if kinds[i] == SLIDES:
            out[i] = slid
        elif kinds[i] == OPEN and pressed > 0.0:
            out[i] = slid * pressed / (pressed + m.sizes.stiffness * max(motion[3 * i + 2], 0.0))
    return out


@kernel
def margins(m: PathReader, row: Array) -> Array:
    """(n, 2) of each contact: how far it is from sliding and from opening, in newtons; below 0, what it has slid and
    opened in the step, as the force that would take it back.
    """
    kinds, forces = read_part(row, m.state, PARTS.kinds), read_part(row, m.state, PARTS.forces)
    motion, spin = read_part(row, m.state, PARTS.motion), read_part(row, m.state, PARTS.spin)
    k, f, shares = m.sizes.stiffness, m.friction, friction_shares(m, row)
    out = np.empty((len(kinds), 2))
    for i in range(len(out)):
        if kinds[i] == OPEN:
            out[i, 0], out[i, 1] = np.inf, -k * max(motion[3 * i + 2], 0.0)
            continue
        out[i, 1] = forces[3 * i + 2]
        if kinds[i] == SLIDES:
            slip = motion[3 * i] ** 2 + motion[3 * i + 1] ** 2 + (spin[i] * m.sizes.length) ** 2
            out[i, 0] = -k * math.sqrt(slip)
        else:
            _, used = _friction_used(f, i, shares[i])
            out[i, 0] = f.coefficients[i] * forces[3 * i + 2] * (1.0 - used) if used < 1.0 - _AT_LIMIT else 0.0
    return out


@kernel
def corner_margins(m: PathReader, state: Array, row: Array) -> Array:
    """(n,) how far friction that is on flat faces of its law in `state` is in another one from reaching a further
    face, in newtons; below 0 it is on that one; inf of other contacts.
    """
    f, kinds, forces = m.friction, read_part(state, m.state, PARTS.kinds), read_part(row, m.state, PARTS.forces)
    out = np.full(len(kinds), np.inf)
    if f.faces == 0:
        return out
    before, now = friction_shares(m, state), friction_shares(m, row)
    for i in range(len(out)):
        normals, on, off = _flat_faces(f, i), -np.inf, -np.inf
        _, used = _friction_used(f, i, before[i])
        if kinds[i] == OPEN or used < 1.0 - _AT_LIMIT:
            continue
        for j in range(len(normals)):
            along, then = _along(normals, j, before[i]), _along(normals, j, now[i])
            if along >= used - _AT_LIMIT:
                on = max(on, then)
            else:
                off = max(off, then)
        far = on - off if abs(on - off) > _AT_LIMIT else 0.0
        out[i] = f.coefficients[i] * forces[3 * i + 2] * far
    return out


@kernel
def friction_shares(m: PathReader, row: Array) -> Array:
    """(n, 3) friction as a share of its limit, along x, y and about z, in coordinates in which the laws are round;
    zeros where nothing presses.
    """
    n, start, f = len(m.max_slip), read_part(row, m.state, PARTS.start), m.friction
    out = np.zeros((n, 3))
    for i in range(n):
        for a in range(2):
            out[i, a] = start[3 * i + a]
    for k in range(len(f.soft)):
        out[f.soft[k], 2] = start[3 * n + k]
    for i in range(n):
        limit = f.coefficients[i] * start[3 * i + 2]
        for a in range(3):
            out[i, a] = out[i, a] / limit if limit > 0.0 else 0.0
    return out


@kernel
def has_plain_friction(m: PathReader) -> bool:
    """Whether every contact has Coulomb's law, the same along all tangents."""
    return len(m.friction.soft) == 0 and bool((m.friction.scale == 1.0).all())


@kernel
def on_same_face(m: PathReader, a: Array, b: Array) -> Bools:
    """(n,) whether friction, as `friction_shares` has it, lies on one flat face, on which slip does not turn."""
    f = m.friction
    out = np.zeros(len(a), np.bool_)
    for i in range(len(a)):
        if f.faces > 0:
            (at, _), (then, _) = _friction_used(f, i, a[i]), _friction_used(f, i, b[i])
            out[i] = at == then or f.faces == 2
    return out


@kernel
def _friction_used(f: FrictionArrays, i: int, x: Array) -> tuple[int, float]:
    """(the flat face that friction is nearest to, -1 of a round set; how much of its limit it is) of a contact whose
    friction is x (3,), as `friction_shares` has it.
    """
    if f.faces == 0:
        return -1, math.sqrt(x[0] ** 2 + x[1] ** 2 + x[2] ** 2)
    normals, best, most = _flat_faces(f, i), -1, -np.inf
    for j in range(len(normals)):
        along = _along(normals, j, x)
        if along > most:
            best, most = j, along
    return best, most


@kernel
def _flat_faces(f: FrictionArrays, i: int) -> Array:
    """(f, 2 or 3) normals of the flat faces of a contact's law."""
    return f.soft_flat if f.lever[i] > 0.0 and len(f.soft_flat) > 0 else f.flat


@kernel
def _along(normals: Array, j: int, x: Array) -> float:
    """How far x is along a normal."""
    far = 0.0
    for a in range(normals.shape[1]):
        far += normals[j, a] * x[a]
    return far


@kernel
def slip_toward(m: PathReader, direction: Array, row: Array) -> Array:
    """(n, 3) as long a slip as that of the step to a state, but along `direction` (n, 3), in the coordinates of
    `friction_shares`; along x and y [m] and about z [rad].
    """
    motion, spin, f = read_part(row, m.state, PARTS.motion), read_part(row, m.state, PARTS.spin), m.friction
    n = len(spin)
    out, scale = np.zeros((n, 3)), np.ones((n, 3))
    for i in range(n):
        for a in range(2):
            scale[i, a], out[i, a] = f.scale[3 * i + a], motion[3 * i + a] * f.scale[3 * i + a]
    for k in range(len(f.soft)):
        i = f.soft[k]
        scale[i, 2], out[i, 2] = f.scale[3 * n + k], spin[i] * f.scale[3 * n + k]
    for i in range(n):
        size, along = 0.0, 0.0
        for a in range(3):
            size += out[i, a] ** 2
            along += direction[i, a] ** 2
        long = math.sqrt(size / max(along, 1e-300))
        for a in range(3):
            out[i, a] = long * direction[i, a] / scale[i, a]
    return out


@kernel
def estimate_error(m: PathReader, state: Array, found: Array, earlier: Array, ratio: float) -> float:
    """Estimated error of the forces at the end of a step, as a share of the largest: friction opposes the slip at the
    end, whose direction is known to second order.

    earlier : the state before `state`; ratio : of this step and the one from there, 0 where that says nothing.
    """
    if not any_slides(m, found):
        return 0.0
    was, end = read_part(state, m.state, PARTS.kinds), read_part(found, m.state, PARTS.kinds)
    f, forces = m.friction, read_part(found, m.state, PARTS.forces)
    now, last = friction_shares(m, found), friction_shares(m, state)
    before = friction_shares(m, earlier) if ratio > 0.0 else last
    same, largest = on_same_face(m, now, last), 0.0
    for i in range(len(now)):
        if end[i] != SLIDES or was[i] != SLIDES or same[i]:
            continue
        turned, bends = 0.0, 0.0
        for a in range(3):
            turned += (now[i, a] - last[i, a]) ** 2
            bends += (now[i, a] - last[i, a] - ratio * (last[i, a] - before[i, a])) ** 2
        error = 0.5 * turned if ratio == 0.0 else math.sqrt(bends) / 3.0 + turned**1.5 / 4.0
        largest = max(largest, error * f.coefficients[i] * forces[3 * i + 2])
    return largest / max(largest_force(m, found), 1e-300)


# ----------------------------------------------------------------
# Limits, and what happens.


@kernel
def limit_shares(m: PathReader, limits: LimitArrays, at: Array, row: Array) -> Array:
    """Shares of the limits, as `failure_mode.limit_shares`: (nv + t,) of torques and tensions, (nv,) of ranges, 2 of
    the object's motion from `at` (6,) on. NaN where a torque is.
    """
    torque, tension = read_part(row, m.state, PARTS.torque), read_part(row, m.state, PARTS.tension)
    efforts, named, nv = len(limits.inverse_efforts), len(limits.lower), len(torque)
    place = read_place(m.poses, read_part(row, m.state, PARTS.where))
    q = place.q
    out = np.empty(efforts + named + 2)
    for j in range(efforts):
        effort = torque[j] + m.springs[0, j] + m.springs[1, j] * q[j] if j < nv else tension[j - nv]
        out[j] = abs(effort) * limits.inverse_efforts[j]
    for j in range(named):
        beyond = max(q[j] - limits.upper[j], limits.lower[j] - q[j])
        out[efforts + j] = beyond * limits.inverse_spans[j] + 1.0
    moved = pose_displacement(m.poses, place.pose) - at
    for part in range(2):
        square = 0.0
        for a in range(3):
            square += moved[3 * part + a] ** 2
        out[efforts + named + part] = math.sqrt(square) / limits.motion[part]
    return out


# Codes of what happens, each begun at an even number and undone at the next; names by code
OPENS, TOUCHES, SLIPS, STICKS_AGAIN, OVER, SLACK, YIELDS, RANGE = 0, 1, 2, 3, 4, 6, 8, 10


@kernel
def write_events(m: PathReader, a: Array, b: Array, out: Array) -> int:
    """Write (code, who) of what happens from one state to the next, into out (·, 2), as far as there is room. How many
    of them there are.
    """
    before, now, count = read_part(a, m.state, PARTS.kinds), read_part(b, m.state, PARTS.kinds), 0
    bare = read_part(a, m.state, PARTS.tally)[2] == 0.0  # a state without a solve says gaps in its base alone
    for i in range(len(now)):
        was, kind = before[i], now[i]
        if was == kind:
            continue
        gap = read_part(a, m.state, PARTS.base if bare else PARTS.motion)[3 * i + 2]
        if kind == OPEN:
            count = _note(out, count, OPENS, i)
        elif was == OPEN and gap > m.near:
            count = _note(out, count, TOUCHES, i)
        if kind == SLIDES:
            count = _note(out, count, SLIPS, i)
        elif kind == STICKS and was == SLIDES:
            count = _note(out, count, STICKS_AGAIN, i)
    limits, named = m.limits, len(m.limits.lower)
    if named == 0:
        return count
    efforts, none = len(limits.inverse_efforts), np.zeros(6)
    first, second = limit_shares(m, limits, none, a), limit_shares(m, limits, none, b)
    most = 1.0 + OVER_LIMIT_TOLERANCE
    for j in range(efforts):
        count = _note_change(out, count, OVER, j, first[j] > most, second[j] > most)
    slack, now_slack = read_part(a, m.state, PARTS.slack), read_part(b, m.state, PARTS.slack)
    for j in range(len(slack)):
        count = _note_change(out, count, SLACK, j, slack[j] != 0.0, now_slack[j] != 0.0)
    yielded, now_yielded = read_part(a, m.state, PARTS.yielded), read_part(b, m.state, PARTS.yielded)
    for j in range(named):
        count = _note_change(out, count, YIELDS, j, yielded[j] != 0.0, now_yielded[j] != 0.0)
    for j in range(named):
        k = efforts + j
        count = _note_change(out, count, RANGE, j, first[k] > most, second[k] > most)
    return count


@kernel
def _note(out: Array, count: int, code: int, who: int) -> int:
    if count < len(out):
        out[count, 0], out[count, 1] = code, who
    return count + 1


@kernel
def _note_change(out: Array, count: int, code: int, who: int, was: bool, now: bool) -> int:
    return count if was == now else _note(out, count, code if now else code + 1, who)


# ----------------------------------------------------------------
# Controls and guesses.


@kernel
def controls_between(begin: Array, end: Array, share: float) -> Array:
    """On the straight way from one to the other; commands that are the same stay so to the last bit: drives that stand
    still hold.
    """
    out, stands = np.empty(len(begin)), True
    for k in range(9, len(begin)):
        stands = stands and begin[k] == end[k]
    for k in range(len(begin)):
        if k == 8 or (k > 8 and stands):
            out[k] = end[k] if k == 8 else begin[k]
        else:
            out[k] = (1.0 - share) * begin[k] + share * end[k]
    return out


@kernel
def guess_between(m: PathReader, a: Array, b: Array, share: float) -> tuple[Array, Array]:
    """(configuration, start) that are expected at this share of the way from state a to state b, in a step from a; or,
    above 1, beyond b, in a step from b. Slip is that of the step, which is as long as its share; in a part of one in
    which slip may turn, on round laws, it is between those of both steps.
    """
    first, second = read_part(a, m.state, PARTS.where), read_part(b, m.state, PARTS.where)
    old, start = read_part(a, m.state, PARTS.start), read_part(b, m.state, PARTS.start).copy()
    where, motions, size = np.empty(len(first)), len(m.friction.scale) + 9, share if share <= 1.0 else share - 1.0
    place_between(m.poses, first, second, share, where)
    if read_part(a, m.state, PARTS.tally)[2] == read_part(b, m.state, PARTS.tally)[2]:
        for k in range(len(start)):
            i = k - motions
            slips = i >= 0 and (i % 3 < 2 or i >= 3 * len(m.max_slip)) and (share > 1.0 or m.friction.faces > 0)
            start[k] = size * start[k] if slips else old[k] + share * (start[k] - old[k])
    return where, start
