"""Many grasps at once, over all cores: for sweeps over loads, postures and designs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, overload

import numpy as np

from handlcp.check import Bools, integer, read_only
from handlcp.errors import InputError
from handlcp.grasp.answer import answers
from handlcp.grasp.first import NOWHERE, Found, Kind, kind_of, pack
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.pyramid import Pyramid, Section, as_section
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.solving import solve, stages
from handlcp.lcp import Auto, ContactSolver, Solver, Status, as_chain

__all__ = ["Solutions", "solve_many"]

_CHUNK = 128  # grasps that a thread takes at a time: long beside the handing over, short beside the whole


class Solutions(Sequence[GraspSolution]):
    """The solutions of `solve_many`, in the order of its grasps; most are made when they are first looked at.

    held : (m,) bool, whether each is SOLVED.
    """

    def __init__(
        self, grasps: tuple[Grasp, ...], sections: Sequence[Section], found: list[Found | GraspSolution]
    ) -> None:
        self._grasps, self._sections, self._found = grasps, sections, found
        self.held: Bools = np.array([isinstance(a, Found) or a.held for a in found], dtype=bool)

    @property
    def statuses(self) -> tuple[Status, ...]:
        """The status of each."""
        return tuple(Status.SOLVED if isinstance(a, Found) else a.status for a in self._found)

    def __len__(self) -> int:
        return len(self._grasps)

    @overload
    def __getitem__(self, at: int) -> GraspSolution: ...
    @overload
    def __getitem__(self, at: slice) -> list[GraspSolution]: ...
    def __getitem__(self, at: int | slice) -> GraspSolution | list[GraspSolution]:
        if isinstance(at, slice):
            return [self[k] for k in range(len(self))[at]]
        answer = self._found[at]
        if isinstance(answer, Found):
            answer = self._found[at] = self._grasps[at]._answered(self._sections[at], answer)
        return answer

    def __repr__(self) -> str:
        return f"Solutions({len(self)} grasps, {int(self.held.sum())} held)"


def solve_many(
    grasps: Iterable[Grasp],
    faces: int | str | Pyramid = 8,
    solver: Solver | ContactSolver | Auto | None = None,
    *,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Solutions:
    """The solution of each grasp, as its own `solve(faces, solver, throw=False)` gives it, whatever the workers.

    workers : threads; None: one a core. Compiled code, which is most of the work, runs side by side. progress : called
    with (grasps done, all grasps) from time to time.

    One grasp after the other takes part in one matrix a kind of scene: what remains of Python is little. Grasps that
    the first stage does not answer go through the later ones alone, and of those, searches of seconds are the price of
    a proof: `Auto(search_seconds=0)` does without. Raises InputError for anything but grasps.
    """
    all_ = tuple(grasps)
    for k, g in enumerate(all_):
        if not isinstance(g, Grasp):
            raise InputError(f"grasps[{k}]", "a Grasp", repr(g)[:80])
    count = (os.cpu_count() or 1) if workers is None else integer("workers", workers, 1)
    either = {planar: as_section(faces, planar=planar) for planar in (False, True)}
    sections = [either[g.scene.plane is not None] for g in all_]
    found: list[Any] = [None] * len(all_)
    parts = [range(at, min(at + _CHUNK, len(all_))) for at in range(0, len(all_), _CHUNK)]
    if parts:  # the first compiles what is not compiled yet: once is enough
        _part(all_, sections, solver, parts[0], found)
    done = len(parts[0]) if parts else 0
    with ThreadPoolExecutor(count) as pool:
        for size in pool.map(lambda part: _part(all_, sections, solver, part, found), parts[1:]):
            if progress is not None:
                progress(done, len(all_))
            done += size
    if progress is not None:
        progress(done, len(all_))
    return Solutions(all_, sections, found)


def _part(
    grasps: Sequence[Grasp],
    sections: Sequence[Section],
    solver: Solver | ContactSolver | Auto | None,
    part: range,
    found: list[Any],
) -> int:
    """Solve some of the grasps into their places; returns how many."""
    chain = as_chain(solver)
    kinds: dict[int, tuple[Kind, list[int]]] = {}
    for k in part:
        grasp, section = grasps[k], sections[k]
        if chain is None or grasp.effects:
            found[k] = solve(grasp, section, solver, throw=False)
        else:
            kind = kind_of(grasp.scene, section)
            kinds.setdefault(id(kind), (kind, []))[1].append(k)
    for kind, members in kinds.values():
        scenes = np.empty((len(members), kind.scene_width))
        for row, k in zip(scenes, members, strict=True):
            pack(grasps[k].scene, sections[k], row)
        rows = np.empty((len(members), kind.answer_width))
        assert chain is not None
        answers(scenes, kind.pattern, NOWHERE, chain.seed, rows)
        for row, k in zip(read_only(rows), members, strict=True):
            first = Found(kind, row)
            passes = first.passes
            found[k] = first if passes else stages(grasps[k], sections[k], solver, False, NOWHERE, first.proposal)
    return len(part)
