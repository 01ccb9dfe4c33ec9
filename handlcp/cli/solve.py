"""`handlcp solve` and `handlcp follow`: the verdict, contacts, joint torques; a scene loaded in steps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer
from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from handlcp.cli.app import (
    Faces,
    Json,
    Scene,
    app,
    check_files,
    load_scene,
    print_json,
    print_tables,
    say,
    say_files,
    sides_of,
    titled,
)
from handlcp.contact.friction import as_section
from handlcp.errors import InputError
from handlcp.grasp import Explanation, Grasp, GraspSolution, Loading, Suggestions, Verdict
from handlcp.grasp.verdict.check import make_suggestions
from handlcp.lcp import Auto
from handlcp.show import tables
from handlcp.show.doors import plot as draw_grasp
from handlcp.show.file import drawn
from handlcp.show.loading import report
from handlcp.show.loading.report import solution_tables
from handlcp.show.loading.series import solution_at_end
from handlcp.show.record import record

_NO_SHARES = "No shares of the time: they are measured at an answer, and there is none."
_COLOURS = {"HELD": "green", "UNDECIDED": "yellow"}  # the rest is red


@app.command()
def solve(
    scene: Scene,
    json: Json = False,
    plot: Annotated[Path | None, typer.Option(help="Draw the grasp into this file (png, svg, pdf).")] = None,
    page: Annotated[
        Path | None, typer.Option(help="Write a page to turn the grasp on, with its loading, into this HTML file.")
    ] = None,
    faces: Annotated[str | None, typer.Option(help="Faces of the friction pyramids, over the file's.")] = None,
    seed: Annotated[int | None, typer.Option(help="Of the solver, over the file's.")] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Which effects are on and off, why, and what each costs.")
    ] = False,
    suggest: Annotated[
        bool, typer.Option("--suggest", help="What is left out and would change the answer by 5 %, or make it hold.")
    ] = False,
    accuracy: Annotated[
        float | None, typer.Option(help="Force error that will do, of the largest force; not with --faces.")
    ] = None,
) -> None:
    """Does the scene hold? The verdict, contacts, joint torques. Exit status 0 HELD, 1 any other verdict, 2 bad input.

    The hand is followed while it squeezes and is loaded, and the tables are of the end. Where that is not reached, or
    with --accuracy, they are of one solve, squeeze and load at once.
    """
    check_files(plot, page=page)
    file = load_scene(scene)
    sides = _sides(file.solve_with.faces, faces, accuracy)
    solver = Auto(seed=file.solve_with.seed if seed is None else seed)
    grasp = file.build()
    explanation = grasp.explain(sides, measure=explain)
    solution = grasp.solve(sides, solver, throw=False, accuracy=accuracy)
    judged = grasp.check(faces=sides, solution=solution)
    shown = _shown(solution, judged)
    if plot is not None:
        draw_grasp(solution, plot, file.shape(), file.title, judged)
    if page is not None:
        from handlcp.show.page.document import save

        save(grasp, solution, page, file.shape(), file.title, judged)
    left_out = _suggested(grasp, solution, sides, judged) if suggest else None
    if json:
        print_json({"title": file.title} | record(grasp, solution, explanation, left_out, judged))
    else:
        out = titled(file.title)
        _print(out, solution, judged, shown, ("Advice",) if suggest else ())
        _print_more(out, left_out, explanation if explain else None)
        say_files(out, Picture=[plot], Page=[page])
    short = solution.held and solution.accuracy is not None and not solution.accuracy.met
    raise typer.Exit(1 if short or not judged.ok else 0)


def _sides(own: Any, faces: str | None, accuracy: float | None) -> Any:
    """Faces of the friction pyramids, or "cone". Raises InputError.

    own : the scene file's.
    """
    if accuracy is not None and faces is not None:
        raise InputError("--accuracy", "nothing where --faces is given: it chooses them", f"{accuracy:g}")
    return "cone" if accuracy is not None else sides_of(own, faces)


def _suggested(grasp: Grasp, solution: GraspSolution, sides: Any, judged: Verdict) -> Suggestions:
    """What `grasp.suggest` returns, without finding the verdict again."""
    return make_suggestions(grasp.spec, as_section(sides, planar=grasp.scene.kind.planar), solution, 0.05, judged)


class _Shown(NamedTuple):
    """The solution that the tables show.

    when : what their titles add.
    whole : whether slips are those of the whole loading.
    """

    solution: GraspSolution
    when: str = ""
    whole: bool = False


def _shown(solution: GraspSolution, judged: Verdict) -> _Shown:
    """The end of the loading that the verdict is about, where it is reached; else the one solve."""
    path = judged.loading
    if path is None:
        return _Shown(solution)
    if path.reached and solution.accuracy is None and (end := solution_at_end(path)).held:
        return _Shown(end, ", squeezed and loaded", True)
    return _Shown(solution, ", one solve: squeeze and load at once")


def _print(out: Console, solution: GraspSolution, judged: Verdict, shown: _Shown, without: Sequence[str]) -> None:
    """Verdict and accuracy, the tables, then warnings and advice but for those `without`, which are told later."""
    (word, text), *rest = judged.paragraphs
    say(out, word, f"bold {_COLOURS.get(word, 'red')}", text)
    if (reached := solution.accuracy) is not None and solution.held:
        words = f"{reached}" if reached.met else f"{reached}: not shown to keep it"
        say(out, "Accuracy", "green" if reached.met else "bold red", words)
    out.print()
    print_tables(out, solution_tables(shown.solution, shown.when, shown.whole))
    for head, sentence in rest:
        if head not in without:
            say(out, head, "yellow" if head == "Warning" else "cyan", sentence)


def _print_more(out: Console, left_out: Suggestions | None, explanation: Explanation | None) -> None:
    """What was asked for besides: suggestions, effects and what they cost."""
    if left_out is not None:
        out.print(Text("Suggestions:", style="yellow"))
        for line in left_out.lines:
            out.print(Padding(Text(line), (0, 0, 0, 2)))
    if explanation is not None:
        out.print(tables.effect_table(explanation))
        if explanation.seconds is None:
            out.print(Text(_NO_SHARES, style="dim"))


# ----------------------------------------------------------------
# `handlcp follow`: a scene loaded in steps, what happens on the way, and what it is like at the end.


@app.command()
def follow(
    scene: Scene,
    json: Json = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw forces, motion and torques over the load into this file (png, svg, pdf).")
    ] = None,
    picture: Annotated[Path | None, typer.Option(help="Draw the hand where it ends into this file.")] = None,
    page: Annotated[
        Path | None, typer.Option(help="Write a page to turn, with a slider through the steps, into this HTML file.")
    ] = None,
    order: Annotated[
        str, typer.Option(help="Stages, one after the other: squeeze, load; or together.")
    ] = "squeeze,load",
    fixed: Annotated[
        bool, typer.Option("--fixed", help="Keep this posture's contacts: small motions, as in `handlcp solve`.")
    ] = False,
    faces: Faces = None,
    steps: Annotated[int, typer.Option(help="Steps of a stage, more where something happens.")] = 40,
) -> None:
    """Load a scene in steps: the hand squeezes, then weight and load come. Exit status 0 HELD, 1 not, 2 bad input.

    The hand is followed as it moves, contacts are detected anew in every step.
    """
    check_files(plot, picture, page=page)
    read = load_scene(scene)
    sides = sides_of(read.solve_with.faces, faces)
    stages = tuple([name.strip() for name in order.split(",")])
    found = read.build().follow(order=stages, geometry="fixed" if fixed else None, faces=sides, steps=steps)
    if plot is not None:
        found.plot(plot, title=read.title)
    if picture is not None:
        from handlcp.show.loading.report import picture as at_end

        drawn(picture, at_end, found, read.title, read.shape())
    if page is not None:
        found.page(page, obj=read.shape(), title=read.title)
    if json:
        print_json({"title": read.title} | found.to_dict())
    else:
        _print_loading(found, read.title, [plot, picture], page)
    raise typer.Exit(0 if found.word == "HELD" else 1)


def _print_loading(found: Loading, title: str, files: list[Path | None], page: Path | None) -> None:
    """The outcome, the object's motion, what happens on the way, contacts and joints at the end."""
    out = titled(title)
    say(out, found.word, f"bold {_COLOURS.get(found.word, 'red')}", found.sentence)
    say(out, "Motion", "bold", report.motion(found))
    out.print()
    if (happens := report.event_table(found)) is not None:
        out.print(happens)
    print_tables(out, report.end_tables(found))
    say_files(out, Picture=files, Page=[page])
