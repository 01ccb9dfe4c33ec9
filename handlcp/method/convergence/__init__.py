"""How fast NSNGRK converges, beside the conditioning that predicts it: units, seeds, greedy and uniform sampling."""

from handlcp.method.convergence.study import (
    Convergence,
    Run,
    convergence,
    generalized_jacobian,
    greedy_bound,
    measured_rate,
    uniform_bound,
)

__all__ = [
    "Convergence", "Run", "convergence", "generalized_jacobian", "greedy_bound", "measured_rate", "uniform_bound",
]  # fmt: skip
