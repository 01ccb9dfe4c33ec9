"""Reading a scene file: TOML in, a checked `SceneFile` out, or one error that lists everything wrong with it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from handlcp.errors import InputError, SceneFileError, unreadable
from handlcp.grasp import Grasp, GraspSolution
from handlcp.hand import Object
from handlcp.lcp import Auto
from handlcp.scene.build import build, shape
from handlcp.scene.refusals import refused
from handlcp.scene.scene_tables import SceneTables

_DEEPEST = 32  # what a scene file needs is six: a matrix in a law in a table by finger
_NESTED = f"at most {_DEEPEST} arrays or tables in each other"


class SceneFile(SceneTables):
    """The tables of a scene file, and the grasp that they describe. Immutable."""

    def build(self) -> Grasp:
        """The grasp: a `HandGrasp` when there is a [hand], else a `Grasp`. Raises InputError, naming the key."""
        return build(self)

    def shape(self) -> Object | None:
        """The object, or None where the file has none."""
        return shape(self)

    def solve(self, throw: bool = True) -> GraspSolution:
        """Build and solve as the file says; see `Grasp.solve`."""
        return self.build().solve(self.solve_with.faces, Auto(seed=self.solve_with.seed), throw)


def load(path: Any) -> SceneFile:
    """Read a scene file. Raises SceneFileError for one that is missing, is no TOML, or does not describe a scene."""
    try:
        file = Path(path)
    except TypeError:
        raise InputError("path", "the path of a scene file", repr(path)) from None
    if path == "":
        raise SceneFileError("path", "the path of a scene file", "'', which is empty")
    if why := unreadable(file):
        raise SceneFileError("path", "the path of a scene file", f"{str(file)!r}, which {why}")
    try:
        text = file.read_bytes().decode("utf-8-sig")  # some editors write a mark before the text
    except (OSError, UnicodeDecodeError) as error:
        raise SceneFileError("path", "a scene file in UTF-8", f"{str(file)!r}: {error}") from None
    return read(text, file.parent, file.name)


def read(text: str, folder: Any = ".", label: str = "scene") -> SceneFile:
    """The same from a string; relative paths start at `folder`, errors start with `label`."""
    if not isinstance(text, str):
        raise InputError("text", "a string of TOML", type(text).__name__)
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneFileError(label, "TOML", str(error)) from None
    except ValueError:  # Python reads no longer integers
        raise SceneFileError(label, "integers of 64 bits", "one of more than 4300 digits") from None
    except RecursionError:
        raise SceneFileError(label, _NESTED, "more") from None
    _check(raw, label)
    try:
        scene = SceneFile.model_validate(raw)
    except ValidationError as error:
        raise refused(label, error) from None
    scene._folder = Path(folder)
    return scene


def _check(raw: Any, label: str) -> None:
    """Raises SceneFileError for what is nested too deeply to be read, and integers that TOML does not have."""
    level, depth = [raw], 0
    while level:
        if depth > _DEEPEST:
            raise SceneFileError(label, _NESTED, "more")
        if any(isinstance(value, int) and not -(2**63) <= value < 2**63 for value in level):
            raise SceneFileError(label, "integers of 64 bits", "a larger one")
        level, depth = [inner for value in level for inner in _within(value)], depth + 1


def _within(value: Any) -> Iterable[Any]:
    """What an array or a table holds."""
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
