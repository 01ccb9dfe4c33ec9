"""`handlcp limits` and `handlcp envelope`: how much load a grasp holds in each direction, and what gives out there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.text import Text

from handlcp.check import Array
from handlcp.cli.app import (
    Faces,
    Json,
    Motion,
    Scene,
    Turn,
    app,
    check_allowed,
    check_files,
    follow_option,
    geometry_of,
    load_scene,
    print_json,
    say,
    say_files,
    sides_of,
    titled,
)
from handlcp.errors import InputError, brief
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.limits.result import LoadLimit, told
from handlcp.record import versions
from handlcp.show.limit import limit_table, size, way

_Wrench = tuple[float, float, float, float, float, float]
_AXES = {"+x": 0, "-x": 1, "+y": 2, "-y": 3, "+z": 4, "-z": 5}
_WAYS = np.repeat(np.eye(3), 2, axis=0) * np.tile([[1.0], [-1.0]], (3, 1))


@app.command()
def limits(
    scene: Scene,
    json: Json = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the load that holds least, from nothing to its limit, into this file.")
    ] = None,
    wrench: Annotated[_Wrench | None, typer.Option(help="One load that grows: Fx Fy Fz [N] Mx My Mz [N·m].")] = None,
    direction: Annotated[
        list[str] | None, typer.Option(help="A direction of force: x,y,z or an axis such as -z; also several times.")
    ] = None,
    motion: Motion = None,
    fixed: Annotated[bool, typer.Option("--fixed", help="Keep this posture's contacts: small motions.")] = False,
    faces: Faces = None,
) -> None:
    """How much load does the scene hold beside its weight? Along ±x, ±y, ±z, or as asked; and what gives out there.

    Exit status 0 where it holds its weight, 1 where squeeze or weight alone are too much, 2 bad input.
    """
    check_files(plot)
    loads = _loads(wrench, direction)
    file = load_scene(scene)
    grasp, sides = file.build(), sides_of(file.solve_with.faces, faces)
    check_allowed(grasp, motion)
    geometry = "fixed" if fixed else None
    found = [grasp.load_limit(load, geometry=geometry, faces=sides, motion=motion) for load in loads]
    least = min(found, key=lambda limit: limit.factor * float(np.linalg.norm(limit.wrench)))
    if plot is not None:
        least.plot(plot, title=file.title)
    if json:
        every = [one.to_dict() | {"some_equilibrium": one.some_equilibrium, "bound": one.bound} for one in found]
        print_json({"title": file.title, "motion_m": motion, "limits": every, "versions": versions("numpy")})
    else:
        _print(found, least, file.title, plot)
    raise typer.Exit(0 if all(limit.factor > 0.0 for limit in found) else 1)


def _loads(wrench: _Wrench | None, directions: list[str] | None) -> Array:
    """(m, 6) unit forces, or the one load that is asked for. Raises InputError."""
    if wrench is not None:
        if directions:
            raise InputError("--direction", "nothing where --wrench is given", " and ".join(directions))
        return np.array([wrench])
    ways = _WAYS if not directions else np.array([_direction(text) for text in directions])
    return np.hstack([ways, np.zeros((len(ways), 3))])


def _direction(text: str) -> Array:
    """The direction that a text means, such as "-z" or "1,0,0.5": a unit vector (3,). Raises InputError."""
    if text in _AXES:
        return np.asarray(_WAYS[_AXES[text]])
    try:
        found = np.array([float(part) for part in text.replace(",", " ").split()])
    except ValueError:
        found = np.zeros(0)
    if len(found) != len(_WAYS[0]) or not np.isfinite(found).all() or not found.any():
        raise InputError("--direction", "numbers x,y,z, not all 0, or an axis such as -z", brief(text))
    return np.asarray(found / np.linalg.norm(found))


def _print(found: list[LoadLimit], least: LoadLimit, title: str, plot: Path | None) -> None:
    """The table, what happens on the way to the least of the limits, and the picture's name."""
    out = titled(title)
    if found[0].factor == 0.0:
        say(out, "NOT HELD", "bold red", found[0].why)
    else:
        out.print(limit_table(found, "Load beside the weight"))
        amount = size(least.wrench, least.factor)
        say(
            out, "Weakest", "bold", f"{way(least.wrench)}, held up to {amount}; there, {describe_failures(least.binds)}"
        )
        for line in told(least.events, lambda factor: size(least.wrench, factor)):
            out.print(Text(f"  {line}"))
    say_files(out, Picture=[plot])


# ----------------------------------------------------------------
# `handlcp envelope`: how much a scene holds in each direction, and what gives out first.


@app.command()
def envelope(
    scene: Scene,
    json: Json = False,
    of: Annotated[
        str, typer.Option(help="What it holds: force in N, torque in N·m, or gravity, the object's mass in kg.")
    ] = "force",
    directions: Annotated[
        str,
        typer.Option(help='At least so many all around; or a plane: xy, yz, xz, also with a number: "xy,72".'),
    ] = "362",
    followed: Annotated[bool | None, follow_option("followed where that takes seconds")] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Relative error of the factors: steps are chosen by it.")
    ] = None,
    motion: Motion = None,
    turn: Turn = None,
    adaptive: Annotated[int, typer.Option(help="How often steps between two causes are halved.")] = 2,
    faces: Faces = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the surface into this file (png, svg, pdf).")] = None,
    polar: Annotated[Path | None, typer.Option(help="Draw polar diagrams into this file.")] = None,
    page: Annotated[Path | None, typer.Option(help="Write a page to turn into this HTML file.")] = None,
) -> None:
    """How much the scene's grasp holds in each direction, what gives out first, and what compliance gives away.

    The load comes slowly, after squeeze and weight. Exit status 0, 1 if it does not hold without a load, 2 bad input.
    """
    from handlcp.study.envelope import envelope as envelope_of
    from handlcp.study.envelope.causes import read_directions

    check_files(plot, polar, page=page)
    asked = _asked(directions)
    flat = read_directions(asked).plane is not None  # raises before any work is done
    read = load_scene(scene)
    sides = sides_of(read.solve_with.faces, faces)
    grasp = read.build()
    check_allowed(grasp, motion, turn)
    if page is not None and (flat or grasp.spec.plane is not None):
        got = directions if flat else "a planar scene, whose directions lie in its plane; --polar draws these"
        raise InputError("--page", "directions all around, which the page can turn", got)
    found = envelope_of(
        grasp,
        asked,
        of=of,
        geometry=geometry_of(followed),
        faces=sides,
        adaptive=adaptive,
        motion=motion,
        turn=turn,
        accuracy=accuracy,
    )
    for path, draw in ((plot, found.plot), (polar, found.polar), (page, found.page)):
        if path is not None:
            draw(path, title=read.title)
    if json:
        print_json({"title": read.title} | found.to_dict())
    else:
        out = titled(read.title)
        typer.echo(str(found))
        say_files(out, Picture=[plot, polar], Page=[page])
    raise typer.Exit(0 if found.weakest.factor > 0.0 else 1)


def _asked(text: str) -> Any:
    """The directions that a text asks for: a count, a plane, or both as (plane, count). Raises InputError."""
    plane, _, count = text.partition(",")
    if not count and not plane.isdecimal():
        return plane
    if not (number := count or plane).isascii() or not number.isdecimal() or len(number) > 9:
        raise InputError("--directions", 'a number, "xy", "yz" or "xz", or both as in "xy,72"', brief(repr(text)))
    return (plane, int(number)) if count else int(number)
