"""What acts on a grasp: the load on its object, and how hard its hand closes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array, read_only
from handlcp.errors import InputError
from handlcp.grasp.assembly.scene_builder import build_scene
from handlcp.grasp.derivatives.linearisation import LawChange, LinearisationPoint
from handlcp.grasp.derivatives.parameter.parameter import (
    MISSING_FORCES,
    MISSING_TORQUE,
    SHARE_WORDS,
    TABLE_SHARE,
    ContactParameter,
    JointParameter,
    Parameter,
    ParameterEntry,
    Samples,
    Shown,
    Trial,
    round_two_digits,
    with_larger_entry,
)
from handlcp.grasp.effects.joint_offset import commanded_offset, find_command, replace_command
from handlcp.grasp.model.request import GraspSpec


class Wrench(Parameter):
    """(6,) about the reference: δb = δw; derivatives [1/N, 1/(N·m)]. In samples, a factor on what loads the object
    besides its weight.
    """

    name = "wrench"
    order, effort, step, spread = 50, 0, 1e-4, "load"
    uncertain = f"Of what loads it besides its weight: {SHARE_WORDS}."

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return (6,)

    def values(self, spec: GraspSpec) -> Array:
        return spec.wrench

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(wrench=with_larger_entry(spec.wrench, k, step))

    def change(self, answer: LinearisationPoint) -> LawChange:
        return answer.law_change(6, balance=np.eye(6))

    def shown(self, answer: LinearisationPoint) -> Shown:
        return Shown("load +10 %", [("", TABLE_SHARE * answer.spec.wrench)])

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        return [ParameterEntry("load", (), 1.0, -np.inf, "×", given, argument)]

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("load", 1, (), values)


def with_load(spec: GraspSpec, load: Array) -> GraspSpec:
    """The grasp under a load (6,) beside the object's weight, about the reference."""
    if spec.mechanism is None:
        return spec.replace(wrench=read_only(np.array(load)))
    made: GraspSpec = spec.mechanism.variation.with_load(spec, load)
    return made


# ----------------------------------------------------------------
# The mass of the object, whose weight is part of the load.


class Mass(Parameter):
    """(1,) [kg] of a grasp of an object with a mass, under gravity; else (0,). δb is the weight of a kilogram."""

    name = "mass"
    order, step, spread = 40, 1e-5, "mass"
    uncertain = f"Of the object: {SHARE_WORDS}."

    def shape(self, spec: GraspSpec) -> tuple[int, ...]:
        return self.values(spec).shape

    def values(self, spec: GraspSpec) -> Array:
        mechanism = spec.mechanism
        weighs = mechanism is not None and mechanism.weight_of_object(spec.reference).any()
        return np.array([mechanism.variation.object_mass]) if mechanism is not None and weighs else np.zeros(0)

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        """With the weight in the load."""
        mechanism = spec.mechanism
        assert mechanism is not None
        before = mechanism.weight_of_object(spec.reference)
        made = mechanism.variation.with_object_mass(mechanism.variation.object_mass + step)
        wrench = read_only(spec.wrench + made.weight_of_object(spec.reference) - before)
        return spec.replace(mechanism=made, wrench=wrench)

    def change(self, answer: LinearisationPoint) -> LawChange:
        weight = answer.mechanism.weight_of_object(answer.spec.reference)
        return answer.law_change(1, balance=weight[:, None] / self.values(answer.spec))

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        values = self.values(spec)
        if not values.any():
            raise InputError(argument, "a grasp of an object with a mass, under gravity; vary 'load' otherwise", "none")
        return [ParameterEntry("mass", (), float(values[0]), 0.0, "kg", given, argument)]

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("mass", 1, (), values / self.values(samples.spec)[0])


# ----------------------------------------------------------------
# How far each finger is commanded into the object: δv_N = -δs. In samples and as a share, a factor on preloads and
# commands of the joints together.

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
        """Preloads: how deep the tips are in the object before joints are commanded any further."""
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
        change = answer.law_change(answer.scene.n)
        np.fill_diagonal(change.contact_motion[2 : 3 * answer.scene.n : 3], -1.0)
        return change

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        """Beside what joints are commanded, it is what a posture leaves."""
        squeeze = TABLE_SHARE * self.values(answer.spec)
        if not squeeze.any():
            return None
        commanded = answer.spec.mechanism is not None and bool(answer.command.any())
        return Shown("overlap left +10 %" if commanded else "squeeze +10 %", [("all fingers", squeeze)], commanded)

    def entries(self, spec: GraspSpec, argument: str, given: Any) -> Sequence[ParameterEntry]:
        return [ParameterEntry("squeeze", (), 1.0, 0.0, "×", given, argument)]

    def write(self, samples: Samples, at: tuple[int, ...], values: Array) -> None:
        samples.times("squeeze", 1, (), values)

    def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
        what = "preload" if spec.mechanism is None else "grip"
        return self.both_shares(spec, share, f"{{}} more {what}", f"{{}} less {what}")

    def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
        """More of it where nothing creates the forces, less where the motors are too weak: by what the hand was told to
        close with, where that has a size, or else by depth.
        """
        scale_command: Any = getattr(spec.asked, "scale_command", None)
        sized = []
        factors = {MISSING_FORCES: _MORE_FACTORS, MISSING_TORQUE: _LESS_SHARES}.get(why, ())
        for times in factors if scale_command is not None else ():
            try:
                found = scale_command(times)
            except InputError:  # there is no such grasp
                continue
            if found is not None:  # what was asked for has a size
                what, text, made = found
                sized.append(Trial(what, times, text, made))
        if sized:
            yield from sized
        elif why == MISSING_FORCES:
            for share in _SQUEEZE_SHARES:
                depth = round_two_digits(share * MAX_SQUEEZE_SHARE * build_scene(spec).units.length_unit)
                hand, text = spec.mechanism, f"{words.format_length(depth)} more squeeze on each finger"
                made = spec.with_squeeze(depth) if hand is None else hand.variation.with_squeeze(spec, depth)
                yield Trial("squeeze", depth, text, made)
        elif why == MISSING_TORQUE and spec.mechanism is not None:  # which limits torques
            for share in _LESS_SHARES:
                made = spec.mechanism.variation.with_squeeze_share(spec, share)
                yield Trial("less squeeze", share, f"{words.format_percent(share)} of the squeeze", made)


class JointCommand(JointParameter):
    """How far each joint is commanded beyond its posture, δq (nv,) [rad, m]: δv = J (C K_g - 1) δq, C = (K + K_g)⁻¹."""

    name = "joint_offset"
    order, effort, common = 70, 0, "command of the joints"

    def values(self, spec: GraspSpec) -> Array:
        return commanded_offset(spec.effects, self.shape(spec)[0])

    def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
        return spec.replace(effects=replace_command(spec.effects, with_larger_entry(self.values(spec), k, step)))

    def change(self, answer: LinearisationPoint) -> LawChange:
        J, loaded = answer.jacobian_rows, answer.loaded_joints
        nv = J.shape[1]
        K_g = np.zeros((nv, nv)) if loaded is None else loaded.stiffness
        follows = np.eye(nv) - answer.compliance @ K_g
        return answer.law_change(nv, contact_motion=-answer.scale[:, None] * (J @ follows), torque=K_g @ follows)

    def shown(self, answer: LinearisationPoint) -> Shown | None:
        if answer.spec.mechanism is None or not answer.command.any():
            return None
        given = "squeeze", "grip_force"
        what = next((name for name in given if getattr(answer.spec.asked, name, None) is not None), "command")
        return Shown(f"{what.replace('_', ' ')} +10 %", [("all joints", TABLE_SHARE * answer.command)])
