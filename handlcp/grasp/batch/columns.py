"""The numbers of a batch as arrays, read off the rows of its answers without making a solution of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.batch.first_stage import Answers, Batch
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.solve.compiled_answer import CompiledAnswer
from handlcp.tolerances import OVER
from handlcp.words import distinct


@dataclass(frozen=True, slots=True)
class Group:
    """The k grasps of a batch with n contacts each and joints of the same names; NaN where one is not held.

    at (k,) : their places in the batch. joints (nv,) : names, () without a hand.
    forces (k, n, 3), displacement (k, 6), torques (k, nv) : as in the solutions. utilisation (k, nv) : |torque| over
    limit.
    """

    at: Ints
    joints: tuple[str, ...]
    forces: Array
    displacement: Array
    torques: Array
    utilisation: Array

    def put(self, row: int, grasp: Grasp, solution: GraspSolution) -> None:
        """Write what a solution says into a row."""
        self.forces[row] = solution.forces
        self.displacement[row] = solution.object_displacement
        if (mechanism := grasp.spec.mechanism) is not None:
            torques: Array = getattr(solution, "torques")  # noqa: B009  that of `mechanism.solution`, a subclass
            self._put_torques(row, torques, mechanism.limits)

    def put_answer(self, row: int, grasp: Grasp, answer: CompiledAnswer) -> None:
        """The same from an answer of the first stage that leaves nothing free, where forces are scaled or joints bear
        them; everything else is there already.
        """
        spec, scene = grasp.spec, grasp.scene
        components, n = scene.physical(answer.components), scene.n
        self.forces[row] = components[: 3 * n].reshape(-1, 3)
        if (mechanism := spec.mechanism) is not None:
            torsion = scene.by_contact(components[3 * n :]) if scene.soft else None
            joints = mechanism.joints(scene, spec.effects, self.forces[row], torsion, {})
            self._put_torques(row, joints.torque, mechanism.limits)

    def _put_torques(self, row: int, torques: Array, limits: Array) -> None:
        self.torques[row] = torques
        np.divide(abs(torques), limits, out=self.utilisation[row])

    def sealed(self) -> Group:
        """The same with arrays that nobody writes to any more."""
        for a in (self.forces, self.displacement, self.torques, self.utilisation):
            read_only(a)
        return self


def groups_of(
    batch: Batch, answers: Sequence[Answers], singles: dict[int, GraspSolution], look: Sequence[GraspSolution]
) -> tuple[Group, ...]:
    """The grasps by how many contacts they have and by the names of their joints, one group at least.

    singles : solutions that are no rows of `answers`. look : the solution of each grasp, made when it is looked at:
    here, where an answer leaves something free.
    """
    number, row, groups = _grouped(batch.grasps)
    for k, solution in singles.items():
        if solution.held:
            groups[number[k]].put(row[k], batch.grasps[k], solution)
    for found in answers:
        direct = found.unique
        for k in found.at[found.passing & ~direct].tolist():
            groups[number[k]].put(row[k], batch.grasps[k], look[k])
        for g in np.unique(number[found.at[direct]]).tolist():
            some = np.flatnonzero(direct & (number[found.at] == g))
            _put_answers(groups[g], row, batch.grasps, found, some)
    return tuple([g.sealed() for g in groups])


def _put_answers(group: Group, row: Ints, grasps: Sequence[Grasp], found: Answers, some: Ints) -> None:
    """Write these rows of the answers into the group."""
    at, n, kind = found.at[some], found.kind.kind.n, found.kind
    places, members = row[at], [grasps[k] for k in at.tolist()]
    components, twist, centre = found.moves(some)
    group.forces[places] = components[:, : 3 * n].reshape(-1, n, 3)
    arm = np.concatenate([g.spec.reference for g in members]).reshape(-1, 3) - centre
    group.displacement[places] = shifted_rows(twist, arm)
    for i, place, g in zip(some.tolist(), places.tolist(), members, strict=True):
        if g.spec.mechanism is not None or g.scene.scale is not None:
            group.put_answer(place, g, CompiledAnswer(kind, found.rows[i]))


def _grouped(grasps: Sequence[Grasp]) -> tuple[Ints, Ints, list[Group]]:
    """(m,) the number of each grasp's group, (m,) its row there, and the groups, full of NaN."""
    keys: dict[tuple[int, tuple[str, ...]], list[int]] = {}
    for k, g in enumerate(grasps):
        spec = g.spec
        keys.setdefault((len(spec.contacts), () if spec.mechanism is None else spec.mechanism.names), []).append(k)
    number, row, groups = np.empty(len(grasps), np.int64), np.empty(len(grasps), np.int64), list[Group]()
    for (n, joints), own in (keys or {(0, ()): list[int]()}).items():
        at = np.array(own, dtype=np.int64)
        number[at], row[at] = len(groups), np.arange(len(at))
        shapes = ((n, 3), (6,), (len(joints),), (len(joints),))
        groups.append(Group(at, joints, *[np.full((len(at), *shape), np.nan) for shape in shapes]))
    return number, row, groups


def shifted_rows(twist: Array, arm: Array) -> Array:
    """(k, 6) `vectors.shifted` row by row."""
    u, v, w, p, q, r = twist.T
    x, y, z = arm.T
    return np.stack([u + q * z - r * y, v + r * x - p * z, w + p * y - q * x, p, q, r], axis=1)


# ---------------------------------------------------------------- A batch as named columns, for a data frame.

_OBJECT = ("x", "y", "z", "rx", "ry", "rz")


def frame(grasps: Sequence[Grasp], groups: Sequence[Group]) -> dict[str, Any]:
    """Columns of m rows each, by name, as `Solutions.to_dict` says; NaN where a grasp has no such number."""
    m = len(grasps)
    fingers: dict[str, Array] = {}
    whole = {f"object.{axis}": np.full(m, np.nan) for axis in _OBJECT}
    joints: dict[str, Array] = {}
    most, binding = np.full(m, np.nan), np.full(m, None, dtype=object)

    def put(columns: dict[str, Array], name: str, at: Any, values: Array) -> None:
        columns.setdefault(name, np.full(m, np.nan))[at] = values

    for g in groups:
        for names, rows in _by_names(grasps, g).items():
            for i, name in enumerate(distinct(names)):
                for a, axis in enumerate("xyz"):
                    put(fingers, f"{name}.force_{axis}", g.at[rows], g.forces[rows, i, a])
        for a, axis in enumerate(_OBJECT):
            put(whole, f"object.{axis}", g.at, g.displacement[:, a])
        for j, name in enumerate(g.joints):
            put(joints, f"{name}.torque", g.at, g.torques[:, j])
            put(joints, f"{name}.utilisation", g.at, g.utilisation[:, j])
        if g.joints:
            most[g.at], binding[g.at] = g.utilisation.max(axis=1), _binding(g)
    if joints:
        joints["utilisation"] = most
        return {**fingers, **whole, **joints, "binding": binding.tolist()}
    return {**fingers, **whole}


def _by_names(grasps: Sequence[Grasp], group: Group) -> dict[tuple[str, ...], list[int]]:
    """Rows of the group by the names of their contacts."""
    rows: dict[tuple[str, ...], list[int]] = {}
    for row, k in enumerate(group.at.tolist()):
        rows.setdefault(grasps[k].spec.names, []).append(row)
    return rows


def _binding(group: Group) -> Any:
    """(k,) the joint with the highest utilisation; None where that is 0 or there is no answer."""
    most = group.utilisation.max(axis=1)
    which = (group.utilisation >= (most - OVER * most)[:, None]).argmax(axis=1)
    names = np.array(group.joints, dtype=object)[which]
    names[~(most > 0.0)] = None
    return names
