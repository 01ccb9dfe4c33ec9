"""What each contact does at an answer: separated, sticking or sliding, and against which faces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.grasp.assembly.candidate import Candidate
from handlcp.grasp.friction import Section, limit_set
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.verify.judge import Verdict
from handlcp.lcp.kernels.compile import kernel
from handlcp.tolerances import ACTIVE

__all__ = [
    "GLIDING", "RESTING", "SEPARATED", "SLIDING", "STICKING", "FaceNormals", "States", "classify", "face_normals",
    "find_states", "names_of",
]  # fmt: skip

# GLIDING pushes without friction, RESTING touches without pushing
SEPARATED, STICKING, SLIDING, GLIDING, RESTING = 0, 1, 2, 3, 4
_NAMES = ("separated", "sticking", "sliding", "sliding", "separated")
_ALONG = 1e-6  # a normal this near to the span of others is one of theirs


class States(NamedTuple):
    """kind (n,): one of the constants above. against (n,), faces (n, 3, 3): how many independent outward normals a
    contact slides against, and those, in rows. turn (n,): slip over friction [m/N] of a contact that slides on a round
    set, where both turn together; else 0.
    """

    kind: Ints
    against: Ints
    faces: Array
    turn: Array


class FaceNormals(NamedTuple):
    """Outward normals of a section's faces, (f, d) for d = 1, 2, 3 tangents; round: whether sets have no faces."""

    line: Array
    plane: Array
    space: Array
    round: bool


def face_normals(section: Section, soft: bool) -> FaceNormals:
    """Of a section; soft : whether any contact has three tangents."""
    one, two = (np.ascontiguousarray(limit_set(section, d).normals.T) for d in (1, 2))
    three = np.ascontiguousarray(limit_set(section, 3).normals.T) if soft else np.zeros((0, 3))
    return FaceNormals(one, two, three, section.faces == 0)


def names_of(kind: Ints) -> tuple[str, ...]:
    """For each contact "separated", "sticking" or "sliding"."""
    return tuple([_NAMES[k] for k in kind.tolist()])


def classify(scene: Scene, section: Section, candidate: Candidate, verdict: Verdict) -> States:
    """States of all contacts, of a candidate that was judged."""
    size = verdict.residuals
    weak, slow = ACTIVE * size.force_scale, ACTIVE * max(size.motion_scale, scene.units.motion)
    normals = face_normals(section, bool(scene.soft))
    contacts, limits = scene.kind.contact_components, scene.limits(section)
    return find_states(contacts, limits, normals, candidate.components, verdict.motion, weak, slow)


@kernel
def find_states(
    contacts: Ints, limits: Array, normals: FaceNormals, forces: Array, v: Array, weak: float, slow: float
) -> States:
    """Of forces (c,) [N] and motions v (c,) [m], of which those up to `weak` and `slow` count as none.

    contacts (n, 4) : as in `contact_laws`. A contact under force control follows the object: it sticks.
    """
    n = len(contacts)
    kind, count = np.zeros(n, np.int64), np.zeros(n, np.int64)
    faces, turn, r = np.zeros((n, 3, 3)), np.zeros(n), np.zeros(3)
    for i in range(n):
        if contacts[i, 0] < 0:
            kind[i] = STICKING
            continue
        tangents, slip, size = 0, 0.0, 0.0
        while tangents < 3 and contacts[i, tangents + 1] >= 0:
            j = contacts[i, tangents + 1]
            r[tangents] = forces[j]
            slip += v[j] * v[j]
            size += forces[j] * forces[j]
            tangents += 1
        slip, size, push = np.sqrt(slip), np.sqrt(size), forces[3 * i + 2]
        if not push > weak:
            kind[i] = RESTING if v[3 * i + 2] <= slow else SEPARATED
        elif limits[i] <= 0.0 or tangents == 0:
            kind[i] = GLIDING
        elif not slip > slow:
            kind[i] = STICKING
        elif not normals.round:
            own = normals.line if tangents == 1 else normals.plane if tangents == 2 else normals.space
            kind[i], count[i] = SLIDING, _active(own, tangents, limits[i] * push, r, weak, faces[i])
        elif size == 0.0:  # a friction too small for a float64 acts like none
            kind[i] = GLIDING
        else:  # one face, the tangent plane at the force
            kind[i], count[i], turn[i] = SLIDING, 1, slip / size
            for k in range(tangents):
                faces[i, 0, k] = r[k] / size
    return States(kind, count, faces, turn)


@kernel
def _active(normals: Array, tangents: int, reach: float, r: Array, weak: float, faces: Array) -> int:
    """Write independent normals of the faces that r lies on into the rows of faces (3, 3); returns how many."""
    found, basis = 0, np.zeros((3, 3))
    for j in range(len(normals)):
        left, rest = reach, np.zeros(3)
        for k in range(tangents):
            left -= normals[j, k] * r[k]
            rest[k] = normals[j, k]
        if left > weak or found == tangents:
            continue
        for q in range(found):
            along = basis[q] @ rest
            rest -= along * basis[q]
        length = np.sqrt(rest @ rest)
        if length > _ALONG:
            basis[found] = rest / length
            for k in range(tangents):
                faces[found, k] = normals[j, k]
            found += 1
    return found
