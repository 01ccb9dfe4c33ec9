"""Where the time of `solve_lcp` and of `grasp.solve` goes: their steps in sequence, and the compiled part of each.

A sequence makes the same calls as the real thing and says after each what that was. It is timed step by step, on a new
grasp every time; then once more with a clock around every compiled function. What remains of a step is Python.
"""

from __future__ import annotations

import functools
import gc
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np
from rich.console import Console

import handlcp as hl
from handlcp.lcp import proposals
from tests.benchmarks.calls import assembled, call_solve, call_solve_lcp
from tests.benchmarks.clock import best_times
from tests.benchmarks.corpus import Faces, as_case
from tests.benchmarks.report import plain_table
from tests.support.kernels import kernels
from tests.support.steps import ByHand, OneCall, certificate

__all__ = ["measure"]

WHOLE = "the whole, measured as one"
BY_STEPS = "the one call of grasp.solve, step by step"


def solving(grasp: hl.Grasp, faces: Faces) -> Iterator[str]:
    """`grasp.solve` where the first stage answers."""
    call = OneCall(grasp, faces)
    yield "effects and layout, known from an earlier scene"
    call.pack()
    yield "the scene as a row of numbers"
    call.answer()
    yield "units, stamps, solver, certificate, states: one call"
    call.conclude(call.read())
    yield "the answer in SI"


def step_by_step(grasp: hl.Grasp, faces: Faces) -> Iterator[str]:
    """What that one call does, and what the later stages do, step by step from Python."""
    steps = ByHand(grasp, faces)
    for step, name in (
        (steps.units, "natural units and blocks of the scene"),
        (steps.assemble, "assembly: effects stamped"),
        (steps.scale, "scaling of rows"),
        (steps.solve, "solver: NSNGRK"),
        (steps.decode, "decoding into forces and motion"),
        (steps.certify, "certificate, from the physics"),
        (steps.finish, "states, uniqueness, the answer in SI"),
    ):
        step()
        yield name


def solving_lcp(problem: Any, faces: Faces) -> Iterator[str]:
    """`solve_lcp` on the assembled problem where the first stage answers."""
    contact = problem if faces == "cone" else problem.contact
    contact.prepared  # noqa: B018
    yield "scaling of rows"
    _, proposal = next(proposals(contact))
    yield "solver: NSNGRK"
    if faces == "cone":
        z = proposal.z * problem.units.z
        yield "units"
        certificate(problem, z, proposal.z)
    else:
        z = problem.lift(proposal.z) * problem.scaled.units.z
        yield "multipliers from the slip, units"
        certificate(problem, z)
    yield "certificate, from M and q"


class Inside:
    """Seconds spent in compiled functions since last asked."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def take(self) -> float:
        """The seconds, and start again from zero."""
        seconds, self.seconds = self.seconds, 0.0
        return seconds

    def clocked(self, kernel: Any) -> Callable[..., Any]:
        """The kernel with a clock around it."""

        def call(*args: Any) -> Any:
            start = time.perf_counter()
            out = kernel(*args)
            self.seconds += time.perf_counter() - start
            return out

        return call


@contextmanager
def clocks() -> Iterator[Inside]:
    """While open, every call from Python of the package's compiled functions is timed; all must be compiled by then."""
    inside = Inside()
    with ExitStack() as stack:
        for module, name, kernel in list(kernels()):
            stack.enter_context(patch.object(module, name, inside.clocked(kernel)))
        yield inside


def laps(sequence: Iterator[str], inside: Inside | None = None) -> dict[str, float]:
    """Seconds of each step, or of the compiled functions in it."""
    out, clock = {}, time.perf_counter
    start = clock()
    for step in sequence:
        out[step] = clock() - start if inside is None else inside.take()
        start = clock()
    return out


def steps(make: Callable[[], Iterator[str]], repeats: int) -> dict[str, tuple[float, float]]:
    """(seconds, compiled seconds) of each step, in the run with the least sum."""

    def best(inside: Inside | None = None) -> dict[str, float]:
        runs = []
        for _ in range(repeats):
            runs += [laps(sequence, inside) for sequence in [make() for _ in range(3)]]
        return min(runs, key=lambda run: sum(run.values()))

    gc.collect()
    gc.disable()
    try:
        plain = best()
        with clocks() as inside:
            compiled = best(inside)
    finally:
        gc.enable()
    return {step: (seconds, compiled[step]) for step, seconds in plain.items()}


def measure(
    console: Console, scenes: Sequence[Any], faces: Faces, rounds: int, most: int = 20
) -> dict[str, dict[str, tuple[float, float]]]:
    """Print both splits; medians over the first `most` scenes that the first stage solves. µs for JSON."""
    name = "cone" if faces == "cone" else f"{faces} faces"
    found: dict[str, list[dict[str, tuple[float, float]]]] = {"grasp.solve": [], BY_STEPS: [], "solve_lcp": []}
    for scene in scenes:
        grasp = as_case(scene, faces).grasp
        problem = functools.partial(assembled, grasp, faces)
        solution, lcp = grasp().solve(faces, throw=False), hl.solve_lcp(problem(), throw=False)
        if not solution.held or len(solution.trace) != 1 or len(lcp.trace) != 1:
            continue
        whole = best_times({"grasp.solve": call_solve(grasp, faces), "solve_lcp": call_solve_lcp(problem)}, rounds)
        sequences = {
            "grasp.solve": lambda grasp=grasp: solving(grasp(), faces),
            BY_STEPS: lambda grasp=grasp: step_by_step(grasp(), faces),
            "solve_lcp": lambda problem=problem: solving_lcp(problem(), faces),
        }
        for key, make in sequences.items():
            parts = steps(make, rounds)
            total = whole[key] if key in whole else sum(us for us, _ in parts.values())
            found[key].append(parts | {WHOLE: (total, 0.0)})
        if len(found["solve_lcp"]) == most:
            break
    out = {}
    for key, runs in found.items():
        out[key] = {step: tuple(1e6 * np.median([run[step] for run in runs], axis=0)) for step in (runs or [{}])[0]}
        _print(console, f"{key}, {name}", out[key], len(runs))
    return out


def _print(console: Console, title: str, parts: dict[str, tuple[float, float]], count: int) -> None:
    table = plain_table(
        f"Where the time goes: {title}; medians over {count} scenes", "step", "µs", "compiled", "Python", "share"
    )
    if not parts:
        return
    rows = {step: values for step, values in parts.items() if step != WHOLE}
    total, inside = parts[WHOLE][0], sum(compiled for _, compiled in rows.values())
    rows["between the steps"] = (total - sum(us for us, _ in rows.values()), 0.0)
    for step, (us, compiled) in rows.items():
        table.add_row(step, f"{us:.1f}", f"{compiled:.1f}", f"{us - compiled:.1f}", f"{100 * us / total:.0f} %")
    table.add_section()
    table.add_row(WHOLE, f"{total:.1f}", f"{inside:.1f}", f"{total - inside:.1f}", "100 %", style="bold")
    console.print(table)
