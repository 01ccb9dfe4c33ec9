"""`Solutions`: the numbers of a batch as arrays, read off the rows of its answers without making a solution of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import chain
from operator import index
from typing import Any, NamedTuple, overload
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from handlcp.check import Array, Bools, Ints, check_method_calls, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.batch.grasp_batch import STATUSES, GraspBatch, ShardAnswers
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.model.mechanism import evaluate_joints
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solve.solve_spec import conclude_first_stage
from handlcp.lazy_property import lazy_property
from handlcp.lcp import Status
from handlcp.record import Record, make_data_frame
from handlcp.tolerances import OVER_LIMIT_TOLERANCE
from handlcp.words import TextTable, number_duplicates, wrap_text


class BatchArrays(NamedTuple):
    """What m solutions say; NaN where one is not held, and after its own contacts and joints where others have more.

    counts (m,) : of the contacts. joints (m,) : names of the joints, () without a hand.
    forces (m, n, 3), displacement (m, 6), torques (m, nv) : as in the solutions. utilisation (m, nv) : |torque| over
    limit.
    """

    counts: list[int]
    joints: list[tuple[str, ...]]
    forces: Array
    displacement: Array
    torques: Array
    utilisation: Array


def make_arrays(
    batch: GraspBatch,
    answers: Sequence[ShardAnswers],
    singles: dict[int, GraspSolution],
    look: Sequence[GraspSolution],
) -> BatchArrays:
    """The arrays of a batch.

    singles : solutions that are no rows of `answers`. look : the solution of each grasp, made when it is looked at:
    here, where an answer leaves something free.
    """
    grasps, m = batch.grasps, len(batch)
    counts = [len(g.spec.contacts) for g in grasps]
    joints = [() if g.spec.mechanism is None else g.spec.mechanism.names for g in grasps]
    shapes = (max(counts, default=0), 3), (6,), (max(map(len, joints), default=0),)
    forces, displacement, torques = (np.full((m, *shape), np.nan) for shape in shapes)
    utilisation = torques.copy()

    def write(k: int, own: Array, torque: Array | None) -> None:
        """Write the forces (n, 3) and the torques (nv,) of grasp k."""
        forces[k, : len(own)] = own
        if torque is not None and (mechanism := grasps[k].spec.mechanism) is not None:
            nv = len(torque)
            torques[k, :nv] = torque
            np.divide(abs(torque), mechanism.limits, out=utilisation[k, :nv])

    free = [k for a in answers for k in a.at[a.found.passes & ~a.found.is_unique].tolist()]
    for k, solution in chain(singles.items(), ((k, look[k]) for k in free)):  # one at a time: a batch may be large
        if solution.held:
            write(k, solution.forces, getattr(solution, "torques", None))
            displacement[k] = solution.object_displacement
    for answer in answers:  # that leave nothing free
        some = np.flatnonzero(answer.found.is_unique)
        at, found = answer.at[some], answer.found[some]
        n = found.kind.scene_kind.n
        forces[at, :n] = found.components[:, : 3 * n].reshape(-1, n, 3)
        arm = np.array([grasps[k].spec.reference for k in at.tolist()]).reshape(-1, 3) - found.centre
        displacement[at] = shift_twists(found.twist, arm)
        for i, k in enumerate(at.tolist()):
            spec, scene, torque = grasps[k].spec, grasps[k].scene, None
            if spec.mechanism is None and scene.scale is None:
                continue  # it is there already: no joint bears the forces, and they are not scaled
            whole = scene.forces_to_contact_axes(found[i].components)
            own = whole[: 3 * n].reshape(-1, 3)
            if spec.mechanism is not None:
                torsion = scene.scatter_torsion(whole[3 * n :]) if scene.soft else None
                torque = evaluate_joints(spec.mechanism, scene, spec.effects, own, torsion, {}).torque
            write(k, own, torque)
    return BatchArrays(counts, joints, *map(read_only, (forces, displacement, torques, utilisation)))


def shift_twists(twist: Array, arm: Array) -> Array:
    """(k, 6) `shift_twist` row by row."""
    u, v, w, p, q, r = twist.T
    x, y, z = arm.T
    return np.stack([u + q * z - r * y, v + r * x - p * z, w + p * y - q * x, p, q, r], axis=1)


# ---------------------------------------------------------------- A batch as named columns, for a data frame.

_OBJECT_AXES = ("x", "y", "z", "rx", "ry", "rz")


def make_columns(grasps: Sequence[Grasp], arrays: BatchArrays) -> dict[str, Any]:
    """Columns of m rows each, by name, as `Solutions.to_dict` says; NaN where a grasp has no such number."""
    m = len(grasps)
    whole = {f"object.{axis}": arrays.displacement[:, a].copy() for a, axis in enumerate(_OBJECT_AXES)}
    fingers, joints = dict[str, Array](), dict[str, Array]()
    most, binding = np.full(m, np.nan), np.full(m, None, dtype=object)

    def put(columns: dict[str, Array], name: str, at: list[int], values: Array) -> None:
        columns.setdefault(name, np.full(m, np.nan))[at] = values

    # By the number of contacts and the names of the joints, then by the names of the contacts: which grasps
    alike = dict[tuple[int, tuple[str, ...]], dict[tuple[str, ...], list[int]]]()
    for k, (g, n, hand) in enumerate(zip(grasps, arrays.counts, arrays.joints, strict=True)):
        alike.setdefault((n, hand), {}).setdefault(g.spec.names, []).append(k)
    for (_, joint_names), by_names in alike.items():
        for names, at in by_names.items():
            for i, name in enumerate(number_duplicates(names)):
                for a, axis in enumerate("xyz"):
                    put(fingers, f"{name}.force_{axis}", at, arrays.forces[at, i, a])
        at = [k for own in by_names.values() for k in own]
        for j, name in enumerate(joint_names):
            put(joints, f"{name}.torque", at, arrays.torques[at, j])
            put(joints, f"{name}.utilisation", at, arrays.utilisation[at, j])
        if joint_names:
            used = arrays.utilisation[at, : len(joint_names)]
            most[at] = largest = used.max(axis=1)
            which = (used >= (largest - OVER_LIMIT_TOLERANCE * largest)[:, None]).argmax(axis=1)
            who = np.array(joint_names, dtype=object)[which]
            who[~(largest > 0.0)] = None
            binding[at] = who
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

    def __init__(self, batch: GraspBatch, answers: Sequence[ShardAnswers], singles: dict[int, GraspSolution]) -> None:
        self._batch, self._answers, self._singles = batch, tuple(answers), singles
        self._where: Ints = np.full((len(batch), 2), -1)  # which of the answers, and which row of it
        codes = np.zeros(len(batch), dtype=np.int8)
        for number, answer in enumerate(self._answers):
            codes[answer.at] = answer.status
            self._where[answer.at, 0], self._where[answer.at, 1] = number, np.arange(len(answer.at))
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
            answers, grasp = self._answers[number], self._batch.grasps[k]
            section = self._batch.section(k)
            known = self._seen[k] = conclude_first_stage(grasp.spec, grasp.scene, section, answers.found[row])
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
        counts = set(self._arrays.counts)
        if len(counts) > 1:
            raise Unsupported(f"forces: the grasps have from {min(counts)} to {max(counts)} contacts; {_MIXED_HINT}")
        return self._arrays.forces

    @property
    def displacement(self) -> Array:
        """(m, 6) m and rad, small motion (linear, angular) of each object about its grasp's reference."""
        return self._arrays.displacement

    @property
    def torques(self) -> Array:
        """(m, nv) N·m, of the joints. Raises Unsupported unless all grasps are of hands with the same joints."""
        return self._of_one_hand("torques")

    @property
    def utilisation(self) -> Array:
        """(m, nv) |torque| / limit, 0 where there is no limit or none is known. Raises as `torques` does."""
        return self._of_one_hand("utilisation")

    def _of_one_hand(self, asked: str) -> Array:
        joints = set(self._arrays.joints)
        if len(joints) > 1 or () in joints:
            some = "not all grasps are of a hand" if () in joints else "the grasps are of hands with different joints"
            raise Unsupported(f"{asked}: {some}; {_MIXED_HINT}")
        found: Array = getattr(self._arrays, asked)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Columns for a data frame, m long each; `to_frame()` makes one.

        "status", "held"; for each finger "<finger>.force_x", "…_y", "…_z" [N], contact axes, z along the normal;
        "object.x", … "object.z" [m] and "object.rx", … "object.rz" [rad], the object's motion. Of hands also, for each
        joint, "<joint>.torque" [N·m] and "<joint>.utilisation"; the largest "utilisation" of all joints; and "binding",
        the joint that has it (None: no joint with a limit bears a torque, or there is no answer).
        Numbers are NaN where a grasp is not held, or has no finger or joint of that name.
        """
        return {"status": self.status, "held": self.held, **make_columns(self._batch.grasps, self._arrays)}

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
    def _arrays(self) -> BatchArrays:
        return make_arrays(self._batch, self._answers, self._singles, self)
