"""`ContactStates`: what each contact does at an answer: separated, sticking or sliding, and against which faces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Ints
from handlcp.contact.friction import Section
from handlcp.grasp.assembly.problem import SolverCandidate
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.status import ContactStatus
from handlcp.grasp.verify.certifier import Certification, FrictionLimits, friction_limits
from handlcp.lcp.kernels.dense import kernel
from handlcp.lcp.modes.mode_cones import STUCK, find_support, new_mode_cones, write_reach
from handlcp.lcp.modes.mode_fit import fit_mode, new_active_columns
from handlcp.tolerances import ACTIVE_TOLERANCE, CERTIFY_TOLERANCE

SEPARATED, STICKING, SLIDING, GLIDING, RESTING, UNKNOWN = map(int, ContactStatus)  # kernels take plain numbers
_SPAN_TOLERANCE = 1e-6  # a normal this near to the span of others is one of theirs


class ContactStates(NamedTuple):
    """The states of n contacts at an answer.

    kind (n,) : of `ContactStatus`.
    face_count (n,), faces (n, 3, 3) : how many independent outward normals a contact slides against, and those, in
        rows.
    turn (n,) : slip over friction [m/N] of a contact that slides on a round set, where both turn together; else 0.
    """

    kind: Ints
    face_count: Ints
    faces: Array
    turn: Array


def classify_contacts(
    scene: Scene, section: Section, candidate: SolverCandidate, certification: Certification
) -> ContactStates:
    """States of all contacts, of a candidate that was judged."""
    size = certification.residuals
    weak, slow = ACTIVE_TOLERANCE * size.force_scale, ACTIVE_TOLERANCE * max(size.motion_scale, scene.units.motion_unit)
    contacts, friction = scene.kind.contact_components, friction_limits(scene, section)
    return find_states(contacts, friction, candidate.components, certification.motion, weak, slow)


@kernel
def find_states(
    contacts: Ints, friction: FrictionLimits, forces: Array, v: Array, weak: float, slow: float
) -> ContactStates:
    """Classify contacts by forces (c,) [N] and motions v (c,) [m], of which those up to `weak` and `slow` are none.

    contacts (n, 4) : as in `SceneKind.contact_components`. A contact under force control follows the object: it sticks.
    """
    n = len(contacts)
    kind, count = np.zeros(n, np.int64), np.zeros(n, np.int64)
    faces, turn, r = np.zeros((n, 3, 3)), np.zeros(n), np.zeros(3)
    for i in range(n):
        r[:] = 0.0
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
        elif friction.coefficients[i] <= 0.0 or tangents == 0:
            kind[i] = GLIDING
        elif not slip > slow:
            kind[i] = STICKING
        elif friction.faces or tangents == 1:
            kind[i], count[i] = (
                SLIDING,
                _write_active_faces(friction, tangents, friction.coefficients[i] * push, r, weak, faces[i]),
            )
        elif size == 0.0:  # a friction too small for a float64 acts like none
            kind[i] = GLIDING
        else:  # one face, the tangent plane at the force
            kind[i], count[i], turn[i] = SLIDING, 1, slip / size
            for k in range(tangents):
                faces[i, 0, k] = r[k] / size
    return ContactStates(kind, count, faces, turn)


@kernel
def _write_active_faces(
    friction: FrictionLimits, tangents: int, reach: float, r: Array, weak: float, faces: Array
) -> int:
    """Write independent normals of the faces that r lies on into the rows of faces (3, 3); returns how many."""
    found, basis, normal = 0, np.zeros((3, 3)), np.zeros(3)
    many = 2 if tangents == 1 else friction.faces if tangents == 2 else len(friction.normals)
    for j in range(many):
        if tangents == 1:
            normal[0] = 1.0 - 2.0 * j
        elif tangents == 2:
            normal[0], normal[1] = np.cos(2.0 * np.pi * j / many), np.sin(2.0 * np.pi * j / many)
        else:
            normal[:] = friction.normals[j]
        if reach - normal @ r > weak or found == tangents:
            continue
        rest = normal.copy()
        for q in range(found):
            rest -= (basis[q] @ rest) * basis[q]
        length = np.sqrt(rest @ rest)
        if length > _SPAN_TOLERANCE:
            basis[found] = rest / length
            faces[found] = normal
            found += 1
    return found


# ----------------------------------------------------------------
# Holdability in one compiled call: the forces within friction that balance a load, or the motion in which it escapes.
#
# t = load + W a, with the a ≥ 0 in the friction cones that makes it smallest: what is left of the load when the
# contacts do all they can. By the optimality of a, no force within friction works against t, and load·t = |t|²: t is
# the proof as well as the direction in which the object goes. Its signs alone are what is believed.

BALANCED, ESCAPES, UNCLEAR = 0, 1, 2
_HIDDEN_FORCE_RATIO = 1e3  # of the load: forces up to that are what rounding in the signs may hide
_CONE_FACES = 64  # faces of the pyramid around the cone; what nothing in it holds, nothing in the cone does


@kernel
def find_escape(full_G: Array, load: Array, contacts: Ints, limits: Array, faces: int, t: Array) -> int:
    """BALANCED, or ESCAPES with a proof in t (dof,), or UNCLEAR, all in natural units.

    full_G (dof, c) : wrenches of the force components. load (dof,). contacts (n, 4) : as in
    `SceneKind.contact_components`. limits (n,), faces : of the friction sets; polyhedra are not known here.
    """
    n, dof = len(contacts), len(load)
    columns = np.zeros((dof, n, 8))
    tangents, codes, corners = np.zeros(n, np.int64), np.full(n, STUCK), np.zeros((n, 3, 3))
    for i in range(n):
        for a in range(4):
            if contacts[i, a] >= 0:
                tangents[i] = a
                for k in range(dof):
                    columns[k, i, a] = full_G[k, contacts[i, a]]
        if tangents[i] == 3 and faces > 2:
            return UNCLEAR
    cones = new_mode_cones(columns, tangents, limits, faces if faces > 0 else _CONE_FACES)
    active = new_active_columns(-load)
    left, _ = fit_mode(cones, codes, corners, active)
    if left == 0.0:
        return BALANCED
    t[:] = -active.rest
    along, of, gain, size, loss = np.zeros((n, 2, 4)), np.zeros((2, 4)), 0.0, 0.0, 0.0
    write_reach(cones, active.rest, along)
    for i in range(n):
        force, _ = find_support(cones, i, STUCK, corners[i], along[i], of)
        loss += _HIDDEN_FORCE_RATIO * max(force, 0.0)
    for k in range(dof):
        gain += load[k] * t[k]
        size += t[k] * t[k]
    length = np.sqrt(np.dot(load, load))
    return ESCAPES if gain > CERTIFY_TOLERANCE * length * np.sqrt(size) and gain > length * loss else UNCLEAR
