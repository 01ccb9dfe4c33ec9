"""How hard the fingers close: how far each is commanded into the object, δv_N = -δs. In samples and as a share, a
factor on preloads and commands of the joints together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.assembly.build import build
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.parameter.parameter import (
    FORCES,
    SHARE,
    TENTH,
    TORQUE,
    Entry,
    OfContacts,
    Shown,
    Trial,
    larger,
    more_and_less,
    two_digits,
)
from handlcp.grasp.parameter.samples import Samples
from handlcp.grasp.tangent.answer import Answer
from handlcp.grasp.tangent.change import Change, no_change

MOST = 0.2  # of the grasp's size: no hand squeezes farther than that for a better hold
_SQUEEZES = (0.125, 0.25, 0.375, 0.5, 0.75, 1.0)  # of the most that is tried
_LESS = (0.75, 0.5, 0.25)  # of the squeeze, or what else was asked for
_MORE = (1.25, 1.5, 2.0, 3.0, 5.0)  # times what was asked for


class Squeeze(OfContacts):
    """(n,) [m] of each normal."""

    name = "squeeze"
    order, effort, step, together, spread = 60, 0, 1e-7, True, "squeeze"
    common, uncertain = "squeeze", f"How hard the hand closes: {SHARE}."

    def values(self, spec: GraspSpec) -> Array:
        """Preloads, without what the joints are commanded."""
        return np.maximum(-spec.offset[:, 2], 0.0)

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(offset=larger(spec.offset, 3 * k + 2, -step))

    def scaled(self, spec: GraspSpec, factor: float) -> GraspSpec | None:
        """Preloads and commands of the joints; None: the grasp has neither."""
        pressed = spec.offset[: spec.of_hand, 2] < 0.0
        if spec.mechanism is None:
            if not pressed.any():
                return None
            offset = spec.offset.copy()
            offset[: spec.of_hand][pressed] *= factor
            return spec.replace(offset=read_only(offset))
        if not (pressed.any() or spec.mechanism.commands(spec)):
            return None
        made: GraspSpec = spec.mechanism.eased(spec, factor)
        return made

    def change(self, answer: Answer) -> Change:
        n = answer.scene.n
        change = no_change(answer, n)
        change.motion[2 : 3 * n : 3] = -np.eye(n)
        return change

    def shown(self, answer: Answer) -> Shown | None:
        """Beside what joints are commanded, it is what a posture leaves."""
        squeeze = TENTH * self.values(answer.spec)
        if not squeeze.any():
            return None
        commanded = answer.spec.mechanism is not None and bool(answer.command.any())
        return Shown("overlap left +10 %" if commanded else "squeeze +10 %", [("all fingers", squeeze)], commanded)

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[Entry]:
        return (Entry("squeeze", (), 1.0, 0.0, "×", given, argument),)

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("squeeze", 1, (), values)

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        what = "preload" if spec.mechanism is None else "grip"
        yield from more_and_less(lambda f: self.scaled(spec, f), share, (f"{{}} more {what}", f"{{}} less {what}"))

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """More of it where nothing creates the forces, less where the motors are too weak: by what the hand was told to
        close with, where that has a size, or else by depth.
        """
        if (harder := getattr(spec.asked, "harder", None)) is not None and why in (FORCES, TORQUE):
            sized = False
            for times in _MORE if why == FORCES else _LESS:
                if (made := _again(harder, times)) is not None:
                    sized = True
                    yield made
            if sized:
                return
        if why == FORCES:
            for share in _SQUEEZES:
                depth = two_digits(share * MOST * build(spec).units.length)
                yield Trial("squeeze", depth, f"{words.length(depth)} more squeeze on each finger", deeper(spec, depth))
        if why == TORQUE and spec.mechanism is not None:  # which limits torques
            for share in _LESS:
                made = spec.mechanism.eased(spec, share)
                yield Trial("less squeeze", share, f"{words.percent(share)} of the squeeze", made)


def _again(harder: Callable[[float], Any], times: float) -> Trial | None:
    """With so many times as much of what was asked for; None where that cannot be, or nothing that has a size was."""
    try:
        found = harder(times)
    except InputError:
        return None
    if found is None:
        return None
    what, text, made = found
    return Trial(what, times, text, made)


def deeper(spec: GraspSpec, depth: float) -> GraspSpec:
    """The grasp with every finger whose force is not prescribed squeezed by depth [m] more."""
    made: GraspSpec = spec.squeezed(depth) if spec.mechanism is None else spec.mechanism.squeezed(spec, depth)
    return made
