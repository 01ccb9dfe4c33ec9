"""Several objectives: a population that improves from generation to generation, by pymoo's NSGA-II.

Deb, Pratap, Agarwal, Meyarivan, A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Transactions on
Evolutionary Computation 6 (2002). Individuals are points of the unit cube, in which choices are parts of a coordinate.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.design.evaluation import Requirement
from handlcp.design.optimise.aims import Aim, margins
from handlcp.design.optimise.trials import Trials
from handlcp.errors import missing_library

_WORST = 1e9  # an objective of a design of which nothing is known; its margins say that it is none


def check_pymoo() -> None:
    """Raises Unsupported without it."""
    try:
        import pymoo  # noqa: F401
    except ImportError:
        raise missing_library("several objectives need pymoo", "pymoo") from None


def spread(
    trials: Trials, aims: Sequence[Aim], needs: Sequence[Requirement], population: int, seed: int, start: Array | None
) -> None:
    """Try generations until the budget is spent, of which Spent tells, or nothing new is found."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    first = trials.space.sobol(population, seed)
    if start is not None:
        first[0] = start
    d = len(trials.space)
    problem = Problem(n_var=d, n_obj=len(aims), n_ieq_constr=1 + len(needs), xl=np.zeros(d), xu=np.ones(d))
    algorithm: Any = NSGA2(pop_size=population, sampling=first)
    algorithm.setup(problem, termination=("n_gen", 10**9), seed=seed, verbose=False)
    while True:
        asked: Any = algorithm.ask()
        if asked is None or not len(asked):
            return
        rows = [trials.rows[k] for k in trials.tried(np.clip(asked.get("X").astype(float), 0.0, 1.0))]
        wanted = np.array([[-np.nan_to_num(aim.of(row), nan=-_WORST) for aim in aims] for row in rows])
        missed = np.array([-margins(row, needs) for row in rows])
        Evaluator().eval(StaticProblem(problem, F=wanted, G=missed), asked)
        algorithm.tell(infills=asked)
