"""A xacro file, URDF with macros, expanded to the URDF that it means, by the package xacrodoc, which needs no ROS."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from handlcp.errors import URDFError
from handlcp.extras import missing


def expanded(argument: str, path: Path, folders: Sequence[Path]) -> bytes:
    """The URDF, with the default of every argument of the file. folders : where $(find package) is looked up, besides
    the folders above the file.

    Raises Unsupported without xacrodoc; URDFError for a file that it refuses.
    """
    try:
        from xacrodoc import XacroDoc, packages
    except ImportError:
        raise missing("no xacro file is expanded without xacrodoc", "xacrodoc") from None
    packages.reset()  # it keeps the folders of former files
    if folders:
        packages.look_in([str(folder) for folder in folders])
    try:
        text = XacroDoc.from_file(str(path), resolve_packages=False).dom.toxml()
    except Exception as error:  # a file runs expressions, which raise what they like
        shown = f"{str(path)!r}: {' '.join(str(error).split()) or type(error).__name__}"
        raise URDFError(argument, "a xacro file that can be expanded", shown[:400]) from None
    return str(text).encode()
