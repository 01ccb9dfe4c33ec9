"""`handlcp envelope`: how much a scene holds in each direction, and what gives out first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from handlcp.cli.app import Faces, Json, SceneFile, app, print_files, print_json, progress_bar, sides_of, titled
from handlcp.errors import InputError, brief
from handlcp.show.file import checked
from handlcp.show.page.file import checked as checked_page


@app.command()
def envelope(
    scene: SceneFile,
    json: Json = False,
    of: Annotated[
        str, typer.Option(help="What it holds: force [N], torque [N·m], or gravity, the object's mass [kg].")
    ] = "force",
    directions: Annotated[
        str,
        typer.Option(help='At least so many all around; or a plane: xy, yz, xz, also with a number: "xy,72".'),
    ] = "362",
    followed: Annotated[
        bool | None,
        typer.Option(
            "--followed/--fixed",
            help="Follow hand and object as they move, or leave contacts where they are; neither: followed where that "
            "takes seconds.",
        ),
    ] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Relative error of the factors: steps are chosen by it.")
    ] = None,
    motion: Annotated[float | None, typer.Option(help="How far the object may move under the load [m].")] = None,
    turn: Annotated[float | None, typer.Option(help="How far the object may turn under the load [rad].")] = None,
    adaptive: Annotated[int, typer.Option(help="How often steps between two causes are halved.")] = 2,
    faces: Faces = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the surface into this file (png, svg, pdf).")] = None,
    polar: Annotated[Path | None, typer.Option(help="Draw polar diagrams into this file.")] = None,
    page: Annotated[Path | None, typer.Option(help="Write a page to turn into this HTML file.")] = None,
) -> None:
    """How much the scene's grasp holds in each direction, what gives out first, and what compliance gives away.

    The load comes slowly, after squeeze and weight. Exit status 0, 1 if it does not hold without a load, 2 bad input.
    """
    from handlcp import scene as scenes
    from handlcp.study.envelope import envelope as envelope_of

    for file in (plot, polar):
        if file is not None:
            checked(file)
    if page is not None:
        checked_page(page)
    read = scenes.load(scene)
    sides = sides_of(read.solve_with.faces, faces)
    with progress_bar() as progress:
        found = envelope_of(
            read.build(), _asked(directions), of=of, geometry={None: None, True: "followed", False: "fixed"}[followed],
            faces=sides, adaptive=adaptive, motion=motion, turn=turn, accuracy=accuracy,
            progress=lambda done, total: progress(done, total, "directions"),
        )  # fmt: skip
    for path, draw in ((plot, found.plot), (polar, found.polar), (page, found.page)):
        if path is not None:
            draw(path, title=read.title)
    if json:
        print_json({"title": read.title} | found.to_dict())
    else:
        out = titled(read.title)
        typer.echo(str(found))
        print_files(out, pictures=(plot, polar), page=page)
    raise typer.Exit(0 if found.weakest.factor > 0.0 else 1)


def _asked(text: str) -> Any:
    """A count, a plane, or both. Raises InputError."""
    plane, _, count = text.partition(",")
    if not count and not plane.isdecimal():
        return plane
    if not (number := count or plane).isascii() or not number.isdecimal() or len(number) > 9:
        raise InputError("--directions", 'a number, "xy", "yz" or "xz", or both as in "xy,72"', brief(repr(text)))
    return (plane, int(number)) if count else int(number)
