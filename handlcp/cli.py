"""The command line: parse, call, print.

Exit status: 0 held; 1 not held, not decided, or over a torque limit; 2 bad input, with one message on stderr.
"""

from __future__ import annotations

import json as jsonlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text
from typer.core import TyperGroup

from handlcp.errors import HandLCPError, InputError
from handlcp.version import VERSION

__all__ = ["app", "main"]


class _Commands(TyperGroup):
    """Any HandLCPError becomes one message on stderr and exit status 2."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except HandLCPError as error:
            Console(stderr=True, soft_wrap=True).print(Text.assemble(("Error: ", "bold red"), str(error)))
            raise typer.Exit(2) from None


app = typer.Typer(
    cls=_Commands,
    name="handlcp",
    help="Does this hand hold this object under this load, with which grasp forces, what slips, which joint gives out?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

Json = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, nothing else.")]


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"handlcp {VERSION}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Grasp forces, slips and joint torques of robot hands."""


@app.command()
def solve(
    scene: Annotated[Path, typer.Argument(help="A scene file (TOML); `handlcp keys` lists what it may hold.")],
    json: Json = False,
    plot: Annotated[Path | None, typer.Option("--plot", help="Draw the grasp into this file (png, svg, pdf).")] = None,
    faces: Annotated[
        str | None, typer.Option("--faces", help="Faces of the friction pyramids, over the file's.")
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", help="Of the solver, over the file's.")] = None,
    accuracy: Annotated[
        float | None, typer.Option("--accuracy", help="Force error that will do, in place of faces: such as 1e-3.")
    ] = None,
) -> None:
    """Solve a scene: effects, contacts, joint torques, verdict. Exit status 0 held, 1 not held, 2 bad input.

    A joint over its torque limit is "not held". A solver that stopped without an answer is not "held" either.
    """
    from handlcp import scene as scenes
    from handlcp.lcp import Auto
    from handlcp.show import tables
    from handlcp.show.record import record
    from handlcp.show.verdict import verdict

    file = scenes.load(scene)
    sides: Any = "cone" if accuracy is not None else file.solve_with.faces
    if faces is not None:
        if accuracy is not None:
            raise InputError("--accuracy", "nothing where --faces is given: it chooses them", f"{accuracy:g}")
        sides = _faces(faces)
    solver = Auto(seed=file.solve_with.seed if seed is None else seed)
    grasp = file.build()
    explanation = grasp.explain(sides)
    solution = grasp.solve(None if accuracy is not None else sides, solver, throw=False, accuracy=accuracy)
    judged = verdict(grasp, solution)
    if plot is not None:
        from handlcp.show.picture import save

        save(grasp, solution, plot, obj=file.shape(), title=file.title)
    if json:
        _json(record(grasp, solution, explanation, file.title))
    else:
        out = Console()
        if file.title:
            out.print(Text(file.title, style="bold"), end="\n\n")
        out.print(tables.effect_table(explanation))
        if solution.held:
            out.print(tables.contact_table(grasp, solution, sides))
            if (check := getattr(solution, "torque_check", None)) is not None:
                out.print(tables.torque_table(check))
        else:
            out.print()
        out.print(Text.assemble((f"{judged.word}: ", f"bold {judged.colour}"), f"{judged.text}."))
        if (reached := solution.accuracy) is not None and solution.held:
            style = "green" if reached.met else "bold red"
            out.print(Text.assemble(("Accuracy: ", style), f"{reached}{'' if reached.met else ': not shown to keep it'}."))
        for note in judged.notes:
            out.print(Text.assemble(("Note: ", "yellow"), f"{note}."))
        if plot is not None:
            out.print(Text(f"Picture: {plot}", style="dim"))
    raise typer.Exit(judged.exit_code)


@app.command()
def audit(
    urdf: Annotated[Path, typer.Argument(help="A hand's URDF file.")],
    base: Annotated[str | None, typer.Option("--base", help="Audit only the links below this one.")] = None,
    json: Json = False,
) -> None:
    """List every doubt about the limits in a URDF, and what to pass instead. Exit status 0, 2 for bad input."""
    from handlcp.hand import audit_urdf

    found = audit_urdf(urdf, base)
    if json:
        doubts = [{"joint": d.joint, "what": d.what, "advice": d.advice} for d in found]
        _json({"source": found.source, "doubts": doubts})
    else:
        Console().print(found)


@app.command()
def paper(json: Json = False) -> None:
    """Recompute the paper's examples and compare them with what is printed there."""
    from handlcp.study.paper import paper_command

    raise typer.Exit(paper_command(json=json, console=Console()))


@app.command()
def accuracy(
    scene: Annotated[Path, typer.Argument(help="A scene file (TOML).")],
    json: Json = False,
    csv: Annotated[Path | None, typer.Option("--csv", help="Write every setting into this file, one a line.")] = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Draw error against time (png, svg, pdf).")] = None,
    seconds: Annotated[float, typer.Option("--seconds", help="What the study may take, compilation aside.")] = 60.0,
) -> None:
    """What accuracy costs in this scene: methods, faces, tolerances, effects left out, against the exact cone.

    Exit status 0, 1 if nothing holds the object exactly (there is nothing to compare with), 2 bad input.
    """
    from handlcp import scene as scenes
    from handlcp.errors import NoSolutionFound
    from handlcp.show import accuracy_table, work_precision
    from handlcp.study.accuracy import accuracy_cost

    file = scenes.load(scene)
    if plot is not None:
        work_precision.checked(plot)
    if csv is not None and not csv.absolute().parent.is_dir():
        raise InputError("csv", "a file in a folder that exists", repr(str(csv)))
    grasp = file.build()
    try:
        with _progress() as progress:
            cost = accuracy_cost(grasp, seconds=seconds, progress=progress)
    except NoSolutionFound as error:
        if json:
            _json({"title": file.title, "status": error.solution.status.name, "diagnosis": error.solution.diagnosis})
        else:
            Console(stderr=True).print(Text(f"Nothing to compare with: {error.solution.diagnosis}."))
        raise typer.Exit(1) from None
    if csv is not None:
        cost.to_csv(csv)
    if plot is not None:
        work_precision.save((file.title, cost), plot)
    if json:
        _json({"title": file.title} | cost.as_dict())
        return
    out = Console()
    if file.title:
        out.print(Text(file.title, style="bold"), end="\n\n")
    for table in accuracy_table.all_tables(cost):
        out.print(table)
    out.print(Text(f"{cost}."))
    for note in cost.notes:
        out.print(Text.assemble(("Note: ", "yellow"), f"{note}."))
    for path in (csv, plot):
        if path is not None:
            out.print(Text(f"Written: {path}", style="dim"))


@app.command()
def hands(json: Json = False) -> None:
    """List the hands to use by name, with their joints and fingertips."""
    from handlcp.hand import HANDS, example_hand
    from handlcp.show import tables

    rows, missing = [], []
    for name in HANDS:
        try:
            rows.append((name, example_hand(name)))
        except HandLCPError as error:
            missing.append((name, str(error)))
    if json:
        listed = [
            {"name": n, "joints": h.joint_names, "fingertips": h.fingertips, "torque_limits_Nm": h.torque_limits}
            for n, h in rows
        ]
        _json({"hands": listed, "missing": dict(missing)})
        return
    limits = [", ".join(f"{x:g}" for x in dict.fromkeys(h.torque_limits.tolist())) for _, h in rows]
    out = Console()
    out.print(tables.hand_table([(n, h.joint_names, h.fingertips, t) for (n, h), t in zip(rows, limits, strict=True)]))
    for name, why in missing:
        out.print(Text(f"{name}: {why}", style="yellow"))


@app.command()
def keys(json: Json = False) -> None:
    """List every key of a scene file, what it holds and what it means."""
    from dataclasses import asdict

    from handlcp import scene
    from handlcp.show import tables

    found = scene.keys()
    if json:
        _json({"keys": [asdict(k) for k in found]})
    else:
        Console().print(tables.key_table(found))


def main() -> None:
    """The entry point of the `handlcp` command."""
    if sys.stdout is not None and sys.stdout is sys.__stdout__:
        _keep_stdout()
    app()


def _keep_stdout() -> None:
    """What C code prints on stdout goes nowhere from here on (HiGHS prints a stray line at times); Python's still
    arrives.
    """
    ours, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = open(ours, "w", encoding=sys.stdout.encoding, errors=sys.stdout.errors)  # noqa: SIM115


@contextmanager
def _progress() -> Iterator[Callable[[int, int, str], None]]:
    """A bar on stderr, where that is a terminal, drawn between steps only: a thread that draws would disturb times."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = Console(stderr=True)
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
    with Progress(
        *columns, console=console, auto_refresh=False, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("", total=None)

        def show(done: int, total: int, text: str) -> None:
            bar.update(task, completed=done, total=total, description=text)
            bar.refresh()

        yield show


def _faces(text: str) -> Any:
    if text == "cone":
        return text
    if not text.isdecimal() or int(text) < 3:
        raise InputError("--faces", 'an integer ≥ 3 or "cone"', repr(text))
    return int(text)


def _json(value: dict[str, Any]) -> None:
    from handlcp.show.record import clean

    typer.echo(jsonlib.dumps(clean(value), indent=2, ensure_ascii=False, allow_nan=False))


if __name__ == "__main__":
    main()
