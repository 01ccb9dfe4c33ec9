"""The paper's Examples 1 to 5 as grasps.

The paper's contact frame (n, o, t) is our (z, x, y): `tangent` is its o axis. It writes G r = F_ext for the wrench that
the fingers exert, so F_ext is minus our wrench and its object displacement minus our object's. Object displacements are
about the world's origin, as in the paper: the tangential slips of its tables fit no other point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.grasp import Contact, Coulomb, Frictionless, Grasp, PrescribedForce
from handlcp.study.paper.data import raw

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
