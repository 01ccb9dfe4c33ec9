"""`handlcp sweep`: many designs of a hand through one brief, from a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from handlcp.cli.app import Json, app, check_files, print_json, say_files
from handlcp.cli.given_hand import given
from handlcp.record import versions


@app.command()
def sweep(
    study: Annotated[Path, typer.Argument(help="A TOML file: hand, space, brief, sampling, samples, seed, out.")],
    best: Annotated[int, typer.Option(min=1, help="How many designs to print.")] = 10,
    by: Annotated[str, typer.Option(help="By what they are the best; with a minus, less is better.")] = "payload",
    plot: Annotated[Path | None, typer.Option(help="Draw front, designs and main effects into this file.")] = None,
    page: Annotated[Path | None, typer.Option(help="Write a page on which the hands on the front turn.")] = None,
    serial: Annotated[bool, typer.Option("--serial", help="In this process alone, not one for each core.")] = False,
    json: Json = False,
) -> None:
    """Evaluate many designs of a hand, print the best, and write a row for each.

    Stopped and started again it goes on with what is missing. Exit status 0, 1 if no design could be evaluated, 2 bad
    input.
    """
    from handlcp.design.sweep.study_file import load
    from handlcp.design.sweep.sweep import sweep as swept

    check_files(plot, page=page)
    file = load(study, given)
    asked, executor = file.tables, "serial" if serial else None
    found = swept(
        file.make, asked.space, file.brief, asked.sampling, asked.samples, file.out, executor, seed=asked.seed
    )
    known = len(found.failed) < len(found)
    first = found.best(best, by) if known else found.failed
    if plot is not None and known:
        found.plot(plot)
    if page is not None and known:
        found.page(page)
    if json:
        failed = [{key: row[key] for key in ("design", "error")} for row in found.failed]
        print_json({"sweep": found.sweep, "best": list(first), "failed": failed, "versions": versions("numpy")})
    else:
        typer.echo(f"{str(found).partition(chr(10) * 2)[0]}\n")
        typer.echo(str(first).partition("\n\n")[2])
        say_files(Console(), Table=[file.out], Picture=[plot] if known else [], Page=[page] if known else [])
    raise typer.Exit(0 if known else 1)
