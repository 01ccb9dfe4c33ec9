"""`handlcp reliability`: how sure it is that a scene holds, when what it is made of varies."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from handlcp.cli.app import Faces, Json, SceneFile, app, print_files, print_json, progress_bar, sides_of, titled
from handlcp.errors import InputError
from handlcp.show.file import checked, writable

_SHARE = "standard deviation, as a share"


@app.command()
def reliability(
    scene: SceneFile,
    friction: Annotated[float | None, typer.Option(help=f"Of the fingers' coefficient: {_SHARE}.")] = None,
    stiffness: Annotated[float | None, typer.Option(help=f"Of the joints: {_SHARE}.")] = None,
    pads: Annotated[float | None, typer.Option(help=f"Of the fingertips' flexibility: {_SHARE}.")] = None,
    mass: Annotated[float | None, typer.Option(help=f"Of the object: {_SHARE}.")] = None,
    load: Annotated[float | None, typer.Option(help=f"Of what loads it besides its weight: {_SHARE}.")] = None,
    squeeze: Annotated[float | None, typer.Option(help=f"How hard the hand closes: {_SHARE}.")] = None,
    positions: Annotated[float | None, typer.Option(help="Of each contact along both tangents [m].")] = None,
    posture: Annotated[float | None, typer.Option(help="Of each joint [rad, m].")] = None,
    samples: Annotated[int, typer.Option(help="At least so many.")] = 10_000,
    seed: Annotated[int, typer.Option(help="Of the samples.")] = 0,
    check: Annotated[
        bool, typer.Option("--check", help="Follow each sample while it is squeezed, then loaded: 30 ms each.")
    ] = False,
    confidence: Annotated[float, typer.Option(help="Of the intervals.")] = 0.95,
    resume: Annotated[Path | None, typer.Option(help="Keep what is done in this .npz file, and go on there.")] = None,
    faces: Faces = None,
    plot: Annotated[Path | None, typer.Option(help="Draw margins and what matters most (png, svg, pdf).")] = None,
    json: Json = False,
) -> None:
    """The chance that a scene holds, what its worst sample fails of, and which spread matters most.

    Exit status 0, 2 for bad input.
    """
    from handlcp import scene as scenes
    from handlcp.study import reliability as study

    given = {
        "friction": friction, "stiffness": stiffness, "pads": pads, "mass": mass, "load": load, "squeeze": squeeze,
        "positions": positions, "posture": posture,
    }  # fmt: skip
    spread = {name: value for name, value in given.items() if value is not None}
    if not spread:
        raise InputError("--friction, --mass, …", "at least one of what varies", "none")
    if plot is not None:
        checked(plot)
    if resume is not None:
        writable("resume", resume)
    file = scenes.load(scene)
    sides = sides_of(file.solve_with.faces, faces)
    with progress_bar() as bar:
        found = study.reliability(
            file.build(), spread, samples, seed=seed, faces=sides, by="check" if check else "solve",
            confidence=confidence, resume=resume, progress=lambda done, total: bar(done, total, "samples"),
        )  # fmt: skip
    if plot is not None:
        found.plot(plot, title=file.title)
    if json:
        print_json({"title": file.title} | found.to_dict())
        return
    out = titled(file.title)
    out.print(Text(str(found)), soft_wrap=True)
    if plot is not None:
        out.print()
        print_files(out, pictures=(plot,))
