"""Designs of a sweep once more, each from the grasps that it started from: the same numbers, now with the grasps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from handlcp.design.evaluation import Evaluation
from handlcp.design.space import Space
from handlcp.design.sweep.cells import cells_of, numbered, points
from handlcp.design.sweep.work import Heads, Maker, Outcome, evaluated
from handlcp.errors import InputError
from handlcp.progress import track_progress


def evaluations(sweep: Mapping[str, Any], maker: Maker, designs: Sequence[int]) -> list[Evaluation]:
    """Of designs by number, in their order. sweep : what the sweep was. Raises InputError for one that fails."""
    space = Space(sweep["space"])
    cube = points(space, sweep["sampling"], sweep["samples"], sweep["seed"])
    values, wanted, found = numbered(space, cube), set(designs), dict[int, Evaluation]()
    with track_progress("designs once more", len(wanted)) as say:
        for cell in cells_of(space, cube):
            own = wanted.intersection(cell)
            if not own:
                continue
            heads, known = Heads(cell), dict[int, Outcome]()
            while not heads.done:
                near = heads.near
                for k in heads.ready():
                    known[k] = evaluated(maker, (k, values[k]), near, True)
                    heads.found[k] = one if isinstance(one := known[k], Evaluation) else None
            for k in sorted(own):
                one = known[k] if k in known else evaluated(maker, (k, values[k]), heads.near, False)
                if isinstance(one, str):
                    raise InputError("designs", "designs that can be evaluated", f"design {k}: {one}")
                found[k] = one
                say(1)
    return [found[k] for k in designs]
