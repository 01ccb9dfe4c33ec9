"""The whole gallery: hands in parallel, each written when it is done, so that a run that was cut short goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from handlcp.hand.find.candidate import Candidate
from handlcp.study.gallery.models import Model
from handlcp.study.gallery.shelf import Shelf, shelf
from handlcp.study.gallery.things import things

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
    text = json.dumps(made.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    _numbers(folder, model).write_text(text + "\n", encoding="utf-8")
    return made


def _numbers(folder: Path, model: Model) -> Path:
    return folder / f"{model.name}.json"
