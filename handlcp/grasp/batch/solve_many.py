"""Many grasps in one call."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from typing import TYPE_CHECKING

from handlcp.check import cores
from handlcp.errors import InputError
from handlcp.grasp.friction import Pyramid
from handlcp.grasp.grasp import Grasp
from handlcp.keywords import helped
from handlcp.lcp.compiler.when import soon
from handlcp.progress import Progress, told

if TYPE_CHECKING:
    from handlcp.grasp.answer.solution import GraspSolution
    from handlcp.grasp.batch.first_stage import Answers
    from handlcp.grasp.batch.solutions import Solutions
    from handlcp.lcp import Auto, ContactSolver, Solver

# ----------------------------------------------------------------
# Many grasps at once, over all cores or a cluster: for sweeps over loads, postures and designs.


@helped()
def solve_many(
    grasps: Iterable[Grasp], faces: int | str | Pyramid = "cone", solver: Solver | ContactSolver | Auto | None = None,
    *, workers: int | None = None, executor: Executor | None = None, progress: Progress = None, proof: bool = True,
) -> Solutions:  # fmt: skip
    """The solution of each grasp, as its own `solve(faces, solver, throw=False, proof=proof)` gives it: the same bits,
    whatever the workers, on machines of one kind.

    workers : how many at a time on this machine; None: one a core.
    executor : any `concurrent.futures` executor, which then does all the work, such as `client.get_executor()` of a
        Dask cluster; None: this machine. handlcp has to be installed where it works.
    progress : None: a line on the terminal once it takes long; False: none; True: a line on stderr that stays; a
        function: called with (grasps done, all grasps) from time to time.
    proof : where no answer is found, whether to search for a proof that there is none, up to some seconds a grasp;
        False: stop there, in bounded time, and say UNDECIDED.

    The solver's first stage takes grasps of one kind as the rows of a matrix, in threads, a few ten microseconds each.
    What it leaves goes through the later stages one by one, and in processes where that takes seconds. An executor
    gets both in shards. Beside the grasps themselves, a batch keeps up to 8 (3 c + n + 27) bytes for each of n contacts
    with c force components, 0.6 kB with five fingers; and some 6 kB for each that the first stage leaves.

    Raises InputError for anything but grasps, and for `workers` beside an executor. What an executor raises, such as
    BrokenProcessPool where a process was killed, comes out as it is, and there are no solutions; a Dask cluster sends
    what a lost worker had to another.
    """
    from handlcp.grasp.batch.first_stage import batch_of
    from handlcp.grasp.batch.run import Single, on_cores, on_executor
    from handlcp.grasp.batch.solutions import Solutions

    batch = batch_of(grasps, faces, solver, proof)
    if executor is not None and not isinstance(executor, Executor):
        raise InputError("executor", "a concurrent.futures.Executor, or None", repr(executor)[:80])
    if executor is not None and workers is not None:
        raise InputError("workers", "None beside an executor, which has its own", workers)
    count = cores(workers)
    answers: list[Answers] = []
    singles: dict[int, GraspSolution] = {}
    with told("grasps", len(batch), progress) as say, soon(len(batch)):
        for found in on_cores(batch, count) if executor is None else on_executor(batch, executor):
            if isinstance(found, Single):
                singles[found.at] = found.solution
                say(1)
            else:
                answers.append(found)
                say(len(found.at))
    return Solutions(batch, answers, singles)
