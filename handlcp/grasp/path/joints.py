"""Joints in a step of a path that do more than give way: dry friction, and tendons that rub on posts and go slack.

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
modes are found by trial, in five kernels that a caller composes with its own solve (`Joints.solved` does it in Python,
`move_free_joints` compiled):

    trial = begin_trial(system, modes, post friction)
    springs = joint_springs(system, trial)                  joints with springs alone, in these modes
    command = joint_command(system, springs, step, trial, at)
        … solve with springs.compliance_factor and command → joints q, torque for the contacts …
    read_joint_state(system, springs, step, trial, q, torque)         tensions and friction there
    assume_anew(system, step, trial, q)      True: the modes were right; else try again with others

All that were wrong are assumed anew; where that goes round in circles, the first of them alone, which ends (Murty,
Linear Algebra and its Applications 7, 1974). Friction of posts that slip depends on the tension, which depends on
friction: that fixed point is found by Anderson's mixing (Journal of the ACM 12, 1965). The memory of a path is where
the joints stand and how far the tendons are drawn in, and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.grasp.model.mechanism import Cables, TendonArms, least_tensions
from handlcp.grasp.path.pull import NO_PULL, Pull, Task
from handlcp.lcp.kernels.dense import kernel

MAX_MODE_TRIALS = 80
MAX_JOINT_TRIALS_AT_ONCE = 6  # trials after which one mode alone is assumed anew
_ROUNDING = 1e-9  # of the friction, of the motion that it makes, or of the largest tension: less is none
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
    dry_friction : (nv,) τ_f [N·m, N]. has_friction : (nv + m,). friction_compliance : (nv + m,) D C Dᵀ, its diagonal.
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
    friction_compliance: Array
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


class JointTrial(NamedTuple):
    """What is assumed of the joints in a trial, and what came of it; all of it is overwritten.

    modes : (nv + m + t,) of joints and posts 0 where they stick, ±1 the way they slip; of tendons 1 where they are
        slack, else 0. post_friction : (m,) f of posts that slip [N].
    friction : (nv + m,) f [N·m, N]. tension, taut, drawn : (t,) t, a and d [N].
    mixed : (2, 4, m) the last iterates of post_friction, and how far each was from what came of it.
    counts : (2,) trials, and iterates in `mixed`.
    """

    modes: Ints
    post_friction: Array
    friction: Array
    tension: Array
    taut: Array
    drawn: Array
    mixed: Array
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
        np.zeros((2, _MIXED, m)), np.zeros(2, np.int64),
    )  # fmt: skip


@kernel
def joint_springs(s: JointSystem, trial: JointTrial) -> JointSprings:
    """The springs in a trial's modes."""
    nv, t = len(s.stiffness), len(s.springs)
    held, slack, lost = _sticking(s, trial.modes), _slack(s, trial.modes), np.zeros((nv, t))
    if len(held) == 0 and len(slack) == 0:
        return JointSprings(s.stiffness, s.compliance_factor, s.compliance, lost)
    K, factor = s.stiffness, np.zeros((nv, nv))
    if len(slack) > 0:
        # t = 0 of the slack ones, s = -k⁻¹ a of these alone; the others lose what springs between tendons take
        taut, joints = _others(slack, t), np.arange(nv)
        columns = -_block(s.arms, slack, joints)
        if len(taut) > 0:
            shared = np.linalg.solve(_block(s.springs, slack, slack), _block(s.springs, slack, taut))
            columns -= np.dot(shared, _block(s.arms, taut, joints))
        for a in range(len(slack)):
            lost[:, slack[a]] = columns[a]
        K = _leave_no_joint_loose(s, s.stiffness + np.dot(lost, s.spring_arms))
    elastic = np.flatnonzero(s.gives)
    if len(elastic) > 0:
        moves = _null_space(_block(s.friction_rows, held, elastic))
        ways = np.zeros((nv, moves.shape[1]))
        ways[elastic] = moves
        if moves.shape[1] > 0:
            across = np.ascontiguousarray(ways.T)
            L = np.linalg.cholesky(np.dot(across, np.dot(K, ways)))
            factor[:, : moves.shape[1]] = np.linalg.solve(L, across).T
    return JointSprings(K, factor, np.dot(factor, np.ascontiguousarray(factor.T)), lost)


@kernel
def joint_command(s: JointSystem, springs: JointSprings, step: JointStep, trial: JointTrial, at: Array) -> Array:
    """(nv,) from where joints stand at an iterate, at (nv,), to where springs alone would have to be driven to."""
    friction = np.dot(np.ascontiguousarray(s.friction_rows.T), _slipping_friction(s, trial))
    driven = step.begun + np.dot(springs.compliance, spring_torque(s, springs, step, step.begun) - friction)
    return np.where(s.gives, driven, step.commanded) - at


@kernel
def spring_torque(s: JointSystem, springs: JointSprings, step: JointStep, q: Array) -> Array:
    """(nv,) with which springs and tendons pull at the joints at q (nv,), friction left out [N·m]."""
    torque = np.dot(springs.stiffness, step.target - q)
    if step.driven:
        return torque
    return torque + np.dot(springs.slack_torque, step.drawn - drawn_force(s, step.target))


@kernel
def drawn_force(s: JointSystem, q: Array) -> Array:
    """(t,) k l: what joints at q (nv,) have drawn in of the tendons, times their stiffness [N]."""
    return np.dot(s.springs, s.shift) + np.dot(s.spring_arms, q)


@kernel
def tensioned_stiffness(s: JointSystem, step: JointStep, trial: JointTrial, at: Array) -> Array:
    """(nv, nv) H = Σ T ∂R/∂q of the tensions with joints at (nv,) [N·m/rad]; empty (0, 0) where arms stay."""
    if len(s.arm_rates) == 0:
        return np.zeros((0, 0))
    tension = _slack_tensions(s, step.drawn - drawn_force(s, at), _slack(s, trial.modes))
    H = np.zeros(s.stiffness.shape)
    for i in range(len(tension)):
        H += tension[i] * s.arm_rates[i]
    return H


# ---------------------------------------------------------------- What comes of a trial.


@kernel
def read_joint_state(
    s: JointSystem, springs: JointSprings, step: JointStep, trial: JointTrial, q: Array, torque: Array
) -> None:
    """Write tensions and friction of a trial whose joints have come to q (nv,), with torques (nv,) left for the
    contacts [N·m].
    """
    pull, arms_t = spring_torque(s, springs, step, q), np.ascontiguousarray(s.arms.T)
    if step.driven:
        # Rᵀ (t - T₀) is what springs pull with in all, and turns the joints against their own springs
        made = pull + np.dot(s.passive, q - s.rest) + s.preload - np.dot(arms_t, s.initial_tension)
        trial.tension[:] = least_tensions(s.arms, s.initial_tension, s.slackens, made)
        trial.taut[:] = trial.tension
        trial.drawn[:] = trial.tension + drawn_force(s, q)
    else:
        trial.drawn[:] = step.drawn
        trial.taut[:] = step.drawn - drawn_force(s, q)
        trial.tension[:] = _slack_tensions(s, trial.taut, _slack(s, trial.modes))
    trial.friction[:] = _slipping_friction(s, trial)
    held = _sticking(s, trial.modes)
    if len(held) > 0:
        rows = _block(s.friction_rows, held, np.arange(len(q)))
        left = pull - torque - np.dot(np.ascontiguousarray(s.friction_rows.T), trial.friction)
        trial.friction[held] = np.linalg.lstsq(np.ascontiguousarray(rows.T), left, _DEPENDENT)[0]


@kernel
def assume_anew(s: JointSystem, step: JointStep, trial: JointTrial, q: Array) -> bool:
    """Whether joints at q (nv,), posts and tendons do what the trial assumed; else assume other modes, or other
    friction of the posts that slip.
    """
    nv, rows = len(s.dry_friction), len(s.friction_rows)
    low, high = _friction_band(s, trial)
    modes, found, wrong = trial.modes, np.zeros(len(trial.modes), np.int64), -1
    moved = np.dot(s.friction_rows, q - step.begun)
    for r in range(rows):
        size = max(high[r], -low[r])
        if s.has_friction[r] and modes[r] == 0:
            if trial.friction[r] > high[r] + _ROUNDING * size:
                found[r] = 1
            elif trial.friction[r] < low[r] - _ROUNDING * size:
                found[r] = -1
        elif s.has_friction[r] and moved[r] * modes[r] >= -_ROUNDING * size * s.friction_compliance[r]:
            found[r] = modes[r]
    _find_slack(s, step, trial, found[rows:])
    for r in range(len(found) - 1, -1, -1):
        if found[r] != modes[r]:
            wrong = r
    settled = np.zeros(rows - nv)
    for p in range(rows - nv):
        if found[nv + p] != 0:
            settled[p] = high[nv + p] if found[nv + p] > 0 else low[nv + p]
    trial.counts[0] += 1
    if wrong < 0:
        largest, change = 0.0, 0.0
        for i in range(len(trial.tension)):
            largest = max(largest, abs(trial.tension[i]))
        for p in range(len(settled)):
            change = max(change, abs(settled[p] - trial.post_friction[p]))
        if change <= _SETTLED * largest:
            trial.post_friction[:] = trial.friction[nv:]
            return True
        _mix(trial, settled)
        return False
    if trial.counts[0] <= MAX_JOINT_TRIALS_AT_ONCE:
        modes[:] = found
    else:
        modes[wrong] = found[wrong]
    trial.post_friction[:] = settled
    trial.counts[1] = 0
    return False


@kernel
def move_free_joints(s: JointSystem, step: JointStep, trial: JointTrial, at: Array) -> tuple[Array, bool]:
    """Where joints come to that meet nothing (nv,), from an iterate at (nv,); whether the trials have ended."""
    nv = len(at)
    for _ in range(MAX_MODE_TRIALS):
        springs = joint_springs(s, trial)
        H, torque = tensioned_stiffness(s, step, trial, at), np.zeros(nv)
        moved = joint_command(s, springs, step, trial, at)
        if len(H) > 0:
            moved = np.linalg.solve(np.eye(nv) - np.dot(springs.compliance, H), moved)
            torque = -np.dot(H, moved)
        read_joint_state(s, springs, step, trial, at + moved, torque)
        if assume_anew(s, step, trial, at + moved):
            return at + moved, True
    return at.copy(), False


@kernel
def _friction_band(s: JointSystem, trial: JointTrial) -> tuple[Array, Array]:
    """(nv + m,) each: the least and the largest friction, with that of a trial at the posts before each."""
    nv, rows, left = len(s.dry_friction), len(s.friction_rows), np.maximum(trial.tension, 0.0)
    low, high = np.zeros(rows), np.zeros(rows)
    low[:nv], high[:nv] = -s.dry_friction, s.dry_friction
    for p in range(rows - nv):
        T, r = left[s.post_tendon[p]], nv + p
        low[r], high[r] = T * (1.0 - np.exp(s.wrap_friction[p])), T * (1.0 - np.exp(-s.wrap_friction[p]))
        left[s.post_tendon[p]] = T - min(max(trial.friction[r], low[r]), high[r])
    return low, high


@kernel
def _find_slack(s: JointSystem, step: JointStep, trial: JointTrial, found: Ints) -> None:
    """Write 1 into found (t,), of zeros, for each tendon that is slack where some were assumed to be."""
    if step.driven:
        return
    slack, largest, slackness = _slack(s, trial.modes), 0.0, np.zeros(len(found))
    for i in range(len(found)):
        largest = max(largest, abs(trial.taut[i]), abs(step.drawn[i]))
    if len(slack) > 0:
        loose = np.linalg.solve(_block(s.springs, slack, slack), -trial.taut[slack])
        for a in range(len(slack)):
            slackness[slack[a]] = s.springs[slack[a], slack[a]] * loose[a]  # k s
    for i in range(len(found)):
        pushes = trial.tension[i] < -_ROUNDING * largest
        if trial.modes[len(s.friction_rows) + i] == 1:
            pushes = slackness[i] >= -_ROUNDING * largest
        if s.slackens[i] and pushes:
            found[i] = 1


@kernel
def _mix(trial: JointTrial, settled: Array) -> None:
    """Take the next iterate of post_friction (m,), from what came of the last ones, settled (m,) of this one."""
    at, apart = trial.mixed[0], trial.mixed[1]
    if trial.counts[1] == _MIXED:
        for i in range(_MIXED - 1):
            at[i], apart[i] = at[i + 1], apart[i + 1]
        trial.counts[1] -= 1
    last = trial.counts[1]
    at[last], apart[last] = trial.post_friction, settled - trial.post_friction
    trial.counts[1] += 1
    trial.post_friction[:] = settled
    if last > 0:
        changes, steps = (apart[1 : last + 1] - apart[:last]).copy(), (at[1 : last + 1] - at[:last]).copy()
        most = _EPS * max(changes.shape[0], changes.shape[1])
        share = np.linalg.lstsq(np.ascontiguousarray(changes.T), apart[last].copy(), most)[0]
        trial.post_friction[:] -= np.dot(share, steps + changes)


# ---------------------------------------------------------------- Parts of it.


@kernel
def _sticking(s: JointSystem, modes: Ints) -> Ints:
    """Numbers of the rows along which friction holds."""
    return np.flatnonzero(s.has_friction & (modes[: len(s.has_friction)] == 0))


@kernel
def _slack(s: JointSystem, modes: Ints) -> Ints:
    """Numbers of the tendons that are slack."""
    return np.flatnonzero(modes[len(s.has_friction) :] == 1)


@kernel
def _slipping_friction(s: JointSystem, trial: JointTrial) -> Array:
    """(nv + m,) f of what slips; 0 of what sticks."""
    nv, f = len(s.dry_friction), np.zeros(len(s.friction_rows))
    for r in range(len(f)):
        if trial.modes[r] != 0:
            f[r] = trial.modes[r] * s.dry_friction[r] if r < nv else trial.post_friction[r - nv]
    return f


@kernel
def _slack_tensions(s: JointSystem, a: Array, slack: Ints) -> Array:
    """(t,) t of tendons that as springs would pull with a (t,), of which some are slack."""
    if len(slack) == 0:
        return a.copy()
    taut, tension = _others(slack, len(a)), np.zeros(len(a))
    loose = np.linalg.solve(_block(s.springs, slack, slack), a[slack])
    tension[taut] = a[taut] - np.dot(_block(s.springs, taut, slack), loose)
    return tension


@kernel
def _leave_no_joint_loose(s: JointSystem, K: Array) -> Array:
    """K (nv, nv), with a little of each joint's stiffness where slack tendons leave a motion without a spring."""
    elastic, diagonal = np.flatnonzero(s.gives), np.diag(s.stiffness).copy()
    size = np.sqrt(diagonal)
    size[size == 0.0] = 1.0
    scaled = _block(K / size / size.reshape(-1, 1), elastic, elastic)
    if len(elastic) > 0 and np.linalg.eigvalsh(scaled)[0] < _LEAST_STIFFNESS:
        return K + _LEAST_STIFFNESS * np.diag(diagonal)
    return K


@kernel
def _null_space(rows: Array) -> Array:
    """(n, k) an orthonormal basis of what is across rows (m, n)."""
    m, n = rows.shape
    if m == 0:
        return np.eye(n)
    unit = rows.copy()
    for i in range(m):
        length = np.sqrt(np.dot(unit[i], unit[i]))
        if length > 0.0:
            unit[i] /= length
    _, values, across = np.linalg.svd(unit)
    rank = 0
    for value in values:
        if value > _DEPENDENT * values[0]:
            rank += 1
    return np.ascontiguousarray(across[rank:].T)


@kernel
def _block(A: Array, rows: Ints, columns: Ints) -> Array:
    """(i, j) these rows and columns of A."""
    out = np.empty((len(rows), len(columns)))
    for i in range(len(rows)):
        for j in range(len(columns)):
            out[i, j] = A[rows[i], columns[j]]
    return out


@kernel
def _others(chosen: Ints, count: int) -> Ints:
    """The numbers below `count` that are not chosen."""
    left = np.ones(count, np.bool_)
    left[chosen] = False
    return np.flatnonzero(left)


# ---------------------------------------------------------------- Tendons along routes: the joints in another posture.


@kernel
def system_in_posture(s: JointSystem, laid: TendonArms, arm_rates: Array) -> JointSystem:
    """The joints where tendons have these arms; arm_rates (t, nv, nv)."""
    nv, rows, elastic = len(s.stiffness), s.friction_rows.copy(), np.flatnonzero(s.gives)
    rows[nv:] = laid.arms_beyond
    spring_arms = np.dot(s.springs, laid.arms)
    K = s.passive + np.dot(np.ascontiguousarray(laid.arms.T), spring_arms)
    K = (K + K.T) / 2.0
    factor = np.zeros((nv, nv))
    if len(elastic) > 0:
        own = np.linalg.solve(np.linalg.cholesky(_block(K, elastic, elastic)), np.eye(len(elastic)))
        for i in range(len(elastic)):
            factor[elastic[i], elastic] = own[:, i]
    C = np.dot(factor, np.ascontiguousarray(factor.T))
    has_friction = s.has_friction.copy()
    for p in range(len(laid.wrap_friction)):
        has_friction[nv + p] = laid.wrap_friction[p] > 0.0 and np.any(laid.arms_beyond[p] != 0.0)
    return JointSystem(
        K, factor, C, s.gives, rows, s.dry_friction, has_friction, _quadratic(rows, C), s.post_tendon,
        laid.wrap_friction, s.rest, s.passive, s.preload, s.springs, s.initial_tension, s.slackens, laid.arms,
        laid.shift, spring_arms, arm_rates,
    )  # fmt: skip


@kernel
def _quadratic(rows: Array, C: Array) -> Array:
    """(m,) the diagonal of rows C rowsᵀ; rows (m, nv)."""
    return (np.dot(rows, C) * rows).sum(axis=1)


@kernel
def spring_target(s: JointSystem, commanded: Array, drawn: Array) -> Array:
    """(nv,) where springs as stiff as in this posture would drive joints whose tendons are drawn in by d (t,):
    K q = Rᵀ (d - k (l - R q)) + K_p q₀ - R₀ᵀ T₀; rigid joints go where they are commanded.
    """
    torque = np.dot(np.ascontiguousarray(s.arms.T), drawn - np.dot(s.springs, s.shift))
    return np.where(s.gives, np.dot(s.compliance, torque + np.dot(s.passive, s.rest) - s.preload), commanded)


@kernel
def commanded_draw(s: JointSystem, commanded: Array) -> Array:
    """(t,) d of tendons that hold joints free of contacts where they are commanded to be (nv,), s in that posture."""
    torque = np.dot(s.passive, commanded - s.rest) + s.preload
    torque = torque - np.dot(np.ascontiguousarray(s.arms.T), s.initial_tension)
    return least_tensions(s.arms, s.initial_tension, s.slackens, torque) + drawn_force(s, commanded)


# ---------------------------------------------------------------- The same for callers in Python.

# From the factor of the joints' compliance, how far they are driven (nv,), and what tendons pull more as arms change
# (nv, nv), to an answer, where joints come to (nv,), and the torques that contacts take (nv,); None: no answer
Solve = Callable[[Array, Array, Array], tuple[Any, Array, Array] | None]


class Joints:
    """Joints of a grasp with springs of compliance C = A Aᵀ, dry friction and tendons, in one posture.

    factor : (nv, k) A. friction : (nv,) [N·m]. cables : None without tendons. posture : (nv,) from which the rest of
    the joints' own springs is counted.
    """

    def __init__(self, factor: Array, friction: Array, cables: Cables | None, posture: Array) -> None:
        cables = Cables.without_tendons(len(friction)) if cables is None else cables
        rest = posture + cables.rest
        at_rest = cables if cables.elasticity_at is None else cables.elasticity_at(rest)[0]
        self.cables = cables
        self.system = _system_of(factor, friction, cables, rest, at_rest.arms.T @ cables.initial_tension)
        self._whole, self._near = self, (b"", self)
        self._drawn_lately = b"", np.zeros(0)

    @property
    def C(self) -> Array:
        """(nv, nv) the joints' compliance."""
        return self.system.compliance

    def at(self, q: Array) -> Joints:
        """With the arms of tendons where joints are at q (nv,)."""
        if self.cables.elasticity_at is None:
            return self
        if self._near[0] != q.tobytes():
            there, made = self.cables.elasticity_at(q)[0], object.__new__(Joints)
            made.__dict__.update(self.__dict__)
            laid = TendonArms(there.arms, there.shift, there.wrap_friction, there.arms_beyond)
            rates = self.system.arm_rates if there.arm_rates is None else there.arm_rates()
            made.cables, made.system = there, system_in_posture(self._whole.system, laid, rates)
            self._near = q.tobytes(), made
        return self._near[1]

    def _step(self, task: Task) -> JointStep:
        """What kernels are asked."""
        driven, routed = task.drawn is None, self._whole is not self
        drawn = np.zeros(len(self.system.springs)) if task.drawn is None else task.drawn
        if driven and routed:
            drawn = self._whole._drawn_to(task.commanded)
        target = spring_target(self.system, task.commanded, drawn) if routed else task.commanded
        return JointStep(task.begun, task.commanded, target, drawn, driven)

    def _drawn_to(self, commanded: Array) -> Array:
        """(t,) d of tendons that hold joints free of contacts where they are commanded to be (nv,)."""
        if self._drawn_lately[0] != commanded.tobytes():
            self._drawn_lately = commanded.tobytes(), commanded_draw(self.at(commanded).system, commanded)
        return self._drawn_lately[1]

    @property
    def still(self) -> Pull:
        """Everything sticks, and all tendons are taut."""
        s = self.system
        modes = np.zeros(len(s.friction_rows) + len(s.springs), dtype=np.int64)
        return NO_PULL._replace(modes=modes, post_friction=np.zeros(len(s.wrap_friction)))

    def solved(self, begun: Pull, task: Task, at: Array, solve: Solve) -> tuple[Any, Pull] | None:
        """The answer in which joints, posts and tendons are in the modes that were assumed, at first those of `begun`,
        and what they do. at (nv,) : where joints stand at the iterate. None where modes have no answer, or none are
        right.
        """
        s, step = self.system, self._step(task)
        trial = begin_trial(s, begun.modes, begun.post_friction)
        for _ in range(MAX_MODE_TRIALS):
            springs, H = joint_springs(s, trial), tensioned_stiffness(s, step, trial, at)
            found = solve(springs.compliance_factor, joint_command(s, springs, step, trial, at), H)
            if found is None:
                return None
            answer, q, torque = found
            read_joint_state(s, springs, step, trial, q, torque - H @ (q - at) if len(H) else torque)
            if assume_anew(s, step, trial, q):
                return answer, _pull_of(trial)
        return None

    def ends(self, begun: Pull, task: Task) -> tuple[Array, Pull]:
        """Where joints come to that meet nothing, and what they do."""
        q = task.begun
        for _ in range(MAX_MODE_TRIALS):
            here, last = self.at(q), q
            trial = begin_trial(here.system, begun.modes, begun.post_friction)
            q, settled = move_free_joints(here.system, here._step(task), trial, last)
            if not settled:
                break
            if here is self or abs(q - last).max() <= _ROUNDING:
                return q, _pull_of(trial)
        still = self.still
        return task.commanded, self.at(task.commanded).pull(still.modes, still.post_friction, task, task.commanded)

    def pull(self, modes: Ints, post_friction: Array, task: Task, q: Array) -> Pull:
        """What tendons do where joints have come to q (nv,), in modes (nv + m + t,)."""
        return _pull_of(self._read(modes, post_friction, task, q, np.zeros(len(q))))._replace(
            modes=modes, post_friction=post_friction
        )

    def rubbing(self, pull: Pull, task: Task, q: Array, torque: Array) -> Array:
        """(nv + m,) f of joints [N·m] and posts [N] where joints have come to q (nv,), with torques (nv,) left for the
        contacts.
        """
        return self._read(pull.modes, pull.post_friction, task, q, torque).friction

    def _read(self, modes: Ints, post_friction: Array, task: Task, q: Array, torque: Array) -> JointTrial:
        s, step = self.system, self._step(task)
        trial = begin_trial(s, modes, post_friction)
        read_joint_state(s, joint_springs(s, trial), step, trial, q, torque)
        return trial

    def taken(self, f: Array) -> Array:
        """(nv,) what friction f (nv + m,) takes of the torques [N·m]."""
        return read_only(np.asarray(self.system.friction_rows.T @ f))


def _pull_of(trial: JointTrial) -> Pull:
    parts = (trial.post_friction, trial.drawn, trial.tension, trial.taut)
    return Pull(trial.modes, *[read_only(part) for part in parts])


def _system_of(factor: Array, friction: Array, cables: Cables, rest: Array, preload: Array) -> JointSystem:
    """As kernels read it, in the posture of the cables."""
    C, nv = factor @ factor.T, len(friction)
    gives, K = C.diagonal() > 0.0, np.zeros_like(C)
    on = np.ix_(gives, gives)
    K[on] = np.linalg.solve(C[on], np.eye(int(gives.sum())))
    rows, dry = np.concatenate([np.eye(nv), cables.arms_beyond]), np.where(gives, friction, 0.0)  # rigid joints stick
    rubs = np.append(dry > 0.0, (cables.wrap_friction > 0.0) & cables.arms_beyond.any(axis=1))
    parts = (
        K, factor, C, gives, rows, dry, rubs, _quadratic(rows, C), cables.post_tendon, cables.wrap_friction, rest,
        cables.passive, preload, cables.springs, cables.initial_tension, np.isfinite(cables.pretension), cables.arms,
        cables.shift, cables.springs @ cables.arms, np.zeros((0, nv, nv)),
    )  # fmt: skip
    return JointSystem(*map(np.ascontiguousarray, parts))
