"""The paper's numbers as printed: magnitudes with their digits, and the misprints among them."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, TypeAdapter

from handlcp.check import Array
from handlcp.grasp import Contact, Coulomb, Frictionless, Grasp, PrescribedForce

NUMBERS = tuple(range(1, 11))
AXES = ("n", "o", "t")
COLUMN = {"n": 2, "o": 0, "t": 1}  # the paper's (n, o, t) are our (z, x, y)


@dataclass(frozen=True, slots=True)
class Number:
    """A printed magnitude: its text, such as "5.83270e0", its value, and one unit of its last digit."""

    text: str
    value: float
    ulp: float

    @staticmethod
    def parse(text: str) -> Number:
        """From the text of the data file."""
        mantissa, _, exponent = text.partition("e")
        decimals = len(mantissa.partition(".")[2])
        return Number(text, float(text), 10.0 ** (int(exponent or 0) - decimals))


Numbers = tuple[Annotated[Number, BeforeValidator(Number.parse)], ...]


@dataclass(frozen=True, slots=True)
class Reading:
    """A force that must be a misprint: finger (from 1), axis "n" | "o" | "t", both texts, and why."""

    finger: int
    axis: str
    printed: str
    read: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperTable:
    """One table. Entries are magnitudes; fingers count from 1.

    example, faces (None: planar), method : what the paper ran.
    golden : the columns that must be reproduced, of "force", "fingertip", "object".
    force : finger → (n, o, t) or (n,). slip : finger → (o, t). fingertip : finger → (n,). object : 6 or 3 numbers.
    readings : misprints. overwritten : (finger, axis) of force entries in whose place a slip is printed.
    """

    number: int
    example: int
    faces: int | None
    method: str
    golden: tuple[str, ...]
    force: dict[int, Numbers]
    slip: dict[int, Numbers] = field(default_factory=dict)
    fingertip: dict[int, Numbers] = field(default_factory=dict)
    object: Numbers
    readings: tuple[Reading, ...]
    overwritten: tuple[tuple[int, str], ...]

    @property
    def title(self) -> str:
        """The heading of the table."""
        faces = "planar" if self.faces is None else f"{self.faces} faces"
        return f"Table {self.number}: Example {self.example}, {faces}, {self.method} method"

    def forces(self, contacts: int, read: bool = True) -> Array:
        """(n, 3) magnitudes in our contact axes (x, y, z) = (o, t, n); NaN where nothing is printed.

        read : replace misprints by what they are read as.
        """
        out = np.full((contacts, 3), np.nan)
        for finger, numbers in self.force.items():
            for axis, number in zip(AXES, numbers, strict=False):
                out[finger - 1, COLUMN[axis]] = number.value
        for r in self.readings if read else ():
            out[r.finger - 1, COLUMN[r.axis]] = float(r.read)
        return out

    def slips(self, contacts: int) -> Array:
        """(n, 2) magnitudes along (x, y) = (o, t) [m]; NaN where nothing is printed."""
        out = np.full((contacts, 2), np.nan)
        for finger, numbers in self.slip.items():
            out[finger - 1] = [x.value for x in numbers]
        return out

    def overwritten_entries(self) -> list[tuple[int, int]]:
        """(contact from 0, our axis) of the overwritten entries."""
        return [(finger - 1, COLUMN[axis]) for finger, axis in self.overwritten]


@cache
def raw() -> dict[str, Any]:
    """The content of the data file."""
    text = resources.files(__package__).joinpath("data.json").read_text(encoding="utf-8")
    data: dict[str, Any] = json.loads(text)
    return data


def short(x: float) -> str:
    """A number in few characters, such as "1.5e-6" or "0.0494"."""
    return f"{x:.3g}".replace("e-0", "e-").replace("e+0", "e")


@cache
def table(number: int) -> PaperTable:
    """Table 1 to 10."""
    return TypeAdapter(PaperTable).validate_python({"number": number} | raw()["tables"][str(number)])


# ---------------------------------------------------------------- The paper's Examples 1 to 5 as grasps.
#
# The paper's contact frame (n, o, t) is our (z, x, y): `tangent` is its o axis. It writes G r = F_ext for the wrench
# that the fingers exert, so F_ext is minus our wrench and its object displacement minus our object's. Object
# displacements are about the world's origin, as in the paper: the tangential slips of its tables fit no other point.

# Squeeze of fingers 1 and 2 with which Example 4 has an elastic equilibrium [m]
PRELOAD = (5e-6, 5e-6, 0.0)


@dataclass(frozen=True, slots=True)
class Example:
    """A grasp of the paper: its number, title, what had to be inferred about it, and the grasp."""

    number: int
    title: str
    note: str
    grasp: Grasp


def example(number: int, *, tangential: float | None = None, preload: Any = 0.0) -> Example:
    """Example 1 to 5. tangential : E_T [m/N] in place of the paper's; preload : as in `Grasp` [m]."""
    e = raw()["examples"][str(number)]
    planar, smooth = number == 1, e.get("frictionless", [])
    contacts = []
    for i, (position, n) in enumerate(zip(e["positions"], e["normals"], strict=True), 1):
        friction = Frictionless() if planar or i in smooth else Coulomb(e["mu"])
        normal, tangent = np.array(n, dtype=float), None if planar else e["o_axes"][i - 1]
        contacts.append(Contact(position, normal / np.linalg.norm(normal), friction, tangent, f"finger {i}"))
    if planar:
        grasp = Grasp(contacts, [-float(x) for x in e["load"]], flexibility=e["flexibility"])
        return Example(number, e["title"], e["note"], grasp)
    wrench, effects = np.zeros(6), []
    if "weight" in e:
        wrench[2] = -e["weight"]
        wrench[3:] = np.cross(e["centre"], wrench[:3])
    if "known_force" in e:  # along the printed direction, whose components are rounded
        effects.append(PrescribedForce(0, (0.0, 0.0, e["known_force"] * float(np.linalg.norm(e["normals"][0])))))
    E_T = e["flexibility_tangential"] if tangential is None else tangential
    flexibility = (E_T, E_T, e["flexibility_normal"])
    grasp = Grasp(contacts, wrench, flexibility=flexibility, preload=preload, effects=effects)
    return Example(number, e["title"], e["note"], grasp)
