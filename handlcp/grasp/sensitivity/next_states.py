"""What a contact at a kink may do next."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from handlcp.check import Array
from handlcp.grasp.friction import limit_set
from handlcp.grasp.sensitivity.stand import Stand
from handlcp.grasp.verify.contact_states import GLIDING, RESTING, SEPARATED, SLIDING, STICKING

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
