"""What `solve(accuracy=...)` was asked for, and what it reached."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Force errors are relative to the largest contact force.

    asked : the error that was asked for. error : the estimate of the error reached, against the equilibrium on the
        exact cone: largest |f_i - f*_i| over the largest |f*_i|. NaN where none is known, and so without an answer.
    setting : what was taken, such as "exact cone". solves : how many problems that took. seconds : how long, estimate
        included.
    """

    asked: float
    error: float
    setting: str
    solves: int
    seconds: float

    @property
    def met(self) -> bool:
        """Whether the estimate keeps what was asked for; never without one."""
        return self.error <= self.asked

    def __str__(self) -> str:
        several = "s" if self.solves > 1 else ""
        cost = f"{self.solves} solve{several}, {self.seconds * 1e3:.3g} ms"
        error = "below 1e-9" if self.error < 1e-9 else f"{self.error:.1e}"
        return f"force error {error}, {self.asked:.1e} asked: {self.setting}, {cost}"
