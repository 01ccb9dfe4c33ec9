"""`Linearisation`: where an answer stands: its contacts' motions and states, and the laws that its changes obey."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from handlcp.check import Array, Bools, Ints
from handlcp.grasp.derivatives.active_set import LinearLaws, active_rows, saddle_matrix, solve_inverse
from handlcp.grasp.derivatives.linearisation_point import LawChange, LinearisationPoint
from handlcp.grasp.model.scene import GraspArrays, wrench_map
from handlcp.grasp.verify.certifier import FrictionLimits
from handlcp.grasp.verify.contact_state import RESTING, STICKING, ContactStates, find_states
from handlcp.lcp.kernels.dense import kernel
from handlcp.tolerances import RANK_TOLERANCE


class PointArrays(NamedTuple):
    """The arrays of an answer that its derivatives need.

    reference (3,), forces (c,), twist (6,) : forces in the laws' coordinates, the twist about the reference.
    tangent (c, c) : ∂v/∂r [m/N].
    rows (m, c) : natural, of the limits that are reached.
    gives (m,) : those that give way.
    sizes (5,) : natural units of force, motion and length; `weak` and `slow` of `find_states`.
    """

    reference: Array
    forces: Array
    twist: Array
    tangent: Array
    rows: Array
    gives: Bools
    sizes: Array


class Linearisation(NamedTuple):
    """An answer linearised while its contacts keep their states.

    v (c,) : motions, as the certifier has them.
    states : of the contacts.
    edge (n,) : 1 where a contact rests, or sticks at its limit, so that its next state depends on the change.
    laws : about the reference.
    inverse (k, k + n) : the changes in natural units that unit right-hand sides cause, as in `active_rows`.
    regular : whether they are unique.
    """

    v: Array
    states: ContactStates
    edge: Ints
    laws: LinearLaws
    inverse: Array
    regular: bool


@kernel
def linearise_point(given: GraspArrays, at: PointArrays, contacts: Ints, friction: FrictionLimits) -> Linearisation:
    """Of an answer; the offset of `given` is d with what yielding limits open."""
    force, motion, length, weak, slow = at.sizes
    G, c, dof = wrench_map(given.positions, at.reference, given.frames, given.spin), len(at.forces), len(given.freedom)
    v = given.offset.copy()
    for i in range(c):
        for k in range(6):
            v[i] += G[k, i] * at.twist[k]
        for j in range(c):
            v[i] += given.flexibility[i, j] * at.forces[j]
    states = find_states(contacts, friction, at.forces, v, weak, slow)
    natural = np.zeros((dof, c))
    for i in range(dof):
        for j in range(c):
            for k in range(6):
                natural[i, j] += given.freedom[i, k] * G[k, j] / (length if k >= 3 else 1.0)
    kept = np.zeros(c + dof + len(at.gives), np.bool_)
    kept[c : c + dof] = True
    kept[c + dof :] = at.gives
    stiffness_unit = force / motion
    K = saddle_matrix(at.tangent, stiffness_unit, natural, at.rows)
    laws = LinearLaws(K, kept, contacts, friction.limits, stiffness_unit)
    A, B = active_rows(laws, states)
    inverse, regular = solve_inverse(A, B, RANK_TOLERANCE)
    return Linearisation(
        v, states, _edge_contacts(contacts, friction, at.forces, states.kind, weak), laws, inverse, regular
    )


@kernel
def _edge_contacts(contacts: Ints, friction: FrictionLimits, forces: Array, kind: Ints, weak: float) -> Ints:
    edge = np.zeros(len(contacts), np.int64)
    for i in range(len(contacts)):
        if contacts[i, 0] < 0:
            continue
        if kind[i] == RESTING:
            edge[i] = 1
        elif kind[i] == STICKING:
            spare = friction.limits[i] * forces[3 * i + 2] - _friction_reach(contacts[i], friction, forces)
            edge[i] = 1 if spare <= weak else 0
    return edge


@kernel
def _friction_reach(own: Ints, friction: FrictionLimits, forces: Array) -> float:
    """The length of a contact's friction force, or the largest component across a face [N]."""
    r, d = np.zeros(3), 0
    while d < 3 and own[d + 1] >= 0:
        r[d] = forces[own[d + 1]]
        d += 1
    if d == 1:
        return float(abs(r[0]))
    if friction.faces == 0:
        return float(np.sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]))
    reach = 0.0
    if d == 2:
        for j in range(friction.faces):
            a = 2.0 * np.pi * j / friction.faces
            reach = max(reach, np.cos(a) * r[0] + np.sin(a) * r[1])
        return float(reach)
    for normal in friction.normals:
        reach = max(reach, normal[0] * r[0] + normal[1] * r[1] + normal[2] * r[2])
    return float(reach)


# ----------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LinearisedPoint:
    """An answer, and what was found of it; v (c,) in the coordinates of the friction laws."""

    answer: LinearisationPoint
    linearisation: Linearisation

    @classmethod
    def linearise(cls, answer: LinearisationPoint) -> LinearisedPoint:
        """One call of compiled code."""
        s, reached = answer.scene, answer.reached_limits
        gives = np.arange(len(reached.at)) < reached.active
        numbers = PointArrays(
            answer.spec.reference, answer.law_forces, answer.twist, answer.tangent, reached.rows, gives, answer.sizes
        )
        given = s.arrays._replace(offset=answer.opening)
        return cls(answer, linearise_point(given, numbers, s.kind.contact_components, answer.friction))

    @property
    def v(self) -> Array:
        """(c,) motions of the object relative to the tips [m]."""
        return self.linearisation.v

    @property
    def states(self) -> ContactStates:
        """The states of the contacts at the answer."""
        return self.linearisation.states

    def equations(self, states: ContactStates, gives: Bools) -> tuple[Array, Array]:
        """(A, B) of `active_rows` with these states; gives (m,) : which of the limits that are reached give way."""
        laws = self.linearisation.laws
        kept = np.append(laws.kept[: len(laws.kept) - len(gives)], gives)
        return active_rows(laws._replace(kept=kept), states)

    def right_hand_sides(self, change: LawChange) -> Array:
        """(k + n, p) in natural units, as `active_rows` orders them."""
        answer, reached = self.answer, self.answer.reached_limits
        push = answer.law_forces[2 : 3 * answer.scene.n : 3]
        # δA r - δb_s: limits of forces depend on no parameter
        used = reached.joints @ change.torque - abs(reached.joints) @ change.torque_limits
        balance = answer.scene.arrays.freedom @ change.balance / answer.balance_sizes[:, None]
        slides = change.friction * (push / answer.sizes[0])[:, None]
        return np.concatenate([change.motion / answer.sizes[1], balance, used / reached.sizes[:, None], slides])

    def motion(self, x: Array) -> Array:
        """(6, p) of the object about the reference, SI, from x (k, p) in natural units."""
        s = self.answer.scene
        return np.asarray(s.arrays.freedom.T @ (x[s.components : s.components + s.dof] * s.twist_units[:, None]))

    def motion_changes(self, x: Array) -> Array:
        """(c, p) changes of v by x (k, p), SI, in the laws' coordinates."""
        return np.asarray(self.linearisation.laws.K[: self.answer.scene.components] @ x * self.answer.sizes[1])
