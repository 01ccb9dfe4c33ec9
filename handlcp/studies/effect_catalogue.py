"""`entries`: what `handlcp effects` lists, and what each effect costs on a reference scene, measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import handlcp.actuation as actuation
import handlcp.geometry as geometry
import handlcp.grasp as mechanics
import handlcp.hand as robots
from handlcp.actuation.transmission import SYNERGIES, TENDONS
from handlcp.errors import NoSolutionFound
from handlcp.geometry import Sphere
from handlcp.geometry.object import OBJECT_WEIGHT
from handlcp.grasp import effect_kinds
from handlcp.grasp.analysis.explanation import ENVIRONMENT_DESCRIPTION, EffectDescription, best_times, describe_effect
from handlcp.hand import HandGrasp, HandState, example_hand
from handlcp.lcp.compiler.compile_policy import compile_now

# ----------------------------------------------------------------
# All effects, in the order of the page: those that follow from a scene's data, a hand's, those asked for by name.


def entries() -> tuple[EffectDescription, ...]:
    """A description of each."""
    kinds = effect_kinds()
    of_hands = [kind for kind in kinds if not kind.by_name]
    asked = [kind for kind in kinds if kind.by_name and kind.file_key is not None]
    from_data = [kind for kind in kinds if kind.by_name and kind.file_key is None]
    parts = (from_data, (TENDONS, SYNERGIES), of_hands, (OBJECT_WEIGHT,), asked, (ENVIRONMENT_DESCRIPTION,))
    return tuple([e if isinstance(e, EffectDescription) else describe_effect(e) for part in parts for e in part])


# ----------------------------------------------------------------
# What each effect costs on the reference scene: unknowns, and the time of making and solving the grasp.
#
# ratio = T(with the effect) / T(without it),    T of state.grasp(ball, …).solve(): contacts found, posed, certified
#
# The two are timed in turns, and the best of many times counts. Friction and the flexibility of the fingers are part of
# the reference scene, and little is left of it without them. Their ratio is 1/(1 - share), with the share of the time
# that `explain(measure=True)` measures.

Clock = Callable[[dict[int, Callable[[], bool]]], dict[int, float]]


@dataclass(frozen=True, slots=True)
class Cost:
    """What an effect costs in one scene.

    unknowns : how many more the scene has (< 0: fewer).
    ratio : of the times; None: every scene has the effect.
    """

    unknowns: int
    ratio: float | None

    @property
    def more(self) -> str:
        """Unknowns, as they are printed."""
        return f"{self.unknowns:+d}" if self.unknowns else "0"

    def __str__(self) -> str:
        return "–" if self.ratio is None else f"× {self.ratio:.1f}"


def costs(clock: Clock = best_times) -> dict[str, Cost]:
    """The cost of every effect by title, in some seconds. clock : measures runs [s]. Raises NoSolutionFound."""
    return {entry.title: cost(entry, clock) for entry in entries()}


@compile_now()
def cost(entry: EffectDescription, clock: Clock = best_times) -> Cost:
    """The cost of one effect."""
    on, off = effect_scenes(entry)
    grasp = on.grasp(on.state(), on.ball())
    if on == off:
        lines = grasp.explain(on.faces, measure=True).effects
        line = next(x for x in lines if x.on and x.title == entry.title)
        return Cost(line.cost, None if line.share is None else 1.0 / (1.0 - line.share))
    less = off.grasp(off.state(), off.ball()).explain(off.faces)
    times = clock({0: _run(off), 1: _run(on)})
    return Cost(grasp.explain(on.faces).unknowns - less.unknowns, times[1] / times[0])


def _run(trial: EffectScene) -> Callable[[], bool]:
    """The work that is timed. It is done once here, to compile it and to show that the grasp holds."""
    state, ball = trial.state(), trial.ball()

    def run() -> bool:
        return trial.grasp(state, ball).solve(trial.faces, throw=False).held

    solution = trial.grasp(state, ball).solve(trial.faces, throw=False)
    if not solution.held:
        raise NoSolutionFound(solution.diagnosis, None, solution)
    return run


# ----------------------------------------------------------------
# The scene that every effect is tried on: a ball in five fingers, or in two for what is planar.
#
# An entry says in Python how its effect is asked for. That text is evaluated here, so what the page shows works.

_PLAIN: dict[str, Any] = {
    "joint_stiffness": 6.0,
    "mass": 0.0,
    "friction": mechanics.Coulomb(0.6),
    "faces": 8,
    "preload": 0.003,
    "wrench": (0.0, 0.0, 3.0, 0.0, 0.0, 0.0),
    "gravity": (0.0, 0.0, 9.81),
}
_SECTION = ("faces", "plane")  # arguments that stay when the effect is left out


@dataclass(frozen=True, slots=True)
class EffectScene:
    """A grasp yet to be made. given : arguments of the hand, its object, `state.grasp` and `solve`, by name."""

    given: dict[str, Any]

    @property
    def faces(self) -> Any:
        """Of the friction pyramids, or "cone"."""
        return self.given["faces"]

    def state(self) -> HandState:
        """The hand, closed on the ball."""
        name = "two_finger" if "plane" in self.given else "five_finger"
        return example_hand(name, joint_stiffness=self.given["joint_stiffness"]).at(_closed_posture(name))

    def ball(self) -> Sphere:
        """The object that the fingers hold."""
        return Sphere(0.035, placement=(0.0, 0.0, 0.07), mass=self.given["mass"])

    def grasp(self, state: HandState, ball: Sphere) -> HandGrasp:
        """`state.grasp` with the remaining arguments."""
        rest = {name: x for name, x in self.given.items() if name not in ("joint_stiffness", "mass", "faces")}
        return state.grasp(ball, **rest)


def effect_scenes(entry: EffectDescription) -> tuple[EffectScene, EffectScene]:
    """The scene with the effect and without it: equal where the reference scene itself has it."""
    names = {kind.__name__: kind for kind in mechanics.effect_kinds()}
    names |= {name: getattr(room, name) for room in (mechanics, actuation, geometry, robots) for name in dir(room)}
    asked = dict(eval(f"dict({entry.in_python})", names))  # the package wrote that text itself
    posed = _PLAIN | {name: x for name, x in asked.items() if name in _SECTION}
    return EffectScene(posed | asked), EffectScene(posed)


@cache
def _closed_posture(name: str) -> Any:
    """The posture of the closed hand, which does not depend on its springs."""
    return example_hand(name).close_on(EffectScene(_PLAIN).ball())
