"""Commands of studies: what accuracy costs, a scene beside MuJoCo."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from handlcp.cli.app import (
    JsonOption,
    app,
    check_output_files,
    load_scene,
    open_console,
    print_files,
    print_json,
    print_sentence,
)
from handlcp.errors import NoSolutionFound
from handlcp.hand import HandGrasp
from handlcp.progress import track_steps
from handlcp.viz import terminal_table as tables
from handlcp.write_file import check_destination

# ----------------------------------------------------------------
# `handlcp accuracy`: what accuracy costs in a scene.


@app.command()
def accuracy(
    scene: Annotated[Path, typer.Argument(help="A scene file (TOML).")],
    json: JsonOption = False,
    csv: Annotated[Path | None, typer.Option(help="Write every setting into this file, one a line.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw error against time (png, svg, pdf).")] = None,
    seconds: Annotated[float, typer.Option(help="What the study may take, compilation aside.")] = 60.0,
) -> None:
    """What accuracy costs in this scene: methods, faces, tolerances, effects left out, against the exact cone.

    Exit status 0, 1 if nothing holds the object exactly (there is nothing to compare with), 2 bad input.
    """
    from handlcp import scene as scenes  # no other command pays for it
    from handlcp.studies.accuracy import accuracy_cost
    from handlcp.viz.accuracy import all_tables, save

    file = scenes.load(scene)
    check_output_files(plot)
    if csv is not None:
        check_destination("csv", csv)
    grasp = file.build()
    try:
        with track_steps() as progress:
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
        save((file.title, cost), plot)
    if json:
        print_json({"title": file.title} | cost.to_dict())
        return
    out = open_console(file.title)
    for table in all_tables(cost):
        out.print(table)
    out.print(Text(f"{cost.summary}."))
    for note in cost.notes:
        print_sentence(out, "Note", "yellow", note)
    print_files(out, Written=[csv, plot])


# ----------------------------------------------------------------
# `handlcp compare`: a scene followed by handlcp, and the same in MuJoCo.


@app.command()
def compare(
    scene: Annotated[Path, typer.Argument(help="A scene file (TOML) with a hand.")],
    json: JsonOption = False,
    together: Annotated[bool, typer.Option("--together", help="Squeeze, weight and load in proportion.")] = False,
    seconds: Annotated[float, typer.Option(help="Of each stage in MuJoCo; 8 where contacts slide far.")] = 2.0,
    steps: Annotated[int, typer.Option(help="Of each stage in handlcp.")] = 40,
) -> None:
    """Load a scene in steps, and in MuJoCo: squeeze, then weight and load. Needs MuJoCo: `pip install mujoco-core`.

    Exit status 0 where both hold the object, 1 where one of them does not, 2 bad input or nothing that MuJoCo can have.
    """
    from handlcp.simulator import compare as side_by_side  # no other command pays for it

    file = load_scene(scene)
    grasp = file.build()
    order: Any = "together" if together else ("squeeze", "load")
    found = side_by_side(grasp, None, order, steps=steps, seconds=seconds)
    if json:
        print_json({"title": file.title} | found.to_dict())
    else:
        assert isinstance(grasp, HandGrasp)  # MuJoCo had it
        _print_comparison(open_console(file.title), grasp, found)
    raise typer.Exit(0 if found.both_hold else 1)


def _print_comparison(out: Console, grasp: HandGrasp, found: Any) -> None:
    if found.both_hold:
        for table in _comparison_tables(grasp, found):
            out.print(table)
        print_sentence(out, "Difference", "bold", found.difference)
    for name, one in (("handlcp", found.loading), ("MuJoCo", found.simulation)):
        print_sentence(out, f"{name}: {one.word}", f"bold {'green' if one.held else 'red'}", one.sentence)
    agree, colour = ("They agree", "green") if found.agree else ("They do not agree", "red")
    print_sentence(out, agree, f"bold {colour}", f"tolerance: {found.tolerance}")
    ours, theirs = found.seconds, found.simulation.seconds
    print_sentence(out, "Time", "bold", f"handlcp {ours:.3g} s, MuJoCo {theirs:.3g} s, {theirs / ours:.0f} ×")


def _comparison_tables(grasp: HandGrasp, found: Any) -> list[Table]:
    """Forces, torques and motions at the end, both and their difference."""
    ours, theirs = found.loading, found.simulation
    forces = [
        (name, _format_vector(a), _format_vector(b), f"{np.linalg.norm(a - b):.4f}")
        for name, a, b in zip(theirs.names, ours.solution.forces_world, theirs.forces_world, strict=True)
    ]
    torques = [
        (name, f"{x:.4f}", f"{y:.4f}", f"{abs(x - y):.5f}")
        for name, x, y in zip(grasp.state.hand.joint_names, ours.solution.torques, theirs.torques, strict=True)
    ]
    motion = []
    for what, part in (("mm", slice(0, 3)), ("mrad", slice(3, 6))):
        a, b = 1e3 * ours.displacement[part], 1e3 * theirs.displacement[part]
        motion.append((what, _format_vector(a), _format_vector(b), f"{np.linalg.norm(a - b):.4f}"))
    both = "handlcp", "MuJoCo", "apart"
    return [
        tables.make_table("Forces", ("contact", *both), "|>>>", forces, "N, on the object, world axes"),
        tables.make_table("Torques", ("joint", *both), "<>>>", torques, "N·m (N of prismatic joints)"),
        tables.make_table("Motion of the object", ("", *both), "<>>>", motion, "since the start, world axes"),
    ]


def _format_vector(values: Any) -> str:
    return " ".join(f"{x:6.3f}" if abs(x) < 99.0 else f"{x:6.1f}" for x in values)
