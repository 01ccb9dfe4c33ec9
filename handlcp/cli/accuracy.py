"""Commands of studies: what accuracy costs, the gallery."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from handlcp.cli.app import Json, app, print_json, say, titled
from handlcp.errors import HandLCPError, InputError, NoSolutionFound, UnknownName
from handlcp.progress import steps
from handlcp.show.file import checked, writable

# ----------------------------------------------------------------
# `handlcp gallery`: find grasps of every hand and write a page of them.


@app.command()
def gallery(
    out: Annotated[Path, typer.Option(help="Folder of the page index.md; made if it is not there.")],
    hand: Annotated[
        list[str] | None, typer.Option(help="A hand by name; may be repeated. None: all there are.")
    ] = None,
    again: Annotated[bool, typer.Option("--again", help="Compute hands anew whose numbers are in the folder.")] = False,
    workers: Annotated[int | None, typer.Option(help="Processes; by default one a core.", min=1)] = None,
    json: Json = False,
) -> None:
    """Find grasps of a ball, a box, a cylinder and household objects by every hand, and write a page of them.

    Some minutes. Hands that are done are written at once, and a run that was cut short goes on. Exit status 0, 2 bad
    input.
    """
    from handlcp.show.contact_sheet import contact_sheet
    from handlcp.show.file import new_figure
    from handlcp.study.gallery import GALLERY_HANDS, model, page, run

    if unknown := [name for name in hand or () if name not in GALLERY_HANDS]:
        raise UnknownName("hand", "a hand", unknown, GALLERY_HANDS)
    new_figure()  # whether matplotlib is there
    models, missing = [], {}
    for name in hand or GALLERY_HANDS:
        try:
            models.append(model(name))
        except HandLCPError as error:
            missing[name] = str(error)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("out", "a folder that can be made", f"{str(out)!r}: {error.strerror}") from None
    if again:
        for one in models:
            (out / f"{one.name}.json").unlink(missing_ok=True)
    with steps() as told:
        shelves = run(models, out, contact_sheet, workers, told)
    file = out / "index.md"
    file.write_text(page(shelves), encoding="utf-8")
    if json:
        print_json({"page": str(file), "hands": [one.to_dict() for one in shelves], "missing": missing})
        return
    for name, why in missing.items():
        typer.echo(f"{name}: {why}", err=True)
    rows = [row for one in shelves for row in one.rows]
    held = sum(row.verdict == "HELD" for row in rows)
    typer.echo(f"{held} of {len(rows)} held by {len(shelves)} hands: {file}")


# ----------------------------------------------------------------
# `handlcp accuracy`: what accuracy costs in a scene.


@app.command()
def accuracy(
    scene: Annotated[Path, typer.Argument(help="A scene file (TOML).")],
    json: Json = False,
    csv: Annotated[Path | None, typer.Option(help="Write every setting into this file, one a line.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw error against time (png, svg, pdf).")] = None,
    seconds: Annotated[float, typer.Option(help="What the study may take, compilation aside.")] = 60.0,
) -> None:
    """What accuracy costs in this scene: methods, faces, tolerances, effects left out, against the exact cone.

    Exit status 0, 1 if nothing holds the object exactly (there is nothing to compare with), 2 bad input.
    """
    from handlcp import scene as scenes
    from handlcp.method import work_precision
    from handlcp.method.accuracy import accuracy_cost, table as accuracy_table

    file = scenes.load(scene)
    if plot is not None:
        checked(plot)
    if csv is not None:
        writable("csv", csv)
    grasp = file.build()
    try:
        with steps() as progress:
            cost = accuracy_cost(grasp, seconds=seconds, progress=progress)
    except NoSolutionFound as error:
        status, why = error.solution.status.name, error.solution.diagnosis
        if json:
            print_json({"title": file.title, "status": status, "diagnosis": why})
        else:
            Console(stderr=True).print(Text(f"Nothing to compare with: {why}."))
        raise typer.Exit(1) from None
    if csv is not None:
        cost.to_csv(csv)
    if plot is not None:
        work_precision.save((file.title, cost), plot)
    if json:
        print_json({"title": file.title} | cost.to_dict())
        return
    out = titled(file.title)
    for table in accuracy_table.all_tables(cost):
        out.print(table)
    out.print(Text(f"{cost.summary}."))
    for note in cost.notes:
        say(out, "Note", "yellow", note)
    for path in (csv, plot):
        if path is not None:
            out.print(Text(f"Written: {path}", style="dim"))
