"""`Study`: the table of a sweep, and what one asks of it: the best designs, the undominated ones, pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, check_integer, check_method_calls, check_sequence
from handlcp.design.evaluation import Evaluation
from handlcp.design.space import Space
from handlcp.design.sweep.again import evaluations
from handlcp.design.sweep.journal import beside, read
from handlcp.design.sweep.same import check_same, digest, too_old
from handlcp.design.sweep.table import DESCRIBED, check_rows, checked_table, columns_of, read_table
from handlcp.design.sweep.work import DESIGN, ERROR, Maker, Row, in_order
from handlcp.errors import InputError, UnknownName, shorten_text as shortly, translate_arguments
from handlcp.grasp.solution.verdict import HELD
from handlcp.record import make_data_frame, parse_entry
from handlcp.words import TextTable, wrap_text

PAYLOAD_COLUMN, LESS_TORQUE_COLUMN = "payload_kg", "-torque_Nm"
_MAX_PRINTED_ROWS = 10  # rows that are printed, and of each, besides the parameters:
_PRINTED_HEADS = {
    "verdict": "verdict",
    "factor": "factor",
    "payload_kg": "payload\nkg",
    "torque_Nm": "torque\nN·m",
    "motion_m": "moves\nmm",
}
COLUMN_ALIASES = {"motor_torque": "torque_Nm"}


@check_method_calls
class Study:
    """Designs of a sweep with their outcomes, in rows. Prints as a short table; iterates over rows, as dictionaries.

    names : the parameters.
    columns : name → values of all designs, None where there is none: "design", its number; the parameters; "error", why
        a design failed; then those of the row of an `Evaluation`.
    sweep : what the sweep was.
    """

    def __init__(self, sweep: Row, rows: Sequence[Row], maker: Maker | None = None) -> None:
        self.sweep, self.columns, self._maker = sweep, columns_of(rows), maker
        self._description = ""  # designs of a larger table these are
        self.names = tuple(sweep["space"])

    @classmethod
    def load(cls, path: Any, make: Any = None, brief: Any = None) -> Self:
        """Load the table that a sweep wrote or, as long as that is under way, what it has so far.

        make, brief : as of `sweep`, for `page`, which makes hands again. Raises InputError, also for another `make` or
        brief than the sweep's; Unsupported for Parquet without pyarrow.
        """
        with translate_arguments({"out": "path"}):
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
        return make_data_frame(self.columns)

    # ---------------------------------------------------------------- The best.

    def best(self, n: int = 10, by: str = PAYLOAD_COLUMN, held: bool = False) -> Self:
        """The first n by a column, the largest first; with a minus before its name, the smallest. Designs that hold all
        that the brief asks come before others.

        by : a column, or what an `Evaluation` calls it, such as "payload" or "-torque". held : only designs that hold
        all that the brief asks. Designs of which the number is not known are left out. Raises InputError, UnknownName.
        """
        most = check_integer("n", n, 1)
        wanted, holds = self.wanted(by)[:, 0], self._is_held()
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
        wanted = self.wanted(*(by or (PAYLOAD_COLUMN, LESS_TORQUE_COLUMN)))
        known = ~np.isnan(wanted).any(axis=1) & (self._is_held() if held else True)
        at = np.flatnonzero(known)
        front = at[is_pareto_optimal(wanted[at])]
        which = f"{len(front)} of {len(self)} designs, which no other one beats"
        return self.some(front[np.argsort(-wanted[front, 0], kind="stable")], which)

    def wanted(self, *by: str) -> Array:
        """(n, k) of these columns, of which more is better; NaN where nothing is known. Raises InputError."""
        return np.array([self._column_to_maximise(name) for name in by]).T.reshape(len(self), len(by))

    def column_of(self, name: Any) -> str:
        """The column of a name, without its minus. Raises UnknownName."""
        if not self.columns:
            raise InputError("study", "designs", "none so far")
        bare = str(name).removeprefix("-")
        named = {parse_entry(line).path: parse_entry(line).key for line in Evaluation.entries} | COLUMN_ALIASES
        for known in (bare, named.get(bare)):
            if known in self.columns:
                return str(known)
        if len(self.failed) == len(self):
            came = f"{len(self)} that failed, most often: {self.why_failed}"
            raise InputError("study", "designs that could be evaluated", came)
        raise UnknownName("by", "a column", [str(name)], self.columns)

    def _column_to_maximise(self, name: Any) -> Array:
        column = self.column_of(name)
        values = self.columns[column]
        if not all(value is None or isinstance(value, int | float) for value in values):
            raise InputError("by", "a column of numbers", f"{column!r}, which has words")
        found = np.array([np.nan if value is None else float(value) for value in values])
        return -found if str(name).startswith("-") else found

    def _is_held(self) -> Bools:
        return np.array([value is True for value in self.columns.get("holds", [False] * len(self))], dtype=bool)

    def some(self, at: Iterable[Any], which: str = "") -> Self:
        """The designs in these rows, in this order.

        at : numbers of rows.
        which : what the designs are called when they are printed.
        """
        last = len(self) - 1
        rows = [
            check_integer(f"at[{i}]", k, 0, last) for i, k in enumerate(check_sequence("at", at, "numbers of rows"))
        ]
        made = type(self)(self.sweep, (), self._maker)
        made._description = which
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

    def plot(self, path: Any = None, title: str = "", by: Sequence[str] = (PAYLOAD_COLUMN, LESS_TORQUE_COLUMN)) -> Any:
        """A figure of the designs and their front, of all parameters as lines, and of what each parameter explains.

        The front is by two columns as in `pareto`. Below it stands the mean of the first column along each parameter,
        with the share of its variance that this explains.

        path : a file to write, .png, .svg, .pdf or .jpg. Raises InputError; Unsupported without matplotlib.
        """
        from handlcp.viz import draw_or_save, draw_study  # answers pay for no picture that nobody draws

        return draw_or_save(path, draw_study, self, title, by)

    def page(
        self, path: Any, title: str = "", by: Sequence[str] = (PAYLOAD_COLUMN, LESS_TORQUE_COLUMN), most: int = 50
    ) -> Path:
        """A page that needs no network: a design on the front is clicked, and its hand turns beside its numbers. Hands
        are made and evaluated again. by : two columns as in `pareto`. most : designs with a hand, evenly along the
        front. Raises InputError; Unsupported without trimesh.
        """
        from handlcp.viz import write_study_page  # studies pay for no page that nobody writes

        return write_study_page(self, path, title, by, most)

    @property
    def space(self) -> Space:
        """The space of parameters that the sweep drew its designs from."""
        return Space(self.sweep["space"])

    def __str__(self) -> str:
        free, rows = list(self.space.free), [self._printed_row(k) for k in range(min(len(self), _MAX_PRINTED_ROWS))]
        outcome = {name: head for name, head in _PRINTED_HEADS.items() if any(name in row for row in rows)}
        heads = (DESIGN, *[name.replace(".", ".\n", 1) for name in free], *outcome.values())
        shown = [DESIGN, *free, *outcome]
        cells = tuple([tuple([_format_cell(name, row.get(name)) for name in shown]) for row in rows])
        table = str(TextTable(heads, cells, "<" + "".join("<" if name == "verdict" else ">" for name in shown[1:])))
        more = f"\n… {len(self) - _MAX_PRINTED_ROWS} more" if len(self) > _MAX_PRINTED_ROWS else ""
        why = self.why_failed
        head = f"Beware: {old}. " if (old := too_old(self.sweep)) else ""
        head += f"{self.counts}." + (f" Most often: {why}" if why else "")
        return wrap_text(head) + (f"\n\n{table}{more}" if cells else "")

    @property
    def counts(self) -> str:
        """How many designs there are, hold what the brief asks, and failed, in words."""
        count, held, failed = len(self), int(self._is_held().sum()), len(self.failed)
        which = self._description or f"{count} {'design' if count == 1 else 'designs'}"
        holding = f"{held} {'holds' if held == 1 else 'hold'} what the brief asks"
        return words.list_names([which, holding, *([f"{failed} failed"] if failed else [])])

    def _printed_row(self, k: int) -> Row:
        """A row with its verdict, the worst of all objects."""
        row = {name: column[k] for name, column in self.columns.items()}
        if "holds" in row:
            worst = row.get(f"objects.{row.get('worst_object')}.word")
            row["verdict"] = "failed" if row.get(ERROR) else HELD if row["holds"] else worst
        return row

    def __repr__(self) -> str:
        return f"Study({len(self)} designs of {list(self.names)})"


def is_pareto_optimal(wanted: Array) -> Bools:
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


def _format_cell(name: str, value: Any) -> str:
    if value is None:
        return "–"
    if value == np.inf:
        return "any"
    value = 1e3 * value if name == "motion_m" else value
    return f"{value:.3g}" if isinstance(value, float) else str(value)


# ----------------------------------------------------------------
# What an outcome is on average along each parameter, and how much of its variance that explains, from any samples.
#
#     S = Var(E(y | x)) / Var(y)      first-order Sobol index of a parameter x
#
# Samples are sorted into k classes by x, each with as many, or into the values of x where these are few. The share of
# the variance between classes is η² = 1 - W / V, with W the sum of squares about the means of the classes and V that
# about the mean of all. By chance alone it is (k - 1) / (n - 1); freed of that it is Kelley's
#
#     ε² = 1 - W / (n - k) · (n - 1) / V
#
# (T. L. Kelley, An unbiased correlation ratio measure, PNAS 21, 1935; indices from given data: E. Plischke, E.
# Borgonovo, C. L. Smith, European Journal of Operational Research 226, 2013). What y changes within a class by x
# itself is missed: of a straight line 1 / k² of the index. Parameters are taken to be independent, as the samples of
# a sweep are.


_CLASS_EXPONENT = 0.4  # k = n^0.4 classes: more of them follow y better, fewer are less noisy


@dataclass(frozen=True, slots=True)
class MainEffect:
    """The main effect of one parameter on an outcome, over k classes of its values.

    places : (k,) of the classes, as unit coordinates.
    means : (k,) of the outcome.
    errors : (k,) standard errors of the means.
    index : first-order Sobol index [-], NaN where nothing varies or samples are few; what is below 0 is chance.
    """

    places: Array
    means: Array
    errors: Array
    index: float


def main_effect(x: Array, y: Array) -> MainEffect:
    """The main effect of a parameter, from n samples.

    x : (n,) unit coordinates of the parameter.
    y : (n,) the outcome, finite.
    """
    n, values = len(x), np.unique(x)
    most = max(2, round(n**_CLASS_EXPONENT))
    if len(values) <= most:
        number = np.searchsorted(values, x)
    else:
        number = np.empty(n, dtype=int)
        number[np.argsort(x, kind="stable")] = np.arange(n) * most // n
    k = int(number.max(initial=0)) + 1
    count = np.bincount(number, minlength=k)
    means = np.bincount(number, y, k) / count
    squares = np.bincount(number, (y - means[number]) ** 2, k)
    total = float(((y - y.mean()) ** 2).sum()) if n else 0.0
    known = n > k and total > 0.0 and len(values) > 1
    index = 1.0 - float(squares.sum()) / (n - k) * (n - 1) / total if known else np.nan
    with np.errstate(divide="ignore", invalid="ignore"):
        errors = np.sqrt(squares / (count - 1) / count)
    return MainEffect(np.bincount(number, x, k) / count, means, np.nan_to_num(errors, posinf=0.0), index)
