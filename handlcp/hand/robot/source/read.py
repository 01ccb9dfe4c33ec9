"""From a path, an XML string, or a Pinocchio model to a `Description`."""

from __future__ import annotations

from typing import Any

import pinocchio as pin

from handlcp.errors import InputError
from handlcp.hand.robot.joints import joint_facts, model_facts
from handlcp.hand.robot.source.description import COLLISION, VISUAL, Description, parts_of
from handlcp.hand.robot.source.units import check_units
from handlcp.hand.robot.source.xml import MJCF, URDF, robot_of
from handlcp.hand.robot.urdf import MOST_JOINTS, build_model, package_folders


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
