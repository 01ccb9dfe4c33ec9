"""The scene that every effect is tried on: a ball in five fingers, or in two for what is planar.

An entry says in Python how its effect is asked for. That text is evaluated here, so what the page shows works.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import handlcp.grasp as mechanics
import handlcp.hand as robots
from handlcp.grasp.analysis.explanation import Description
from handlcp.hand import HandGrasp, HandState, Sphere, example_hand

_PLAIN: dict[str, Any] = {
    "joint_stiffness": 6.0, "mass": 0.0, "friction": mechanics.Coulomb(0.6), "faces": 8, "preload": 0.003,
    "wrench": (0.0, 0.0, 3.0, 0.0, 0.0, 0.0), "gravity": (0.0, 0.0, 9.81),
}  # fmt: skip
_SECTION = ("faces", "plane")  # arguments that stay when the effect is left out


@dataclass(frozen=True, slots=True)
class Trial:
    """A grasp yet to be made. given : arguments of the hand, its object, `state.grasp` and `solve`, by name."""

    given: dict[str, Any]

    @property
    def faces(self) -> Any:
        """Of the friction pyramids, or "cone"."""
        return self.given["faces"]

    def state(self) -> HandState:
        """The hand, closed on the ball."""
        name = "two_finger" if "plane" in self.given else "five_finger"
        return example_hand(name, joint_stiffness=self.given["joint_stiffness"]).at(_closed(name))

    def ball(self) -> Sphere:
        """The object."""
        return Sphere(0.035, placement=(0.0, 0.0, 0.07), mass=self.given["mass"])

    def grasp(self, state: HandState, ball: Sphere) -> HandGrasp:
        """`state.grasp` with the remaining arguments."""
        rest = {name: x for name, x in self.given.items() if name not in ("joint_stiffness", "mass", "faces")}
        return state.grasp(ball, **rest)


def arguments(entry: Description) -> dict[str, Any]:
    """The keyword arguments that `in_python` shows; the package wrote that text itself."""
    names = {kind.__name__: kind for kind in mechanics.effect_kinds()} | vars(mechanics) | vars(robots)
    return dict(eval(f"dict({entry.in_python})", names))


def trials(entry: Description) -> tuple[Trial, Trial]:
    """The scene with the effect and without it: equal where the reference scene itself has it."""
    asked = arguments(entry)
    posed = _PLAIN | {name: x for name, x in asked.items() if name in _SECTION}
    return Trial(posed | asked), Trial(posed)


@cache
def _closed(name: str) -> Any:
    """The posture of the closed hand, which does not depend on its springs."""
    return example_hand(name).close_on(Trial(_PLAIN).ball())
