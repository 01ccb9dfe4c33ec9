"""Effects left out that would change the answer: each evaluated once, from the answer on.

    change = max |r_with - r| / max |r|,    r_with from one solve that starts at r

What needs numbers that nobody gave (a soft surface, a bound), or does not go with what is on, cannot be judged, and is
listed as such.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from handlcp.check import Array, number
from handlcp.errors import InputError
from handlcp.grasp.catalogue import BY_NAME
from handlcp.grasp.pyramid import Pyramid, Section
from handlcp.grasp.solution import GraspSolution
from handlcp.lcp import Auto

if TYPE_CHECKING:
    from handlcp.grasp.grasp import Grasp

__all__ = ["Suggestion", "Suggestions", "change_of", "left_out", "of_force", "percent", "shares", "suggest"]


@dataclass(frozen=True, slots=True)
class Suggestion:
    """One effect that the grasp leaves out.

    effect : its title. change : the largest change that it makes, as a share of the largest force (or torque, as
    `words` say); infinite where there is no equilibrium with it. words : what changes. ask : how to ask for it.
    """

    effect: str
    change: float
    words: str
    ask: str

    def __str__(self) -> str:
        return f"{self.effect}: {self.words} ({self.ask})"


@dataclass(frozen=True, slots=True)
class Suggestions:
    """What `Grasp.suggest` found, the largest change first.

    found : those above `least`. small : (title, change) of those below. unjudged : titles of effects that need numbers,
    or a hand, or do not go with those that are on.
    """

    found: tuple[Suggestion, ...]
    small: tuple[tuple[str, float], ...]
    unjudged: tuple[str, ...]
    least: float

    def __len__(self) -> int:
        return len(self.found)

    def __iter__(self) -> Iterator[Suggestion]:
        return iter(self.found)

    def __str__(self) -> str:
        lines = [str(s) for s in self.found] or [f"nothing that is judged changes the answer by {percent(self.least)}"]
        if self.small:
            lines.append("small: " + ", ".join(f"{title} {percent(change)}" for title, change in self.small))
        if self.unjudged:
            lines.append("not judged (no numbers given, or not beside what is on): " + ", ".join(self.unjudged))
        return "\n".join(lines)


def suggest(grasp: Grasp, solution: GraspSolution | None, faces: int | str | Pyramid, least: float) -> Suggestions:
    """See `Grasp.suggest`."""
    least = number("least", least, minimum=0.0)
    if solution is None:
        solution = grasp.solve(faces)
    if not isinstance(solution, GraspSolution) or len(solution.forces) != grasp.scene.n or not solution.held:
        raise InputError("solution", "an answer of this grasp, or None", repr(getattr(solution, "status", solution)))
    every = sorted(grasp._left_out(solution, faces), key=lambda s: -s.change)
    found = tuple(s for s in every if s.change >= least)
    small = tuple((s.effect, s.change) for s in every if s.change < least)
    done = {e.title for e in grasp.effects} | {s.effect for s in every}
    return Suggestions(found, small, tuple(kind.title for kind in BY_NAME if kind.title not in done), least)


def left_out(grasp: Grasp, solution: GraspSolution, faces: int | str | Pyramid) -> Iterator[Suggestion]:
    """What any grasp may leave out: the exact cone."""
    scene, section = grasp.scene, grasp._section(faces)
    if scene.frictional and scene.plane is None and isinstance(section, Pyramid):
        yield change_of(grasp, grasp, solution, "cone", "exact friction cone", 'faces="cone"')


def change_of(
    grasp: Grasp, other: Grasp, solution: GraspSolution, faces: int | str | Section, effect: str, ask: str
) -> Suggestion:
    """What the other grasp's answer, from this one's on, is different by."""
    again = other.solve(faces, Auto(search_seconds=0), throw=False, start=solution)  # type: ignore[arg-type]
    if not again.held:
        return Suggestion(effect, math.inf, "no equilibrium is found with it", ask)
    share = shares(solution.forces, again.forces)
    k = int(share.argmax())
    return Suggestion(effect, float(share[k]), of_force(grasp, k, share[k]), ask)


def shares(before: Array, after: Array) -> Array:
    """(n,) |Δr_i| over the largest |r|."""
    size = float(np.sqrt((before**2).sum(axis=1)).max()) or 1.0
    return np.asarray(np.sqrt(((after - before) ** 2).sum(axis=1)) / size)


def of_force(grasp: Grasp, contact: int, share: float) -> str:
    """Such as "9 % of thumb's force"."""
    name = grasp.names[contact]
    whose = f"{name}'" if name.endswith("s") else f"{name}'s"
    return f"{percent(share)} of {whose} force"


def percent(share: float) -> str:
    """In two digits."""
    return f"{100 * share:.2g} %"
