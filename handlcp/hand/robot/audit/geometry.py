"""Doubts about the geometry of links: what is missing, and what that leaves unchecked. No mesh is loaded for them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any

from handlcp import words
from handlcp.errors import URDFError
from handlcp.hand.robot.doubt import Doubt
from handlcp.hand.robot.source.description import COLLISION, VISUAL, Description
from handlcp.hand.robot.urdf import resolve_meshes

_ADVICE = "a file with collision geometry, or tip_radius for the fingertips"


def geometry_doubts(described: Description) -> Iterator[Doubt]:
    """Of a robot's links."""
    solid, seen = described.has(COLLISION), described.has(VISUAL)
    if not solid:
        what = "no link has collision geometry: whether links are inside the object is not checked"
        yield Doubt("hand", what, _ADVICE, "serious", "geometry")
    elif bare := [name for name in seen if name not in solid]:
        what = "without collision geometry: not checked to be outside the object"
        yield Doubt(", ".join(bare), what, _ADVICE, "minor", "geometry")
    if described.root is None:
        return
    for kind, severity in ((COLLISION, "serious"), (VISUAL, "information")):
        if missing := _missing(described, kind):
            what = f"mesh files of {kind} geometry are not found: {words.listed(missing)}"
            yield Doubt("hand", what, "package_dirs with the folder that holds them", severity, "geometry")


def tip_doubts(hand: Any) -> Iterator[Doubt]:
    """Of the fingertips of a hand: what contacts are found on."""
    drawn = [name for i, name in enumerate(hand.fingertips) if hand.tip_kind(i) == VISUAL]
    if drawn:
        what = "nothing there collides, so contacts are found on what is drawn of it"
        yield Doubt(", ".join(drawn), what, "tip_radius, or a file with collision geometry", "minor", "geometry")
    bare = [name for i, name in enumerate(hand.fingertips) if hand.tip_kind(i) == ""]
    if bare:
        what = "its link has no geometry, so that no contact with an object can be found"
        yield Doubt(", ".join(bare), what, "tip_radius", "serious", "geometry")


def _missing(described: Description, kind: str) -> list[str]:
    """Addresses of meshes that are not found."""
    missing = []
    assert described.root is not None
    for mesh in described.root.iterfind(f"link/{kind}/geometry/mesh"):
        alone = ET.Element("link")
        alone.append(ET.Element("mesh", mesh.attrib))
        try:
            resolve_meshes(alone, described.folders)
        except URDFError:
            missing.append(mesh.get("filename", ""))
    return list(dict.fromkeys(missing))
