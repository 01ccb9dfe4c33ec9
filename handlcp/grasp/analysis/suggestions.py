"""`suggest`: effects left out that would change the answer, each evaluated once, from the answer on.

    change = max |r_with - r| / max |r|,    r_with from one solve that starts at r

What needs numbers that nobody gave (a soft surface, a bound), or does not go with what is on, cannot be judged, and is
listed as such.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from handlcp.check import Array
from handlcp.contact.friction import Cone, Pyramid, Section
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solution.verdict import HELD
from handlcp.grasp.solve.compiled_answer import start_values
from handlcp.grasp.solve.solve_spec import solve_in_stages
from handlcp.lcp import Auto
from handlcp.record import Record
from handlcp.words import wrap_text


@dataclass(frozen=True, slots=True)
class Suggestion:
    """One effect that the grasp leaves out; or, of a grasp that fails, one change with which it holds.

    effect : its title, or what is changed. change : the largest change that it makes, as a share of the largest force
    (or torque, as `words` say); infinite where it decides whether there is an equilibrium. words : what changes.
    ask : how to ask for it.
    """

    effect: str
    change: float
    words: str
    ask: str

    def __str__(self) -> str:
        return f"{self.effect}: {self.words} ({self.ask})"


@dataclass(frozen=True, slots=True)
class Suggestions(Record):
    """What `Grasp.suggest` found, the largest change first.

    found : those above `least`; of a grasp that fails, the changes that were tried and hold. small : (title, change) of
    those below. unjudged : titles of effects that need numbers, or a hand, or do not go with those that are on.
    word : of the verdict where the grasp fails, such as "NOT HELD"; "" where effects were judged. tried : what was
    tried to make it hold, in vain.
    """

    found: tuple[Suggestion, ...]
    small: tuple[tuple[str, float], ...]
    unjudged: tuple[str, ...]
    least: float
    word: str = ""
    tried: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.found)

    def __iter__(self) -> Iterator[Suggestion]:
        return iter(self.found)

    @property
    def lines(self) -> tuple[str, ...]:
        """What it prints, one sentence each."""
        lines = [str(s) for s in self.found]
        if self.word == HELD:
            lines.append("grasp.check() follows the grasp as it moves, and says HELD; one solve finds no equilibrium")
        if self.word and not lines:
            tried = f": neither {' nor '.join(self.tried)}" if self.tried else ""
            lines = [f"nothing was found that would make it hold{tried}"]
        if not lines:
            lines = [f"no effect that was judged changes the answer by as much as {_format_percent(self.least)}"]
        if self.small:
            little = [f"{title} {_format_percent(change)}" for title, change in self.small]
            lines.append(f"changes little: {', '.join(little)}")
        if self.unjudged:
            lines.append("not judged (they need numbers, or do not go with what is on): " + ", ".join(self.unjudged))
        return tuple(lines)

    def __str__(self) -> str:
        return "\n".join(wrap_text(line, "  ") for line in self.lines)


def suggest(spec: GraspSpec, section: Section, solution: GraspSolution, least: float) -> Suggestions:
    """Which effects that are left out would change the solution, an answer with this section, by more than `least`."""
    every = sorted(_all_suggestions(spec, section, solution), key=lambda s: -s.change)
    done = {e.title for e in spec.effects} | {s.effect for s in every}
    return Suggestions(
        tuple(s for s in every if s.change >= least),
        tuple((s.effect, s.change) for s in every if s.change < least),
        tuple(kind.title for kind in effect_kinds() if kind.file_key is not None and kind.title not in done),
        least,
    )


def _all_suggestions(spec: GraspSpec, section: Section, solution: GraspSolution) -> Iterator[Suggestion]:
    """The exact cone, and every effect that can be tried."""
    if build_scene(spec).frictional and isinstance(section, Pyramid):
        yield _suggest_change(spec, Cone(), solution, "exact friction cone", 'faces="cone"')
    on = {type(e) for e in spec.effects}
    torque = getattr(solution, "torques", np.zeros(0))
    for kind in effect_kinds():
        trial = None if kind in on else kind.trial(spec, spec.effects, solution.forces, torque)
        if trial is None:
            continue
        estimate = Suggestion(kind.title, trial.change, trial.words, kind.in_python)
        if trial.effect is None:
            yield estimate
            continue
        other = spec.replace(effects=(*spec.effects, trial.effect))
        s = _suggest_change(other, section, solution, kind.title, kind.in_python)
        if trial.instead:
            yield s if estimate.change <= s.change else estimate
        elif estimate.change:
            yield replace(s, change=max(s.change, estimate.change), words=f"{estimate.words}: {s.words}")
        else:
            yield replace(s, words=estimate.words) if math.isinf(s.change) else s


def _suggest_change(other: GraspSpec, section: Section, solution: GraspSolution, effect: str, ask: str) -> Suggestion:
    """What the other grasp's answer, from this one's on, is different by."""
    share = _force_changes(other, section, solution)
    k = int(share.argmax())
    if math.isinf(share[k]):
        return Suggestion(effect, math.inf, "no equilibrium is found with it", ask)
    name = other.names[k]
    whose = f"{name}'" if name.endswith("s") else f"{name}'s"
    return Suggestion(effect, float(share[k]), f"{_format_percent(share[k])} of {whose} force", ask)


def _force_changes(other: GraspSpec, section: Section, solution: GraspSolution) -> Array:
    """(n,) |Δr_i| over the largest |r|, of the other grasp solved once from the solution on; infinite: no answer."""
    scene = build_scene(other)
    again = solve_in_stages(other, scene, section, Auto(search_seconds=0.0), start_values(solution, scene))
    if not again.held:
        return np.full(other.n, np.inf)
    size = float(np.linalg.norm(solution.forces, axis=1).max()) or 1.0
    return np.asarray(np.linalg.norm(again.forces - solution.forces, axis=1) / size)


def force_change(spec: GraspSpec, section: Section, solution: GraspSolution, effect: Effect) -> Array:
    """(n,) by how much an effect that depends on forces would change each finger's, as a share of the largest: from one
    correction at this solution. Infinite where it allows no answer.
    """
    others = tuple(e for e in spec.effects if type(e) is not type(effect))
    there = effect.under(spec, solution.forces, others)
    if isinstance(there, str):
        return np.full(spec.n, np.inf)
    return _force_changes(spec.replace(effects=(*others, there)), section, solution)


def _format_percent(share: float) -> str:
    """Write a share as percent in two digits."""
    return f"{100 * share:.2g} %"
