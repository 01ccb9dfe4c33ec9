"""A hand's description read: which kind of file it is, its units, and what it says."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.errors import InputError, URDFError
from handlcp.hand.robot.joint_limits import Doubt
from handlcp.hand.robot.joints import joint_facts, model_facts
from handlcp.hand.robot.source.description import COLLISION, VISUAL, Description, parts_of
from handlcp.hand.robot.source.mjcf import urdf_of_mjcf
from handlcp.hand.robot.urdf import MOST_JOINTS, build_model, check_robot, package_folders

# ----------------------------------------------------------------
# Numbers that look as if they were in other units than metres and kilograms.

_WIDEST, _HEAVIEST = 20.0, 2000.0  # [m, kg] no robot that carries a hand is larger


def check_units(argument: str, model: Any) -> None:
    """Raises URDFError for a robot that is wider than 20 m or heavier than 2 t, and says how to go on."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    places = np.array([place.translation for place in data.oMf])
    width = float(np.ptp(places, axis=0).max()) if np.isfinite(places).all() else 0.0
    if width > _WIDEST:
        expected = (
            "lengths in metres (are they in millimetres? then multiply each xyz, size, radius and length by 0.001)"
        )
        raise URDFError(argument, expected, f"a robot {width:.3g} m wide")
    mass = sum(float(inertia.mass) for inertia in model.inertias)
    if mass > _HEAVIEST:
        expected = "masses in kilograms (are they in grams? then multiply each mass and inertia by 0.001)"
        raise URDFError(argument, expected, f"a robot of {mass:.3g} kg")


# ----------------------------------------------------------------
# The XML of a robot: from a path or a string to its <robot> element, a URDF's own or that of an MJCF file.

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


# ----------------------------------------------------------------
# From a path, an XML string, or a Pinocchio model to a `Description`.


def describe_xml(
    argument: str, source: Any, base: str | None = None, package_dirs: Any = None, kinds: tuple[str, ...] = (URDF, MJCF)
) -> Description:
    """Of a URDF or MJCF file, or of such a text; arguments as of `robot_of` and `Hand.from_urdf`.

    Raises URDFError, UnknownName, InputError, and Unsupported for an MJCF file without MuJoCo.
    """
    root, path, doubts = robot_of(argument, source, base, kinds)
    folders = package_folders(package_dirs, path)
    name = str(path) if path is not None else "the XML string"
    model = build_model(argument, root, name)
    check_units(argument, model)
    short = path.name if path is not None else str(model.name)
    return Description(short, model, joint_facts(root), root, folders, (), doubts)


def describe_model(argument: str, source: Any) -> Description:
    """Of a pinocchio.Model, or a RobotWrapper, whose collision and visual geometry come with it.

    Raises InputError for what is none, is too large, or has mimic joints; URDFError for units that look wrong.
    """
    model = getattr(source, "model", source)
    if not isinstance(model, pin.Model):
        raise InputError(argument, "a pinocchio.Model or a pinocchio.RobotWrapper", repr(source)[:80])
    if model.nv > MOST_JOINTS:
        raise InputError(argument, f"a model of at most {MOST_JOINTS} degrees of freedom", f"{model.nv}")
    if mimic := [name for name, joint in zip(model.names, model.joints, strict=True) if "Mimic" in joint.shortname()]:
        expected = "a model built with mimic=False (Hand.from_urdf reads <mimic> tags itself)"
        raise InputError(argument, expected, f"mimic joints: {', '.join(mimic)}")
    model = pin.Model(model)
    check_units(argument, model)
    given = []
    for kind in (COLLISION, VISUAL):
        geometry = getattr(source, f"{kind}_model", None)
        if isinstance(geometry, pin.GeometryModel):
            given.append((kind, parts_of(model, geometry)))
    return Description(str(model.name), model, model_facts(model), given=tuple(given))
