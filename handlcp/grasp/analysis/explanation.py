"""Which effects a grasp has, why, and what each costs in unknowns; and the words of what is no effect of its own."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from handlcp.grasp.assembly.contact_form import called_for, stamped
from handlcp.grasp.assembly.problem import MULTIPLIERS, GraspProblem, assemble
from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.effects.finger_flexibility import FingerFlexibility
from handlcp.grasp.friction import Section
from handlcp.grasp.model.effect import FOLLOWED, ONE_SOLVE
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.record import Record
from handlcp.text_table import wrapped
from handlcp.words import length, listed


@dataclass(frozen=True, slots=True)
class Description:
    """An effect in words, or something else that a grasp can be made of; the page of effects is made of these.

    title, equation : as in `Effect`. when : who wants it, in one sentence. in_python : keyword arguments that ask for
    it, as Python; "": every grasp has it. in_file : the same as lines of a scene file (TOML); "": no scene file can.
    brings : its unknowns. source : where its law is from. module : dotted name of the module that holds it.
    """

    title: str
    equation: str
    when: str
    in_python: str
    in_file: str
    brings: str
    source: str
    module: str

    @property
    def in_short(self) -> str:
        """In Python, without what a mapping holds."""
        return re.sub(r"{.*}", "{…}", self.in_python)

    @property
    def file_keys(self) -> tuple[str, ...]:
        """What a scene file has for it: dotted keys, or a table with brackets about its name."""
        if self.in_file.startswith("["):
            return (self.in_file.partition("\n")[0],)
        return tuple(line.partition(" = ")[0] for line in self.in_file.splitlines())


def describe_effect(kind: type[Effect]) -> Description:
    """That of an effect, read off its class."""
    return Description(
        kind.title, kind.equation, kind.when, kind.in_python, kind.in_file, kind.brings, kind.source, kind.__module__
    )


ENVIRONMENT = Description(
    title="environment contacts",
    equation="E = blkdiag(E_fingers, E_environment),  J_environment = 0",
    when="The object rests on a table, leans on a wall or sits in a fixture.",
    in_python="environment=Table((0, 0, 0.104), normal=(0, 0, -1))",
    in_file="environment = [{ point_m = [0, 0, 0.104], normal = [0, 0, -1] }]",
    brings="a contact's for each",
    source="contacts as any other: Ai & Li (2025), equations (3) and (4)",
    module="handlcp.grasp.model.environment",
)


_WHICH = {
    FOLLOWED: "check, follow, load_limit, payload, required_grip, required_torque and what else follows the loading in "
    "steps; not solve, margins, sensitivity or reliability(by=\"solve\"), which know no way",
    ONE_SOLVE: "solve, margins and sensitivity; what follows the loading has it in its geometry",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class EffectLine:
    """One effect: its title and law, whether it is on, why, and the unknowns it brings: ((name, count, free), …).

    answers : which answers count it, "followed loadings alone" or "one solve alone"; "": every answer.
    share : of a solve's time, as measured (`compare_without`); below 0 where it saves time. None: not measured, or
        nothing to measure: an effect that is off, or that no scene is without.
    """

    title: str
    equation: str
    on: bool
    why: str
    unknowns: tuple[tuple[str, int, bool], ...] = ()
    answers: str = ""
    share: float | None = None

    @property
    def cost(self) -> int:
        """How many unknowns."""
        return sum(count for _, count, _ in self.unknowns)


@dataclass(frozen=True, slots=True)
class Explanation(Record):
    """All effects, on and off, and the size of the problem that comes of them.

    unknowns : of all effects together. eliminated : how many of them never reach the solver.
    rcond : reciprocal condition estimate of the free block, which decided about elimination; None for the exact cone,
        where nothing is eliminated.
    seconds : what a solve takes from its answer on [s], which the shares are of; None: not measured.
    """

    entries = ("effects", "unknowns", "eliminated", "rcond", "seconds", "size")

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
            brings = ", ".join(f"{name}: {count}{' free' if free else ''}" for name, count, free in e.unknowns)
            takes = "" if e.share is None else f"; {round(100 * e.share)} % of the solve"
            counts = f"; in {e.answers}" if e.answers else ""
            cost = f" [{brings or 'no unknowns'}{takes}{counts}]" if e.on else ""
            lines.append(wrapped(f"{e.title}: {e.why}{cost}", "     ", "on   " if e.on else "off  "))
        what = f"{self.eliminated} free unknowns eliminated" if self.eliminated else "none eliminated"
        if self.rcond is not None:
            what += f" (condition of their block {1.0 / self.rcond:.1e})" if self.rcond > 0.0 else " (singular block)"
        lines.append(wrapped(f"{self.unknowns} unknowns, {what}: the solver sees {self.size}", "  "))
        if self.seconds is not None:
            time = f"{1e6 * self.seconds:.0f} µs from the numbers to a certified answer, started at the answer"
            lines.append(wrapped(time, "  "))
        lines += [wrapped(note, "  ") for note in self.notes]
        return "\n".join(lines)

    @property
    def notes(self) -> tuple[str, ...]:
        """Which answers are meant where not every one counts an effect; () where all count all of them."""
        some = {e.answers for e in self.effects if e.on}
        return tuple([f"{which}: {_WHICH[which]}" for which in (FOLLOWED, ONE_SOLVE) if which in some])


def effects_on(spec: GraspSpec, scene: Scene, section: Section) -> tuple[Effect, ...]:
    """All effects that a grasp has: those that its data call for, then those asked for."""
    return (*called_for(scene, section), *spec.effects)


def explain(spec: GraspSpec, scene: Scene, section: Section) -> Explanation:
    """What is on comes first; the sizes are those of the assembled problem."""
    on, problem = effects_on(spec, scene, section), assemble(scene, section, stamped(spec.effects))
    counted = {g.name: g for g in problem.groups}
    lines, k = [], 3 * spec.of_hand
    own, m = spec.flexibility[:k, :k], spec.n - spec.of_hand
    for e in on:
        names = [name for u in e.unknowns(scene) for name in (u.name, MULTIPLIERS.get(u.name))]
        brought = tuple([(name, counted[name].count, counted[name].free) for name in names if name in counted])
        line = EffectLine(e.title, e.equation, True, e.why(scene), brought, e.answers)
        if e.title == FingerFlexibility.title:  # told apart from what compliances asked for add to E
            line = replace(line, why=f"E is not zero ({length(own.trace() / k)}/N in the mean)")
            if not own.any():
                line = replace(line, on=False, why="E of the fingers is zero: rigid fingers", unknowns=())
        lines.append(line)
    present = {type(e) for e in on}
    for kind in effect_kinds():
        if kind not in present and (why := kind.absent(scene, section)) is not None:
            lines.append(EffectLine(kind.title, kind.equation, False, why))
    # The unknowns of the environment are counted with contact and friction
    lines.append(EffectLine(ENVIRONMENT.title, ENVIRONMENT.equation, m > 0, _surroundings(spec, m)))
    for title, law, is_on, why, answers in () if spec.mechanism is None else spec.mechanism.lines():
        lines.append(EffectLine(title, law, is_on, why, answers=answers))
    total = sum(g.count for g in problem.groups)
    rcond = problem.rcond if isinstance(problem, GraspProblem) else None
    return Explanation(tuple(sorted(lines, key=lambda line: not line.on)), total, total - problem.n, rcond)


def _surroundings(spec: GraspSpec, m: int) -> str:
    """What the m contacts of the environment are."""
    if not m:
        return "none given"
    block = spec.flexibility[-3 * m :, -3 * m :]
    soft = f"{length(block.trace() / (3 * m))}/N in the mean" if block.any() else "rigid"
    return f"{m} of the {spec.n} contacts: {listed(spec.names[-m:])}; {soft}"
