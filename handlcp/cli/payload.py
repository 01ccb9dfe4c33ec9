"""`handlcp payload`: the largest mass that a grasp holds however the hand is turned, and what gives out first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from handlcp.cli.app import (
    Faces,
    Json,
    Motion,
    Scene,
    app,
    check_allowed,
    check_files,
    follow_option,
    geometry_of,
    load_scene,
    print_json,
    say_files,
    sides_of,
    titled,
)
from handlcp.record import versions


@app.command()
def payload(
    scene: Scene,
    json: Json = False,
    plot: Annotated[Path | None, typer.Option(help="Draw a bar for each direction of gravity into this file.")] = None,
    every: Annotated[
        bool, typer.Option("--any", help="Look for the worst direction of gravity all around, too.")
    ] = False,
    acceleration: Annotated[
        float, typer.Option(help="Of the hand, the worst of six ways beside gravity, in m/s².")
    ] = 0.0,
    motion: Motion = None,
    followed: Annotated[bool | None, follow_option("followed; --any looks in this posture where that is long")] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Relative error of the masses: steps are chosen by it.")
    ] = None,
    faces: Faces = None,
) -> None:
    """How heavy may the object be, with gravity along ±x, ±y, ±z of the hand; and what gives out first?

    The hand closes as in the scene, then the mass grows. Exit status 0, 1 if the scene does not hold without a mass,
    2 bad input.
    """
    check_files(plot)
    file = load_scene(scene)
    grasp = file.build()
    check_allowed(grasp, motion)
    found = grasp.payload(
        "any" if every else 6,
        acceleration,
        geometry=geometry_of(followed),
        faces=sides_of(file.solve_with.faces, faces),
        motion=motion,
        accuracy=accuracy,
    )
    if plot is not None:
        found.plot(plot, title=file.title)
    if json:
        print_json({"title": file.title} | found.to_dict() | {"versions": versions("numpy")})
    else:
        out = titled(file.title)
        typer.echo(str(found))
        say_files(out, Picture=[plot])
    raise typer.Exit(0 if found.mass > 0.0 else 1)
