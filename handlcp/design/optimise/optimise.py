"""The best numbers of a hand for a brief: `handlcp.optimise`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import Any

import numpy as np

from handlcp.check import Array, check_call, check_integer, check_number
from handlcp.design.evaluation import Evaluation, Requirement
from handlcp.design.optimise.aims import Aim, meets, read_aims, read_needs
from handlcp.design.optimise.best import Best, Kink, slopes_of
from handlcp.design.optimise.climb import climb
from handlcp.design.optimise.front import check_pymoo, spread
from handlcp.design.optimise.passed import Passed, passes
from handlcp.design.optimise.trials import Trials, ended
from handlcp.design.space import Space
from handlcp.design.study import Study, is_pareto_optimal
from handlcp.design.sweep.journal import Journal, beside
from handlcp.design.sweep.run import executor_for
from handlcp.design.sweep.same import check_same, description
from handlcp.design.sweep.sweep import check_names
from handlcp.design.sweep.table import checked_table, write_table
from handlcp.design.sweep.work import Maker, packed, unpacked
from handlcp.errors import InputError, translate_arguments
from handlcp.progress import Progress, track_progress

_TRIED = 10  # designs that are tried, the best first, until one passes
_MOST = 10**9


@check_call()
def optimise(
    make: Any, space: Mapping[str, Any], brief: Any, objectives: Any = "payload", constraints: Any = (),
    budget: Any = None, *, seconds: Any = None, start: Mapping[str, Any] | None = None, population: int = 24,
    seed: int = 0, mujoco: bool = False, out: Any = None, executor: Any = None, progress: Progress = None,
) -> Best:  # fmt: skip
    """Look for the parameters of a hand with which it does best what a brief asks.

    make, space, brief, executor, progress : as of `sweep`.
    objectives : "payload", "factor", "force", "torque", "torque_used" or "motion", of the worst object, with a minus
        before it where less is better: one, or several. constraints : texts such as "torque<=0.5", as of
        `Evaluation.require`; what the brief asks is one always.
    One objective goes uphill by its derivatives, from the best of a few designs, for each combination of choices.
    Several give designs of which none beats another in all, from generations of `population` designs (pymoo).
    budget : how many evaluations, those for derivatives among them; None: 200, or, with `seconds`, any number.
    seconds : after which nothing new is begun.
    start : parameters to begin with, beside those that are sampled with `seed`.
    mujoco : whether each design that is given back must be held by MuJoCo, too, as far as the brief asks.
    out : a table of all that was tried, .parquet or .csv, with its rows beside it as they come: the same call made
        again, also with more budget, goes on from them.

    Every design of the answer was evaluated once more, its grasps checked; those that did not pass are named. What is
    interrupted, by Ctrl-C, too, gives what it has so far. The same seed and budget give the same answer.

    Raises InputError, also for a file with something else in it; UnknownName; Unsupported without pymoo for several
    objectives, without MuJoCo, without pyarrow for a .parquet. What an executor raises comes out; the rows are kept.
    """
    room = space if isinstance(space, Space) else Space(space)
    aims, needs = read_aims(objectives), read_needs(constraints)
    check_names(room)
    most, longest = _limits(budget, seconds)
    check_integer("population", population, 4)
    check_integer("seed", seed, 0)
    if len(aims) > 1:
        check_pymoo()
    if mujoco:
        from handlcp.simulator.settings import import_mujoco

        import_mujoco()
    maker = Maker(make, brief)
    first = None if start is None else _started(room, start)
    maker.check(room.point(np.full(len(room), 0.5) if first is None else first))
    asked = {"objectives": [str(aim) for aim in aims], "constraints": [str(need) for need in needs]}
    how = f"optimise {asked}, population {population}, start {None if first is None else first.tolist()}"
    same = description(room.to_dict(), how, None, seed, make, brief)
    file = None if out is None else checked_table(out)
    journal = None if file is None else Journal(beside(file), same)
    with (
        journal or nullcontext(),
        executor_for(executor) as renewed,
        track_progress("evaluations", None if most == _MOST else most, progress, 0) as say,
    ):
        if journal is not None:
            check_same(str(file), journal.sweep, same)
        trials = Trials(maker, room, most, longest, renewed, journal, say)
        with ended() as why:
            if len(aims) > 1:
                spread(trials, aims, needs, population, seed, first)
            else:
                climb(trials, aims[0], needs, seed, first)
        if file is not None and trials.rows:
            write_table(file, same, [*trials.rows, *trials.beyond])
        return _best(trials, aims, needs, mujoco, why[0] if why else "nothing better was found", same)


def _started(space: Space, start: Any) -> Array:
    """Where the parameters to begin with are in the cube. Raises InputError, UnknownName."""
    if not isinstance(start, Mapping):
        raise InputError("start", "a mapping of parameters to values", repr(start)[:80])
    with translate_arguments({"values": "start"}):
        return space.unit(start)


def _limits(budget: Any, seconds: Any) -> tuple[int, float]:
    """How many evaluations, and how long [s]. Raises InputError."""
    longest = np.inf if seconds is None else check_number("seconds", seconds, above=0.0)
    if budget is None:
        return (200 if seconds is None else _MOST), longest
    return check_integer("budget", budget, 1, _MOST), longest


def _best(
    trials: Trials, aims: Sequence[Aim], needs: Sequence[Requirement], mujoco: bool, why: str, same: Any
) -> Best:  # fmt: skip
    """Of what was tried: those of the best that pass."""
    dropped, found = dict[int, str](), dict[int, Evaluation]()
    order = _order(trials, aims, needs)
    groups = [order] if len(aims) > 1 else [[k] for k in order[:_TRIED]]
    for group in groups:
        for k, one in zip(group, _passed(trials, group, needs, mujoco), strict=True):
            if one.why or one.evaluation is None:
                dropped[k] = one.why
            else:
                found[k] = unpacked(one.evaluation)
        if found:
            break
    numbers = tuple([k for k in order if k in found])
    slopes, kinks = dict[str, float](), tuple[Kink, ...]()
    if numbers and numbers[0] in trials.gradients:
        slopes, kinks = slopes_of(trials.space, trials.values(numbers[0]), aims[0], *trials.gradients[numbers[0]])
    study = Study(same, trials.rows)
    if not order:
        failed = f": {len(study.failed)} of {len(study)} failed, most often: {study.why_failed}"
        why = f"{why}, and no design meets what was asked{failed if study.why_failed else ''}"
    return Best(
        tuple([str(aim) for aim in aims]), tuple([trials.values(k) for k in numbers]), numbers, why, dropped, slopes,
        kinks, study, trials.maker, tuple([found[k] for k in numbers]),
    )  # fmt: skip


def _order(trials: Trials, aims: Sequence[Aim], needs: Sequence[Requirement]) -> list[int]:
    """Numbers of the designs that meet all that is asked, by the first objective; of several those that none beats."""
    own = [k for k, row in enumerate(trials.rows) if meets(row, needs)]
    wanted: Array = np.array([[aim.of(trials.rows[k]) for aim in aims] for k in own]).reshape(len(own), len(aims))
    known = [not np.isnan(one).any() for one in wanted]
    own, wanted = [k for k, good in zip(own, known, strict=True) if good], wanted[known]
    if len(aims) > 1:
        front = is_pareto_optimal(wanted)
        own, wanted = [k for k, good in zip(own, front, strict=True) if good], wanted[front]
    return [own[i] for i in np.argsort(-wanted[:, 0], kind="stable")]


def _passed(trials: Trials, numbers: Sequence[int], needs: Sequence[Requirement], mujoco: bool) -> list[Passed]:
    maker = packed(trials.maker)
    tasks = [(maker, (k, trials.values(k)), trials.near(trials.started(k)), tuple(needs), mujoco) for k in numbers]
    found = dict(trials.sent(passes, tasks))
    return [found[k] for k in range(len(tasks))]
