"""A contact of whose force some components are known: a fingertip's reading, or a finger under force control.

    r_k = r̄_k  for the known k,    ε_k += κ_k, free: the finger moves until it reads that much

Written as two limits that meet, r_k ≤ r̄_k and -r_k ≤ -r̄_k, with κ = κ⁺ - κ⁻. The unknown components keep their laws:
the contact may slide, stick or let go, and what it is known to pull sideways has to be within its friction. Where all
three are known and friction is no matter, `PrescribedForce` brings no unknowns at all.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, integer, number, several
from handlcp.errors import InputError
from handlcp.grasp.model.effect import Effect
from handlcp.grasp.model.kind import Placement
from handlcp.grasp.model.limit import CONTACT_KEY, FileKey, Finite, From0, Limit, contact_number
from handlcp.grasp.model.scene import Scene
from handlcp.keywords import helped_init
from handlcp.words import NOTHING, length

_AXES = ("x", "y", "normal")
_ONE_KNOWN = "three numbers or None (x, y, normal), one known at least"


@helped_init()
@dataclass(frozen=True, init=False)
class KnownForce(Effect):
    """Contact number `contact` (from 0) pushes with these components of its force [N], contact axes; None: not known.

    force : three numbers or None (x, y, normal), at least one known; a known normal force is ≥ 0. A contact without
    friction has no tangential force to be known. Raises InputError.
    """

    contact: int
    force: tuple[float | None, float | None, float | None]

    title = "known force components"
    equation = "r_k = r̄_k,  ε_k += κ_k free"
    when = "A fingertip's sensor reads part of its force, such as the normal force alone."
    in_python = "effects=[KnownForce(0, (None, None, 2.0))]"
    in_file = "effects.known_force = [{ contact = 0, normal_N = 2.0 }]"
    brings = "2 a known component"
    source = "component by component what Ai & Li (2025), Example 2, know of whole forces"
    order = 250
    file_key = FileKey(
        "known_force",
        (
            CONTACT_KEY,
            FileKey("x_N", Finite, "a finite number", "along its tangent x"),
            FileKey("y_N", Finite, "a finite number", "along its tangent y"),
            FileKey("normal_N", From0, "a number ≥ 0", "along its normal"),
        ),
        "tables",
        "contacts of whose force some components are known, one [[effects.known_force]] each",
        many=True,
    )

    def __init__(self, contact: int, force: Any) -> None:
        object.__setattr__(self, "contact", integer("KnownForce.contact", contact, 0))
        given = several("KnownForce.force", force, _ONE_KNOWN)
        if len(given) != 3 or all(f is None for f in given):
            raise InputError("KnownForce.force", _ONE_KNOWN, repr(force))
        checked = [None if f is None else number(f"KnownForce.force[{k}]", f) for k, f in enumerate(given)]
        if checked[2] is not None and checked[2] < 0.0:
            raise InputError("KnownForce.force[2]", "a normal force ≥ 0: fingers push", checked[2])
        object.__setattr__(self, "force", tuple(checked))

    @classmethod
    def from_file(cls, value: Any, key: str, fingers: tuple[str, ...]) -> Iterable[Effect]:
        for i, table in enumerate(value):
            parts = tuple(table.get(name) for name in ("x_N", "y_N", "normal_N"))
            contact = contact_number(f"{key}[{i}].contact", table["contact"], fingers)
            if parts == (None, None, None):
                raise InputError(f"{key}[{i}]", _ONE_KNOWN, repr(parts))
            yield cls(contact, parts)

    @property
    def key(self) -> object:
        return type(self), self.contact

    @property
    def called(self) -> str:
        return f"known force of contact {self.contact}"

    def check(self, argument: str, at: Placement, others: tuple[Effect, ...]) -> None:
        """At a contact that there is, and whose force is not prescribed as a whole."""
        if self.contact >= at.n:
            raise InputError(f"{argument}.contact", f"a contact's number from 0 to {at.n - 1}", self.contact)
        if any(self.contact in e.prescribed() for e in others):
            raise InputError(f"{argument}.contact", "a contact whose force is not prescribed", self.contact)

    def why(self, scene: Scene) -> str:
        known = [f"{a} {f:g} N" for a, f in zip(_AXES, self.force, strict=True) if f is not None]
        return f"asked for: contact {self.contact} pushes with {', '.join(known)}"

    def limits(self, scene: Scene) -> tuple[Limit, ...]:
        """κ⁺ and κ⁻: how far the finger moves along each known component, away from the object and towards it."""
        unknown = set(scene.kind.index.tolist())
        known = [(3 * self.contact + k, f) for k, f in enumerate(self.force) if f is not None]
        bears = [(at, f) for at, f in known if at in unknown]
        if any(f for at, f in known if at not in unknown):
            expected = "no force along tangents without friction or out of the plane"
            raise InputError("KnownForce.force", expected, self.force)
        rows, room = np.zeros((len(bears), scene.components)), np.array([f for _, f in bears])
        rows[range(len(bears)), [at for at, _ in bears]] = 1.0
        rows, name = scene.physical(rows), f"κ{self.contact}"
        return (Limit(f"{name}⁺", rows, room), Limit(f"{name}⁻", -rows, -room))

    def words(self, scene: Scene, names: tuple[str, ...], extra: dict[str, Array]) -> Iterable[str]:
        moved = [extra[limit.name] for limit in self.present(scene)]
        if moved and (far := float(abs(moved[0] - moved[1]).max())) > NOTHING:
            yield f"{names[self.contact]} moves by {length(far)} to push as it is known to"
