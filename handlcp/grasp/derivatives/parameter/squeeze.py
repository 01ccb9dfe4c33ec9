"""`Squeeze`: how hard the fingers close: how far each is commanded into the object, δv_N = -δs. In samples and as a
share, a factor on preloads and commands of the joints together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.linearisation_point import LawChange, LinearisationPoint, restrict_to_plane, zero_change
from handlcp.grasp.derivatives.parameter.parameter import (
    MISSING_FORCES,
    MISSING_TORQUE,
    SHARE_WORDS,
    TABLE_SHARE,
    ContactParameter,
    JointParameter,
    ParameterEntry,
    Samples,
    Shown,
    Trial,
    round_two_digits,
    scale_both_ways,
    with_larger_entry,
)
from handlcp.grasp.effects.joint_offset import commanded_offset, find_command, replace_command
from handlcp.grasp.model.request import GraspSpec

MAX_SQUEEZE_SHARE = 0.2  # of the grasp's size: no hand squeezes farther than that for a better hold
_SQUEEZE_SHARES = (0.125, 0.25, 0.375, 0.5, 0.75, 1.0)  # of the most that is tried
_LESS_SHARES = (0.75, 0.5, 0.25)  # of the squeeze, or what else was asked for
_MORE_FACTORS = (1.25, 1.5, 2.0, 3.0, 5.0)  # times what was asked for


class Squeeze(ContactParameter):
    """How deep each contact's normal is squeezed, (n,) [m]."""

    name = "squeeze"
    order, effort, step, together, spread = 60, 0, 1e-7, True, "squeeze"
    common, uncertain = "squeeze", f"How hard the hand closes: {SHARE_WORDS}."

    def values(self, spec: GraspSpec) -> Array:
        """Preloads, without what the joints are commanded."""
        return np.maximum(-spec.offset[:, 2], 0.0)

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(offset=with_larger_entry(spec.offset, 3 * k + 2, -step))

    def scaled(self, spec: GraspSpec, factor: float) -> GraspSpec | None:
        """Preloads and commands of the joints; None: the grasp has neither."""
        pressed = spec.offset[: spec.of_hand, 2] < 0.0
        if spec.mechanism is None:
            if not pressed.any():
                return None
            offset = spec.offset.copy()
            offset[: spec.of_hand][pressed] *= factor
            return spec.replace(offset=read_only(offset))
        if not (pressed.any() or find_command(spec.effects)):
            return None
        made: GraspSpec = spec.mechanism.variation.with_squeeze_share(spec, factor)
        return made

    def change(self, answer: LinearisationPoint) -> LawChange:
        n = answer.scene.n
        change = zero_change(answer, n)
        change.motion[2 : 3 * n : 3] = -np.eye(n)
        return change

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        """Beside what joints are commanded, it is what a posture leaves."""
        squeeze = TABLE_SHARE * self.values(answer.spec)
        if not squeeze.any():
            return None
        commanded = answer.spec.mechanism is not None and bool(answer.command.any())
        return Shown("overlap left +10 %" if commanded else "squeeze +10 %", [("all fingers", squeeze)], commanded)

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        return (ParameterEntry("squeeze", (), 1.0, 0.0, "×", given, argument),)

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("squeeze", 1, (), values)

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        what = "preload" if spec.mechanism is None else "grip"
        yield from scale_both_ways(lambda f: self.scaled(spec, f), share, (f"{{}} more {what}", f"{{}} less {what}"))

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """More of it where nothing creates the forces, less where the motors are too weak: by what the hand was told to
        close with, where that has a size, or else by depth.
        """
        if (harder := getattr(spec.asked, "scale_command", None)) is not None and why in (
            MISSING_FORCES,
            MISSING_TORQUE,
        ):
            sized = False
            for times in _MORE_FACTORS if why == MISSING_FORCES else _LESS_SHARES:
                if (made := _repeat_harder(harder, times)) is not None:
                    sized = True
                    yield made
            if sized:
                return
        if why == MISSING_FORCES:
            for share in _SQUEEZE_SHARES:
                depth = round_two_digits(share * MAX_SQUEEZE_SHARE * build_scene(spec).units.length_unit)
                yield Trial(
                    "squeeze",
                    depth,
                    f"{words.format_length(depth)} more squeeze on each finger",
                    squeeze_deeper(spec, depth),
                )
        if why == MISSING_TORQUE and spec.mechanism is not None:  # which limits torques
            for share in _LESS_SHARES:
                made = spec.mechanism.variation.with_squeeze_share(spec, share)
                yield Trial("less squeeze", share, f"{words.format_percent(share)} of the squeeze", made)


def _repeat_harder(harder: Callable[[float], Any], times: float) -> Trial | None:
    """With so many times as much of what was asked for; None where that cannot be, or nothing that has a size was."""
    try:
        found = harder(times)
    except InputError:
        return None
    if found is None:
        return None
    what, text, made = found
    return Trial(what, times, text, made)


def squeeze_deeper(spec: GraspSpec, depth: float) -> GraspSpec:
    """The grasp with every finger whose force is not prescribed squeezed by depth [m] more."""
    made: GraspSpec = (
        spec.with_squeeze(depth) if spec.mechanism is None else spec.mechanism.variation.with_squeeze(spec, depth)
    )
    return made


# ----------------------------------------------------------------
# How far the joints are commanded beyond the posture: δv = J (C K_g - 1) δq, C = (K + K_g)⁻¹.


class JointCommand(JointParameter):
    """How far each joint is commanded beyond its posture, δq (nv,) [rad, m]."""

    name = "joint_offset"
    order, effort, common = 70, 0, "command of the joints"

    def values(self, spec: GraspSpec) -> Array:
        return commanded_offset(spec.effects, self.shape(spec)[0])

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(effects=replace_command(spec.effects, with_larger_entry(self.values(spec), k, step)))

    def change(self, answer: LinearisationPoint) -> LawChange:
        J = answer.jacobian_rows
        nv = J.shape[1]
        change, follows = zero_change(answer, nv), np.eye(nv)
        if answer.geometric_stiffness is not None:
            follows = follows - answer.compliance @ answer.geometric_stiffness
            change.torque[:] = answer.geometric_stiffness @ follows
        change.motion[:] = -answer.scale[:, None] * (J @ follows)
        return restrict_to_plane(answer, change)

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        if answer.spec.mechanism is None or not answer.command.any():
            return None
        given = ("squeeze", "squeeze"), ("grip_force", "grip force")
        what = next((words for name, words in given if getattr(answer.spec.asked, name, None) is not None), "command")
        return Shown(f"{what} +10 %", [("all joints", TABLE_SHARE * answer.command)])
