"""`handlcp accuracy`: what accuracy costs in a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from handlcp.cli.app import Json, app, print_json, progress_bar, say, titled
from handlcp.errors import NoSolutionFound
from handlcp.show.file import checked, writable


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
    from handlcp.show import accuracy_table, work_precision
    from handlcp.study.accuracy import accuracy_cost

    file = scenes.load(scene)
    if plot is not None:
        checked(plot)
    if csv is not None:
        writable("csv", csv)
    grasp = file.build()
    try:
        with progress_bar() as progress:
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
