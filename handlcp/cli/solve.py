"""`handlcp solve`: effects, contacts, joint torques, verdict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from handlcp.cli.app import Json, app, print_json, say, sides_of, titled
from handlcp.errors import InputError, Unsupported
from handlcp.grasp import Grasp, GraspSolution, Verdict
from handlcp.grasp.verdict.check import STEPS
from handlcp.lcp import Auto
from handlcp.show import tables
from handlcp.show.file import checked
from handlcp.show.page.file import checked as checked_page
from handlcp.show.record import record

__all__ = ["solve"]

_COLOURS = {"HELD": "green", "UNDECIDED": "yellow"}  # the rest is red


@app.command()
def solve(
    scene: Annotated[Path, typer.Argument(help="A scene file (TOML); `handlcp keys` lists what it may hold.")],
    json: Json = False,
    plot: Annotated[Path | None, typer.Option(help="Draw the grasp into this file (png, svg, pdf).")] = None,
    page: Annotated[
        Path | None, typer.Option(help="Write a page to turn the grasp on, with its loading, into this HTML file.")
    ] = None,
    faces: Annotated[str | None, typer.Option(help="Faces of the friction pyramids, over the file's.")] = None,
    seed: Annotated[int | None, typer.Option(help="Of the solver, over the file's.")] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Measure each effect's share of the solve, beside its unknowns.")
    ] = False,
    suggest: Annotated[
        bool, typer.Option("--suggest", help="Which effects that are left out would change the answer by 5 % or more.")
    ] = False,
    accuracy: Annotated[
        float | None, typer.Option(help="Force error that will do, of the largest force; not with --faces.")
    ] = None,
) -> None:
    """Solve a scene: effects, contacts, joint torques, verdict. Exit status 0 HELD, 1 any other verdict, 2 bad input.

    The tables are of one solve, squeeze and load at once. The verdict follows the hand while it squeezes and is loaded.
    """
    from handlcp import scene as scenes

    if plot is not None:
        checked(plot)
    if page is not None:
        checked_page(page)
    file = scenes.load(scene)
    sides = _sides(file.solve_with.faces, faces, accuracy)
    solver = Auto(seed=file.solve_with.seed if seed is None else seed)
    grasp = file.build()
    explanation = grasp.explain(sides, measure=explain)
    solution = grasp.solve(sides, solver, throw=False, accuracy=accuracy)
    judged = grasp.check(faces=sides, solution=solution)
    if plot is not None:
        from handlcp.show.picture import save

        save(grasp, solution, plot, obj=file.shape(), title=file.title, verdict=judged)
    if page is not None:
        _write_page(page, file, grasp, solution, judged, sides)
    left_out = grasp.suggest(solution, sides) if suggest and solution.held else None
    if json:
        print_json(record(grasp, solution, explanation, file.title, left_out, judged))
    else:
        out = titled(file.title)
        out.print(tables.effect_table(explanation))
        if explain and explanation.seconds is None:
            out.print(Text("No shares of the time: they are measured at an answer, and there is none.", style="dim"))
        _print_numbers(out, grasp, solution, sides)
        _print_words(out, solution, judged)
        if left_out is not None:
            out.print(Text("Left out:", style="yellow"))
            out.print(Padding(Text(str(left_out)), (0, 0, 0, 2)))
        if plot is not None:
            out.print(Text(f"Picture: {plot}", style="dim"))
        if page is not None:
            out.print(Text(f"Page: {page}", style="dim"))
    short = solution.held and solution.accuracy is not None and not solution.accuracy.met
    raise typer.Exit(1 if short or not judged.ok else 0)


def _write_page(
    page: Path, file: Any, grasp: Grasp, solution: GraspSolution, judged: Verdict, sides: Any
) -> None:  # fmt: skip
    """With the loading that the verdict followed, where it could be followed."""
    from handlcp.show.page.document import save

    try:
        loading = grasp.follow(faces=sides, steps=STEPS)
    except Unsupported:
        loading = None
    save(grasp, solution, page, file.shape(), file.title, judged, loading)


def _sides(own: Any, faces: str | None, accuracy: float | None) -> Any:
    """Faces of the friction pyramids, or "cone". own : the scene file's. Raises InputError."""
    if accuracy is not None and faces is not None:
        raise InputError("--accuracy", "nothing where --faces is given: it chooses them", f"{accuracy:g}")
    return "cone" if accuracy is not None else sides_of(own, faces)


def _print_numbers(out: Console, grasp: Grasp, solution: GraspSolution, sides: Any) -> None:
    """Tables of contacts, joints and actuators; an empty line where there is no answer."""
    if not solution.held:
        return out.print()
    out.print(tables.contact_table(grasp, solution, sides))
    for part, table in (("torque_check", tables.torque_table), ("effort", tables.effort_table)):
        if (found := getattr(solution, part, None)) is not None:
            out.print(table(found))


def _print_words(out: Console, solution: GraspSolution, judged: Verdict) -> None:
    """Verdict, accuracy, warnings and advice."""
    (word, text), *rest = judged.paragraphs
    say(out, word, f"bold {_COLOURS.get(word, 'red')}", text)
    if (reached := solution.accuracy) is not None and solution.held:
        words = f"{reached}" if reached.met else f"{reached}: not shown to keep it"
        say(out, "Accuracy", "green" if reached.met else "bold red", words)
    for head, sentence in rest:
        say(out, head, "yellow" if head == "Warning" else "cyan", sentence)
