"""`find_rates`: how an answer responds to changes of its laws, and one-sided derivatives at kinks.

At a kink a contact's next state depends on the direction of the change. One that touches without force begins to push
or opens; one that sticks at its limit begins to slide or goes on sticking; a limit that is just reached gives way or
not. The rates obey the laws of the next state:

    opens    Δr = 0, Δv_N ≥ 0                  sticks   Δv_T = 0, nᵀΔr_T ≤ Δ(μ r_N)
    pushes   Δv_N = 0, Δr_N ≥ 0                slides   nᵀΔr_T = Δ(μ r_N), Δv_T = -λ n, λ ≥ 0
    holds    A Δr ≤ Δb                         yields   A Δr = Δb, Δs ≥ 0

Choices are tried one after the other, at most 4096 of them: few contacts are at a kink at once. The first that obeys
every sign is the derivative.
Source: Robinson, Mathematics of Operations Research 5 (1980): the directional derivative is such a problem in the
rates.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.contact.friction import limit_set
from handlcp.grasp.derivatives.active_set import least_norm_solutions
from handlcp.grasp.derivatives.linearisation import LawChange, LinearisationPoint
from handlcp.grasp.verify.contact_state import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, ContactStates
from handlcp.tolerances import RANK_TOLERANCE

# ---------------------------------------------------------------- What a contact at a kink may do next.

# α in natural units, `turn` of a state: so large that P Δr_T = 0, and friction stays along its normal
_RIGID_DIRECTION_RATIO = 1e12


class NextState(NamedTuple):
    """A contact state that may follow on a small change.

    kind, turn : as in `ContactStates`.
    faces (k, 3) : outward normals that it slides against.
    direction_unknown : whether the slip begins in a direction that is still to be found. `faces` is then a first guess,
        turned against the slip that follows from it until the two agree.
    already_slipping : whether it slips in the answer itself.
    """

    kind: int
    faces: Array = np.zeros((0, 3))
    turn: float = 0.0
    direction_unknown: bool = False
    already_slipping: bool = False


def next_states(at: LinearisationPoint, i: int) -> list[NextState]:
    """Of contact i, at its limit or at rest."""
    own, kind = at.tangential_components(i), at.states.kind[i]
    d, cone, slip, opens = len(own), at.section.faces == 0 and len(own) > 1, at.v[own], NextState(SEPARATED)
    if kind == RESTING and (d == 0 or at.friction.coefficients[i] <= 0.0):
        return [opens, NextState(GLIDING)]
    slipping, reached = bool(kind == SLIDING), normals_reached(at, i)
    slides = [NextState(SLIDING, faces, already_slipping=slipping) for faces in _subsets(reached, d)]
    if kind != RESTING:
        return slides if kind == SLIDING else [NextState(STICKING), *slides]
    speed, units = float(np.sqrt(slip @ slip)), at.scene.units
    turn = _RIGID_DIRECTION_RATIO * units.motion_unit / units.force_unit
    if speed <= at.motion_tolerance:
        if cone:
            ways = (*np.eye(d), *-np.eye(d))
            slides = [NextState(SLIDING, _pad_normals([m]), turn, direction_unknown=True) for m in ways]
        return [opens, NextState(STICKING), *slides]
    against = -slip / speed
    if cone:
        return [opens, NextState(SLIDING, _pad_normals([against]), turn, already_slipping=True)]
    friction = limit_set(at.section, d)  # it works most at a corner of these faces
    level = friction.normals.T @ friction.vertices[:, int(np.argmax(against @ friction.vertices))]
    meeting = [m for m, x in zip(friction.normals.T, level, strict=True) if x > level.max() - 1e-9]
    return [opens, *(NextState(SLIDING, faces, already_slipping=True) for faces in _subsets(meeting, d))]


def normals_reached(at: LinearisationPoint, i: int) -> list[Array]:
    """Outward normals (d,) of the friction set of contact i where its force stands: all of them without a force, but
    none of a cone.
    """
    r = at.law_forces[at.tangential_components(i)]
    reach = at.friction.coefficients[i] * at.law_forces[3 * i + 2]
    if at.section.faces == 0 and len(r) > 1:
        length = float(np.sqrt(r @ r))
        return [r / length] if length > at.force_tolerance else []
    return [m for m in limit_set(at.section, len(r)).normals.T if reach - m @ r <= at.force_tolerance]


def _subsets(normals: list[Array], d: int) -> Iterator[Array]:
    """Every choice of up to d independent ones of them, larger ones first."""
    for size in range(min(d, len(normals)), 0, -1):
        for some in itertools.combinations(normals, size):
            if np.linalg.matrix_rank(np.array(some), tol=1e-6) == size:
                yield _pad_normals(some)


def _pad_normals(normals: Sequence[Array]) -> Array:
    """Stack normals of one to three entries as rows (k, 3), padded by 0."""
    out = np.zeros((len(normals), 3))
    out[:, : len(normals[0])] = normals
    return out


# ---------------------------------------------------------------- Where that is asked.

_MAX_COMBINATIONS = 4096  # combinations that are tried
_SIGN_TOLERANCE = 1e-9  # of the largest rate: a sign that is missed by less is kept
_MAX_DIRECTION_ROUNDS = 100  # in search of the direction of a slip that begins


@dataclass(frozen=True, slots=True)
class DerivativeKink:
    """Why a derivative has two sides. who : a finger, or the name of a limit. what : "touches without force", "is at
    the limit of its friction", "is just reached", or "just touches where it was detected". contact : its number; None
    for a limit. by : the parameters whose derivatives alone have two sides; () for all.
    """

    who: str
    what: str
    contact: int | None
    by: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.who} {self.what}" + (f" (by {' and '.join(self.by)})" if self.by else "")


def find_kinks(at: LinearisationPoint) -> tuple[DerivativeKink, ...]:
    """Of contacts, then of limits in the order in which they are reached."""
    found, reached = [], at.reached_limits
    for i in np.flatnonzero(at.scene.force_unknown_mask):
        if at.states.kind[i] == RESTING:
            found.append(DerivativeKink(at.spec.names[i], "touches without force", int(i)))
        elif _is_at_edge(at, int(i)):
            found.append(DerivativeKink(at.spec.names[i], "is at the limit of its friction", int(i)))
    limits = [name for name, gives in zip(reached.names, reached.gives, strict=True) if not gives]
    return (*found, *(DerivativeKink(name, "is just reached", None) for name in limits))


def _is_at_edge(at: LinearisationPoint, i: int) -> bool:
    """Whether a contact sticks at its limit, or slides with its force where several faces of its pyramid meet, but its
    slip against fewer of them.
    """
    own, kind, rank = at.tangential_components(i), at.states.kind[i], int(at.states.face_count[i])
    if kind == STICKING:
        r, push = at.law_forces[own], at.law_forces[3 * i + 2]
        if at.section.faces == 0 and len(own) > 1:
            return bool(at.friction.coefficients[i] * push - np.sqrt(r @ r) <= at.force_tolerance)
        return bool(normals_reached(at, i))
    slip = at.v[own]
    for some in itertools.combinations(normals_reached(at, i), rank - 1) if kind == SLIDING and rank > 1 else ():
        faces = np.array(some)
        shares = np.linalg.lstsq(faces.T, -slip, rcond=None)[0]
        missed = float(abs(faces.T @ shares + slip).max())
        if (shares >= -at.motion_tolerance).all() and missed <= at.motion_tolerance:
            return True
    return False


def one_sided_changes(at: LinearisationPoint, kinks: tuple[DerivativeKink, ...], b: Array) -> tuple[Array, Array]:
    """Find how an answer changes on one side of its kinks, and what stays free: (x (k,), N (k, j)).

    x are the changes in natural units for right-hand sides b (k + n,) as `LinearisationPoint` has them; NaN where no
    next state that is tried is consistent: but for those that are not tried, nothing near is an answer on that side.
    N spans the changes that no law of the next states resists.
    """
    reached, contacts = at.reached_limits, [k.contact for k in kinks if k.contact is not None]
    every = [next_states(at, i) for i in contacts]
    limits = [(True,) if gives else (False, True) for gives in reached.gives]
    ways: Iterator[tuple[Any, ...]] = itertools.product(*every, *limits)
    for way in itertools.islice(ways, _MAX_COMBINATIONS):
        picked, gives = dict(zip(contacts, way, strict=False)), np.array(way[len(contacts) :], bool)
        if (found := _changes_with(at, picked, gives, b)) is not None:
            return found
    size = len(at.laws.K)
    return np.full(size, np.nan), np.zeros((size, 0))


def _changes_with(
    at: LinearisationPoint, picked: dict[int, NextState], gives: Bools, b: Array
) -> tuple[Array, Array] | None:
    """The changes where contacts have these next states; None where they do not keep every sign."""
    c, free = at.scene.components, [i for i, p in picked.items() if p.direction_unknown]
    for _ in range(_MAX_DIRECTION_ROUNDS if free else 1):
        A, B = at.equations(_with_next_states(at.states, picked), gives)
        found, N = least_norm_solutions(A, (B @ b)[:, None], RANK_TOLERANCE)
        if np.isnan(found).any():
            return None
        x, dv = found[:, 0], at.contact_motion_changes(found)[:, 0] + b[:c] * at.scene.units.motion_unit
        change = 0.0
        for i in free:
            slip = dv[at.tangential_components(i)]
            if (speed := float(np.sqrt(slip @ slip))) > 0.0:
                before, after = picked[i].faces, _pad_normals([-slip / speed])
                change = max(change, float(abs(after - before).max()))
                picked[i] = picked[i]._replace(faces=after)
        if change <= 1e-14:
            break
    fits = all(_keeps_signs(at, i, p, x, dv, b) for i, p in picked.items())
    return (x, N) if fits and _limits_keep(at, x, gives, b) else None


def _with_next_states(states: ContactStates, picked: dict[int, NextState]) -> ContactStates:
    """The states with these contacts' next ones."""
    kind, against, faces, turn = states.kind.copy(), states.face_count.copy(), states.faces.copy(), states.turn.copy()
    for i, p in picked.items():
        kind[i], against[i], turn[i], faces[i] = p.kind, len(p.faces), p.turn, 0.0
        faces[i, : len(p.faces)] = p.faces
    return ContactStates(kind, against, faces, turn)


def _keeps_signs(at: LinearisationPoint, i: int, state: NextState, x: Array, dv: Array, b: Array) -> bool:
    """Whether a contact's rates have the signs of its next state."""
    t, force = at.tangential_components(i), x[: at.scene.components]
    small = _SIGN_TOLERANCE * float(abs(force).max())
    slow = _SIGN_TOLERANCE * float(max(abs(dv).max(), at.scene.units.motion_unit * abs(x).max()))
    if state.kind == SEPARATED:
        return bool(dv[3 * i + 2] >= -slow)
    if at.states.kind[i] == RESTING and force[3 * i + 2] < -small:
        return False
    if state.kind == GLIDING:
        return True
    room, reached = at.friction.coefficients[i] * force[3 * i + 2] + b[len(x) + i], normals_reached(at, i)
    if state.kind == STICKING and not reached:  # a cone at rest
        return bool(np.sqrt(force[t] @ force[t]) <= room + small)
    if state.kind == STICKING:
        return all(float(m @ force[t]) <= room + small for m in reached)
    if state.turn > 0.0 and state.already_slipping:  # friction is against the slip by construction
        return True
    faces = state.faces[:, : len(t)]
    now, more = (-np.linalg.lstsq(faces.T, v[t], rcond=None)[0] for v in (at.v, dv))
    if float(abs(faces.T @ now + at.v[t]).max()) > at.motion_tolerance:  # it slips against another face, too
        return False
    others = [m for m in reached if float(abs(faces - m).max(axis=1).min()) > 1e-9]
    inside = state.direction_unknown or all(float(m @ force[t]) <= room + small for m in others)
    return inside and bool((more[now <= at.motion_tolerance] >= -slow).all())


def _limits_keep(at: LinearisationPoint, x: Array, gives: Bools, b: Array) -> bool:
    """Whether limits that are just reached hold, or yield outwards."""
    reached, c, own = at.reached_limits, at.scene.components, slice(at.scene.components + at.scene.dof, len(x))
    outwards = np.where(gives, x[own], -b[own] - reached.rows @ x[:c])
    return bool((outwards[~reached.gives] >= -_SIGN_TOLERANCE * float(abs(x).max(initial=0.0))).all())


# ---------------------------------------------------------------- One elimination for all changes, or one side each.

_FREE_TOLERANCE = 1e-7  # what the free directions of a singular system move by less is determined


class ResponseRates(NamedTuple):
    """What p parameters do to an answer, SI, each (…, p). forces (c, p) in contact axes, moments of soft contacts last;
    object_twist (6, p) about the reference; contact_motion (c, p) of v, contact axes: slips and normal gaps. NaN where
    it is not determined.
    """

    forces: Array
    object_twist: Array
    contact_motion: Array


def free_directions(at: LinearisationPoint) -> Array:
    """(k, j) what spans the changes that no law resists, natural units; j = 0: there are none."""
    if at.response_matrix[1]:
        return np.zeros((len(at.laws.K), 0))
    A, _ = at.equations(at.states, at.reached_limits.gives)
    return least_norm_solutions(A, A[:, :0], RANK_TOLERANCE)[1]


def find_rates(at: LinearisationPoint, kinks: tuple[DerivativeKink, ...], change: LawChange) -> ResponseRates:
    """The rates; at kinks those of a growing parameter, column by column."""
    b, c, units, scale = at.right_hand_sides(change), at.scene.components, at.scene.units, at.scale[:, None]
    matrix, regular = at.response_matrix
    free: list[tuple[slice, Array]] = []
    if kinks:
        found = [one_sided_changes(at, kinks, column) for column in b.T]
        x = np.column_stack([np.zeros((len(matrix), 0)), *[x for x, _ in found]])
        free = [(slice(k, k + 1), N) for k, (_, N) in enumerate(found)]
    elif regular:
        x = matrix @ b
    else:
        A, B = at.equations(at.states, at.reached_limits.gives)
        x, N = least_norm_solutions(A, B @ b, RANK_TOLERANCE)
        free = [(slice(None), N)]
    forces = x[:c] * units.force_unit * scale
    contact_motion = (at.contact_motion_changes(x) + change.contact_motion) / scale
    rates = ResponseRates(forces, at.object_twist(x), contact_motion)
    twist_scaling = np.repeat([1.0, units.length_unit], 3)[:, None]
    for columns, N in free:
        twist = at.object_twist(N) * twist_scaling / units.motion_unit
        moved = N[:c], twist, at.contact_motion_changes(N) / units.motion_unit
        for rate, more in zip(rates, moved, strict=True):
            rate[abs(more).max(axis=1, initial=0.0) > _FREE_TOLERANCE, columns] = np.nan
    return rates
