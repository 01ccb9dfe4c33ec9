"""The XML of a robot: from a path or a string to its <robot> element, a URDF's own or that of an MJCF file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, URDFError
from handlcp.hand.robot.doubt import Doubt
from handlcp.hand.robot.source.mjcf import urdf_of_mjcf
from handlcp.hand.robot.urdf import check_robot

URDF, MJCF = "robot", "mujoco"  # tags of the first element
_MOST_BYTES = 5_000_000
_ADVICE = {URDF: "Hand.from_urdf", MJCF: "Hand.from_mjcf"}
_STRING = "the XML string"


def robot_of(
    argument: str, source: Any, base: str | None = None, kinds: tuple[str, ...] = (URDF, MJCF)
) -> tuple[ET.Element, Path | None, tuple[Doubt, ...]]:
    """The <robot> of a path, or of a string that starts with "<", below the link `base`; the path, None for a string;
    and what was read in a way worth knowing.

    kinds : formats that are welcome, by the tag of the first element. Raises URDFError for what is missing, unreadable,
    not XML, of another kind, or too large; UnknownName for the base; InputError.
    """
    text, path = _content(argument, source)
    shown = _STRING if path is None else repr(str(path))
    root = _parsed(argument, text, shown)
    if root.tag not in kinds:
        raise URDFError(argument, _wanted(kinds, root.tag, path), f"<{root.tag}> in {shown}")
    doubts: tuple[Doubt, ...] = ()
    if root.tag == MJCF:
        _shallow(argument, root, shown)
        root, doubts = urdf_of_mjcf(text.decode() if path is None else "", path)
    return check_robot(argument, root, base, shown), path, doubts


def _content(argument: str, source: Any) -> tuple[bytes, Path | None]:
    """Bytes, and the path that they are from."""
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        text = source.lstrip("\ufeff \t\r\n").encode(errors="replace")
        if len(text) > _MOST_BYTES:
            raise URDFError(argument, f"at most {_MOST_BYTES // 10**6} MB of XML", f"{len(text) / 1e6:.0f} MB")
        return text, None
    try:
        path = Path(source)
        there, known = path.is_file(), path.exists()
    except TypeError:
        expected = "the path of a URDF file, or its text; Hand.from_model takes a pinocchio.Model"
        raise InputError(argument, expected, repr(source)[:80]) from None
    except (OSError, ValueError) as error:  # a name that is too long, or holds a null byte
        raise URDFError(argument, "the path of a URDF file", f"{str(source)[:60]!r}: {error}"[:200]) from None
    shown = repr(str(path))
    if not there:
        raise URDFError(
            argument, "the path of a URDF file", f"{shown}, which {'is no file' if known else 'does not exist'}"
        )
    try:
        if (size := path.stat().st_size) > _MOST_BYTES:
            raise URDFError(argument, f"at most {_MOST_BYTES // 10**6} MB of XML", f"{shown} of {size / 1e6:.0f} MB")
        return path.read_bytes(), path
    except OSError as error:
        raise URDFError(argument, "a readable URDF file", f"{shown}: {error}") from None


def _parsed(argument: str, text: bytes, shown: str) -> ET.Element:
    try:
        return ET.fromstring(text)
    except ET.ParseError as error:
        raise URDFError(argument, "well-formed XML", f"{shown}: {error}") from None
    except (ValueError, LookupError) as error:
        raise URDFError(argument, "a readable URDF file", f"{shown}: {error}") from None


def _shallow(argument: str, root: ET.Element, shown: str) -> None:
    """Raises URDFError where elements are nested deeper than a library below can follow."""
    try:
        ET.tostring(root)
    except RecursionError:
        raise URDFError(argument, "an MJCF file", f"{shown}, whose elements are nested thousands deep") from None


def _wanted(kinds: tuple[str, ...], came: str, path: Path | None) -> str:
    """What was expected, and who reads what came."""
    names = " or ".join(f"<{kind}>" for kind in kinds)
    hint = f" ({_ADVICE[came]} reads <{came}>)" if came in _ADVICE else ""
    if path is not None and path.suffix == ".xacro":
        hint = " (expand a xacro file to a URDF first)"
    return f"a {names} element at the top{hint}"
