"""What `solve_many` gives back: a solution for each grasp, made when it is looked at, and arrays over all of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from operator import index
from typing import Any, overload
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.errors import Unsupported
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.batch.columns import Group, groups_of
from handlcp.grasp.batch.first_stage import STATUSES, Answers, Batch
from handlcp.grasp.solve.compiled_answer import CompiledAnswer
from handlcp.keywords import helped_methods
from handlcp.lazy import lazy
from handlcp.lcp import Status
from handlcp.record import Record, data_frame
from handlcp.text_table import TextTable, wrapped
from handlcp.views import view

_INSTEAD = "to_dict() has a column for each name, and solutions[k] the numbers of grasp k"


@helped_methods
class Solutions(Record, Sequence[GraspSolution]):
    """The solutions of `solve_many`, in the order of its m grasps, and what they say as arrays, read-only.

    A solution is made when it is looked at, and kept as long as somebody holds it; the arrays are computed when first
    asked for, without making solutions, and equal theirs bit for bit. They are NaN where a grasp is not held. Only
    where an answer leaves forces free, as rigid fingers do, each has to be looked at by itself.

    held : (m,) bool, whether each is SOLVED.
    """

    def __init__(self, batch: Batch, answers: Sequence[Answers], singles: dict[int, GraspSolution]) -> None:
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
        from handlcp.grasp.solve.stages import answered

        if isinstance(at, slice):
            return [self[k] for k in range(len(self))[at]]
        k = range(len(self))[index(at)]
        known = self._singles.get(k) or self._seen.get(k)
        if known is None:
            number, row = self._where[k].tolist()
            found, grasp = self._answers[number], self._batch.grasps[k]
            answer = CompiledAnswer(found.kind, found.rows[row])
            known = self._seen[k] = answered(grasp.spec, grasp.scene, self._batch.section(k), answer)
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
            raise Unsupported(f"forces: the grasps have from {min(counts)} to {max(counts)} contacts; {_INSTEAD}")
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
            raise Unsupported(f"{asked}: {some}; {_INSTEAD}")

    def to_dict(self) -> dict[str, Any]:
        """Columns for a data frame, m long each; `to_frame()` makes one.

        "status", "held"; for each finger "<finger>.force_x", "…_y", "…_z" [N], contact axes, z along the normal;
        "object.x", … "object.z" [m] and "object.rx", … "object.rz" [rad], the object's motion. Of hands also, for each
        joint, "<joint>.torque" [N·m] and "<joint>.utilisation"; the largest "utilisation" of all joints; and "binding",
        the joint that has it (None: no joint with a limit bears a torque, or there is no answer).
        Numbers are NaN where a grasp is not held, or has no finger or joint of that name.
        """
        from handlcp.grasp.batch.columns import frame

        return {"status": self.status, "held": self.held, **frame(self._batch.grasps, self._groups)}

    def to_frame(self) -> Any:
        """The same as a pandas table, a row for each grasp. Raises Unsupported without pandas."""
        return data_frame(self.to_dict())

    def _repr_html_(self) -> str:
        """What a notebook shows: how many came to what."""
        counts = Counter(self.status.tolist()).most_common()
        rows = tuple((name, str(k)) for name, k in counts)
        text: str = view("table_html")(TextTable(("status", f"of {len(self)} grasps"), rows, "<>"))
        return text

    def __str__(self) -> str:
        """How many came to what."""
        counts = Counter(self.status.tolist())
        return wrapped(f"{len(self)} grasps: {', '.join(f'{k} {name}' for name, k in counts.most_common())}", "  ")

    @lazy
    def _groups(self) -> tuple[Group, ...]:
        return groups_of(self._batch, self._answers, self._singles, self)

    def _over_all(self, parts: list[Array]) -> Array:
        """(m, …) from the arrays of the groups."""
        if len(parts) == 1:
            return parts[0]
        out = np.full((len(self), *parts[0].shape[1:]), np.nan)
        for group, part in zip(self._groups, parts, strict=True):
            out[group.at] = part
        return read_only(out)
