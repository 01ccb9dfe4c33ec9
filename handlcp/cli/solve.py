"""`handlcp solve`, `follow` and `demo`: the verdict, contacts, joint torques; a scene loaded in steps; an example."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.padding import Padding
from rich.text import Text

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
from handlcp.contact.friction import as_section
from handlcp.errors import InputError, pip_command, refuse_unwritable
from handlcp.grasp import GraspSolution, Loading, Verdict
from handlcp.grasp.verdict.check import make_suggestions
from handlcp.lcp import Auto
from handlcp.viz import terminal_table as tables
from handlcp.viz.loading import figure as report
from handlcp.viz.loading.curves import solution_at_end
from handlcp.viz.loading.figure import plot_solution, solution_tables
from handlcp.viz.output_file import draw_or_save
from handlcp.viz.solution_output import solution_record
from handlcp.write_file import write_file

_NO_SHARES_NOTE = "No shares of the time: they are measured at an answer, and there is none."
_WORD_COLOURS = {"HELD": "green", "UNDECIDED": "yellow"}  # the rest is red


@app.command()
def solve(
    scene: SceneArgument,
    json: JsonOption = False,
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
    check_output_files(plot, page=page)
    file = load_scene(scene)
    if accuracy is not None and faces is not None:
        raise InputError("--accuracy", "nothing where --faces is given: it chooses them", f"{accuracy:g}")
    sides = "cone" if accuracy is not None else choose_faces(file.solve_with.faces, faces)
    solver = Auto(seed=file.solve_with.seed if seed is None else seed)
    grasp = file.build()
    explanation = grasp.explain(sides, measure=explain)
    solution = grasp.solve(sides, solver, throw=False, accuracy=accuracy)
    judged = grasp.check(faces=sides, solution=solution)
    if plot is not None:
        plot_solution(solution, plot, file.shape(), file.title, judged)
    if page is not None:
        from handlcp.viz.page.document import write_grasp_page  # pages are paid for by those who ask for one

        write_grasp_page(grasp, solution, page, file.shape(), file.title, judged)
    left_out = None
    if suggest:  # what `grasp.suggest` returns, without finding the verdict again
        section = as_section(sides, planar=grasp.scene.kind.planar)
        left_out = make_suggestions(grasp.spec, section, solution, 0.05, judged)
    if json:
        print_json({"title": file.title} | solution_record(grasp, solution, explanation, left_out, judged))
    else:
        out = open_console(file.title)
        _print_solution(out, solution, judged, ("Advice",) if suggest else ())
        if left_out is not None:
            out.print(Text("Suggestions:", style="yellow"))
            for line in left_out.lines:
                out.print(Padding(Text(line), (0, 0, 0, 2)))
        if explain:
            out.print(tables.effect_table(explanation))
            if explanation.seconds is None:
                out.print(Text(_NO_SHARES_NOTE, style="dim"))
        print_files(out, Picture=[plot], Page=[page])
    short = solution.held and solution.accuracy is not None and not solution.accuracy.met
    raise typer.Exit(1 if short or not judged.ok else 0)


def _print_solution(out: Console, solution: GraspSolution, judged: Verdict, without: Sequence[str]) -> None:
    """Verdict and accuracy, the tables, then warnings and advice but for those `without`, which are told later.

    Tables are of the end of the loading that the verdict is about, where it is reached; else of the one solve.
    """
    path = judged.loading
    tabled, title_end, whole = solution, "" if path is None else ", one solve: squeeze and load at once", False
    if path is not None and path.reached and solution.accuracy is None and (end := solution_at_end(path)).held:
        tabled, title_end, whole = end, ", squeezed and loaded", True
    (word, text), *rest = judged.paragraphs
    print_sentence(out, word, f"bold {_WORD_COLOURS.get(word, 'red')}", text)
    if (reached := solution.accuracy) is not None and solution.held:
        words = f"{reached}" if reached.met else f"{reached}: not shown to keep it"
        print_sentence(out, "Accuracy", "green" if reached.met else "bold red", words)
    out.print()
    print_tables(out, solution_tables(tabled, title_end, whole))
    for head, sentence in rest:
        if head not in without:
            print_sentence(out, head, "yellow" if head == "Warning" else "cyan", sentence)


# ----------------------------------------------------------------
# `handlcp follow`: a scene loaded in steps, what happens on the way, and what it is like at the end.


@app.command()
def follow(
    scene: SceneArgument,
    json: JsonOption = False,
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
    faces: FacesOption = None,
    steps: Annotated[int, typer.Option(help="Steps of a stage, more where something happens.")] = 40,
) -> None:
    """Load a scene in steps: the hand squeezes, then weight and load come. Exit status 0 HELD, 1 not, 2 bad input.

    The hand is followed as it moves, contacts are detected anew in every step.
    """
    check_output_files(plot, picture, page=page)
    read = load_scene(scene)
    sides = choose_faces(read.solve_with.faces, faces)
    stages = tuple([name.strip() for name in order.split(",")])
    found = read.build().follow(order=stages, geometry="fixed" if fixed else None, faces=sides, steps=steps)
    if plot is not None:
        found.plot(plot, title=read.title)
    if picture is not None:
        draw_or_save(picture, report.draw_end_picture, found, read.title, read.shape())
    if page is not None:
        found.page(page, obj=read.shape(), title=read.title)
    if json:
        print_json({"title": read.title} | found.to_dict())
    else:
        _print_loading(found, read.title, [plot, picture], page)
    raise typer.Exit(0 if found.word == "HELD" else 1)


def _print_loading(found: Loading, title: str, files: list[Path | None], page: Path | None) -> None:
    """The outcome, the object's motion, what happens on the way, contacts and joints at the end."""
    out = open_console(title)
    print_sentence(out, found.word, f"bold {_WORD_COLOURS.get(found.word, 'red')}", found.sentence)
    print_sentence(out, "Motion", "bold", report.describe_object_motion(found))
    out.print()
    if (happens := report.event_table(found)) is not None:
        out.print(happens)
    print_tables(out, report.end_tables(found))
    print_files(out, Picture=files, Page=[page])


# ----------------------------------------------------------------
# `handlcp demo`: what the package answers, on a scene that it brings along.


_EXAMPLE_FILE = "cube_three_fingers.toml"  # of the examples at the top of the checkout
_OPTIONAL_OUTPUTS = {"matplotlib": "a picture", "trimesh": "a page to turn"}  # library: what it makes


@app.command()
def demo(
    folder: Annotated[
        Path, typer.Argument(help="Where scene, picture and page go; it is made where it is missing.")
    ] = Path("handlcp_demo"),
) -> None:
    """A cube in a hand of three fingers: verdict, picture, page, and the scene file to go on from. Takes seconds.

    A scene file that is there already is kept and run. Exit status as of `handlcp solve`.
    """
    scene = folder / "cube.toml"
    if not scene.exists():
        with refuse_unwritable("FOLDER", scene):
            folder.mkdir(parents=True, exist_ok=True)
        package = Path(str(resources.files("handlcp.cli"))).parent  # an installed package, or that of a checkout
        places = package / "examples" / _EXAMPLE_FILE, package.parent / "examples" / _EXAMPLE_FILE
        write_file("FOLDER", scene, next(file for file in places if file.is_file()).read_bytes())
    there = {library: find_spec(library) is not None for library in _OPTIONAL_OUTPUTS}
    plot, page = scene.with_suffix(".png"), scene.with_suffix(".html")
    try:
        solve(scene, plot=plot if there["matplotlib"] else None, page=page if there["trimesh"] else None)
    except typer.Exit as done:
        out = Console(soft_wrap=True)
        print_files(out, Scene=[scene])
        for library in [library for library, found in there.items() if not found]:
            out.print(Text(f"For {_OPTIONAL_OUTPUTS[library]}, too: {pip_command(library)}"))
        out.print(Text(f"Next: open the page, change the scene, and see: handlcp solve {scene}"))
        raise typer.Exit(done.exit_code) from None
