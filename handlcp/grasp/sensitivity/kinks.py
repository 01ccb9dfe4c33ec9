"""One-sided derivatives where a contact's next state depends on the direction of the change.

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
from handlcp.grasp.friction import limit_set
from handlcp.grasp.sensitivity.stand import Stand
from handlcp.grasp.tangent.solutions import smallest
from handlcp.grasp.verify.contact_states import GLIDING, RESTING, SEPARATED, SLIDING, STICKING, States
from handlcp.tolerances import RANK

# ---------------------------------------------------------------- What a contact at a kink may do next.

_AT_ONCE = 1e12  # natural units: friction that is against its contact's slip from the beginning


class Next(NamedTuple):
    """kind, turn : as in `States`. faces (k, 3) : outward normals that it slides against. follows : whether the normal
    is against the slip that begins, which is not known before. slips : whether it slips already.
    """

    kind: int
    faces: Array
    turn: float = 0.0
    follows: bool = False
    slips: bool = False

    def turned(self, normal: Array) -> Next:
        """Against another slip."""
        return self._replace(faces=_padded([normal]))


def next_states(at: Stand, i: int) -> list[Next]:
    """Of contact i, at its limit or at rest."""
    answer, none, kind = at.answer, np.zeros((0, 3)), at.states.kind[i]
    own = [int(j) for j in answer.scene.kind.contact_components[i, 1:] if j >= 0]
    d, cone = len(own), answer.section.faces == 0 and len(own) > 1
    if kind == SLIDING:
        return [Next(SLIDING, f, slips=True) for f in _subsets(normals_reached(at, i), d)]
    if kind != RESTING:
        return [Next(STICKING, none), *(Next(SLIDING, f) for f in _subsets(normals_reached(at, i), d))]
    opens, slip = Next(SEPARATED, none), at.v[own]
    if d == 0 or answer.friction.limits[i] <= 0.0:
        return [opens, Next(GLIDING, none)]
    speed, at_once = float(np.sqrt(slip @ slip)), _AT_ONCE * answer.sizes[1] / answer.sizes[0]
    if speed > answer.slow and cone:
        return [opens, Next(SLIDING, _padded([-slip / speed]), at_once, slips=True)]
    if speed > answer.slow:
        return [opens, *(Next(SLIDING, f, slips=True) for f in _subsets(_corner(at, i, -slip / speed), d))]
    if cone:
        starts = [Next(SLIDING, _padded([m]), at_once, follows=True) for m in (*np.eye(d), *-np.eye(d))]
        return [opens, Next(STICKING, none), *starts]
    return [opens, Next(STICKING, none), *(Next(SLIDING, f) for f in _subsets(normals_reached(at, i), d))]


def normals_reached(at: Stand, i: int) -> list[Array]:
    """Outward normals (d,) of the friction set of contact i where its force stands: all of them without a force."""
    answer = at.answer
    own = [int(j) for j in answer.scene.kind.contact_components[i, 1:] if j >= 0]
    r, d = answer.lawful[own], len(own)
    if answer.section.faces == 0 and d > 1:
        length = float(np.sqrt(r @ r))
        return [r / length] if length > answer.weak else []
    reach = answer.friction.limits[i] * answer.lawful[3 * i + 2]
    return [m for m in limit_set(answer.section, d).normals.T if reach - m @ r <= answer.weak]


def _corner(at: Stand, i: int, against: Array) -> list[Array]:
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
                yield _padded(list(some))


def _padded(normals: list[Array]) -> Array:
    """Rows of three."""
    out = np.zeros((len(normals), 3))
    for row, m in zip(out, normals, strict=True):
        row[: len(m)] = m
    return out


# ----------------------------------------------------------------

_MOST = 4096  # combinations that are tried
_SMALL = 1e-9  # of the largest rate: a sign that is missed by less is kept
_ROUNDS = 100  # in search of the direction of a slip that begins


@dataclass(frozen=True, slots=True)
class Kink:
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


def kinks_at(at: Stand) -> tuple[Kink, ...]:
    """Of contacts, then of limits in the order in which they are reached."""
    reached = at.answer.yielding
    if not (at.found.edge.any() or (at.states.against > 1).any() or len(reached.at)):
        return ()
    names, found = at.answer.spec.names, []
    for i in range(at.answer.scene.n):
        if at.found.edge[i] or (at.states.kind[i] == SLIDING and _grazes(at, i)):
            rests = at.states.kind[i] == RESTING
            found.append(Kink(names[i], "touches without force" if rests else "is at the limit of its friction", i))
    of_limits = [limit.name for limit in reached.every for _ in range(len(limit.room))]
    return (*found, *(Kink(of_limits[k], "is just reached", None) for k in reached.at[reached.active :]))


def _grazes(at: Stand, i: int) -> bool:
    """Whether a contact's force is where several faces of its pyramid meet, but its slip against fewer of them."""
    if at.states.against[i] < 2:
        return False
    slip, rank = at.v[_tangents(at, i)], int(at.states.against[i])
    for some in itertools.combinations(normals_reached(at, i), rank - 1):
        faces = np.array(some)
        shares = np.linalg.lstsq(faces.T, -slip, rcond=None)[0]
        if (shares >= -at.answer.slow).all() and float(abs(faces.T @ shares + slip).max()) <= at.answer.slow:
            return True
    return False


def one_sided(at: Stand, kinks: tuple[Kink, ...], b: Array) -> tuple[Array, Array]:
    """(x (k,), N (k, j)): the changes in natural units for right-hand sides b (k + n,) as `Stand` has them, and what
    spans the changes that no law of the next states resists. NaN where no next state is consistent: nothing near is an
    answer on that side.
    """
    reached, contacts = at.answer.yielding, [k.contact for k in kinks if k.contact is not None]
    every = [next_states(at, i) for i in contacts]
    resting = len(reached.at) - reached.active
    ways = itertools.product(*every, *([(False, True)] * resting))
    for way in itertools.islice(ways, _MOST):
        picked: list[Any] = list(way[: len(contacts)])
        gives = np.array((True,) * reached.active + way[len(contacts) :], bool)
        found = _rates(at, contacts, picked, gives, b)
        if found is not None:
            return found
    size = len(at.found.inverse)
    return np.full(size, np.nan), np.zeros((size, 0))


def _rates(at: Stand, contacts: list[int], picked: list[Next], gives: Bools, b: Array) -> tuple[Array, Array] | None:
    """The changes with these next states where they keep every sign; None where they do not."""
    c, free = at.answer.scene.components, [k for k, p in enumerate(picked) if p.follows]
    for _ in range(_ROUNDS if free else 1):
        A, B = at.equations(_with(at.states, contacts, picked), gives)
        x, N = smallest(A, (B @ b)[:, None], RANK)
        if np.isnan(x).any():
            return None
        dv = at.moved(x)[:, 0] + b[:c] * at.answer.sizes[1]
        change = 0.0
        for k in free:
            slip = dv[_tangents(at, contacts[k])]
            if (speed := float(np.sqrt(slip @ slip))) > 0.0:
                new = picked[k].turned(-slip / speed)
                change = max(change, float(abs(new.faces - picked[k].faces).max()))
                picked[k] = new
        if change <= 1e-14:
            break
    fits = all(_keeps(at, i, p, x[:, 0], dv, b) for i, p in zip(contacts, picked, strict=True))
    return (x[:, 0], N) if fits and _limits_keep(at, x[:, 0], gives, b) else None


def _keeps(at: Stand, i: int, state: Next, x: Array, dv: Array, b: Array) -> bool:
    """Whether a contact's rates have the signs of its next state."""
    answer = at.answer
    t, force = _tangents(at, i), x[: answer.scene.components]
    small, slow = _SMALL * float(abs(force).max()), _SMALL * float(max(abs(dv).max(), answer.sizes[1] * abs(x).max()))
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
    if float(abs(faces.T @ now + at.v[t]).max()) > answer.slow:  # it slips against another face, too
        return False
    others = [m for m in normals_reached(at, i) if float(abs(faces - m).max(axis=1).min()) > 1e-9]
    inside = state.follows or all(float(m @ force[t]) <= room + small for m in others)
    return inside and bool((more[now <= answer.slow] >= -slow).all())


def _limits_keep(at: Stand, x: Array, gives: Bools, b: Array) -> bool:
    """Whether limits that are just reached hold, or yield outwards."""
    reached, scene = at.answer.yielding, at.answer.scene
    new, own = np.arange(len(reached.at)) >= reached.active, slice(scene.components + scene.dof, len(x))
    room = -b[own] - reached.rows @ x[: scene.components]
    small = _SMALL * float(abs(x).max(initial=0.0))
    return bool((np.where(gives, x[own], room)[new] >= -small).all())


def _tangents(at: Stand, i: int) -> list[int]:
    """The tangential components of a contact."""
    own = at.answer.scene.kind.contact_components[i, 1:]
    return [int(j) for j in own if j >= 0]


def _with(states: States, contacts: list[int], picked: list[Next]) -> States:
    """The states with these contacts' next ones."""
    kind, against, faces, turn = states.kind.copy(), states.against.copy(), states.faces.copy(), states.turn.copy()
    for i, p in zip(contacts, picked, strict=True):
        kind[i], against[i], turn[i] = p.kind, len(p.faces), p.turn
        faces[i] = 0.0
        faces[i, : len(p.faces)] = p.faces
    return States(kind, against, faces, turn)
