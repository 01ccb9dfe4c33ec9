"""The commands `motors` and `reliability`: which motors hold every load of a brief, and how sure a scene holds."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table
from rich.text import Text

from handlcp import words
from handlcp.actuation.motor import Motor
from handlcp.check import check_array, check_number
from handlcp.cli.app import (
    FacesOption,
    JsonOption,
    SceneArgument,
    app,
    check_output_files,
    choose_faces,
    load_scene,
    open_console,
    print_files,
    print_json,
    print_sentence,
    print_tables,
)
from handlcp.errors import InputError, shorten_text, translate_arguments
from handlcp.grasp.derivatives.parameter import parameters
from handlcp.hand import HandGrasp
from handlcp.hand.motor_requirement import RequiredTorque
from handlcp.record import to_plain
from handlcp.viz import terminal_table as tables
from handlcp.write_file import check_destination

_GRAVITY_DIRECTIONS = {
    "x up": (-1.0, 0.0, 0.0),
    "x down": (1.0, 0.0, 0.0),
    "y up": (0.0, -1.0, 0.0),
    "y down": (0.0, 1.0, 0.0),
    "z up": (0.0, 0.0, -1.0),
    "z down": (0.0, 0.0, 1.0),
}


@app.command()
def motors(
    scene: Annotated[Path, typer.Argument(help="A scene file (TOML) with a hand.")],
    json: JsonOption = False,
    safety: Annotated[float, typer.Option(help="Factor on every load and on the object's weight.")] = 1.5,
    load: Annotated[
        list[str] | None,
        typer.Option(help="A load beside the weight, as name=Fx,Fy,Fz or name=Fx,Fy,Fz,Mx,My,Mz [N, N·m]. Repeat it."),
    ] = None,
    turned: Annotated[
        bool, typer.Option("--turned", help="The file's load with gravity along each axis of the hand's base, too.")
    ] = False,
    motor: Annotated[
        str | None,
        typer.Option(
            help="A motor to buy, as CONTINUOUS,PEAK or CONTINUOUS,PEAK,FRICTION: its gear at each joint or tendon. "
            "Torques of the motor itself [N·m]; dry friction is that at the joint [N·m] or tendon [N]."
        ),
    ] = None,
    efficiency: Annotated[float, typer.Option(help="Of that gear, 0 to 1.")] = 1.0,
    most_force: Annotated[
        float | None, typer.Option(help="The largest normal force that the object bears at a contact, in N.")
    ] = None,
    faces: FacesOption = None,
) -> None:
    """Which motors? The torque of each joint and the grip of each finger with which every load times safety holds.

    Torques are those at the joint, pulls those of tendons: peak for a moment, continuous for good, and with --motor the
    gear that brings them there. Without --load and --turned: for the file's own load. The hand closes by a grip force
    at each fingertip, in place of what the file says. Exit status 0 such a grip was found and check() says HELD of
    every load, 1 otherwise, 2 bad input.
    """
    bought = None if motor is None else _parse_motor(motor, efficiency)
    read = load_scene(scene)
    grasp = read.build()
    if not isinstance(grasp, HandGrasp):
        raise InputError("scene", "a scene with a [hand], whose joints need motors", "one without")
    brief_ = _read_loads(grasp, load or [], turned)
    sides = choose_faces(read.solve_with.faces, faces)
    with translate_arguments({"most_force": "--most-force"}):
        found = grasp.required_torque(brief_, safety, sides, most_force=most_force)
    if json:
        gears = {} if bought is None else {"reductions": to_plain(found.reductions(bought))}
        if bought is not None and found.tensions is not None:
            gears["tendon_reductions"] = to_plain(found.tensions.reductions(bought))
        print_json({"title": read.title, **found.to_dict(), **gears})
    else:
        _print_motors(found, read.title, bought)
    raise typer.Exit(0 if found.confirmed else 1)


def _read_loads(grasp: HandGrasp, loads: list[str], turned: bool) -> dict[str, Any] | None:
    """The loads by name; None: the file's own. Raises InputError."""
    found = dict[str, Any]()
    for text in loads:
        name, equals, numbers = text.partition("=")
        values = _parse_numbers(numbers) if name and equals else None
        if values is None or len(values) not in (3, 6) or name in found:
            raise InputError("--load", "a new name=Fx,Fy,Fz or name=Fx,Fy,Fz,Mx,My,Mz", shorten_text(repr(text)))
        found[name] = np.append(check_array("--load", values), np.zeros(6 - len(values)))
    if turned:
        if (g := float(np.linalg.norm(grasp.given_gravity))) == 0.0:
            raise InputError("--turned", "a scene with gravity", "one without")
        found |= {name: {"gravity": g * np.array(way)} for name, way in _GRAVITY_DIRECTIONS.items()}
    return found or None


def _parse_numbers(text: str) -> list[float] | None:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        return None


def _parse_motor(text: str, efficiency: float) -> Motor:
    """The motor of the text CONTINUOUS, CONTINUOUS,PEAK or CONTINUOUS,PEAK,FRICTION. Raises InputError."""
    values = _parse_numbers(text)
    if values is None or len(values) not in (1, 2, 3):
        expected = "CONTINUOUS,PEAK or CONTINUOUS,PEAK,FRICTION in N·m, such as 0.02,0.06"
        raise InputError("--motor", expected, shorten_text(repr(text)))
    motor = Motor(values[0], values[:2][-1], efficiency=efficiency)
    friction = check_number("--motor: friction", values[2] if len(values) == 3 else 0.0, minimum=0.0)
    return replace(motor, friction=friction, reduction=1.0 + friction / motor.at_peak)  # a gear that overcomes it


def _print_motors(found: RequiredTorque, title: str, motor: Motor | None) -> None:
    out = open_console(title)
    word, style = ("FOUND", "green") if found.confirmed else ("NOT CONFIRMED", "yellow")
    if not found.holds:
        word, style = "NONE", "red"
    print_sentence(out, word, f"bold {style}", " ".join(found.sentence.split()).removesuffix("."))
    out.print()
    if found.holds:
        print_tables(out, _motor_tables(found, motor))


def _motor_tables(found: RequiredTorque, motor: Motor | None) -> Iterator[Table]:
    """Sizes of the motors, pulls of the tendons, gears for the motor to buy, and the grip to command."""
    when = "peak from first touch to full load, continuous under full load"
    heads = "joint", "peak", "continuous", "limit", "of limit", "sized by", ""
    note = f"N·m at the joint (N of prismatic joints): {when}"
    table = tables.make_table("Sizes of the motors", heads, "<>>>><<", note=note)
    for joint, peak, held, limit, share, load, remark in found.rows:
        table.add_row(Text(joint), peak, held, limit, share, Text(load), remark, style="red" if remark else None)
    yield table
    if found.tensions is not None:
        rows, note = found.tensions.table.rows, f"N at the tendon: {when}"
        yield tables.make_table("Pull of the tendons", ("tendon", "peak", "continuous", ""), "|>><", rows, note=note)
    if motor is not None:
        yield from _gear_tables(found, motor)
    grips = zip(found.grip, words.format_column(found.grip.values()), strict=True)
    yield tables.make_table("Grip force to command", ("fingertip", "grip [N]"), "<>", grips)


def _gear_tables(found: RequiredTorque, motor: Motor) -> Iterator[Table]:
    """Tables of the gears that joints without a tendon motor need, and that tendons need."""
    note = "the least with which the motor gives peak and continuous torque"
    least = found.reductions(motor)
    if (own := ~np.isnan(least)).any():
        joints = [joint for joint, its in zip(found.joints, own, strict=True) if its]
        rows = zip(joints, words.format_column(least[own]), strict=True)
        yield tables.make_table("Reduction that the motor needs", ("joint", "reduction"), "<>", rows, note=note)
    if found.tensions is not None:
        rows = zip(found.tensions.tendons, words.format_column(found.tensions.reductions(motor)), strict=True)
        note = "N of tension per N·m of the motor: gear over radius of the spool in m"
        yield tables.make_table("Reduction at each tendon", ("tendon", "reduction"), "<>", rows, note=note)


# ----------------------------------------------------------------
# `handlcp reliability`: how sure it is that a scene holds, when what it is made of varies.


def _add_spread_options(command: Any) -> Any:
    """The command with an option for each parameter that may vary, in place of its `**spread`."""
    own = inspect.signature(command, eval_str=True)
    scene, *others = [p.replace(kind=p.KEYWORD_ONLY) for p in own.parameters.values() if p.kind != p.VAR_KEYWORD]
    spread = []
    for p in parameters():
        if p.spread:
            option = Annotated[float | None, typer.Option(help=p.uncertain)]
            spread.append(inspect.Parameter(p.spread, scene.kind, default=None, annotation=option))
    command.__signature__ = own.replace(parameters=[scene, *spread, *others])
    command.__annotations__ = {p.name: p.annotation for p in command.__signature__.parameters.values()}
    return command


@app.command()
@_add_spread_options
def reliability(
    scene: SceneArgument,
    samples: Annotated[int, typer.Option(help="At least so many.")] = 10_000,
    seed: Annotated[int, typer.Option(help="Of the samples.")] = 0,
    check: Annotated[
        bool, typer.Option("--check", help="Follow each sample while it is squeezed, then loaded: 10 to 400 ms each.")
    ] = False,
    confidence: Annotated[float, typer.Option(help="Of the intervals.")] = 0.95,
    resume: Annotated[Path | None, typer.Option(help="Keep what is done in this .npz file, and go on there.")] = None,
    faces: FacesOption = None,
    plot: Annotated[Path | None, typer.Option(help="Draw margins and what matters most (png, svg, pdf).")] = None,
    json: JsonOption = False,
    **spread: float | None,
) -> None:
    """The chance that a scene holds, what its worst sample fails of, and which spread matters most.

    Exit status 0, 2 for bad input.
    """
    from handlcp.studies import reliability as study  # no other command pays for it

    varies = {name: value for name, value in spread.items() if value is not None}
    if not varies:
        raise InputError("--friction, --mass, …", "at least one of what varies", "none")
    check_output_files(plot)
    if resume is not None:
        check_destination("resume", resume)
    file = load_scene(scene)
    sides = choose_faces(file.solve_with.faces, faces)
    found = study.reliability(
        file.build(),
        varies,
        samples,
        seed=seed,
        faces=sides,
        by="check" if check else "solve",
        confidence=confidence,
        resume=resume,
    )
    if plot is not None:
        found.plot(plot, title=file.title)
    if json:
        print_json({"title": file.title} | found.to_dict())
        return
    out = open_console(file.title)
    out.print(Text(str(found)), soft_wrap=True)
    if plot is not None:
        out.print()
        print_files(out, Picture=[plot])
