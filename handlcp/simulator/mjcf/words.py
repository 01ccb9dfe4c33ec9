"""Numbers and elements as MJCF writes them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pinocchio as pin

from handlcp.check import Array


def text(value: Any) -> str:
    """One number or several, to the last bit."""
    return " ".join(repr(float(x)) for x in np.ravel(value))


def add(parent: ET.Element, tag: str, **attributes: Any) -> ET.Element:
    """A new element below `parent`; strings are written as they are, numbers by `text`. A trailing _ of a name goes."""
    written = {k.rstrip("_"): v if isinstance(v, str) else text(v) for k, v in attributes.items()}
    return ET.SubElement(parent, tag, written)


def quaternion(rotation: Array) -> Array:
    """(4,) w, x, y, z, as MuJoCo orders it."""
    x, y, z, w = pin.Quaternion(np.array(rotation)).normalized().coeffs()
    return np.array([w, x, y, z])


def placed(rotation: Array, translation: Array) -> dict[str, Any]:
    """Attributes of an element that stands elsewhere than its parent."""
    return {"pos": translation, "quat": quaternion(rotation)}
