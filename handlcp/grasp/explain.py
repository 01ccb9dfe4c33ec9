"""Which effects a grasp has, why, and what each costs in unknowns."""

from __future__ import annotations

from dataclasses import dataclass

from handlcp.grasp.assemble import GraspContact, GraspProblem
from handlcp.grasp.catalogue import absent
from handlcp.grasp.scene import Scene
from handlcp.grasp.soft_form import GraspBalls

__all__ = ["EffectLine", "Explanation", "explain"]


@dataclass(frozen=True, slots=True)
class EffectLine:
    """One effect: its title and law, whether it is on, why, and the unknowns it brings: ((name, count, free), …).

    share : of a solve's time, as measured (`handlcp.grasp.share`); below 0 where it saves time. None: not measured, or
        nothing to measure: an effect that is off, or that no scene is without.
    """

    title: str
    equation: str
    on: bool
    why: str
    unknowns: tuple[tuple[str, int, bool], ...]
    share: float | None = None

    @property
    def cost(self) -> int:
        """How many unknowns."""
        return sum(count for _, count, _ in self.unknowns)


@dataclass(frozen=True, slots=True)
class Explanation:
    """All effects, on and off, and the size of the problem that comes of them.

    unknowns : of all effects together. eliminated : how many of them never reach the solver.
    rcond : reciprocal condition estimate of the free block, which decided about elimination; None for the exact cone,
        where nothing is eliminated.
    seconds : what a solve takes from its answer on [s], which the shares are of; None: not measured.
    """

    effects: tuple[EffectLine, ...]
    unknowns: int
    eliminated: int
    rcond: float | None
    seconds: float | None = None

    @property
    def size(self) -> int:
        """Unknowns the solver sees."""
        return self.unknowns - self.eliminated

    def __str__(self) -> str:
        lines = []
        for e in self.effects:
            brings = (
                ", ".join(f"{name}: {count}{' free' if free else ''}" for name, count, free in e.unknowns)
                or "no unknowns"
            )
            takes = "" if e.share is None else f"; {round(100 * e.share)} % of the solve"
            lines.append(f"{'on ' if e.on else 'off'}  {e.title}: {e.why}" + (f" [{brings}{takes}]" if e.on else ""))
        what = f"{self.eliminated} free unknowns eliminated" if self.eliminated else "mixed problem"
        if self.rcond is not None:
            what += f" (rcond of their block {self.rcond:.1e})"
        lines.append(f"{self.unknowns} unknowns, {what}: the solver sees {self.size}")
        if self.seconds is not None:
            lines.append(f"{1e6 * self.seconds:.0f} µs from the numbers to a certified answer, started at the answer")
        return "\n".join(lines)


def explain(scene: Scene, problem: GraspProblem | GraspContact | GraspBalls) -> Explanation:
    """From the assembled problem itself, so that what is printed is what is solved."""
    lines = [
        EffectLine(e.title, e.equation, True, e.why(scene), tuple((u.name, u.count, u.free) for u in e.unknowns(scene)))
        for e in problem.effects
    ]
    lines += [EffectLine(kind.title, kind.equation, False, why, ()) for kind, why in absent(scene, problem.effects)]
    total = sum(g.count for g in problem.groups)
    rcond = problem.rcond if isinstance(problem, GraspProblem) else None
    return Explanation(tuple(lines), total, total - problem.n, rcond)
