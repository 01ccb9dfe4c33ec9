"""`handlcp limits`: how much load a grasp holds in each direction, and what gives out there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.text import Text

from handlcp.check import Array
from handlcp.cli.app import Faces, Json, SceneFile, app, print_files, print_json, say, sides_of, titled
from handlcp.errors import InputError, brief
from handlcp.grasp.cause.wording import said
from handlcp.grasp.limits.result import LoadLimit, told
from handlcp.record import versions
from handlcp.show.file import checked

_Wrench = tuple[float, float, float, float, float, float]
_AXES = {"+x": 0, "-x": 1, "+y": 2, "-y": 3, "+z": 4, "-z": 5}
_WAYS = np.repeat(np.eye(3), 2, axis=0) * np.tile([[1.0], [-1.0]], (3, 1))


@app.command()
def limits(
    scene: SceneFile,
    json: Json = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the load that holds least, from nothing to its limit, into this file.")
    ] = None,
    wrench: Annotated[_Wrench | None, typer.Option(help="One load that grows: Fx Fy Fz [N] Mx My Mz [N·m].")] = None,
    direction: Annotated[
        list[str] | None, typer.Option(help="A direction of force: x,y,z or an axis such as -z; also several times.")
    ] = None,
    motion: Annotated[
        float | None, typer.Option(help="How far the load may move the object [mm]; without: any distance.")
    ] = None,
    fixed: Annotated[bool, typer.Option("--fixed", help="Keep this posture's contacts: small motions.")] = False,
    faces: Faces = None,
) -> None:
    """How much load does the scene hold beside its weight? Along ±x, ±y, ±z, or as asked; and what gives out there.

    Exit status 0 where it holds its weight, 1 where squeeze or weight alone are too much, 2 bad input.
    """
    from handlcp import scene as scenes

    if plot is not None:
        checked(plot)
    loads, most = _loads(wrench, direction), None if motion is None else 1e-3 * motion
    file = scenes.load(scene)
    grasp, sides = file.build(), sides_of(file.solve_with.faces, faces)
    geometry = "fixed" if fixed else None
    found = [grasp.load_limit(load, geometry=geometry, faces=sides, motion=most) for load in loads]
    least = min(found, key=lambda limit: limit.factor * float(np.linalg.norm(limit.wrench)))
    if plot is not None:
        least.plot(plot, title=file.title)
    if json:
        every = [one.to_dict() | {"some_equilibrium": one.some_equilibrium, "bound": one.bound} for one in found]
        print_json({"title": file.title, "motion_m": most, "limits": every, "versions": versions("numpy")})
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
    """(3,) unit vector. Raises InputError."""
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
    from handlcp.show.limit.report import limit_table, size, way

    out = titled(title)
    if found[0].factor == 0.0:
        say(out, "NOT HELD", "bold red", found[0].why)
    else:
        out.print(limit_table(found, "Load beside the weight"))
        amount = size(least.wrench, least.factor)
        say(out, "Weakest", "bold", f"{way(least.wrench)}, held up to {amount}; there, {said(least.binds)}")
        for line in told(least.events, lambda factor: size(least.wrench, factor)):
            out.print(Text(f"  {line}"))
    print_files(out, pictures=(plot,))
