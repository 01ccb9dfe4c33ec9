"""Whether a design may be given back: evaluated once more, its grasps checked, and, asked for, tried in MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from handlcp.design.brief import Brief
from handlcp.design.evaluate import evaluate
from handlcp.design.evaluation import Evaluation, Requirement
from handlcp.design.optimise.aims import number_of
from handlcp.design.sweep.work import FAILURES, Numbered, bare, packed, unpacked, why_failed
from handlcp.grasp.solution.verdict import HELD
from handlcp.hand.find.candidate import Candidate


class Passed(NamedTuple):
    """why : it did not pass, in words; "" where it did. evaluation : packed; None where there is none."""

    why: str
    evaluation: bytes | None


def passes(
    maker: bytes, design: Numbered, near: bytes | None, needs: Sequence[Requirement], mujoco: bool
) -> Passed:  # fmt: skip
    """In any process: a design evaluated in full, from the grasps that it started from."""
    made, values = unpacked(maker), design[1]
    try:
        brief: Brief = made.asked(values)
        found = evaluate(made.hand(values), brief, None if near is None else unpacked(near))
        return Passed(_why_not(found, brief, needs, mujoco), packed(bare(found)))
    except FAILURES as error:
        return Passed(why_failed(error), None)


def _why_not(found: Evaluation, brief: Brief, needs: Sequence[Requirement], mujoco: bool) -> str:
    """What stands against it first; "" for nothing."""
    row = found.to_row()
    for name, case in found.cases.items():
        if case.candidate is None or case.word != HELD:
            return f"{name}: {case.word}, {case.gives_out}"
        verdict = case.candidate.grasp.check()
        if not verdict.ok:
            return f"{name}: {verdict.word} when checked"
    for need in needs:
        if not need.is_met(number_of(row, need.name)):
            return f"{need} is not met: {number_of(row, need.name):.4g}"
    for name, case in found.cases.items() if mujoco else ():
        assert case.candidate is not None
        if why := _lost_in_mujoco(case.candidate, brief, name):
            return f"{name}: {why}"
    return ""


def _lost_in_mujoco(one: Candidate, brief: Brief, name: str) -> str:
    """Under the weight and each load, as many times as the brief asks."""
    from handlcp.simulator import compare

    grasp, mass = one.grasp, brief.objects[name].mass
    if mass:
        heavy = compare(grasp.replace(mass=brief.safety * mass))
        if not heavy.simulation.held:
            return f"MuJoCo loses {brief.safety * mass:.3g} kg"
    for load, wrench in brief.loads.items():
        pulled = compare(grasp, brief.safety * wrench)
        if not pulled.simulation.held:
            return f"MuJoCo loses it under {brief.safety:g} times {load!r}"
    return ""
