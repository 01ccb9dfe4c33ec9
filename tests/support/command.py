"""The command line, called as from a shell; and scene files for it."""

import json
import pathlib

import pytest
from typer.testing import CliRunner

from handlcp.cli import app

ROOT = pathlib.Path(__file__).parents[2]
CUBE = str(ROOT / "examples" / "cube_three_fingers.toml")


def run(*arguments, width="80", status=None):
    """What `handlcp` with these arguments gives, on a terminal of this width without colours. status : how it exits."""
    done = CliRunner().invoke(app, [str(a) for a in arguments], env={"COLUMNS": width, "NO_COLOR": "1"})
    assert status is None or done.exit_code == status, done.output
    return done


def strict(text):
    """JSON without NaN or Infinity."""
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))


def changed(folder, *changes):
    """The scene of the cube, written into a folder with these texts (old, new) replaced."""
    text = pathlib.Path(CUBE).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = folder / "scene.toml"
    file.write_text(text, encoding="utf-8")
    return file
