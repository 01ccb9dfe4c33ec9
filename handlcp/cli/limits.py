"""`handlcp limits`, `envelope` and `payload`: how much load or mass a grasp holds, and what gives out first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.text import Text

from handlcp.check import Array
from handlcp.cli.app import (
    FacesOption,
    JsonOption,
    MotionOption,
    SceneArgument,
    TurnOption,
    app,
    check_motion_limits,
    check_output_files,
    choose_faces,
    choose_geometry,
    follow_option,
    load_scene,
    open_console,
    print_files,
    print_json,
    print_sentence,
)
from handlcp.errors import InputError, shorten_text
from handlcp.grasp import Grasp
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.limits.result import LoadLimit, told
from handlcp.grasp.model.contact import AXIS_DIRECTIONS, axis_directions
from handlcp.grasp.model.validate import height_above
from handlcp.record import package_versions
from handlcp.viz.load_limit_figure import format_load_direction, format_load_size, limit_table

_WrenchValues = tuple[float, float, float, float, float, float]
_AXIS_NUMBERS = {"+x": 0, "-x": 1, "+y": 2, "-y": 3, "+z": 4, "-z": 5}


@app.command()
def limits(
    scene: SceneArgument,
    json: JsonOption = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the load that holds least, from nothing to its limit, into this file.")
    ] = None,
    wrench: Annotated[
        _WrenchValues | None, typer.Option(help="One load that grows: Fx Fy Fz [N] Mx My Mz [N·m].")
    ] = None,
    direction: Annotated[
        list[str] | None, typer.Option(help="A direction of force: x,y,z or an axis such as -z; also several times.")
    ] = None,
    motion: MotionOption = None,
    fixed: Annotated[bool, typer.Option("--fixed", help="Keep this posture's contacts: small motions.")] = False,
    faces: FacesOption = None,
) -> None:
    """How much load does the scene hold beside its weight? Along ±x, ±y, ±z, or as asked; and what gives out there.

    Exit status 0 where it holds its weight, 1 where squeeze or weight alone are too much, 2 bad input.
    """
    check_output_files(plot)
    file = load_scene(scene)
    grasp, sides = file.build(), choose_faces(file.solve_with.faces, faces)
    loads = _read_loads(grasp, wrench, direction)
    check_motion_limits(grasp, motion)
    geometry = "fixed" if fixed else None
    found = [grasp.load_limit(load, geometry=geometry, faces=sides, motion=motion) for load in loads]
    least = min(found, key=lambda limit: limit.factor * float(np.linalg.norm(limit.wrench)))
    if plot is not None:
        least.plot(plot, title=file.title)
    if json:
        every = [one.to_dict() | {"some_equilibrium": one.some_equilibrium, "bound": one.bound} for one in found]
        print_json({"title": file.title, "motion_m": motion, "limits": every, "versions": package_versions("numpy")})
    else:
        _print_limits(found, least, file.title, plot)
    raise typer.Exit(0 if all(limit.factor > 0.0 for limit in found) else 1)


def _read_loads(grasp: Grasp, wrench: _WrenchValues | None, directions: list[str] | None) -> Array:
    """(m, 6) unit forces, of a planar scene in its plane, or the one load that is asked for. Raises InputError."""
    if wrench is not None:
        if directions:
            raise InputError("--direction", "nothing where --wrench is given", " and ".join(directions))
        return np.array([wrench])
    spec = grasp.spec
    ways = np.array([_parse_direction(text) for text in directions]) if directions else axis_directions(spec.plane)
    arm = np.zeros(3) if spec.plane is None else height_above(spec.positions, spec.reference, spec.plane) * spec.plane
    return np.hstack([ways, np.cross(arm, ways)])


def _parse_direction(text: str) -> Array:
    """The direction that a text means, such as "-z" or "1,0,0.5": a unit vector (3,). Raises InputError."""
    if text in _AXIS_NUMBERS:
        return np.asarray(AXIS_DIRECTIONS[_AXIS_NUMBERS[text]])
    try:
        found = np.array([float(part) for part in text.replace(",", " ").split()])
    except ValueError:
        found = np.zeros(0)
    if len(found) != len(AXIS_DIRECTIONS[0]) or not np.isfinite(found).all() or not found.any():
        raise InputError("--direction", "numbers x,y,z, not all 0, or an axis such as -z", shorten_text(text))
    return np.asarray(found / np.linalg.norm(found))


def _print_limits(found: list[LoadLimit], least: LoadLimit, title: str, plot: Path | None) -> None:
    """The table, what happens on the way to the least of the limits, and the picture's name."""
    out = open_console(title)
    if found[0].factor == 0.0:
        print_sentence(out, "NOT HELD", "bold red", found[0].why)
    else:
        out.print(limit_table(found, "Load beside the weight"))
        held = f"held up to {format_load_size(least.wrench, least.factor)}; there, {describe_failures(least.binds)}"
        print_sentence(out, "Weakest", "bold", f"{format_load_direction(least.wrench)}, {held}")
        for line in told(least.events, lambda factor: format_load_size(least.wrench, factor)):
            out.print(Text(f"  {line}"))
    print_files(out, Picture=[plot])


# ----------------------------------------------------------------
# `handlcp envelope`: how much a scene holds in each direction, and what gives out first.


@app.command()
def envelope(
    scene: SceneArgument,
    json: JsonOption = False,
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
    motion: MotionOption = None,
    turn: TurnOption = None,
    adaptive: Annotated[int, typer.Option(help="How often steps between two causes are halved.")] = 2,
    faces: FacesOption = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the surface into this file (png, svg, pdf).")] = None,
    polar: Annotated[Path | None, typer.Option(help="Draw polar diagrams into this file.")] = None,
    page: Annotated[Path | None, typer.Option(help="Write a page to turn into this HTML file.")] = None,
) -> None:
    """How much the scene's grasp holds in each direction, what gives out first, and what compliance gives away.

    The load comes slowly, after squeeze and weight. Exit status 0, 1 if it does not hold without a load, 2 bad input.
    """
    from handlcp.studies.envelope import envelope as envelope_of  # no other command pays for it
    from handlcp.studies.envelope.direction import read_directions

    check_output_files(plot, polar, page=page)
    plane, _, count = directions.partition(",")
    asked: Any = plane
    if count or plane.isdecimal():
        if not (number := count or plane).isascii() or not number.isdecimal() or len(number) > 9:
            expected = 'a number, "xy", "yz" or "xz", or both as in "xy,72"'
            raise InputError("--directions", expected, shorten_text(repr(directions)))
        asked = (plane, int(number)) if count else int(number)
    flat = read_directions(asked).plane is not None  # raises before any work is done
    read = load_scene(scene)
    sides = choose_faces(read.solve_with.faces, faces)
    grasp = read.build()
    check_motion_limits(grasp, motion, turn)
    if page is not None and (flat or grasp.spec.plane is not None):
        got = directions if flat else "a planar scene, whose directions lie in its plane; --polar draws these"
        raise InputError("--page", "directions all around, which the page can turn", got)
    found = envelope_of(
        grasp,
        asked,
        of=of,
        geometry=choose_geometry(followed),
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
        out = open_console(read.title)
        typer.echo(str(found))
        print_files(out, Picture=[plot, polar], Page=[page])
    raise typer.Exit(0 if found.weakest.factor > 0.0 else 1)


# ----------------------------------------------------------------
# `handlcp payload`: the largest mass that a grasp holds however the hand is turned, and what gives out first.


@app.command()
def payload(
    scene: SceneArgument,
    json: JsonOption = False,
    plot: Annotated[Path | None, typer.Option(help="Draw a bar for each direction of gravity into this file.")] = None,
    every: Annotated[
        bool, typer.Option("--any", help="Look for the worst direction of gravity all around, too.")
    ] = False,
    acceleration: Annotated[
        float, typer.Option(help="Of the hand, the worst of six ways beside gravity, in m/s².")
    ] = 0.0,
    motion: MotionOption = None,
    followed: Annotated[bool | None, follow_option("followed; --any looks in this posture where that is long")] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Relative error of the masses: steps are chosen by it.")
    ] = None,
    faces: FacesOption = None,
) -> None:
    """How heavy may the object be, with gravity along ±x, ±y, ±z of the hand; and what gives out first?

    The hand closes as in the scene, then the mass grows. Exit status 0, 1 if the scene does not hold without a mass,
    2 bad input.
    """
    check_output_files(plot)
    file = load_scene(scene)
    grasp = file.build()
    check_motion_limits(grasp, motion)
    found = grasp.payload(
        "any" if every else 6,
        acceleration,
        geometry=choose_geometry(followed),
        faces=choose_faces(file.solve_with.faces, faces),
        motion=motion,
        accuracy=accuracy,
    )
    if plot is not None:
        found.plot(plot, title=file.title)
    if json:
        print_json({"title": file.title} | found.to_dict() | {"versions": package_versions("numpy")})
    else:
        out = open_console(file.title)
        typer.echo(str(found))
        print_files(out, Picture=[plot])
    raise typer.Exit(0 if found.mass > 0.0 else 1)
