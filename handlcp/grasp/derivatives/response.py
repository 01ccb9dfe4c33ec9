"""`LinearResponse`: one-sided derivatives where a contact's next state depends on the direction of the change.

A contact that touches without force begins to push or opens; one that sticks at its limit begins to slide or goes on
sticking; a limit that is just reached gives way or not. The rates obey the laws of the next state:

    opens    Δr = 0, Δv_N ≥ 0                  sticks   Δv_T = 0, nᵀΔr_T ≤ Δ(μ r_N)
    pushes   Δv_N = 0, Δr_N ≥ 0                slides   nᵀΔr_T = Δ(μ r_N), Δv_T = -λ n, λ ≥ 0
    holds    A Δr ≤ Δb                         yields   A Δr = Δb, Δs ≥ 0

Few contacts are at a kink at once, so that all choices are tried; the first that obeys every sign is the derivative.
Source: Robinson, Mathematics of Operations Research 5 (1980): the directional derivative is such a problem in the
rates.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from handlcp.check import Array, Bools
from handlcp.contact.friction import limit_set
from handlcp.grasp.derivatives.active_set import least_norm_solutions
from handlcp.grasp.derivatives.linearisation import LinearisedPoint
from handlcp.grasp.derivatives.linearisation_point import LawChange, LinearisationPoint, ResponseRates
from handlcp.grasp.verify.contact_state import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, ContactStates
from handlcp.lazy_property import lazy_property
from handlcp.tolerances import RANK_TOLERANCE

# ---------------------------------------------------------------- What a contact at a kink may do next.

_IMMEDIATE_TURN = 1e12  # natural units: friction that is against its contact's slip from the beginning


class NextState(NamedTuple):
    """A contact state that may follow on a small change.

    kind, turn : as in `ContactStates`.
    faces (k, 3) : outward normals that it slides against.
    follows : whether the normal is against the slip that begins, which is not known before.
    slips : whether it slips already.
    """

    kind: int
    faces: Array
    turn: float = 0.0
    follows: bool = False
    slips: bool = False

    def with_slip_against(self, normal: Array) -> NextState:
        """The same state, sliding against another outward normal (3,) or (2,)."""
        return self._replace(faces=_pad_normals([normal]))


def next_states(at: LinearisedPoint, i: int) -> list[NextState]:
    """Of contact i, at its limit or at rest."""
    answer, none, kind = at.answer, np.zeros((0, 3)), at.states.kind[i]
    own = [int(j) for j in answer.scene.kind.contact_components[i, 1:] if j >= 0]
    d, cone = len(own), answer.section.faces == 0 and len(own) > 1
    if kind == SLIDING:
        return [NextState(SLIDING, f, slips=True) for f in _subsets(normals_reached(at, i), d)]
    if kind != RESTING:
        return [NextState(STICKING, none), *(NextState(SLIDING, f) for f in _subsets(normals_reached(at, i), d))]
    opens, slip = NextState(SEPARATED, none), at.v[own]
    if d == 0 or answer.friction.limits[i] <= 0.0:
        return [opens, NextState(GLIDING, none)]
    speed, at_once = float(np.sqrt(slip @ slip)), _IMMEDIATE_TURN * answer.sizes[1] / answer.sizes[0]
    if speed > answer.motion_tolerance and cone:
        return [opens, NextState(SLIDING, _pad_normals([-slip / speed]), at_once, slips=True)]
    if speed > answer.motion_tolerance:
        return [opens, *(NextState(SLIDING, f, slips=True) for f in _subsets(_corner_faces(at, i, -slip / speed), d))]
    if cone:
        starts = [NextState(SLIDING, _pad_normals([m]), at_once, follows=True) for m in (*np.eye(d), *-np.eye(d))]
        return [opens, NextState(STICKING, none), *starts]
    return [opens, NextState(STICKING, none), *(NextState(SLIDING, f) for f in _subsets(normals_reached(at, i), d))]


def normals_reached(at: LinearisedPoint, i: int) -> list[Array]:
    """Outward normals (d,) of the friction set of contact i where its force stands: all of them without a force."""
    answer = at.answer
    own = [int(j) for j in answer.scene.kind.contact_components[i, 1:] if j >= 0]
    r, d = answer.law_forces[own], len(own)
    if answer.section.faces == 0 and d > 1:
        length = float(np.sqrt(r @ r))
        return [r / length] if length > answer.force_tolerance else []
    reach = answer.friction.limits[i] * answer.law_forces[3 * i + 2]
    return [m for m in limit_set(answer.section, d).normals.T if reach - m @ r <= answer.force_tolerance]


def _corner_faces(at: LinearisedPoint, i: int, against: Array) -> list[Array]:
    """The faces that meet where a force works most along a direction."""
    found = limit_set(at.answer.section, len(against))
    corner = found.vertices[:, int(np.argmax(against @ found.vertices))]
    level = found.normals.T @ corner
    return [m for m, x in zip(found.normals.T, level, strict=True) if x > level.max() - 1e-9]


def _subsets(normals: list[Array], d: int) -> Iterator[Array]:
    """Every choice of up to d independent ones of them, larger ones first."""
    for size in range(min(d, len(normals)), 0, -1):
        for some in itertools.combinations(normals, size):
            if np.linalg.matrix_rank(np.array(some), tol=1e-6) == size:
                yield _pad_normals(list(some))


def _pad_normals(normals: list[Array]) -> Array:
    """Stack normals of two or three entries as rows (k, 3), padded by 0."""
    out = np.zeros((len(normals), 3))
    for row, m in zip(out, normals, strict=True):
        row[: len(m)] = m
    return out


# ----------------------------------------------------------------

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


def find_kinks(at: LinearisedPoint) -> tuple[DerivativeKink, ...]:
    """Of contacts, then of limits in the order in which they are reached."""
    reached = at.answer.reached_limits
    if not (at.linearisation.edge.any() or (at.states.face_count > 1).any() or len(reached.at)):
        return ()
    names, found = at.answer.spec.names, []
    for i in range(at.answer.scene.n):
        if at.linearisation.edge[i] or (at.states.kind[i] == SLIDING and _grazes_edge(at, i)):
            rests = at.states.kind[i] == RESTING
            found.append(
                DerivativeKink(names[i], "touches without force" if rests else "is at the limit of its friction", i)
            )
    of_limits = [limit.name for limit in reached.every for _ in range(len(limit.room))]
    return (*found, *(DerivativeKink(of_limits[k], "is just reached", None) for k in reached.at[reached.active :]))


def _grazes_edge(at: LinearisedPoint, i: int) -> bool:
    """Whether a contact's force is where several faces of its pyramid meet, but its slip against fewer of them."""
    if at.states.face_count[i] < 2:
        return False
    slip, rank = at.v[_tangential_components(at, i)], int(at.states.face_count[i])
    for some in itertools.combinations(normals_reached(at, i), rank - 1):
        faces = np.array(some)
        shares = np.linalg.lstsq(faces.T, -slip, rcond=None)[0]
        if (shares >= -at.answer.motion_tolerance).all() and float(
            abs(faces.T @ shares + slip).max()
        ) <= at.answer.motion_tolerance:
            return True
    return False


def one_sided_changes(at: LinearisedPoint, kinks: tuple[DerivativeKink, ...], b: Array) -> tuple[Array, Array]:
    """Find how an answer changes on one side of its corners, and what stays free: (x (k,), N (k, j)).

    x are the changes in natural units for right-hand sides b (k + n,) as `LinearisedPoint` has them; NaN where no next
    state is consistent: nothing near is an answer on that side. N spans the changes that no law of the next states
    resists.
    """
    reached, contacts = at.answer.reached_limits, [k.contact for k in kinks if k.contact is not None]
    every = [next_states(at, i) for i in contacts]
    resting = len(reached.at) - reached.active
    ways = itertools.product(*every, *([(False, True)] * resting))
    for way in itertools.islice(ways, _MAX_COMBINATIONS):
        picked: list[Any] = list(way[: len(contacts)])
        gives = np.array((True,) * reached.active + way[len(contacts) :], bool)
        found = _rates_with(at, contacts, picked, gives, b)
        if found is not None:
            return found
    size = len(at.linearisation.inverse)
    return np.full(size, np.nan), np.zeros((size, 0))


def _rates_with(
    at: LinearisedPoint, contacts: list[int], picked: list[NextState], gives: Bools, b: Array
) -> tuple[Array, Array] | None:
    """The changes with these next states where they keep every sign; None where they do not."""
    c, free = at.answer.scene.components, [k for k, p in enumerate(picked) if p.follows]
    for _ in range(_MAX_DIRECTION_ROUNDS if free else 1):
        A, B = at.equations(_with_next_states(at.states, contacts, picked), gives)
        x, N = least_norm_solutions(A, (B @ b)[:, None], RANK_TOLERANCE)
        if np.isnan(x).any():
            return None
        dv = at.motion_changes(x)[:, 0] + b[:c] * at.answer.sizes[1]
        change = 0.0
        for k in free:
            slip = dv[_tangential_components(at, contacts[k])]
            if (speed := float(np.sqrt(slip @ slip))) > 0.0:
                new = picked[k].with_slip_against(-slip / speed)
                change = max(change, float(abs(new.faces - picked[k].faces).max()))
                picked[k] = new
        if change <= 1e-14:
            break
    fits = all(_keeps_signs(at, i, p, x[:, 0], dv, b) for i, p in zip(contacts, picked, strict=True))
    return (x[:, 0], N) if fits and _limits_keep(at, x[:, 0], gives, b) else None


def _keeps_signs(at: LinearisedPoint, i: int, state: NextState, x: Array, dv: Array, b: Array) -> bool:
    """Whether a contact's rates have the signs of its next state."""
    answer = at.answer
    t, force = _tangential_components(at, i), x[: answer.scene.components]
    small, slow = (
        _SIGN_TOLERANCE * float(abs(force).max()),
        _SIGN_TOLERANCE * float(max(abs(dv).max(), answer.sizes[1] * abs(x).max())),
    )
    if state.kind == SEPARATED:
        return bool(dv[3 * i + 2] >= -slow)
    if at.states.kind[i] == RESTING and force[3 * i + 2] < -small:
        return False
    if state.kind == GLIDING:
        return True
    room = answer.friction.limits[i] * force[3 * i + 2] + b[len(x) + i]
    if state.kind == STICKING and not len(reached := normals_reached(at, i)):  # a cone at rest
        return bool(np.sqrt(force[t] @ force[t]) <= room + small)
    if state.kind == STICKING:
        return all(float(m @ force[t]) <= room + small for m in reached)
    if state.turn > 0.0 and state.slips:  # friction is against the slip by construction
        return True
    faces = state.faces[:, : len(t)]
    now, more = (-np.linalg.lstsq(faces.T, v[t], rcond=None)[0] for v in (at.v, dv))
    if float(abs(faces.T @ now + at.v[t]).max()) > answer.motion_tolerance:  # it slips against another face, too
        return False
    others = [m for m in normals_reached(at, i) if float(abs(faces - m).max(axis=1).min()) > 1e-9]
    inside = state.follows or all(float(m @ force[t]) <= room + small for m in others)
    return inside and bool((more[now <= answer.motion_tolerance] >= -slow).all())


def _limits_keep(at: LinearisedPoint, x: Array, gives: Bools, b: Array) -> bool:
    """Whether limits that are just reached hold, or yield outwards."""
    reached, scene = at.answer.reached_limits, at.answer.scene
    new, own = np.arange(len(reached.at)) >= reached.active, slice(scene.components + scene.dof, len(x))
    room = -b[own] - reached.rows @ x[: scene.components]
    small = _SIGN_TOLERANCE * float(abs(x).max(initial=0.0))
    return bool((np.where(gives, x[own], room)[new] >= -small).all())


def _tangential_components(at: LinearisedPoint, i: int) -> list[int]:
    """The tangential components of a contact."""
    own = at.answer.scene.kind.contact_components[i, 1:]
    return [int(j) for j in own if j >= 0]


def _with_next_states(states: ContactStates, contacts: list[int], picked: list[NextState]) -> ContactStates:
    """The states with these contacts' next ones."""
    kind, against, faces, turn = states.kind.copy(), states.face_count.copy(), states.faces.copy(), states.turn.copy()
    for i, p in zip(contacts, picked, strict=True):
        kind[i], against[i], turn[i] = p.kind, len(p.faces), p.turn
        faces[i] = 0.0
        faces[i, : len(p.faces)] = p.faces
    return ContactStates(kind, against, faces, turn)


# ----------------------------------------------------------------
# How an answer responds to changes: one elimination for all of them, and one side after the other at a kink.


_FREE_TOLERANCE = 1e-7  # what the free directions of a singular system move by less is determined


@dataclass(frozen=True, eq=False)
class LinearResponse:
    """Of an answer, at which it stands."""

    at: LinearisedPoint

    @classmethod
    def from_point(cls, answer: LinearisationPoint) -> LinearResponse:
        """Where it stands, and what unit changes do to it."""
        return cls(LinearisedPoint.linearise(answer))

    @lazy_property
    def kinks(self) -> tuple[DerivativeKink, ...]:
        """Contacts and limits whose next state depends on the direction of the change."""
        return find_kinks(self.at)

    @lazy_property
    def free(self) -> Array:
        """(k, j) what spans the changes that no law resists, natural units; j = 0: there are none."""
        if self.at.linearisation.regular:
            return np.zeros((len(self.at.linearisation.inverse), 0))
        A, _ = self.at.equations(self.at.states, self._yielding)
        return least_norm_solutions(A, np.zeros((len(A), 0)), RANK_TOLERANCE)[1]

    @property
    def _yielding(self) -> Bools:
        """(m,) the limits that give way."""
        reached = self.at.answer.reached_limits
        return np.arange(len(reached.at)) < reached.active

    def rates_for(self, change: LawChange) -> ResponseRates:
        """The rates; at a kink those of a growing parameter, column by column."""
        at, b = self.at, self.at.right_hand_sides(change)
        if self.kinks:
            found = [one_sided_changes(at, self.kinks, column) for column in b.T]
            none = np.zeros((len(at.linearisation.inverse), 0))
            rates = self._rates(np.column_stack([none, *[x for x, _ in found]]), change)
            for k, (_, free) in enumerate(found):
                self._leave_open(rates, slice(k, k + 1), free)
            return rates
        if at.linearisation.regular:
            return self._rates(at.linearisation.inverse @ b, change)
        A, B = at.equations(at.states, self._yielding)
        rates = self._rates(least_norm_solutions(A, B @ b, RANK_TOLERANCE)[0], change)
        self._leave_open(rates, slice(None), self.free)
        return rates

    def _rates(self, x: Array, change: LawChange) -> ResponseRates:
        """In SI and contact axes."""
        at, c = self.at, self.at.answer.scene.components
        scale = at.answer.scale[:, None]
        forces, motion = x[:c] * at.answer.sizes[0] * scale, at.motion(x)
        return ResponseRates(forces, motion, (at.motion_changes(x) + change.motion) / scale)

    def _leave_open(self, rates: ResponseRates, columns: slice, N: Array) -> None:
        """Write NaN into columns of rates, for what N (k, j) leaves free."""
        if not N.shape[1]:
            return
        at, units, c = self.at, self.at.answer.sizes, self.at.answer.scene.components
        rates.forces[abs(N[:c]).max(axis=1) > _FREE_TOLERANCE, columns] = np.nan
        moved = at.motion(N) / (units[1] / np.array((1.0,) * 3 + (units[2],) * 3))[:, None]
        rates.motion[abs(moved).max(axis=1) > _FREE_TOLERANCE, columns] = np.nan
        rates.slip[abs(at.motion_changes(N)).max(axis=1) > _FREE_TOLERANCE * units[1], columns] = np.nan
