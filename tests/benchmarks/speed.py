"""Times on solvable rings of five fingers, one thread, as multiples of the fastest facet peer on the same scenes."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

import handlcp as hl
from tests.benchmarks import split
from tests.benchmarks.calls import assembled, call_solve, call_solve_lcp
from tests.benchmarks.clock import best_times
from tests.benchmarks.corpus import Faces, PeersFolder, as_case
from tests.benchmarks.peers import answers
from tests.benchmarks.report import plain_table

__all__ = ["measure"]

SECTIONS: tuple[Faces, ...] = (4, 8, 16, 32, "cone")
QUANTECON, LCP, WHOLE, NEWTON = "QuantEcon Lemke", "solve_lcp", "grasp.solve", "siconos-nsn-ac"
AGAIN = "solve_lcp, same problem again"
IN_PROCESS = "quantecon-lemke"  # measured here, between our own calls
OTHERS = (NEWTON, "siconos-lemke", "pin-admm")  # in processes of their own, one after the other
Times = dict[tuple[Faces, str], np.ndarray]  # (scenes,) best times [µs], NaN where there is no answer


def measure(console: Console, folder: PeersFolder, ring: Path, peers: Sequence[str], rounds: int) -> dict[str, Any]:
    """Print times, ratios and the split; the numbers for JSON."""
    scenes = folder.read(ring)
    lemke = _quantecon(console) if not peers or IN_PROCESS in peers else None
    others = [p for p in OTHERS if p in peers]
    times: Times = {}
    for faces in SECTIONS:
        with console.status(f"{len(scenes)} scenes, {faces}"):
            times |= _ours(folder, scenes, faces, lemke, rounds)
    for peer, found in answers(console, folder, ring, others, SECTIONS, repeats=3 * rounds).items():
        for faces in SECTIONS:
            said = [found.get((s.name, faces)) for s in scenes]
            us = [1e6 * a.seconds if a and a.verdict == "solved" and a.seconds else np.nan for a in said]
            times[faces, peer] = np.array(us)
    _print_times(console, times, len(scenes))
    limits = _limits(times)
    _print_limits(console, limits)
    parts = {str(faces): split.measure(console, scenes, faces, rounds) for faces in (8, "cone")}
    return {
        "times_us": {f"{f}, {name}": [None if np.isnan(t) else t for t in us] for (f, name), us in times.items()},
        "limits": [dict(zip(("measure", "value", "limit"), row, strict=True)) for row in limits],
        "split_us": parts,
    }


def _ours(folder: PeersFolder, scenes: Sequence[Any], faces: Faces, lemke: Any, rounds: int) -> Times:
    names = (LCP, AGAIN, WHOLE) if faces == "cone" or lemke is None else (QUANTECON, LCP, AGAIN, WHOLE)
    out = {(faces, name): np.full(len(scenes), np.nan) for name in names}
    for k, scene in enumerate(scenes):
        tasks, solved = {}, {}
        grasp = as_case(scene, faces).grasp
        solution = grasp().solve(faces, throw=False)
        solved[WHOLE] = solution.held and folder.residual_of(scene, solution, faces) <= folder.problems.TOL
        tasks[WHOLE] = call_solve(grasp, faces)
        problem = assembled(grasp, faces)
        solved[LCP] = solved[AGAIN] = hl.solve_lcp(problem, throw=False).status is hl.Status.SOLVED
        tasks[LCP] = call_solve_lcp(functools.partial(assembled, grasp, faces))
        tasks[AGAIN] = call_solve_lcp(lambda problem=problem: problem)
        if QUANTECON in names:
            mixed = folder.problems.mixed(scene, faces)
            standard = folder.problems.standard(mixed)
            M, q = np.ascontiguousarray(standard.M), standard.q
            z = lemke(M, q, max_iter=10000).z
            forces, twist = mixed.to_si(standard.X @ z + standard.x0)
            solved[QUANTECON] = folder.residual(scene, forces, twist, faces) <= folder.problems.TOL
            tasks[QUANTECON] = lambda M=M, q=q: lambda: lemke(M, q, max_iter=10000)
        chosen = {name: tasks[name] for name in names if solved[name]}
        for name, seconds in best_times(chosen, rounds).items():
            out[faces, name][k] = 1e6 * seconds
    return out


def _quantecon(console: Console) -> Any:
    try:
        from quantecon.optimize import lcp_lemke
    except ImportError:
        console.print(
            "quantecon is not installed here, and limits are multiples of its time: handlcp\\[bench] brings it"
        )
        return None
    return lcp_lemke


def _print_times(console: Console, times: Times, count: int) -> None:
    names = list(dict.fromkeys(name for _, name in times))
    table = plain_table(
        f"{count} rings of five fingers: solved: median / 95th percentile in µs over those", "",
        *(f"{f} faces" if f != "cone" else "cone" for f in SECTIONS),
        caption="Best call of several rounds in turns. solve_lcp on the assembled problem, certificate included; "
        "grasp.solve from contacts to forces. Both get a new problem or grasp for every call, so that nothing is left "
        "over from the call before, but in the row of the repeated one.",
    )  # fmt: skip
    for name in names:
        cells = []
        for f in SECTIONS:
            us = times.get((f, name), np.array([np.nan]))
            ok = us[~np.isnan(us)]
            cells.append(f"{len(ok)}: {np.median(ok):.0f} / {np.percentile(ok, 95):.0f}" if len(ok) else "–")
        table.add_row(name, *cells)
    console.print(table)


def _limits(times: Times) -> list[tuple[str, float, float]]:
    """(what, measured, at most) for each limit of the issue that can be measured here."""
    out: list[tuple[str, float, float]] = []

    def ratio(words: str, mine: tuple[Faces, str], other: tuple[Faces, str], limit: float) -> None:
        if mine in times and other in times:
            both = ~np.isnan(times[mine]) & ~np.isnan(times[other])
            if both.any():
                out.append((words, float(np.median(times[mine][both]) / np.median(times[other][both])), limit))

    for faces, limit in ((8, 3.0), (16, 2.0), (32, 0.5)):
        ratio(f"solve_lcp, {faces} faces / QuantEcon, {faces}", (faces, LCP), (faces, QUANTECON), limit)
    ratio("solve_lcp, cone / QuantEcon, 8", ("cone", LCP), (8, QUANTECON), 3.0)
    ratio("solve_lcp, cone / Siconos Newton", ("cone", LCP), ("cone", NEWTON), 0.2)
    for faces in (8, 16, 32, "cone"):
        us = times[faces, LCP][~np.isnan(times[faces, LCP])]
        name = f"{faces} faces" if faces != "cone" else faces
        if len(us):
            out.append(
                (f"solve_lcp, {name}: 95th percentile / median", float(np.percentile(us, 95) / np.median(us)), 10.0)
            )
    for faces in (8, 16, 32, "cone"):
        name = f"{faces} faces" if faces != "cone" else faces
        ratio(f"grasp.solve, {name} / QuantEcon, 8", (faces, WHOLE), (8, QUANTECON), 10.0)
    return out


def _print_limits(console: Console, limits: Sequence[tuple[str, float, float]]) -> None:
    table = plain_table(
        "Limits", "ratio of medians", "measured", "at most", "",
        caption="Each ratio over the scenes that both solve; percentiles over all that solve_lcp solves.",
    )  # fmt: skip
    for words, value, limit in limits:
        met = "met" if value <= limit else f"missed by {100 * (value / limit - 1):.0f} %"
        table.add_row(words, f"{value:.2f}", f"{limit:g}", met)
    console.print(table)
