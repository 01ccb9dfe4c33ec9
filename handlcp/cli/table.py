"""`handlcp table`: what every hand at hand holds of every object, written as it goes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from handlcp.cli.app import Json, app, print_json, say_files
from handlcp.design.table import SECONDS
from handlcp.record import pick


@app.command()
def table(
    out: Annotated[Path, typer.Option(help="A folder; made if it is not there.")] = Path("table"),
    hands: Annotated[str | None, typer.Option(help="Names with commas between them; without: all there are.")] = None,
    objects: Annotated[str | None, typer.Option(help="Names with commas; without: YCB, ball, cylinder.")] = None,
    kinds: Annotated[str, typer.Option(help="Kinds of grasps.")] = "pinch,power",
    seconds: Annotated[float, typer.Option(help="Of computing that finding one grasp may take.")] = SECONDS,
    mujoco: Annotated[bool, typer.Option(help="Whether MuJoCo judges the better grasp of each pair.")] = True,
    serial: Annotated[bool, typer.Option("--serial", help="In this process alone, not one for each core.")] = False,
    json: Json = False,
) -> None:
    """What hands hold of objects: payload with its interval, what gives out first, MuJoCo's verdict; a page of it.

    Stopped and started again it goes on with what is missing. Exit status 0, 2 bad input.
    """
    from handlcp.design.table.make import table as made

    found = made(
        _names(hands), _names(objects), out, "serial" if serial else None, kinds=_names(kinds) or (), seconds=seconds,
        simulated=mujoco,
    )  # fmt: skip
    page = found.page(out / "index.html")
    if json:
        print_json(pick(found, "summary") | {"page": str(page)})
        return
    typer.echo(str(found))
    say_files(Console(), Page=[page], Table=[out / "table.parquet", out / "table.json"])


def _names(text: str | None) -> tuple[str, ...] | None:
    """Of an option with commas."""
    return None if text is None else tuple([name.strip() for name in text.split(",") if name.strip()])
