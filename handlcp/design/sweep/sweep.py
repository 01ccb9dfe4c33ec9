"""Many designs through one brief: `handlcp.sweep`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from typing import Any

from handlcp.check import check_call
from handlcp.design.evaluation import Evaluation
from handlcp.design.space import Space
from handlcp.design.study import Study
from handlcp.design.sweep.cells import SOBOL, cells_of, numbered, points
from handlcp.design.sweep.journal import Journal, beside
from handlcp.design.sweep.run import rows_of
from handlcp.design.sweep.same import check_same, description
from handlcp.design.sweep.table import checked_table, read_table, write_table
from handlcp.design.sweep.work import DESIGN, ERROR, Maker, Row, Values, in_order, packed
from handlcp.errors import InputError, refuse_unwritable
from handlcp.progress import Progress, track_progress


@check_call()
def sweep(
    make: Any, space: Mapping[str, Any], brief: Any, sampling: str = SOBOL, samples: Any = None,
    out: Any = None, executor: Any = None, *, seed: int = 0, progress: Progress = None,
) -> Study:  # fmt: skip
    """Evaluate many designs of a hand, and keep a row of numbers for each.

    make : a function from parameters to a `Hand`; or a Hand, whose parameters are then the names of `Hand.vary`.
    space : the parameters by name, each (low, high), (low, high, "log"), a list of numbers or words to choose from, or
        one value. brief : a `Brief`, or a function from parameters to one. Each function gets, by name, those of the
        parameters that it names, or all with `**`; a Hand those that are not the brief's.
    sampling : "sobol", evenly spread; "lhs", a Latin hypercube; "grid", all combinations of levels. samples : how many
        designs; of a grid how many levels each range has, a number or a mapping by name. seed : of "sobol" and "lhs".
    out : the table to write, .parquet or .csv; None: none. Until it is complete rows are kept beside it as they come,
        in a file that ends in .rows: the same call, killed and made again, goes on with what is missing.
    executor : None: processes, one a core; any `concurrent.futures` executor; the client of a Dask cluster; "serial":
        this process alone. All give the same bits, on machines of one kind.
    progress : None: a line on the terminal once it takes long; False: none; True: a line that stays; a function: called
        with (designs done, all designs).

    Every design is searched, as by `evaluate`. The grasps of the best designs in the middle of up to 256 that lie
    together are candidates of the others, too, as in `evaluate(…, near=…)`: no row is worse than an evaluation of its
    own. A design that fails, or ends its process, is a row with its reason in "error".

    Raises InputError, also for a file with another sweep in it, and says what differs, and for one that another run is
    writing; UnknownName; Unsupported without
    pyarrow for a .parquet. What an executor that was given raises, such as BrokenProcessPool, comes out; rows are kept.
    """
    room = space if isinstance(space, Space) else Space(space)
    cube = points(room, sampling, samples, seed)
    check_names(room)
    maker = Maker(make, brief)
    maker.check(room.point(cube[0]))
    same = description(room.to_dict(), sampling, samples, seed, make, brief)
    every, found = numbered(room, cube), list[Row]()
    file = None if out is None else checked_table(out)
    if file is not None and file.exists():
        before, rows = read_table(file)
        check_same(str(file), before, same)
        found = list({row[DESIGN]: row for row in rows if _fits(row, every)}.values())
    if len(found) < len(every):
        cells = cells_of(room, cube)
        if file is None:
            _run(maker, every, cells, executor, progress, found, found.extend)
        else:
            with Journal(beside(file), same) as journal:
                check_same(str(journal.file), journal.sweep, same)
                there = {row[DESIGN] for row in journal.rows}
                journal.append([row for row in found if row[DESIGN] not in there])  # of a table that is damaged
                found = journal.rows
                _run(maker, every, cells, executor, progress, found, journal.append)
                write_table(file, same, in_order(found))
    if file is not None:
        with refuse_unwritable("out", beside(file)):
            beside(file).unlink(missing_ok=True)
    return Study(same, in_order(found), maker)


def _fits(row: Row, values: Mapping[int, Values]) -> bool:
    """Whether a row is one of the designs."""
    own = values.get(row.get(DESIGN, -1))
    return own is not None and all(row.get(name) == value for name, value in own.items())


def check_names(space: Space) -> None:
    """Raises InputError for parameters that are called as a column of the outcome."""
    taken = {DESIGN, ERROR, *[key.partition(" = ")[0] for key in Evaluation.entries or ()]}
    if both := [name for name in space.names if name in taken or name.startswith("objects.")]:
        raise InputError("space", "names that are not columns of the outcome", ", ".join(both))


def _run(
    maker: Maker, values: Mapping[int, Values], cells: Sequence[Sequence[int]], executor: Any, progress: Progress,
    there: Sequence[Row], keep: Callable[[list[Row]], Any],
) -> None:  # fmt: skip
    """Keep the rows that are not there yet, as they come."""
    known = frozenset(row[DESIGN] for row in there)
    found = rows_of(packed(maker), cells, values, known, executor)
    with track_progress("designs", len(values), progress, len(known)) as say, closing(found):
        for rows in found:
            keep(rows)
            say(len(rows))
