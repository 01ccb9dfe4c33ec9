"""A xacro file, URDF with macros, expanded to the URDF that it means, by the package xacrodoc, which needs no ROS.

xacro keeps the file that it reads, and the folders of packages, in variables of its modules. They are set for each file
here, one file at a time: what was read before, and the working directory, make no difference.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Sequence
from pathlib import Path

from handlcp import words
from handlcp.errors import URDFError
from handlcp.extras import missing

_MACRO = re.compile(rb"<[\w.-]+:macro\s[^>]*?name\s*=\s*[\"']([^\"']+)[\"']")
_ELEMENTS = re.compile(rb"<(link|joint)[\s/>]")
_one_at_a_time = threading.Lock()


def expanded(argument: str, path: Path, text: bytes, folders: Sequence[Path]) -> bytes:
    """The URDF, with the default of every argument of the file. text : of the file. folders : where $(find package) is
    looked up, besides the folders above the file.

    Raises Unsupported without xacrodoc; URDFError for a file that it refuses, and for one of macros that calls none.
    """
    try:
        import xacrodoc.xacrodoc as library
        from xacrodoc import XacroDoc, packages
    except ImportError:
        raise missing("no xacro file is expanded without xacrodoc", "xacrodoc") from None
    file = path.resolve()
    with _one_at_a_time:
        packages.reset()  # it keeps the folders of former files
        if folders:
            packages.look_in([str(folder) for folder in folders])
        try:
            library.xacro.init_stacks(str(file))  # what is included is looked up beside the file that includes it
            urdf = str(XacroDoc.from_file(str(file), resolve_packages=False).dom.toxml()).encode()
        except Exception as error:  # a file runs expressions, which raise what they like
            shown = f"{str(path)!r}: {' '.join(str(error).split()) or type(error).__name__}"
            raise URDFError(argument, "a xacro file that can be expanded", shown[:400]) from None
        finally:
            library.xacro.init_stacks(None)
    if not _ELEMENTS.search(urdf) and (macros := [name.decode(errors="replace") for name in _MACRO.findall(text)]):
        came = f"{str(path)!r}, which defines macros ({words.listed(macros)}) and calls none: it makes no link"
        raise URDFError(argument, "a xacro file that makes a robot, such as the one that includes this one", came)
    return urdf
