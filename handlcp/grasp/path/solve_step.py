"""`solve_step`: one quasi-static step of a path in one compiled call.

Newton's method on the laws at the end of the step: contacts looked at anew, the consistent tangent about them, one warm
solve; repeated until the contacts were looked at where the step ends. A state is a row of numbers (`StateRow`), and so
are controls: load (6,), weight, preload, whether the object is kept, command (nv,).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.model.status import SEPARATED, SLIDING, ContactStatus, PathStatus
from handlcp.grasp.path.joint_system import (
    MAX_MODE_TRIALS,
    JointSystem,
    JointTask,
    JointTrial,
    assume_anew,
    begin_trial,
    joint_command,
    joint_springs,
    joints_of_task,
    read_joint_state,
    tensioned_stiffness,
)
from handlcp.grasp.path.linearise import (
    GeometryArrays,
    Placed,
    linearise,
    move_pose,
    new_contacts,
    place_between,
    placed_contacts,
    pose_difference,
    pose_displacement,
    read_place,
    slip_between,
)
from handlcp.grasp.path.newton.answer import AnswerArrays, read_answer
from handlcp.grasp.path.newton.by_contact import iteration_by_contact
from handlcp.grasp.path.newton.iteration import one_iteration
from handlcp.grasp.path.newton.linear_solve import Rules
from handlcp.grasp.path.newton.numbers import Damping, Elastic, Loads, Situation
from handlcp.grasp.path.newton.row_layout import RowLayout
from handlcp.lcp import Auto
from handlcp.lcp.compiler.borrow import borrowed
from handlcp.lcp.kernels.dense import add_product, add_transposed, kernel

MAX_ITERATES = 9  # of one step, after which it counts as one that does not settle
KEPT = 1e6  # 1 / h of the object alone, where something keeps it in place: it gives way by a millionth of the fingers
NO_FORCE = 3e-9  # of a force that moves a finger by the contacts' distance: a smaller one may come from the damper
SEED = int(Auto().seed)
_HELD_BACK = 1e-6  # of the forces: where the damper takes more, it holds the object, and the contacts do not
_CREEPS = 1e-3  # of the load that comes in a step: where the damper takes more, the object moves on without more load
_CONTRACTS, _PARTS = 0.6, 1.5  # times the last miss: more ends the iterates from the fourth on, and any iterate
_LARGEST = 0.1  # motion in one step, as a share of the contacts' radii
CLOSE = 1e-3  # of the forces: an answer this near to what was expected is the one that continues it
_LEAST = 0.2  # of the way from an iterate to its end
PRESSED = (16.0, 8.0, 4.0, 3.0, 2.0, 1.7, 1.4, 1.2, 1.1, 1.0)  # times friction as it is
SETTLED = int(PathStatus.REACHED)  # what a step returns that has an end
GOES_ON = -1  # one that needs another iterate
_NO_FORCES, _TOO_FAR = int(PathStatus.NO_FORCES), int(PathStatus.TOO_FAR)
_RUNS_AWAY = int(PathStatus.RUNS_AWAY)
_OPEN, _SLIDES, _GLIDES = int(SEPARATED), int(SLIDING), int(ContactStatus.GLIDING)


class Preloads(NamedTuple):
    """What preloads and offsets put between object and fingertips. given (n, 3) [m] : at preload 1; fades (n,) [m] :
    what fades in with the squeeze, of overlaps and of gaps that just touch. acts : whether there is anything. touches
    [m] : gap or overlap of contacts that just touch.
    """

    given: Array
    fades: Array
    acts: bool
    touches: float


class Sizes(NamedTuple):
    """Of a grasp, by which steps are judged. length [m] : of contacts from their centre; stiffness [N/m]; tolerance :
    how far the end of a step may be from where its contacts were looked at, as a share of their radii; slow : h of a
    quasi-static step.
    """

    length: float
    stiffness: float
    tolerance: float
    slow: float


class StepModel(NamedTuple):
    """All that the steps of a grasp have in common. posture (nv,) : from which commands are counted; weight (3,) [N];
    damper (6,) : D, of a step with h = 1. by_contact : whether contacts are eliminated one by one. rubs : whether
    joints do more than give way, as joints and joint_layout say (`pack_joints`). state, answer : where the parts of
    their rows begin.
    """

    geometry: GeometryArrays
    rules: Rules
    preloads: Preloads
    posture: Array
    weight: Array
    damper: Array
    sizes: Sizes
    by_contact: bool
    rubs: bool
    joints: Array
    joint_layout: Ints
    state: Ints
    answer: Ints


class StepOptions(NamedTuple):
    """Of a step, as in `Stepper.step`: h of its damper, rough, past (n, 3), slow_pads."""

    h: float
    rough: float
    past: Array
    slow_pads: bool


# ----------------------------------------------------------------
# A state as a row.


class StateRow(RowLayout):
    """Where the numbers of a state stand in their row. n contacts, nv joints, c force components, dof : of the object;
    pose : numbers of its pose; m posts and t tendons of joints that do more than give way, or none of this.
    """

    def __init__(self, n: int, nv: int, c: int, dof: int, pose: int, joints: tuple[int, int] | None) -> None:
        m, t = joints or (0, 0)
        modes = 0 if joints is None else nv + m + t
        shapes: dict[str, tuple[int, ...]] = {
            "where": (nv + 4 * n + pose,), "at": (nv + 4 * n + pose,), "positions": (n, 3), "frames": (n, 3, 3),
            "axes": (n, 3, 3), "places": (n, 3), "slips": (n, 3), "base": (n, 3), "since": (n,),
            "slip_memory": (n, 3), "forces": (n, 3), "motion": (n, 3), "torsion": (n,), "spin": (n,), "torque": (nv,),
            "deflection": (nv,), "kinds": (n,), "start": (2 * c + 9,), "met": (dof, dof), "controls": (9 + nv,),
            "tally": (4,), "tension": (t,), "slack": (t,), "yielded": (nv,), "modes": (modes,),
            "post_friction": (m,), "drawn": (t,), "taut": (t,), "rubs": (nv,),
        }  # fmt: skip
        super().__init__(shapes)


class StateArrays(NamedTuple):
    """A state: views into its row, in this order. where : its configuration; at : that of the contacts as the step was
    solved with them, of which positions to slips tell where they were (`Placed`). base (n, 3), since (n,) : of `Loads`.
    tally (4,) : of iterates; 1 where `met` was measured; 1 where there is a start; the number that Python knows the
    state by. tension, slack (t,) : of tendons; modes to taut : as in `Pull`; yielded, rubs (nv,) : as in `State`, and
    so is all else.
    """

    where: Array
    at: Array
    positions: Array
    frames: Array
    axes: Array
    places: Array
    slips: Array
    base: Array
    since: Array
    slip_memory: Array
    forces: Array
    motion: Array
    torsion: Array
    spin: Array
    torque: Array
    deflection: Array
    kinds: Array
    start: Array
    met: Array
    controls: Array
    tally: Array
    tension: Array
    slack: Array
    yielded: Array
    modes: Array
    post_friction: Array
    drawn: Array
    taut: Array
    rubs: Array


PARTS: Any = StateArrays(*range(len(StateArrays._fields)))  # the number of each part of a row


@kernel
def read_part(row: Array, s: Ints, part: int) -> Array:
    """One part of a row, flat: a view that costs a twentieth of all of them. s : where they begin."""
    return row[s[part] : s[part + 1]]


@kernel
def read_state(row: Array, s: Ints) -> StateArrays:
    """The parts of a row; s : where they begin."""
    n = (s[3] - s[2]) // 3
    dof = 6
    while dof * dof > s[19] - s[18]:
        dof -= 1
    return StateArrays(
        row[s[0] : s[1]],
        row[s[1] : s[2]],
        row[s[2] : s[3]].reshape(n, 3),
        row[s[3] : s[4]].reshape(n, 3, 3),
        row[s[4] : s[5]].reshape(n, 3, 3),
        row[s[5] : s[6]].reshape(n, 3),
        row[s[6] : s[7]].reshape(n, 3),
        row[s[7] : s[8]].reshape(n, 3),
        row[s[8] : s[9]],
        row[s[9] : s[10]].reshape(n, 3),
        row[s[10] : s[11]].reshape(n, 3),
        row[s[11] : s[12]].reshape(n, 3),
        row[s[12] : s[13]],
        row[s[13] : s[14]],
        row[s[14] : s[15]],
        row[s[15] : s[16]],
        row[s[16] : s[17]],
        row[s[17] : s[18]],
        row[s[18] : s[19]].reshape(dof, dof),
        row[s[19] : s[20]],
        row[s[20] : s[21]],
        row[s[21] : s[22]],
        row[s[22] : s[23]],
        row[s[23] : s[24]],
        row[s[24] : s[25]],
        row[s[25] : s[26]],
        row[s[26] : s[27]],
        row[s[27] : s[28]],
        row[s[28] : s[29]],
    )


# ----------------------------------------------------------------
# The step.


@kernel
def solve_step(
    m: StepModel, before: Array, controls: Array, guess: Array, start: Array, asked: StepOptions, row: Array
) -> int:
    """Write the state under other controls, from the state `before`; whether it settles, as a `PathStatus`: REACHED, or
    why not. guess : a configuration near its end; start (2c + 9,) : as in `Reached`.
    """
    g, poses, sizes = m.geometry, m.geometry.poses, m.sizes
    old, end = read_state(borrowed(before), m.state), read_state(borrowed(row), m.state)
    n, near = len(old.kinds), asked.rough * sizes.tolerance
    loaded, kinds = is_loaded(old.kinds), old.kinds.astype(np.int64)
    contacts, slow, pads = new_contacts(g), 1.0 / asked.h, 1.0 / asked.h if asked.slow_pads else 0.0
    damper = KEPT * m.damper if controls[8] != 0.0 else m.damper / asked.h
    was, stood = read_place(poses, old.where), read_place(poses, old.at)
    placed = Placed(old.positions, old.frames, old.axes, old.places, old.slips)
    preload, commanded = preload_offsets(m.preloads, controls[7], old.controls[7]), m.posture + controls[9:]
    load, weight = controls[:6].copy(), controls[6] * m.weight
    more = load_change(sizes, m.weight, old.controls, controls) if asked.h >= sizes.slow else 0.0
    where, answer = guess.copy(), np.empty(m.answer[-1])
    swing, last = np.zeros(8), np.inf
    found = read_answer(answer, m.answer)
    modes, post_friction = old.modes.astype(np.int64), old.post_friction.copy()
    if poses.follows:
        contacts.frames[:] = old.frames
    for count in range(1, MAX_ITERATES + 1):
        linearise(g, where, contacts)
        at = read_place(poses, where)
        now = placed_contacts(contacts)
        slipped = slip_between(g, placed, now, stood, at, old.slip_memory)
        if len(asked.past) > 0:
            slipped -= asked.past
        base = slipped + preload
        for i in range(n):
            base[i, 2] = contacts.touch.gap[i] + preload[i, 2]
        loads = Loads(
            base, slipped[:, 2].copy(), at.give, at.turn, commanded - at.q, load, contacts.reference, weight,
            contacts.mass_at,
        )  # fmt: skip
        done = pose_difference(poses, was.pose, at.pose)
        damping = Damping(slow, pads, damper, done, was.q - at.q, was.give - at.give, was.turn - at.turn)
        radius = g.hand.radius if poses.follows else g.posture.radius
        situation = Situation(
            contacts.touch, contacts.frames, contacts.moving, contacts.elastic, loads, slipped, radius, damping
        )
        measured = near if poses.follows else -1.0
        task = joint_task(m, old, was.q, controls, modes, post_friction, at.q)
        if not answer_iterate(
            situation, m.rules, m.by_contact, task, start, loaded, kinds, measured, m.answer, answer
        ):  # fmt: skip
            return _NO_FORCES
        modes, post_friction = found.modes.astype(np.int64), found.post_friction.copy()
        to = read_place(poses, end.where)
        to.q[:], to.give[:], to.turn[:] = at.q + found.change, found.give, found.turn
        move_pose(poses, at.pose, found.twist, found.centre, to.pose)
        start = found.start.copy()  # the next answer is written over it
        moved = pose_difference(poses, was.pose, to.pose)
        free = not (load.any() or weight.any())
        judged = judge_iterate(
            sizes, m.damper, poses.follows, answer[1], near, last, count, moved, found.forces, free, more
        )  # fmt: skip
        if judged == SETTLED:
            end.at[:] = where
            end.positions[:], end.frames[:] = contacts.touch.positions, contacts.frames
            end.axes[:], end.places[:], end.slips[:] = contacts.axes, contacts.touch.places, contacts.slips
            end.base[:], end.since[:], end.slip_memory[:] = base, loads.spin, found.slip_memory
            end.deflection[:], end.controls[:] = commanded - to.q, controls
            end.tally[:] = 0.0
            end.tally[0], end.tally[1], end.tally[2] = count, answer[2], 1.0
            end.yielded[:] = 0.0
            ahead = (free or controls[8] != 0.0) and is_pushed_ahead(sizes, found.forces)
            _write_response(found, asked.past, ahead, end)
            end.rubs[:] = 0.0
            end.modes[:], end.post_friction[:], end.rubs[: len(found.rubs)] = modes, post_friction, found.rubs
            write_tendons(found.drawn, found.tension, found.taut, end)
            return SETTLED
        if judged != GOES_ON:
            return judged
        share = relax_share(swing, pose_displacement(poses, to.pose) - pose_displacement(poses, at.pose))
        if share == 1.0:
            last = answer[1]
            where[:] = end.where
        else:
            last = max(answer[1], last)
            place_between(poses, where.copy(), end.where, share, where)
    return _RUNS_AWAY


@kernel
def _write_response(found: AnswerArrays, past: Array, ahead: bool, end: StateArrays) -> None:
    """Write forces, motions and contact states of a step's end."""
    end.forces[:], end.motion[:], end.torsion[:] = found.forces, found.motion, found.torsion
    end.spin[:], end.torque[:], end.start[:], end.met[:] = found.spin, found.torque, found.start, found.met
    for i in range(len(end.kinds)):
        end.kinds[i] = _OPEN if ahead else shown_status(int(found.kinds[i]))
        if len(past) > 0:
            end.motion[i, 0] += past[i, 0]
            end.motion[i, 1] += past[i, 1]
            end.spin[i] += past[i, 2]


@kernel
def joint_task(
    m: StepModel, old: StateArrays, begun: Array, controls: Array, modes: Ints, post_friction: Array, at: Array
) -> JointTask:
    """What a step asks of the joints at an iterate, in which they stand at (nv,). begun (nv,) : before the step."""
    commanded, driven = m.posture + controls[9:], False
    for j in range(len(commanded)):
        driven = driven or controls[9 + j] != old.controls[9 + j]
    drawn = np.zeros(len(old.drawn)) if driven else old.drawn.copy()
    return JointTask(
        m.rubs, m.joints, m.joint_layout, begun, commanded, commanded, drawn, driven, modes, post_friction, at
    )


@kernel
def write_tendons(drawn: Array, tension: Array, taut: Array, end: StateArrays) -> None:
    """Write what tendons do (t,) at a step's end."""
    end.drawn[:], end.tension[:], end.taut[:] = drawn, tension, taut
    for i in range(len(tension)):
        end.slack[i] = 1.0 if tension[i] > taut[i] else 0.0


@kernel
def rubbing(s: JointSystem, trial: JointTrial, out: Array) -> None:
    """Write what friction takes of the torques (nv,) in a trial [N·m]."""
    out[:] = 0.0
    add_transposed(s.friction_rows, trial.friction, 1.0, out)


@kernel
def preload_offsets(p: Preloads, now: float, before: float) -> Array:
    """(n, 3) what preloads add between object and fingertips, along the tangents since the step began [m]."""
    out = np.zeros(p.given.shape)
    if not p.acts:
        return out
    for i in range(len(out)):
        for a in range(2):
            if now != before:
                out[i, a] = now * p.given[i, a] - before * p.given[i, a]
        out[i, 2] = now * p.given[i, 2] + (1.0 - min(now, 1.0)) * p.fades[i]
    return out


@kernel
def judge_iterate(
    sizes: Sizes,
    damper: Array,
    follows: bool,
    miss: float,
    near: float,
    last: float,
    count: int,
    moved: Array,
    forces: Array,
    free: bool,
    more: float,
) -> int:
    """Whether an iterate ends its step: SETTLED, GOES_ON, or why the step has no end.

    miss, last : how far its end is from it, as a share of the contacts' radii, and the one before. near : what is
    allowed of that. moved (6,) : of the object in the step; forces (n, 3). free : whether nothing loads the object.
    more : load that comes in a quasi-static step [N].
    """
    far = pose_distance(sizes.length, moved)
    if miss <= near or not follows:
        if follows and far > _LARGEST:
            return _TOO_FAR
        held = not follows and not (free and is_pushed_ahead(sizes, forces))
        if held and damper_force(sizes, damper, moved) > _CREEPS * more > 0.0:
            return _TOO_FAR
        if held and damper_share(sizes, damper, moved, forces) > _HELD_BACK:
            return _NO_FORCES
        return SETTLED
    if (count > 3 and miss > _CONTRACTS * last) or miss > _PARTS * last:
        return _RUNS_AWAY
    return _TOO_FAR if far > 2.0 * _LARGEST else GOES_ON


@kernel
def pose_distance(length: float, moved: Array) -> float:
    """How far a motion (6,) of the object is, as a share of the contacts' distances from their centre, length [m]."""
    x, y, z, p, q, r = moved[0], moved[1], moved[2], moved[3], moved[4], moved[5]
    return math.sqrt(x * x + y * y + z * z) / length + math.sqrt(p * p + q * q + r * r)


@kernel
def damper_share(sizes: Sizes, damper: Array, moved: Array, forces: Array) -> float:
    """What the object's damper (6,) takes in a quasi-static step that moves it by (6,), as a share of the normal forces
    at its end; forces (n, 3).
    """
    normal = 0.0
    for i in range(len(forces)):
        normal += forces[i, 2]
    return damper_force(sizes, damper, moved) / max(normal, 1e-9 * sizes.stiffness * sizes.length)


@kernel
def damper_force(sizes: Sizes, damper: Array, moved: Array) -> float:
    """What the object's damper (6,) takes in a quasi-static step that moves it by (6,) [N]."""
    pull, turn = 0.0, 0.0
    for a in range(3):
        pull += (damper[a] * moved[a]) ** 2
        turn += (damper[3 + a] * moved[3 + a]) ** 2
    return math.sqrt(pull + turn / sizes.length**2) / sizes.slow


@kernel
def load_change(sizes: Sizes, weight: Array, before: Array, controls: Array) -> float:
    """How much load comes with other controls, a torque as a force at the contacts' distances [N]."""
    pull, turn, times = 0.0, 0.0, controls[6] - before[6]
    for a in range(3):
        pull += (controls[a] - before[a] + times * weight[a]) ** 2
        turn += (controls[3 + a] - before[3 + a]) ** 2
    return math.sqrt(pull + turn / sizes.length**2)


@kernel
def is_pushed_ahead(sizes: Sizes, forces: Array) -> bool:
    """Whether forces (n, 3) are none: those of an object that fingers push ahead of them, held by nobody."""
    largest = 0.0
    for i in range(len(forces)):
        largest = max(largest, forces[i, 2])
    return bool(largest <= NO_FORCE * sizes.stiffness * sizes.length)


@kernel
def relax_share(swing: Array, moved: Array) -> float:
    """How far to go from an iterate to its end: all the way, or less where ends swing from one side to the other, as a
    contact that sticks on one side and slides on the other does. Aitken's relaxation.

    moved (6,) : of the object from the iterate to its end. swing (8,) : that of the last one, the last share, and how
    many there were; 0 at first.
    """
    if swing[7] == 0.0:
        swing[6] = 1.0
    else:
        size, along = 0.0, 0.0
        for a in range(6):
            size += (swing[a] - moved[a]) ** 2
            along += swing[a] * (swing[a] - moved[a])
        swing[6] = min(max(swing[6] * along / size, _LEAST), 1.0) if size > 0.0 else 1.0
    swing[:6] = moved
    swing[7] += 1.0
    return float(swing[6])


@kernel
def is_loaded(kinds: Array) -> bool:
    """Whether any contact carries anything."""
    carries = False
    for kind in kinds:
        carries = carries or kind != _OPEN
    return carries


@kernel
def shown_status(kind: int) -> int:
    """As `shown_statuses`, of one contact."""
    if kind == _GLIDES:
        return _SLIDES
    return _OPEN if kind > _GLIDES else kind


# ----------------------------------------------------------------
# The answer of an iterate, of those that Newton's method may find.


@kernel
def answer_iterate(
    s: Situation,
    rules: Rules,
    by_contact: bool,
    joints: JointTask,
    start: Array,
    loaded: bool,
    kinds: Ints,
    near: float,
    parts: Ints,
    row: Array,
) -> bool:
    """Write the answer that continues what is expected, `start`; whether there is one. Where a contact changes its
    state, the answer found from contacts that all stick is asked for, too, and the one is taken that changes no state,
    else the nearer one.

    loaded : whether anything was carried before; kinds (n,) : contact states then. near : as in `one_iteration`. parts,
    row : of `Answer`.
    """
    s, rules, joints, begun = borrowed(s), borrowed(rules), borrowed(joints), start if loaded else start[:0]
    found = solve_in_modes(s, rules, by_contact, joints, begun, True, near, parts, row)
    answer = read_answer(row, parts)
    if not loaded and not (found and answer.kinds.any()):
        pressed = np.empty(len(row))
        if _solve_pressed(s, rules, by_contact, joints, parts, pressed):
            row[:] = pressed
            return True
        return found
    if len(begun) == 0 or (found and _same_kinds(answer.kinds, kinds)):
        return found
    c = len(rules.laws.scale)
    forces, apart = start[:c], largest_change(answer.start[:c], start[:c])
    if found and apart <= CLOSE * largest_change(forces, np.zeros(c)):
        return True
    other = np.empty(len(row))
    if not solve_in_modes(s, rules, by_contact, joints, begun, False, near, parts, other):
        return found
    second = read_answer(other, parts)
    nearer = largest_change(second.start[:c], forces) < apart
    if not found or _same_kinds(second.kinds, kinds) or nearer:
        row[:] = other
    return True


@kernel
def solve_in_modes(
    s: Situation,
    rules: Rules,
    by_contact: bool,
    joints: JointTask,
    start: Array,
    begun: bool,
    near: float,
    parts: Ints,
    row: Array,
) -> bool:
    """Write the answer in which joints, posts and tendons are in the modes that were assumed, and what these do; where
    joints do nothing but give way, that of one solve. False where modes have no answer, or none are right.
    """
    if not joints.acts:
        return solve_once(s, rules, by_contact, start, begun, near, row)
    (system, step, fits), at, el, loads, nv = joints_of_task(joints), joints.at, s.elastic, s.loads, len(joints.at)
    if not fits:
        return False
    trial, found = begin_trial(system, joints.modes, joints.post_friction), read_answer(row, parts)
    q, torque, held = np.empty(nv), np.empty(nv), 1.0 - rules.laws.sags
    for _ in range(MAX_MODE_TRIALS):
        springs, H = joint_springs(system, trial), tensioned_stiffness(system, step, trial, at)
        elastic = Elastic(el.P, el.J, el.turning, springs.compliance_factor, el.gravity, H)
        command = joint_command(system, springs, step, trial, at)
        driven = Loads(
            loads.base, loads.spin, loads.give, loads.turn, command, loads.load, loads.reference, loads.weight,
            loads.mass_at,
        )  # fmt: skip
        now = Situation(s.touch, s.frames, s.moving, elastic, driven, s.slipped, s.radius, s.damping)
        if not solve_once(now, rules, by_contact, start, begun, near, row):
            return False
        for j in range(nv):
            q[j] = at[j] + found.change[j]
            torque[j] = found.torque[j] - held * el.gravity[j]
        if len(H) > 0:
            add_product(H, found.change, -1.0, torque)
        read_joint_state(system, springs, step, trial, q, torque)
        if assume_anew(system, step, trial, q):
            found.modes[:], found.post_friction[:] = trial.modes, trial.post_friction
            found.drawn[:], found.tension[:], found.taut[:] = trial.drawn, trial.tension, trial.taut
            rubbing(system, trial, found.rubs)
            return True
    return False


@kernel
def solve_once(
    s: Situation, rules: Rules, by_contact: bool, start: Array, begun: bool, near: float, row: Array
) -> bool:
    """Write one answer; whether there is one."""
    row[:] = 0.0
    if by_contact:
        iteration_by_contact(s, rules, start, begun, SEED, near, row)
    else:
        one_iteration(s, rules, start, begun, SEED, near, row)
    return bool(row[0] != 0.0)


@kernel
def _solve_pressed(
    s: Situation, rules: Rules, by_contact: bool, joints: JointTask, parts: Ints, row: Array
) -> bool:  # fmt: skip
    """Write the loaded answer nearest to contacts that all stick: friction starts high and comes down to what it is,
    each solve from the last. Whether no answer opens all contacts on the way.
    """
    start, answer = np.zeros(0), read_answer(row, parts)
    for times in PRESSED:
        more = Rules(
            rules.laws, times * rules.friction_coefficients, rules.extra, rules.giving, rules.yields, rules.pattern
        )
        if not solve_in_modes(s, more, by_contact, joints, start, True, -1.0, parts, row) or not answer.kinds.any():
            return False
        start = answer.start.copy()
    return True


@kernel
def _same_kinds(kinds: Array, before: Ints) -> bool:
    """Whether contacts are in the states that they were in."""
    same = True
    for i in range(len(kinds)):
        same = same and shown_status(int(kinds[i])) == before[i]
    return same


@kernel
def largest_change(a: Array, b: Array) -> float:
    """The largest difference between numbers (k,) of two rows."""
    largest = 0.0
    for i in range(len(a)):
        largest = max(largest, abs(a[i] - b[i]))
    return largest
