"""A contact whose force is known (measured, or commanded by force control): its wrench joins the load.

    w += G_i r_i,    ε += E_(·i) r_i

No unknowns, no unilateral law and no friction law at that contact; the other fingers still feel it through shared
joints.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from handlcp.check import Array, array, integer
from handlcp.errors import InputError
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.kind import Placement
from handlcp.grasp.model.limit import CONTACT_KEY, FileKey, Three, contact_number
from handlcp.grasp.model.scene import Scene
from handlcp.keywords import helped_init


@helped_init()
@dataclass(frozen=True, init=False, eq=False)
class PrescribedForce(Effect):
    """Contact number `contact` (from 0) pushes with `force` (3,) N in its contact axes (x, y, normal)."""

    contact: int
    force: Array

    title = "prescribed contact force"
    equation = "w += G_i r_i,  ε += E_(·i) r_i"
    when = "A finger under force control, or one whose force is measured."
    in_python = "effects=[PrescribedForce(0, (0, 0, 1.5))]"
    in_file = "effects.prescribed_force = [{ contact = 0, force_N = [0, 0, 1.5] }]"
    brings = "takes the contact's away"
    source = "Ai & Li (2025), Example 2"
    order = 240
    file_key = FileKey(
        "prescribed_force",
        (
            CONTACT_KEY,
            FileKey("force_N", Three, "three finite numbers", "contact axes: x and y, then the normal", required=True),
        ),
        "tables",
        "contacts whose force is known, one [[effects.prescribed_force]] each",
        many=True,
    )

    def __init__(self, contact: int, force: Any) -> None:
        object.__setattr__(self, "contact", integer("PrescribedForce.contact", contact, 0))
        object.__setattr__(self, "force", array("PrescribedForce.force", force, (3,)))

    @classmethod
    def from_file(cls, value: Any, key: str, fingers: tuple[str, ...]) -> Iterable[Effect]:
        for i, table in enumerate(value):
            yield cls(contact_number(f"{key}[{i}].contact", table["contact"], fingers), table["force_N"])

    @property
    def key(self) -> object:
        return type(self), self.contact

    def check(self, argument: str, at: Placement, others: tuple[Effect, ...]) -> None:
        """At a contact that there is, with a force in the plane of a planar scene."""
        if self.contact >= at.n:
            raise InputError(f"{argument}.contact", f"a contact's number from 0 to {at.n - 1}", self.contact)
        if at.planar and self.force[1] != 0.0:
            expected = "no force out of the plane (y) in a planar scene"
            raise InputError("PrescribedForce.force", expected, self.force.tolist())

    def why(self, scene: Scene) -> str:
        return f"asked for: contact {self.contact} pushes with {self.force.tolist()} N"

    def prescribed(self) -> dict[int, Array]:
        return {self.contact: self.force}

    def words(self, scene: Scene, names: tuple[str, ...], extra: dict[str, Array]) -> Iterable[str]:
        if self.force[2] < 0.0:
            yield f"{names[self.contact]} pulls, as prescribed"
