"""Small pictures of several grasps of one hand, side by side: hand, object and forces, without numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handlcp.errors import InputError
from handlcp.hand import Candidate
from handlcp.show.file import new_figure
from handlcp.show.picture.camera import camera_for, frame
from handlcp.show.picture.content import LOAD, Content
from handlcp.show.picture.overlay import Overlay
from handlcp.show.picture.painter import paint

COLUMNS, CELL, CAPTION, DPI = 5, 4.0, 0.3, 60  # pictures in a row; inches of each, to its name; dots an inch
_COLOURS = 128  # of the file: half the size, and no difference to the eye


def contact_sheet(grasps: list[tuple[str, Candidate | None]], file: Path) -> None:
    """Write a png with one picture for each named grasp, an empty place for None.

    Raises InputError for a file that cannot be written; Unsupported without matplotlib.
    """
    rows = -(-len(grasps) // COLUMNS)
    wide, high = COLUMNS * CELL, rows * CELL
    figure = new_figure(figsize=(wide, high))
    for k, (name, candidate) in enumerate(grasps):
        x, y = (k % COLUMNS) * CELL, high - (k // COLUMNS + 1) * CELL
        ax = figure.add_axes((x / wide, y / high, CELL / wide, CELL / high))
        ax.axis("off")
        if candidate is not None:
            _picture(ax, candidate)
        where = (x + 0.5 * CELL) / wide, (y + CAPTION) / high
        figure.text(*where, name if candidate else f"{name}: none found", ha="center", va="center", fontsize=22)
    _write(figure, file)


def _picture(ax: Any, candidate: Candidate) -> None:
    shown = Content(candidate.grasp, candidate.solution, None, verdict=candidate.verdict)
    camera = camera_for(shown.grasp, shown.solids, shown.glass, shown.marks())
    view = frame(camera, shown.solids, shown.glass, shown.reach(), (CELL, CELL), 0.1)
    scene = shown.grasp.scene
    hidden = shown.hidden(paint(ax, camera, shown.solids, shown.glass, view, DPI)(scene.positions))
    over = Overlay(ax, camera, view.inch)
    if shown.load > 0:
        over.arrow(shown.acts_at, shown.pull, LOAD, 1.6)
    for i, (p, force) in enumerate(zip(scene.positions, shown.forces, strict=True)):
        over.arrow(p, force, shown.colours[i], 1.6)
        over.dot(p, shown.colours[i], bool(hidden[i]))
    ax.set_xlim(view.box[:2])
    ax.set_ylim(view.box[2:])


def _write(figure: Any, file: Path) -> None:
    """With few colours, where Pillow is there, which matplotlib brings."""
    import io

    from PIL import Image

    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=DPI, facecolor="white", format="png")
    drawn.seek(0)
    try:
        Image.open(drawn).convert("RGB").quantize(_COLOURS, Image.Quantize.MAXCOVERAGE).save(file, optimize=True)
    except OSError as error:
        raise InputError("out", "a folder that can be written", f"{str(file)!r}: {error.strerror or error}") from None
