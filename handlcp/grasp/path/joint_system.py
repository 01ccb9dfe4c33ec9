"""`JointSystem`: joints in a step of a path that do more than give way, compiled: dry friction, posts, slack tendons.

A joint's springs, driven to q_c, pull with K (q_c - q). What is left of that for the contacts, τ, is less by friction
f, which opposes the motion of the step as friction at a contact does. At a joint |f| ≤ τ_f. Where a tendon wraps around
a post by θ, f is what the post takes of the tension T with which the tendon comes from its drive (capstan):

    T (1 - exp(μθ)) ≤ f ≤ T (1 - exp(-μθ)),    τ -= Dᵀ f,

with D q how much of the tendon is drawn in from beyond. A post sticks with f inside that band. It slips with f at the
upper end where the tendon is drawn towards its drive, and at the lower end where it is drawn away. The next post of the
tendon has what is left of T.

Once the hand is closed, a tendon pulls with t ≥ 0, or is slack by s:

    0 ≤ t ⟂ s ≥ 0,    t = a + k s,    a = d - k l(q),    τ = K (q_c - q) + Rᵀ (t - a) - Dᵀ f.

a is the force of the tendon as a spring that could push, d how much of it is drawn in times its stiffness k [N], l what
the joints have drawn in, R = ∂l/∂q its arms. While the hand is driven, its drives keep all tendons taut: they pull with
the least tensions that make its torques.

With the mode of each joint, post and tendon known (sticks or slips, taut or slack), a step is one of joints with
springs alone: what sticks is rigid, what slips is commanded by K⁻¹ Dᵀ f less, and a slack tendon is a spring less. The
modes are found by trial, in kernels that a caller composes with its own solve (`solve_in_modes` of contacts,
`move_free_joints` of joints that meet nothing):

    trial = begin_trial(system, modes, post friction)
    springs = joint_springs(system, trial)                  joints with springs alone, in these modes
    command = joint_command(system, springs, step, trial, at)
    H = tensioned_stiffness(system, step, trial, at)        by which tendons pull harder as their arms change
        … solve with springs.compliance_factor, command and H → joints q, torque for the contacts …
    read_joint_state(system, springs, step, trial, q, torque - H (q - at))     tensions and friction there
    assume_anew(system, step, trial, q)                     True: the modes were right; else try again with others

All that were wrong are assumed anew; where that goes round in circles, the first of them alone, which ends (Murty,
Linear Algebra and its Applications 7, 1974). Friction of posts that slip depends on the tension, which depends on
friction: that fixed point is found by Anderson's mixing (Journal of the ACM 12, 1965). The memory of a path is where
the joints stand and how far the tendons are drawn in, and nothing else.

Of tendons along routes, `joints_of_task` gives the joints with the arms of a posture.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.model.mechanism import least_tensions
from handlcp.kinematics.cable_kinematics import (
    CablePosture,
    PackedRoutes,
    RoutedTendons,
    TendonArms,
    lay_tendons,
    tendon_arm_rates,
)
from handlcp.kinematics.joint_tree import JointTree, TipPlacements, compose_placement, write_joint_motions
from handlcp.lcp.kernels.dense import (
    add_product,
    add_transposed,
    inverse_root,
    kernel,
    product,
    solve_least_squares,
    solve_wide,
)

MAX_MODE_TRIALS = 80
_ALL_AT_ONCE = 6  # trials after which one mode alone is assumed anew
JOINT_ROUNDING = 1e-9  # of the friction, of the motion that it makes, or of the largest tension: less is none
_SETTLED = 1e-10  # of the largest tension: friction at posts that changes by no more
_DEPENDENT = 1e-9  # of the longest: rows shorter than this across others say nothing that these do not
_LEAST_STIFFNESS = 1e-5  # of its stiffness: what a joint keeps that no taut tendon and no spring holds
_MIXED = 4  # iterates that Anderson's mixing remembers
_EPS = float(np.finfo(float).eps)


class JointSystem(NamedTuple):
    """nv joints with springs, m posts and t tendons; of tendons along routes, in one posture.

    stiffness : (nv, nv) K with all tendons taut [N·m/rad], 0 of rigid joints. compliance_factor : (nv, k) A, compliance
        (nv, nv) C = A Aᵀ of these springs. gives : (nv,) joints that are not rigid.
    friction_rows : (nv + m, nv) D: ones of the joints, and arms of tendons from each post on [1, m/rad].
    dry_friction : (nv,) τ_f [N·m, N]. has_friction : (nv + m,).
    post_tendon : (m,) number of the tendon. wrap_friction : (m,) μθ.
    rest : (nv,) q₀ of the joints' own springs, passive (nv, nv) K_p. preload : (nv,) R₀ᵀ T₀, which they bear at rest.
    springs : (t, t) k [N/m]. initial_tension : (t,) T₀ [N]. slackens : (t,) tendons that can go slack.
    arms : (t, nv) R. shift : (t,) l - R q [m]. spring_arms : (t, nv) k R.
    arm_rates : (t, nv, nv) ∂R/∂q [m/rad²]; empty (0, nv, nv) where arms stay.
    """

    stiffness: Array
    compliance_factor: Array
    compliance: Array
    gives: Bools
    friction_rows: Array
    dry_friction: Array
    has_friction: Bools
    post_tendon: Ints
    wrap_friction: Array
    rest: Array
    passive: Array
    preload: Array
    springs: Array
    initial_tension: Array
    slackens: Bools
    arms: Array
    shift: Array
    spring_arms: Array
    arm_rates: Array


class TendonRoutes(NamedTuple):
    """Tendons along routes on the links of a hand. links : where these are on the hand's joints."""

    links: TipPlacements
    tendons: RoutedTendons


_SYSTEM_PARTS = len(JointSystem._fields)
_TREE_PARTS = 7  # of a `JointTree`: all but masses


class JointStep(NamedTuple):
    """What is asked of the joints in a step. begun, commanded (nv,) : where they stood before it and are commanded to.
    target (nv,) : where springs as stiff as here would drive them (`spring_target`). drawn (t,) : d [N]; of a driven
    hand along routes, what holds its joints where they are commanded. driven : whether drives move in this step.
    """

    begun: Array
    commanded: Array
    target: Array
    drawn: Array
    driven: bool


class JointTask(NamedTuple):
    """What solves of an iterate ask of the joints. acts : whether they do more than give way; else all else is unused.
    numbers, layout : of `pack_joints`. begun to driven : as in `JointStep`; of tendons whose routes are packed, target
    and drawn are worked out there. modes (nv + m + t,), post_friction (m,) : assumed first, as in `JointTrial`. at
    (nv,) : where joints stand at the iterate.
    """

    acts: bool
    numbers: Array
    layout: Ints
    begun: Array
    commanded: Array
    target: Array
    drawn: Array
    driven: bool
    modes: Ints
    post_friction: Array
    at: Array


class JointTrial(NamedTuple):
    """What is assumed of the joints in a trial, and what came of it; all of it is overwritten.

    modes : (nv + m + t,) of joints and posts 0 where they stick, ±1 the way they slip; of tendons 1 where they are
        slack, else 0. post_friction : (m,) f of posts that slip [N].
    friction : (nv + m,) f [N·m, N]. tension, taut, drawn : (t,) t, a and d [N].
    mixed : (4, m) the last iterates of post_friction. apart : (4, m) how far each was from what came of it.
    counts : (2,) trials, and iterates in `mixed`.
    """

    modes: Ints
    post_friction: Array
    friction: Array
    tension: Array
    taut: Array
    drawn: Array
    mixed: Array
    apart: Array
    counts: Ints


class JointSprings(NamedTuple):
    """Joints of which some stick and some tendons are slack. stiffness (nv, nv) : K without slack tendons.
    compliance_factor (nv, k) : A of what can move, compliance (nv, nv) : A Aᵀ. slack_torque (nv, t) : Rᵀ (t - a) by a.
    """

    stiffness: Array
    compliance_factor: Array
    compliance: Array
    slack_torque: Array


# ---------------------------------------------------------------- Joints with springs alone, in given modes.


@kernel
def begin_trial(s: JointSystem, modes: Ints, post_friction: Array) -> JointTrial:
    """Assume these modes (nv + m + t,) and this friction of posts that slip (m,)."""
    rows, m, t = len(s.friction_rows), len(s.wrap_friction), len(s.springs)
    return JointTrial(
        modes.copy(), post_friction.copy(), np.zeros(rows), np.zeros(t), np.zeros(t), np.zeros(t),
        np.zeros((_MIXED, m)), np.zeros((_MIXED, m)), np.zeros(2, np.int64),
    )  # fmt: skip


@kernel
def joint_springs(s: JointSystem, trial: JointTrial) -> JointSprings:
    """The springs in a trial's modes.

    Of slack tendons t = 0 and s = -k⁻¹ a of these alone, and the others lose what springs between tendons take. What
    sticks leaves of the compliance A Aᵀ the part across its rows: A (1 - Qᵀ Q), with Q an orthonormal basis of D A.
    """
    nv, t = len(s.stiffness), len(s.springs)
    held, slack, lost = _sticking(s, trial.modes), _tendons_in(s, trial.modes, 1), np.zeros((nv, t))
    if len(held) == 0 and len(slack) == 0:
        return JointSprings(s.stiffness, s.compliance_factor, s.compliance, lost)
    K, factor = s.stiffness, s.compliance_factor
    if len(slack) > 0:
        taut = _tendons_in(s, trial.modes, 0)
        shared = _solve_block(s.springs, slack, _block(s.springs, slack, taut))
        for a in range(len(slack)):
            for j in range(nv):
                lost[j, slack[a]] = -s.arms[slack[a], j]
                for b in range(len(taut)):
                    lost[j, slack[a]] -= shared[a, b] * s.arms[taut[b], j]
        K = product(lost, s.spring_arms)
        for i in range(nv):
            for j in range(nv):
                K[i, j] += s.stiffness[i, j]
        _stiffen_loose(K, s.stiffness, s.gives)
        factor = _factor_of(K, s.gives)
    if len(held) > 0:
        factor = _factor_across(factor, product(_block(s.friction_rows, held, np.arange(nv)), factor))
    return JointSprings(K, factor, product(factor, np.ascontiguousarray(factor.T)), lost)


@kernel
def joint_command(s: JointSystem, springs: JointSprings, step: JointStep, trial: JointTrial, at: Array) -> Array:
    """(nv,) from where joints stand at an iterate, at (nv,), to where springs alone would have to be driven to."""
    torque = spring_torque(s, springs, step, step.begun)
    add_transposed(s.friction_rows, _slipping_friction(s, trial), -1.0, torque)
    driven = step.begun.copy()
    add_product(springs.compliance, torque, 1.0, driven)
    for j in range(len(at)):
        driven[j] = (driven[j] if s.gives[j] else step.commanded[j]) - at[j]
    return driven


@kernel
def spring_torque(s: JointSystem, springs: JointSprings, step: JointStep, q: Array) -> Array:
    """(nv,) with which springs and tendons pull at the joints at q (nv,), friction left out [N·m]."""
    torque = np.zeros(len(q))
    add_product(springs.stiffness, step.target, 1.0, torque)
    add_product(springs.stiffness, q, -1.0, torque)
    if not step.driven:
        taut = step.drawn.copy()
        add_drawn_force(s, step.target, -1.0, taut)
        add_product(springs.slack_torque, taut, 1.0, torque)
    return torque


@kernel
def add_drawn_force(s: JointSystem, q: Array, sign: float, out: Array) -> None:
    """Add ±k l to out (t,): what joints at q (nv,) have drawn in of the tendons, times their stiffness [N]."""
    add_product(s.springs, s.shift, sign, out)
    add_product(s.spring_arms, q, sign, out)


@kernel
def tensioned_stiffness(s: JointSystem, step: JointStep, trial: JointTrial, at: Array) -> Array:
    """(nv, nv) H = Σ T ∂R/∂q of the tensions with joints at (nv,) [N·m/rad]; empty (0, 0) where arms stay."""
    if len(s.arm_rates) == 0:
        return np.zeros((0, 0))
    taut, H = step.drawn.copy(), np.zeros(s.stiffness.shape)
    add_drawn_force(s, at, -1.0, taut)
    tension = _slack_tensions(s, taut, trial.modes)
    for i in range(len(tension)):
        for j in range(len(H)):
            for k in range(len(H)):
                H[j, k] += tension[i] * s.arm_rates[i, j, k]
    return H


# ---------------------------------------------------------------- What comes of a trial.


@kernel
def read_joint_state(
    s: JointSystem, springs: JointSprings, step: JointStep, trial: JointTrial, q: Array, torque: Array
) -> None:
    """Write tensions and friction of a trial whose joints have come to q (nv,), with torques (nv,) left for the
    contacts [N·m].
    """
    pull, drawn = spring_torque(s, springs, step, q), np.zeros(len(s.springs))
    add_drawn_force(s, q, 1.0, drawn)
    if step.driven:
        # Rᵀ (t - T₀) is what springs pull with in all, and turns the joints against their own springs
        made = pull.copy()
        add_passive_torque(s, q, made)
        tension = least_tensions(s.arms, s.initial_tension, s.slackens, made)
        for i in range(len(drawn)):
            trial.taut[i], trial.drawn[i] = tension[i], tension[i] + drawn[i]
    else:
        for i in range(len(drawn)):
            trial.taut[i], trial.drawn[i] = step.drawn[i] - drawn[i], step.drawn[i]
        tension = _slack_tensions(s, trial.taut, trial.modes)
    for i in range(len(drawn)):
        trial.tension[i] = tension[i]
    friction, held = _slipping_friction(s, trial), _sticking(s, trial.modes)
    for r in range(len(friction)):
        trial.friction[r] = friction[r]
    if len(held) > 0:
        add_transposed(s.friction_rows, friction, -1.0, pull)
        rows = np.empty((len(q), len(held)))
        for j in range(len(q)):
            pull[j] -= torque[j]
            for a in range(len(held)):
                rows[j, a] = s.friction_rows[held[a], j]
        found = solve_least_squares(rows, pull, _DEPENDENT)
        for a in range(len(held)):
            trial.friction[held[a]] = found[a]


@kernel
def assume_anew(s: JointSystem, step: JointStep, trial: JointTrial, q: Array) -> bool:
    """Whether joints at q (nv,), posts and tendons do what the trial assumed; else assume other modes, or other
    friction of the posts that slip.
    """
    nv, rows = len(s.dry_friction), len(s.friction_rows)
    low, high = _friction_band(s, trial)
    modes, found, wrong = trial.modes, np.zeros(len(trial.modes), np.int64), -1
    for r in range(rows):
        size = max(high[r], -low[r])
        if s.has_friction[r] and modes[r] == 0:
            if trial.friction[r] > high[r] + JOINT_ROUNDING * size:
                found[r] = 1
            elif trial.friction[r] < low[r] - JOINT_ROUNDING * size:
                found[r] = -1
        elif s.has_friction[r]:
            moved, yields = 0.0, 0.0  # along the row, and by a unit of friction
            for i in range(nv):
                moved += s.friction_rows[r, i] * (q[i] - step.begun[i])
                for j in range(nv):
                    yields += s.friction_rows[r, i] * s.compliance[i, j] * s.friction_rows[r, j]
            if moved * modes[r] >= -JOINT_ROUNDING * size * yields:
                found[r] = modes[r]
    _find_slack(s, step, trial, found)
    for r in range(len(found) - 1, -1, -1):
        if found[r] != modes[r]:
            wrong = r
    settled, largest, change = np.zeros(rows - nv), 0.0, 0.0
    for p in range(rows - nv):
        if found[nv + p] != 0:
            settled[p] = high[nv + p] if found[nv + p] > 0 else low[nv + p]
        change = max(change, abs(settled[p] - trial.post_friction[p]))
    for i in range(len(trial.tension)):
        largest = max(largest, abs(trial.tension[i]))
    trial.counts[0] += 1
    if wrong < 0 and change > _SETTLED * largest:
        _mix(trial, settled)
        return False
    for p in range(rows - nv):
        trial.post_friction[p] = trial.friction[nv + p] if wrong < 0 else settled[p]
    for r in range(len(found)):
        if trial.counts[0] <= _ALL_AT_ONCE or r == wrong:
            modes[r] = found[r]
    trial.counts[1] = 0
    return wrong < 0


@kernel
def move_free_joints(s: JointSystem, step: JointStep, trial: JointTrial, at: Array) -> tuple[Array, bool]:
    """Where joints come to that meet nothing (nv,), from an iterate at (nv,); whether the trials have ended."""
    nv, q, torque = len(at), at.copy(), np.zeros(len(at))
    for _ in range(MAX_MODE_TRIALS):
        springs, H = joint_springs(s, trial), tensioned_stiffness(s, step, trial, at)
        moved = joint_command(s, springs, step, trial, at)
        if len(H) > 0:  # (1 - C H) δq = command
            A = np.zeros((nv, nv + 1))
            A[:, :nv] = product(springs.compliance, H)
            for i in range(nv):
                for j in range(nv):
                    A[i, j] = (1.0 if i == j else 0.0) - A[i, j]
                A[i, nv] = moved[i]
            if not solve_wide(A, 0.0):
                break
            moved = A[:, nv].copy()
            torque = np.zeros(nv)
            add_product(H, moved, -1.0, torque)
        for j in range(nv):
            q[j] = at[j] + moved[j]
        read_joint_state(s, springs, step, trial, q, torque)
        if assume_anew(s, step, trial, q):
            return q, True
    return q, False


@kernel
def _friction_band(s: JointSystem, trial: JointTrial) -> tuple[Array, Array]:
    """(nv + m,) each: the least and the largest friction, with that of a trial at the posts before each."""
    nv, rows, left = len(s.dry_friction), len(s.friction_rows), trial.tension.copy()
    low, high = np.zeros(rows), np.zeros(rows)
    for j in range(nv):
        low[j], high[j] = -s.dry_friction[j], s.dry_friction[j]
    for p in range(rows - nv):
        T, r, wrap = max(left[s.post_tendon[p]], 0.0), nv + p, s.wrap_friction[p]
        low[r], high[r] = T * (1.0 - math.exp(wrap)), T * (1.0 - math.exp(-wrap))
        left[s.post_tendon[p]] = T - min(max(trial.friction[r], low[r]), high[r])
    return low, high


@kernel
def _find_slack(s: JointSystem, step: JointStep, trial: JointTrial, found: Ints) -> None:
    """Write 1 into the last t of found, of zeros, for each tendon that is slack where some were assumed to be."""
    if step.driven:
        return
    slack, rows, largest = _tendons_in(s, trial.modes, 1), len(s.friction_rows), 0.0
    for i in range(len(trial.taut)):
        largest = max(largest, abs(trial.taut[i]), abs(step.drawn[i]))
    for i in range(len(trial.taut)):
        if s.slackens[i] and trial.modes[rows + i] == 0 and trial.tension[i] < -JOINT_ROUNDING * largest:
            found[rows + i] = 1
    pushed = np.zeros((len(slack), 1))
    for a in range(len(slack)):
        pushed[a, 0] = -trial.taut[slack[a]]
    loose = _solve_block(s.springs, slack, pushed)
    for a in range(len(slack)):
        if s.slackens[slack[a]] and s.springs[slack[a], slack[a]] * loose[a, 0] >= -JOINT_ROUNDING * largest:  # k s
            found[rows + slack[a]] = 1


@kernel
def _mix(trial: JointTrial, settled: Array) -> None:
    """Take the next iterate of post_friction (m,), from what came of the last ones, settled (m,) of this one."""
    m, at, apart = len(settled), trial.mixed, trial.apart
    if trial.counts[1] == _MIXED:
        for i in range(_MIXED - 1):
            for p in range(m):
                at[i, p], apart[i, p] = at[i + 1, p], apart[i + 1, p]
        trial.counts[1] -= 1
    last = trial.counts[1]
    trial.counts[1] += 1
    changes, miss = np.empty((m, last)), np.empty(m)
    for p in range(m):
        at[last, p], apart[last, p] = trial.post_friction[p], settled[p] - trial.post_friction[p]
        trial.post_friction[p], miss[p] = settled[p], apart[last, p]
        for i in range(last):
            changes[p, i] = apart[i + 1, p] - apart[i, p]
    if last > 0:
        share = solve_least_squares(changes, miss, _EPS * max(m, last))
        for p in range(m):
            for i in range(last):
                trial.post_friction[p] -= share[i] * (at[i + 1, p] - at[i, p] + changes[p, i])


# ---------------------------------------------------------------- Parts of it.


@kernel
def _sticking(s: JointSystem, modes: Ints) -> Ints:
    """Numbers of the rows along which friction holds."""
    found, count = np.empty(len(s.has_friction), np.int64), 0
    for r in range(len(found)):
        if s.has_friction[r] and modes[r] == 0:
            found[count] = r
            count += 1
    return found[:count].copy()


@kernel
def _tendons_in(s: JointSystem, modes: Ints, mode: int) -> Ints:
    """Numbers of the tendons that are slack, mode 1, or taut, mode 0."""
    found, count, rows = np.empty(len(s.springs), np.int64), 0, len(s.has_friction)
    for i in range(len(found)):
        if modes[rows + i] == mode:
            found[count] = i
            count += 1
    return found[:count].copy()


@kernel
def _slipping_friction(s: JointSystem, trial: JointTrial) -> Array:
    """(nv + m,) f of what slips; 0 of what sticks."""
    nv, f = len(s.dry_friction), np.zeros(len(s.friction_rows))
    for r in range(len(f)):
        if trial.modes[r] != 0:
            f[r] = trial.modes[r] * s.dry_friction[r] if r < nv else trial.post_friction[r - nv]
    return f


@kernel
def _slack_tensions(s: JointSystem, a: Array, modes: Ints) -> Array:
    """(t,) t of tendons that as springs would pull with a (t,), of which some are slack."""
    slack, taut, tension = _tendons_in(s, modes, 1), _tendons_in(s, modes, 0), np.zeros(len(a))
    pulled = np.empty((len(slack), 1))
    for k in range(len(slack)):
        pulled[k, 0] = a[slack[k]]
    loose = _solve_block(s.springs, slack, pulled)
    for i in taut:
        tension[i] = a[i]
        for k in range(len(slack)):
            tension[i] -= s.springs[i, slack[k]] * loose[k, 0]
    return tension


@kernel
def add_passive_torque(s: JointSystem, q: Array, out: Array) -> None:
    """Add K_p (q - q₀) + R₀ᵀ T₀ - Rᵀ T₀ to out (nv,), with joints at q (nv,) [N·m]. To what springs pull with there,
    that makes Rᵀ (t - T₀).
    """
    add_product(s.passive, q, 1.0, out)
    add_product(s.passive, s.rest, -1.0, out)
    add_transposed(s.arms, s.initial_tension, -1.0, out)
    for j in range(len(out)):
        out[j] += s.preload[j]


@kernel
def _stiffen_loose(K: Array, before: Array, gives: Bools) -> None:
    """Add a little of each joint's stiffness `before` (nv, nv) to K (nv, nv), where joints that give way (nv,) can move
    with hardly a spring.
    """
    on = np.flatnonzero(gives)
    scaled = _block(K, on, on)
    for i in range(len(on)):
        for j in range(len(on)):
            scaled[i, j] /= math.sqrt(before[on[i], on[i]] * before[on[j], on[j]])
        scaled[i, i] -= _LEAST_STIFFNESS
    if not inverse_root(scaled, np.zeros((len(on), len(on)))):
        for i in range(len(on)):
            K[on[i], on[i]] += _LEAST_STIFFNESS * before[on[i], on[i]]


@kernel
def _factor_of(K: Array, gives: Bools) -> Array:
    """(nv, nv) A of K⁻¹ = A Aᵀ over the joints that give way (nv,), 0 of the others."""
    on, out = np.flatnonzero(gives), np.zeros(K.shape)
    A = np.zeros((len(on), len(on)))
    inverse_root(_block(K, on, on), A)
    for i in range(len(on)):
        for j in range(len(on)):
            out[on[i], on[j]] = A[i, j]
    return out


@kernel
def _factor_across(A: Array, rows: Array) -> Array:
    """A (nv, k) without what is along rows (m, k): A (1 - Qᵀ Q), Q an orthonormal basis of the rows, which are
    overwritten. Modified Gram-Schmidt, twice.
    """
    out, m, k = A.copy(), len(rows), A.shape[1]
    for r in range(m):
        size = 0.0
        for c in range(k):
            size += rows[r, c] ** 2
        for _ in range(2):
            for b in range(r):
                along = 0.0
                for c in range(k):
                    along += rows[b, c] * rows[r, c]
                for c in range(k):
                    rows[r, c] -= along * rows[b, c]
        left = 0.0
        for c in range(k):
            left += rows[r, c] ** 2
        scale = 1.0 / math.sqrt(left) if left > _DEPENDENT**2 * size else 0.0
        for c in range(k):
            rows[r, c] *= scale
        for _ in range(2):
            for i in range(len(out)):
                along = 0.0
                for c in range(k):
                    along += out[i, c] * rows[r, c]
                for c in range(k):
                    out[i, c] -= along * rows[r, c]
    return out


@kernel
def _block(A: Array, rows: Ints, columns: Ints) -> Array:
    """(i, j) these rows and columns of A."""
    out = np.empty((len(rows), len(columns)))
    for i in range(len(rows)):
        for j in range(len(columns)):
            out[i, j] = A[rows[i], columns[j]]
    return out


@kernel
def _solve_block(A: Array, chosen: Ints, b: Array) -> Array:
    """(i, j) A⁻¹ b of the chosen rows and columns of A, positive definite; b (i, j)."""
    n, wide = len(chosen), np.empty((len(chosen), len(chosen) + b.shape[1]))
    for i in range(n):
        for j in range(n):
            wide[i, j] = A[chosen[i], chosen[j]]
        for j in range(b.shape[1]):
            wide[i, n + j] = b[i, j]
    solve_wide(wide, 0.0)
    return wide[:, n:].copy()


# ---------------------------------------------------------------- Tendons along routes: the joints in another posture.


def pack_joints(system: JointSystem, tree: JointTree | None, routes: TendonRoutes | None) -> tuple[Array, Ints]:
    """Joints, and routes of tendons on the links that a tree of joints carries, as two arrays: calls hand on two in
    place of forty. (numbers, one array behind the other; (·, 4) where each begins, and its shape).
    """
    parts: list[Any] = list(system)
    if tree is not None and routes is not None:
        parts += tree[:_TREE_PARTS]
        tendons = routes.tendons
        parts += [*routes.links, *tendons.routes, tendons.numbers, tendons.coupling, tendons.elastic, *tendons.given]
        parts.append(tendons.post_legs)
    layout, begins = np.zeros((len(parts), 4), dtype=np.int64), 0
    for row, part in zip(layout, parts, strict=True):
        row[0], row[1 : 1 + part.ndim] = begins, part.shape
        begins += part.size
    return np.concatenate([np.asarray(part, dtype=float).reshape(-1) for part in parts]), layout


@kernel
def read_joint_system(x: Array, at: Ints) -> JointSystem:
    """The joints of `pack_joints`."""
    return JointSystem(
        _matrix(x, at, 0), _matrix(x, at, 1), _matrix(x, at, 2), _vector(x, at, 3) != 0.0, _matrix(x, at, 4),
        _vector(x, at, 5), _vector(x, at, 6) != 0.0, _vector(x, at, 7).astype(np.int64), _vector(x, at, 8),
        _vector(x, at, 9), _matrix(x, at, 10), _vector(x, at, 11), _matrix(x, at, 12), _vector(x, at, 13),
        _vector(x, at, 14) != 0.0, _matrix(x, at, 15), _vector(x, at, 16), _matrix(x, at, 17), _cube(x, at, 18),
    )  # fmt: skip


@kernel
def joints_of_task(task: JointTask) -> tuple[JointSystem, JointStep, bool]:
    """(the joints at the iterate; the step there; whether tendons along routes can run there and where joints are
    commanded: no site of theirs is inside a body).
    """
    whole, drawn, fits = read_joint_system(task.numbers, task.layout), task.drawn.copy(), True
    if len(task.layout) == _SYSTEM_PARTS:
        return whole, JointStep(task.begun, task.commanded, task.target, drawn, task.driven), True
    if task.driven:
        there, fits = _joints_in_posture(whole, task.numbers, task.layout, task.commanded)
        drawn = commanded_draw(there, task.commanded)
    here, runs = _joints_in_posture(whole, task.numbers, task.layout, task.at)
    target = spring_target(here, task.commanded, drawn)
    return here, JointStep(task.begun, task.commanded, target, drawn, task.driven), fits and runs


@kernel
def _joints_in_posture(s: JointSystem, x: Array, at: Ints, q: Array) -> tuple[JointSystem, bool]:
    """The joints at q (nv,) with the arms that tendons have there; whether no site of theirs is inside a body."""
    k = _SYSTEM_PARTS
    turns, places = _cube(x, at, k + 1), _matrix(x, at, k + 2)
    tree = JointTree(
        _vector(x, at, k).astype(np.int64), turns, places, _matrix(x, at, k + 3),
        _vector(x, at, k + 4).astype(np.int64), _matrix(x, at, k + 5), _vector(x, at, k + 6), x[:0], places[:0],
    )  # fmt: skip
    k += _TREE_PARTS
    carriers, rotations, origins = _vector(x, at, k).astype(np.int64), _cube(x, at, k + 1), _matrix(x, at, k + 2)
    routes = PackedRoutes(
        _vector(x, at, k + 3).astype(np.int64), _matrix(x, at, k + 4), _matrix(x, at, k + 5), _matrix(x, at, k + 6),
        _vector(x, at, k + 7), _matrix(x, at, k + 8), _matrix(x, at, k + 9).astype(np.int64), _vector(x, at, k + 10),
    )  # fmt: skip
    given = TendonArms(_matrix(x, at, k + 14), _vector(x, at, k + 15), _vector(x, at, k + 16), _matrix(x, at, k + 17))
    tendons = RoutedTendons(
        routes, _vector(x, at, k + 11).astype(np.int64), _matrix(x, at, k + 12), _vector(x, at, k + 13) != 0.0, given,
        _vector(x, at, k + 18).astype(np.int64),
    )  # fmt: skip
    joints, count = len(tree.parents), len(carriers)
    R, p, columns = np.empty((joints, 3, 3)), np.empty((joints, 3)), np.empty((joints, 6))
    write_joint_motions(tree, q, R, p, columns)
    placements, turned, place = np.zeros((count, 4, 4)), np.empty((3, 3)), np.empty(3)
    for i in range(count):
        compose_placement(R, p, carriers[i], rotations[i], origins[i], turned, place)
        placements[i, 3, 3] = 1.0
        for a in range(3):
            placements[i, a, 3] = place[a]
            for b in range(3):
                placements[i, a, b] = turned[a, b]
    posed = CablePosture(placements, columns)
    laid, _, wrong, _ = lay_tendons(tendons, posed, q)
    return system_in_posture(s, laid, tendon_arm_rates(tendons, posed)), wrong < 0


@kernel
def _vector(x: Array, at: Ints, i: int) -> Array:
    """One of the arrays of `pack_joints`, of one dimension."""
    return x[at[i, 0] : at[i, 0] + at[i, 1]]


@kernel
def _matrix(x: Array, at: Ints, i: int) -> Array:
    """One of two dimensions."""
    return x[at[i, 0] : at[i, 0] + at[i, 1] * at[i, 2]].reshape(at[i, 1], at[i, 2])


@kernel
def _cube(x: Array, at: Ints, i: int) -> Array:
    """One of three dimensions."""
    size = at[i, 1] * at[i, 2] * at[i, 3]
    return x[at[i, 0] : at[i, 0] + size].reshape(at[i, 1], at[i, 2], at[i, 3])


@kernel
def system_in_posture(s: JointSystem, laid: TendonArms, arm_rates: Array) -> JointSystem:
    """The joints where tendons have these arms; arm_rates (t, nv, nv)."""
    nv, rows, has_friction = len(s.stiffness), s.friction_rows.copy(), s.has_friction.copy()
    for p in range(len(laid.wrap_friction)):
        reach = 0.0
        for j in range(nv):
            rows[nv + p, j] = laid.arms_beyond[p, j]
            reach = max(reach, abs(rows[nv + p, j]))
        has_friction[nv + p] = laid.wrap_friction[p] > 0.0 and reach > 0.0
    spring_arms = product(s.springs, laid.arms)
    K = product(np.ascontiguousarray(laid.arms.T), spring_arms)
    for i in range(nv):
        for j in range(i + 1):
            K[i, j] = K[j, i] = s.passive[i, j] + 0.5 * (K[i, j] + K[j, i])
    factor = _factor_of(K, s.gives)
    return JointSystem(
        K, factor, product(factor, np.ascontiguousarray(factor.T)), s.gives, rows, s.dry_friction, has_friction,
        s.post_tendon, laid.wrap_friction, s.rest, s.passive, s.preload, s.springs, s.initial_tension, s.slackens,
        laid.arms, laid.shift, spring_arms, arm_rates,
    )  # fmt: skip


@kernel
def spring_target(s: JointSystem, commanded: Array, drawn: Array) -> Array:
    """(nv,) where springs as stiff as in this posture would drive joints whose tendons are drawn in by d (t,):
    K q = Rᵀ (d - k (l - R q)) + K_p q₀ - R₀ᵀ T₀; rigid joints go where they are commanded.
    """
    pull, torque, target = drawn.copy(), np.zeros(len(commanded)), np.zeros(len(commanded))
    add_product(s.springs, s.shift, -1.0, pull)
    add_product(s.passive, s.rest, 1.0, torque)
    add_transposed(s.arms, pull, 1.0, torque)
    for j in range(len(torque)):
        torque[j] -= s.preload[j]
    add_product(s.compliance, torque, 1.0, target)
    for j in range(len(torque)):
        if not s.gives[j]:
            target[j] = commanded[j]
    return target


@kernel
def commanded_draw(s: JointSystem, commanded: Array) -> Array:
    """(t,) d of tendons that hold joints free of contacts where they are commanded to be (nv,), s in that posture."""
    torque = np.zeros(len(commanded))
    add_passive_torque(s, commanded, torque)
    drawn = least_tensions(s.arms, s.initial_tension, s.slackens, torque)
    add_drawn_force(s, commanded, 1.0, drawn)
    return drawn
