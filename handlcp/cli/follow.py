"""`handlcp follow`: a scene loaded in steps, what happens on the way, and what it is like at the end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from handlcp.cli.app import Faces, Json, SceneFile, app, print_files, print_json, print_tables, say, sides_of, titled
from handlcp.grasp import Loading
from handlcp.show.file import checked
from handlcp.show.page.file import checked as checked_page


@app.command()
def follow(
    scene: SceneFile,
    json: Json = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw forces, motion and torques over the load into this file (png, svg, pdf).")
    ] = None,
    picture: Annotated[Path | None, typer.Option(help="Draw the hand where it ends into this file.")] = None,
    page: Annotated[
        Path | None, typer.Option(help="Write a page to turn, with a slider through the steps, into this HTML file.")
    ] = None,
    order: Annotated[
        str, typer.Option(help="Stages, one after the other: squeeze, load; or together.")
    ] = "squeeze,load",
    fixed: Annotated[
        bool, typer.Option("--fixed", help="Keep this posture's contacts: small motions, as in `handlcp solve`.")
    ] = False,
    faces: Faces = None,
    steps: Annotated[int, typer.Option(help="Steps of a stage, more where something happens.")] = 40,
) -> None:
    """Load a scene in steps: the hand squeezes, then weight and load come. Exit status 0 reached, 1 lost, 2 bad input.

    The hand is followed as it moves, contacts are detected anew in every step.
    """
    from handlcp import scene as scenes

    for file in (plot, picture):
        if file is not None:
            checked(file)
    if page is not None:
        checked_page(page)
    read = scenes.load(scene)
    sides = sides_of(read.solve_with.faces, faces)
    stages = tuple([name.strip() for name in order.split(",")])
    found = read.build().follow(order=stages, geometry="fixed" if fixed else None, faces=sides, steps=steps)
    _draw(found, read, plot, picture)
    if page is not None:
        found.page(page, obj=read.shape(), title=read.title)
    if json:
        print_json({"title": read.title} | found.to_dict())
    else:
        _print(found, read.title, (plot, picture), page)
    raise typer.Exit(0 if found.reached else 1)


def _draw(found: Loading, read: Any, plot: Path | None, picture: Path | None) -> None:
    from handlcp.show import loading as shown

    if plot is not None:
        found.plot(plot, title=read.title)
    if picture is not None:
        shown.save_picture(found, picture, read.title, read.shape())


def _print(found: Loading, title: str, drawn: tuple[Path | None, ...], page: Path | None) -> None:
    """The outcome, the object's motion, what happens on the way, contacts and joints at the end."""
    from handlcp.show.loading import report

    out = titled(title)
    word, style = ("REACHED", "green") if found.reached else ("LOST", "red")
    say(out, word, f"bold {style}", found.why.removeprefix("reached ").removeprefix("lost "))
    say(out, "Motion", "bold", report.motion(found))
    out.print()
    if (happens := report.event_table(found)) is not None:
        out.print(happens)
    print_tables(out, report.end_tables(found))
    print_files(out, pictures=drawn, page=page)
