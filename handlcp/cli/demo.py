"""`handlcp demo`: what the package answers, on a scene that it brings along."""

from __future__ import annotations

from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from handlcp.cli.app import app, say_files
from handlcp.cli.solve import solve
from handlcp.errors import writing
from handlcp.extras import pip_install
from handlcp.write_file import write_file

_SCENE = "cube_three_fingers.toml"  # of the examples at the top of the checkout
_MORE = {"matplotlib": "a picture", "trimesh": "a page to turn"}  # library: what it makes


@app.command()
def demo(
    folder: Annotated[
        Path, typer.Argument(help="Where scene, picture and page go; it is made where it is missing.")
    ] = Path("handlcp_demo"),
) -> None:
    """A cube in a hand of three fingers: verdict, picture, page, and the scene file to go on from. Takes seconds.

    A scene file that is there already is kept and run. Exit status as of `handlcp solve`.
    """
    scene = _written(folder / "cube.toml")
    there = {library: find_spec(library) is not None for library in _MORE}
    plot, page = scene.with_suffix(".png"), scene.with_suffix(".html")
    try:
        solve(scene, plot=plot if there["matplotlib"] else None, page=page if there["trimesh"] else None)
    except typer.Exit as done:
        out = Console(soft_wrap=True)
        say_files(out, Scene=[scene])
        for library in [library for library, found in there.items() if not found]:
            out.print(Text(f"For {_MORE[library]}, too: {pip_install(library)}"))
        out.print(Text(f"Next: open the page, change the scene, and see: handlcp solve {scene}"))
        raise typer.Exit(done.exit_code) from None


def _written(file: Path) -> Path:
    """The scene file, written unless it is there. Raises InputError where it cannot be."""
    if not file.exists():
        with writing("FOLDER", file):
            file.parent.mkdir(parents=True, exist_ok=True)
        write_file("FOLDER", file, _example().read_bytes())
    return file


def _example() -> Path:
    """The scene of an installed package, or of a checkout."""
    package = Path(str(resources.files("handlcp.cli"))).parent
    places = [package / "examples", package.parent / "examples"]
    return next(file for place in places if (file := place / _SCENE).is_file())
