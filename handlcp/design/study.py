"""The table of a sweep, and what one asks of it: the best designs, those that none beats in everything, pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, integer, several
from handlcp.design.evaluation import Evaluation
from handlcp.design.space import Space
from handlcp.design.sweep.again import evaluations
from handlcp.design.sweep.journal import beside, read
from handlcp.design.sweep.same import check_same, digest, too_old
from handlcp.design.sweep.table import DESCRIBED, check_rows, checked_table, columns_of, read_table
from handlcp.design.sweep.work import DESIGN, ERROR, Maker, Row, in_order
from handlcp.errors import InputError, UnknownName, brief as shortly, keyed
from handlcp.grasp.solution.verdict import HELD
from handlcp.keywords import helped_methods
from handlcp.record import data_frame, entry
from handlcp.text_table import TextTable, wrapped
from handlcp.views import view

PAYLOAD, TORQUE = "payload_kg", "-torque_Nm"
_SHOWN = 10  # rows that are printed, and of each, besides the parameters:
_HEADS = {
    "verdict": "verdict",
    "factor": "factor",
    "payload_kg": "payload\nkg",
    "torque_Nm": "torque\nN·m",
    "motion_m": "moves\nmm",
}
ALIASES = {"motor_torque": "torque_Nm"}


@helped_methods
class Study:
    """Designs of a sweep with their outcomes, in rows. Prints as a short table; iterates over rows, as dictionaries.

    names : the parameters.
    columns : name → values of all designs, None where there is none: "design", its number; the parameters; "error", why
        a design failed; then those of the row of an `Evaluation`.
    sweep : what the sweep was.
    """

    def __init__(self, sweep: Row, rows: Sequence[Row], maker: Maker | None = None) -> None:
        self.sweep, self.columns, self._maker = sweep, columns_of(rows), maker
        self._which = ""  # designs of a larger table these are
        self.names = tuple(sweep["space"])

    @classmethod
    def load(cls, path: Any, make: Any = None, brief: Any = None) -> Self:
        """Load the table that a sweep wrote or, as long as that is under way, what it has so far.

        make, brief : as of `sweep`, for `page`, which makes hands again. Raises InputError, also for another `make` or
        brief than the sweep's; Unsupported for Parquet without pyarrow.
        """
        with keyed({"out": "path"}):
            file = checked_table(path)
            if file.exists() or not beside(file).exists():
                sweep, rows = read_table(file)
            else:
                begun, rows, _ = read(beside(file))
                if begun is None:
                    raise InputError("path", "the table of a sweep", f"{str(path)!r}, which has only just begun")
                sweep, rows = begun, [row for row in rows if DESIGN in row]
                check_rows(beside(file), sweep, rows)
        if make is None or brief is None:
            return cls(sweep, in_order(rows))
        if not all(key in sweep for key in DESCRIBED):
            raise InputError("path", "a table that says all of its sweep, to make hands again", repr(str(path)))
        check_same(str(path), sweep, sweep | {"make": digest(make), "brief": digest(brief)})
        return cls(sweep, in_order(rows), Maker(make, brief))

    def __len__(self) -> int:
        return len(self.columns.get(DESIGN, ()))

    def __iter__(self) -> Iterator[Row]:
        for k in range(len(self)):
            yield {name: column[k] for name, column in self.columns.items()}

    @property
    def failed(self) -> Self:
        """The designs that could not be evaluated, with the reason in "error"."""
        return self.some(np.flatnonzero([error is not None for error in self.columns.get(ERROR, ())]))

    @property
    def why_failed(self) -> str:
        """The reason that designs failed for most often; "" where none did."""
        why = Counter(error for error in self.columns.get(ERROR, ()) if error is not None).most_common(1)
        return "".join(shortly(reason) for reason, _ in why)

    def to_frame(self) -> Any:
        """A pandas table with a row for each design. Raises Unsupported without pandas."""
        return data_frame(self.columns)

    # ---------------------------------------------------------------- The best.

    def best(self, n: int = 10, by: str = PAYLOAD, held: bool = False) -> Self:
        """The first n by a column, the largest first; with a minus before its name, the smallest. Designs that hold all
        that the brief asks come before others.

        by : a column, or what an `Evaluation` calls it, such as "payload" or "-torque". held : only designs that hold
        all that the brief asks. Designs of which the number is not known are left out. Raises InputError, UnknownName.
        """
        most = integer("n", n, 1)
        wanted, holds = self.wanted(by)[:, 0], self._held()
        order = np.lexsort((-wanted, ~holds))
        found = order[~np.isnan(wanted[order]) & (holds[order] if held else True)][:most]
        return self.some(found, f"the best {len(found)} of {len(self)} designs by {by}")

    def pareto(self, *by: str, held: bool = True) -> Self:
        """The designs that no other one beats, sorted by the first column.

        A design beats another where it is at least as good in all these columns, and better in one.

        by : as in `best`; none: "payload", "-torque".
        held : whether only designs that hold all that the brief asks are compared; False: all are.

        Raises InputError, UnknownName.
        """
        wanted = self.wanted(*(by or (PAYLOAD, TORQUE)))
        known = ~np.isnan(wanted).any(axis=1) & (self._held() if held else True)
        at = np.flatnonzero(known)
        front = at[not_beaten(wanted[at])]
        which = f"{len(front)} of {len(self)} designs, which no other one beats"
        return self.some(front[np.argsort(-wanted[front, 0], kind="stable")], which)

    def wanted(self, *by: str) -> Array:
        """(n, k) of these columns, of which more is better; NaN where nothing is known. Raises InputError."""
        return np.array([self._wanted(name) for name in by]).T.reshape(len(self), len(by))

    def column_of(self, name: Any) -> str:
        """The column of a name, without its minus. Raises UnknownName."""
        if not self.columns:
            raise InputError("study", "designs", "none so far")
        bare = str(name).removeprefix("-")
        named = {entry(line).path: entry(line).key for line in Evaluation.entries} | ALIASES
        for known in (bare, named.get(bare)):
            if known in self.columns:
                return str(known)
        if len(self.failed) == len(self):
            came = f"{len(self)} that failed, most often: {self.why_failed}"
            raise InputError("study", "designs that could be evaluated", came)
        raise UnknownName("by", "a column", [str(name)], self.columns)

    def _wanted(self, name: Any) -> Array:
        column = self.column_of(name)
        values = self.columns[column]
        if not all(value is None or isinstance(value, int | float) for value in values):
            raise InputError("by", "a column of numbers", f"{column!r}, which has words")
        found = np.array([np.nan if value is None else float(value) for value in values])
        return -found if str(name).startswith("-") else found

    def _held(self) -> Bools:
        return np.array([value is True for value in self.columns.get("holds", [False] * len(self))], dtype=bool)

    def some(self, at: Iterable[Any], which: str = "") -> Self:
        """The designs in these rows, in this order.

        at : numbers of rows.
        which : what the designs are called when they are printed.
        """
        last = len(self) - 1
        rows = [integer(f"at[{i}]", k, 0, last) for i, k in enumerate(several("at", at, "numbers of rows"))]
        made = type(self)(self.sweep, (), self._maker)
        made._which = which
        made.columns = {name: [column[k] for k in rows] for name, column in self.columns.items()}
        return made

    # ---------------------------------------------------------------- To look at.

    def evaluations(self) -> list[Evaluation]:
        """Evaluate each design of this table again with its grasps, by the hands that `make` makes: the same numbers.

        Raises InputError where the study does not know `make` and `brief`, and for a design that failed.
        """
        if self._maker is None:
            raise InputError("make", "Study.load(path, make, brief), to make hands again", "a study without them")
        return evaluations(self.sweep, self._maker, self.columns[DESIGN])

    def plot(self, path: Any = None, title: str = "", by: Sequence[str] = (PAYLOAD, TORQUE)) -> Any:
        """A figure of the designs and their front, of all parameters as lines, and of what each parameter explains.

        The front is by two columns as in `pareto`. Below it stands the mean of the first column along each parameter,
        with the share of its variance that this explains.

        path : a file to write, .png, .svg, .pdf or .jpg. Raises InputError; Unsupported without matplotlib.
        """
        return view("study_plot")(self, path, title, by)

    def page(self, path: Any, title: str = "", by: Sequence[str] = (PAYLOAD, TORQUE), most: int = 50) -> Path:
        """A page that needs no network: a design on the front is clicked, and its hand turns beside its numbers. Hands
        are made and evaluated again. by : two columns as in `pareto`. most : designs with a hand, evenly along the
        front. Raises InputError; Unsupported without trimesh.
        """
        return Path(view("study_page")(self, path, title, by, most))

    @property
    def space(self) -> Space:
        """The space of parameters that the sweep drew its designs from."""
        return Space(self.sweep["space"])

    def __str__(self) -> str:
        free, rows = list(self.space.free), [self._printed(k) for k in range(min(len(self), _SHOWN))]
        outcome = {name: head for name, head in _HEADS.items() if any(name in row for row in rows)}
        heads = (DESIGN, *[name.replace(".", ".\n", 1) for name in free], *outcome.values())
        shown = [DESIGN, *free, *outcome]
        cells = tuple([tuple([_cell(name, row.get(name)) for name in shown]) for row in rows])
        table = str(TextTable(heads, cells, "<" + "".join("<" if name == "verdict" else ">" for name in shown[1:])))
        more = f"\n… {len(self) - _SHOWN} more" if len(self) > _SHOWN else ""
        why = self.why_failed
        head = f"Beware: {old}. " if (old := too_old(self.sweep)) else ""
        head += f"{self.counts}." + (f" Most often: {why}" if why else "")
        return wrapped(head) + (f"\n\n{table}{more}" if cells else "")

    @property
    def counts(self) -> str:
        """How many designs there are, hold what the brief asks, and failed, in words."""
        count, held, failed = len(self), int(self._held().sum()), len(self.failed)
        which = self._which or f"{count} {'design' if count == 1 else 'designs'}"
        holding = f"{held} {'holds' if held == 1 else 'hold'} what the brief asks"
        return words.listed([which, holding, *([f"{failed} failed"] if failed else [])])

    def _printed(self, k: int) -> Row:
        """A row with its verdict, the worst of all objects."""
        row = {name: column[k] for name, column in self.columns.items()}
        if "holds" in row:
            worst = row.get(f"objects.{row.get('worst_object')}.word")
            row["verdict"] = "failed" if row.get(ERROR) else HELD if row["holds"] else worst
        return row

    def __repr__(self) -> str:
        return f"Study({len(self)} designs of {list(self.names)})"


def not_beaten(wanted: Array) -> Bools:
    """(n,) whether no other row of (n, k) is at least as large in all columns and larger in one."""
    order = np.lexsort(-wanted.T[::-1])  # whoever beats a row comes before it
    front = np.zeros((0, wanted.shape[1]))
    found = np.zeros(len(wanted), dtype=bool)
    for i in order:
        row = wanted[i]
        if not ((front >= row).all(axis=1) & (front > row).any(axis=1)).any():
            found[i] = True
            front = np.vstack([front, row])
    return found


def _cell(name: str, value: Any) -> str:
    if value is None:
        return "–"
    if value == np.inf:
        return "any"
    value = 1e3 * value if name == "motion_m" else value
    return f"{value:.3g}" if isinstance(value, float) else str(value)
