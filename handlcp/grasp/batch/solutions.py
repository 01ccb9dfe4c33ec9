"""`Solutions`: the numbers of a batch as arrays, read off the rows of its answers without making a solution of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from operator import index
from typing import Any, overload
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from handlcp.check import Array, Bools, Ints, check_method_calls, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.batch.first_stage import STATUSES, FirstStageAnswers, GraspBatch
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.mechanism import read_joints
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.compiled_answer import CompiledAnswer
from handlcp.grasp.solve.solve_spec import conclude_first_stage
from handlcp.lazy_property import lazy_property
from handlcp.lcp import Status
from handlcp.record import Record, make_data_frame
from handlcp.tolerances import OVER_LIMIT_TOLERANCE
from handlcp.words import TextTable, number_duplicates, wrap_text


@dataclass(frozen=True, slots=True)
class GraspGroup:
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

    def set_row(self, row: int, grasp: Grasp, forces: Array, torques: Array | None) -> None:
        """Write forces (n, 3) and torques (nv,) into a row."""
        self.forces[row] = forces
        if torques is not None and (mechanism := grasp.spec.mechanism) is not None:
            self.torques[row] = torques
            np.divide(abs(torques), mechanism.limits, out=self.utilisation[row])


def make_groups(
    batch: GraspBatch,
    answers: Sequence[FirstStageAnswers],
    singles: dict[int, GraspSolution],
    look: Sequence[GraspSolution],
) -> tuple[GraspGroup, ...]:
    """The grasps by how many contacts they have and by the names of their joints, one group at least.

    singles : solutions that are no rows of `answers`. look : the solution of each grasp, made when it is looked at:
    here, where an answer leaves something free.
    """
    grasps = batch.grasps
    number, row, groups = _make_empty_groups(grasps)
    free = [k for found in answers for k in found.at[found.is_certified & ~found.is_unique].tolist()]
    for k, solution in chain(singles.items(), ((k, look[k]) for k in free)):  # one at a time: a batch may be large
        if solution.held:
            groups[number[k]].set_row(row[k], grasps[k], solution.forces, getattr(solution, "torques", None))
            groups[number[k]].displacement[row[k]] = solution.object_displacement
    for found in answers:
        direct = found.is_unique
        for g in np.unique(number[found.at[direct]]).tolist():
            some = np.flatnonzero(direct & (number[found.at] == g))
            _put_answers(groups[g], row, grasps, found, some)
    for group in groups:
        for a in (group.forces, group.displacement, group.torques, group.utilisation):
            read_only(a)
    return tuple(groups)


def _put_answers(group: GraspGroup, row: Ints, grasps: Sequence[Grasp], found: FirstStageAnswers, some: Ints) -> None:
    """Write these rows of the answers, which leave nothing free, into the group."""
    at, n, kind = found.at[some], found.kind.scene_kind.n, found.kind
    places, members = row[at], [grasps[k] for k in at.tolist()]
    components, twist, centre = found.forces_and_twists(some)
    group.forces[places] = components[:, : 3 * n].reshape(-1, n, 3)
    arm = np.concatenate([g.spec.reference for g in members]).reshape(-1, 3) - centre
    group.displacement[places] = shift_twists(twist, arm)
    for i, place, g in zip(some.tolist(), places.tolist(), members, strict=True):
        spec, scene, torques = g.spec, g.scene, None
        if spec.mechanism is None and scene.scale is None:
            continue  # it is there already: no joint bears the forces, and they are not scaled
        own = scene.forces_to_contact_axes(CompiledAnswer(kind, found.rows[i]).components)
        forces = own[: 3 * n].reshape(-1, 3)
        if spec.mechanism is not None:
            torsion = scene.scatter_torsion(own[3 * n :]) if scene.soft else None
            torques = read_joints(spec.mechanism, scene, spec.effects, forces, torsion, {}).torque
        group.set_row(place, g, forces, torques)


def _make_empty_groups(grasps: Sequence[Grasp]) -> tuple[Ints, Ints, list[GraspGroup]]:
    """(m,) the number of each grasp's group, (m,) its row there, and the groups, full of NaN."""
    keys: dict[tuple[int, tuple[str, ...]], list[int]] = {}
    for k, g in enumerate(grasps):
        spec = g.spec
        keys.setdefault((len(spec.contacts), () if spec.mechanism is None else spec.mechanism.names), []).append(k)
    number, row, groups = np.empty(len(grasps), np.int64), np.empty(len(grasps), np.int64), list[GraspGroup]()
    for (n, joints), own in (keys or {(0, ()): list[int]()}).items():
        at = np.array(own, dtype=np.int64)
        number[at], row[at] = len(groups), np.arange(len(at))
        shapes = ((n, 3), (6,), (len(joints),), (len(joints),))
        groups.append(GraspGroup(at, joints, *[np.full((len(at), *shape), np.nan) for shape in shapes]))
    return number, row, groups


def shift_twists(twist: Array, arm: Array) -> Array:
    """(k, 6) `shift_twist` row by row."""
    u, v, w, p, q, r = twist.T
    x, y, z = arm.T
    return np.stack([u + q * z - r * y, v + r * x - p * z, w + p * y - q * x, p, q, r], axis=1)


# ---------------------------------------------------------------- A batch as named columns, for a data frame.

_OBJECT_AXES = ("x", "y", "z", "rx", "ry", "rz")


def make_columns(grasps: Sequence[Grasp], groups: Sequence[GraspGroup]) -> dict[str, Any]:
    """Columns of m rows each, by name, as `Solutions.to_dict` says; NaN where a grasp has no such number."""
    m = len(grasps)
    fingers: dict[str, Array] = {}
    whole = {f"object.{axis}": np.full(m, np.nan) for axis in _OBJECT_AXES}
    joints: dict[str, Array] = {}
    most, binding = np.full(m, np.nan), np.full(m, None, dtype=object)

    def put(columns: dict[str, Array], name: str, at: Any, values: Array) -> None:
        columns.setdefault(name, np.full(m, np.nan))[at] = values

    for g in groups:
        by_names = dict[tuple[str, ...], list[int]]()  # rows by the names of their contacts
        for row, k in enumerate(g.at.tolist()):
            by_names.setdefault(grasps[k].spec.names, []).append(row)
        for names, rows in by_names.items():
            for i, name in enumerate(number_duplicates(names)):
                for a, axis in enumerate("xyz"):
                    put(fingers, f"{name}.force_{axis}", g.at[rows], g.forces[rows, i, a])
        for a, axis in enumerate(_OBJECT_AXES):
            put(whole, f"object.{axis}", g.at, g.displacement[:, a])
        for j, name in enumerate(g.joints):
            put(joints, f"{name}.torque", g.at, g.torques[:, j])
            put(joints, f"{name}.utilisation", g.at, g.utilisation[:, j])
        if g.joints:
            most[g.at] = largest = g.utilisation.max(axis=1)
            which = (g.utilisation >= (largest - OVER_LIMIT_TOLERANCE * largest)[:, None]).argmax(axis=1)
            who = np.array(g.joints, dtype=object)[which]
            who[~(largest > 0.0)] = None
            binding[g.at] = who
    if joints:
        joints["utilisation"] = most
        return {**fingers, **whole, **joints, "binding": binding.tolist()}
    return {**fingers, **whole}


# ----------------------------------------------------------------
# What `solve_many` gives back: a solution for each grasp, made when it is looked at, and arrays over all of them.


_MIXED_HINT = "to_dict() has a column for each name, and solutions[k] the numbers of grasp k"


@check_method_calls
class Solutions(Record, Sequence[GraspSolution]):
    """The solutions of `solve_many`, in the order of its m grasps, and what they say as arrays, read-only.

    A solution is made when it is looked at, and kept as long as somebody holds it; the arrays are computed when first
    asked for, without making solutions, and equal theirs bit for bit. They are NaN where a grasp is not held. Only
    where an answer leaves forces free, as rigid fingers do, each has to be looked at by itself.

    held : (m,) bool, whether each is SOLVED.
    """

    def __init__(
        self, batch: GraspBatch, answers: Sequence[FirstStageAnswers], singles: dict[int, GraspSolution]
    ) -> None:
        self._batch, self._answers, self._singles = batch, tuple(answers), singles
        self._where: Ints = np.full((len(batch), 2), -1)  # which of the answers, and which row of it
        codes = np.zeros(len(batch), dtype=np.int8)
        for number, found in enumerate(self._answers):
            codes[found.at] = found.status
            self._where[found.at, 0], self._where[found.at, 1] = number, np.arange(len(found.at))
        for k, solution in singles.items():
            codes[k] = STATUSES.index(solution.status)
        self._codes = codes
        self._seen: WeakValueDictionary[int, GraspSolution] = WeakValueDictionary()
        self.held: Bools = codes == STATUSES.index(Status.SOLVED)
        self.held.flags.writeable = False

    # ---- a sequence
    def __len__(self) -> int:
        return len(self._batch)

    @overload
    def __getitem__(self, at: int) -> GraspSolution: ...
    @overload
    def __getitem__(self, at: slice) -> list[GraspSolution]: ...
    def __getitem__(self, at: int | slice) -> GraspSolution | list[GraspSolution]:
        if isinstance(at, slice):
            return [self[k] for k in range(len(self))[at]]
        k = range(len(self))[index(at)]
        known = self._singles.get(k) or self._seen.get(k)
        if known is None:
            number, row = self._where[k].tolist()
            found, grasp = self._answers[number], self._batch.grasps[k]
            answer = CompiledAnswer(found.kind, found.rows[row])
            known = self._seen[k] = conclude_first_stage(grasp.spec, grasp.scene, self._batch.section(k), answer)
        return known

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without what was made meanwhile."""
        return (type(self), (self._batch, self._answers, self._singles))

    def __repr__(self) -> str:
        return f"Solutions({len(self)} grasps, {int(self.held.sum())} held)"

    # ---- arrays over the batch
    @property
    def statuses(self) -> tuple[Status, ...]:
        """The status of each."""
        return tuple([STATUSES[c] for c in self._codes.tolist()])

    @property
    def status(self) -> npt.NDArray[np.str_]:
        """(m,) the names of the statuses, such as "SOLVED"."""
        return np.array([s.name for s in STATUSES])[self._codes]

    @property
    def forces(self) -> Array:
        """(m, n, 3) N, of each finger on the object in its contact axes. Raises Unsupported unless all grasps have n
        contacts; `to_dict` takes any.
        """
        counts = {g.forces.shape[1] for g in self._groups}
        if len(counts) > 1:
            raise Unsupported(f"forces: the grasps have from {min(counts)} to {max(counts)} contacts; {_MIXED_HINT}")
        return self._over_all([g.forces for g in self._groups])

    @property
    def displacement(self) -> Array:
        """(m, 6) m and rad, small motion (linear, angular) of each object about its grasp's reference."""
        return self._over_all([g.displacement for g in self._groups])

    @property
    def torques(self) -> Array:
        """(m, nv) N·m, of the joints. Raises Unsupported unless all grasps are of hands with the same joints."""
        self._one_hand("torques")
        return self._over_all([g.torques for g in self._groups])

    @property
    def utilisation(self) -> Array:
        """(m, nv) |torque| / limit, 0 where there is no limit or none is known. Raises as `torques` does."""
        self._one_hand("utilisation")
        return self._over_all([g.utilisation for g in self._groups])

    def _one_hand(self, asked: str) -> None:
        joints = {g.joints for g in self._groups}
        if len(joints) > 1 or (len(self) and () in joints):
            some = "not all grasps are of a hand" if () in joints else "the grasps are of hands with different joints"
            raise Unsupported(f"{asked}: {some}; {_MIXED_HINT}")

    def to_dict(self) -> dict[str, Any]:
        """Columns for a data frame, m long each; `to_frame()` makes one.

        "status", "held"; for each finger "<finger>.force_x", "…_y", "…_z" [N], contact axes, z along the normal;
        "object.x", … "object.z" [m] and "object.rx", … "object.rz" [rad], the object's motion. Of hands also, for each
        joint, "<joint>.torque" [N·m] and "<joint>.utilisation"; the largest "utilisation" of all joints; and "binding",
        the joint that has it (None: no joint with a limit bears a torque, or there is no answer).
        Numbers are NaN where a grasp is not held, or has no finger or joint of that name.
        """
        return {"status": self.status, "held": self.held, **make_columns(self._batch.grasps, self._groups)}

    def to_frame(self) -> Any:
        """The same as a pandas table, a row for each grasp. Raises Unsupported without pandas."""
        return make_data_frame(self.to_dict())

    def _repr_html_(self) -> str:
        """What a notebook shows: how many came to what."""
        counts = Counter(self.status.tolist()).most_common()
        rows = tuple((name, str(k)) for name, k in counts)
        from handlcp.viz import table_html  # for notebooks alone

        return table_html(TextTable(("status", f"of {len(self)} grasps"), rows, "<>"))

    def __str__(self) -> str:
        """How many came to what."""
        counts = Counter(self.status.tolist())
        return wrap_text(f"{len(self)} grasps: {', '.join(f'{k} {name}' for name, k in counts.most_common())}", "  ")

    @lazy_property
    def _groups(self) -> tuple[GraspGroup, ...]:
        return make_groups(self._batch, self._answers, self._singles, self)

    def _over_all(self, parts: list[Array]) -> Array:
        """(m, …) from the arrays of the groups."""
        if len(parts) == 1:
            return parts[0]
        out = np.full((len(self), *parts[0].shape[1:]), np.nan)
        for group, part in zip(self._groups, parts, strict=True):
            out[group.at] = part
        return read_only(out)
