"""`handlcp evaluate`: how well a hand does what a brief asks, and whether that is enough."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from handlcp.cli.app import Json, app, print_json
from handlcp.cli.given_hand import PackageDirs, given
from handlcp.errors import keyed
from handlcp.record import versions
from handlcp.text_table import wrapped


@app.command()
def evaluate(
    hand: Annotated[Path, typer.Argument(help="A URDF or MJCF file, a hand's name, or a scene file with a hand.")],
    brief: Annotated[Path, typer.Argument(help="A brief (TOML); `handlcp keys --brief` lists what it may hold.")],
    require: Annotated[
        list[str] | None,
        typer.Option(
            help='Such as "payload>=1.5"; payload, factor, force, torque, torque_used or motion, SI; may be repeated.'
        ),
    ] = None,
    joint_stiffness: Annotated[float | None, typer.Option(help="Of each joint, in N·m/rad.")] = None,
    pad_flexibility: Annotated[float | None, typer.Option(help="Of each pad, in m/N.")] = None,
    tip_radius: Annotated[float | None, typer.Option(help="Fingertips as balls, in m.")] = None,
    torque_limits: Annotated[float | None, typer.Option(help="Of each joint, in N·m, over the file's.")] = None,
    base: Annotated[str | None, typer.Option(help="Only the links below this one are the hand.")] = None,
    package_dir: PackageDirs = None,
    json: Json = False,
) -> None:
    """Find grasps of a brief's objects, and say what the hand holds, what gives out first, and what is not enough.

    Exit status 0 where every object is held and every requirement met, 1 otherwise, 2 bad input.
    """
    from handlcp.design.brief import Brief
    from handlcp.design.evaluate import evaluate as evaluated
    from handlcp.design.require import read, unmet

    with keyed({"requirement": "--require"}):
        asked = [read(text) for text in require or ()]
    the_hand = given(
        hand,
        base,
        package_dir,
        joint_stiffness=joint_stiffness,
        pad_flexibility=pad_flexibility,
        tip_radius=tip_radius,
        torque_limits=torque_limits,
    )
    found = evaluated(the_hand, Brief.from_toml(brief))
    sentences = unmet(asked, found.cases)
    if json:
        print_json(found.to_dict() | {"unmet": sentences, "versions": versions("numpy")})
    else:
        typer.echo(str(found))
        for sentence in sentences:
            typer.echo(f"\n{wrapped(f'{sentence}.')}")
    raise typer.Exit(0 if found.holds and not sentences else 1)
