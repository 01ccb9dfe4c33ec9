"""`PrescribedForce`: a contact whose whole force is prescribed; `KnownForce`: some components known;
`wrench_from_fingertip_forces`.

A prescribed force is measured, or commanded by force control: its wrench joins the load.

    w += G_i r_i,    ε += E_(·i) r_i

No unknowns, no unilateral law and no friction law at that contact; the other fingers still feel it through shared
joints.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import (
    Array,
    check_array,
    check_call,
    check_init_call,
    check_integer,
    check_number,
    check_sequence,
    read_only,
)
from handlcp.errors import InputError
from handlcp.grasp.model import validate
from handlcp.grasp.model.contact import Placement, cross_rows
from handlcp.grasp.model.effect import CONTACT_KEY, Effect, FileKey, Finite, From0, Limit, Three, contact_number
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.words import NEGLIGIBLE_LENGTH, format_length


@check_init_call()
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
        object.__setattr__(self, "contact", check_integer("PrescribedForce.contact", contact, 0))
        object.__setattr__(self, "force", check_array("PrescribedForce.force", force, (3,)))

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


# ----------------------------------------------------------------
# A contact of whose force some components are known: a fingertip's reading, or a finger under force control.
#
#     r_k = r̄_k  for the known k,    ε_k += κ_k, free: the finger moves until it reads that much
#
# Written as two limits that meet, r_k ≤ r̄_k and -r_k ≤ -r̄_k, with κ = κ⁺ - κ⁻. The unknown components keep their
# laws: the contact may slide, stick or let go, and what it is known to pull sideways has to be within its friction.
# Where all three are known and friction is no matter, `PrescribedForce` brings no unknowns at all.


_AXES = ("x", "y", "normal")
_ONE_KNOWN = "three numbers or None (x, y, normal), one known at least"


@check_init_call()
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
        object.__setattr__(self, "contact", check_integer("KnownForce.contact", contact, 0))
        given = check_sequence("KnownForce.force", force, _ONE_KNOWN)
        if len(given) != 3 or all(f is None for f in given):
            raise InputError("KnownForce.force", _ONE_KNOWN, repr(force))
        checked = [None if f is None else check_number(f"KnownForce.force[{k}]", f) for k, f in enumerate(given)]
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
        """How far the finger moves along each known component, away from the object and towards it: κ⁺ and κ⁻."""
        unknown = set(scene.kind.index.tolist())
        known = [(3 * self.contact + k, f) for k, f in enumerate(self.force) if f is not None]
        bears = [(at, f) for at, f in known if at in unknown]
        if any(f for at, f in known if at not in unknown):
            expected = "no force along tangents without friction or out of the plane"
            raise InputError("KnownForce.force", expected, self.force)
        rows, room = np.zeros((len(bears), scene.components)), np.array([f for _, f in bears])
        rows[range(len(bears)), [at for at, _ in bears]] = 1.0
        rows, name = scene.rows_to_law_axes(rows), f"κ{self.contact}"
        return (Limit(f"{name}⁺", rows, room), Limit(f"{name}⁻", -rows, -room))

    def words(self, scene: Scene, names: tuple[str, ...], extra: dict[str, Array]) -> Iterable[str]:
        moved = [extra[limit.name] for limit in self.present(scene)]
        if moved and (far := float(abs(moved[0] - moved[1]).max())) > NEGLIGIBLE_LENGTH:
            yield f"{names[self.contact]} moves by {format_length(far)} to push as it is known to"


# ----------------------------------------------------------------
# From readings of force and torque sensors in the fingertips to the load on the object.


_ROUNDING_SHARE = 1e-12  # of all that is added up


@check_call()
def wrench_from_fingertip_forces(
    grasp: Any, forces: Any, torques: Any = None, *, positions: Any = None, frames: Any = None
) -> Array:
    """(6,) the wrench [N, N·m] about the grasp's reference that the world applies to the object, its weight included.

    grasp : a `Grasp`. forces : (n, 3) N of each finger on the object, in contact axes unless `frames` says otherwise.
    torques : (n, 3) N·m likewise, None: not measured.
    positions, frames : where the readings are taken, (n, 3) [m] and (n, 3, 3) with the sensor's axes in columns, world
        axes; None: at the contact points, in contact axes.

    The object rests, so w = -Σ (R f; p × R f + R τ): the equilibrium w + G r = 0 (model; paper, equation (1)) read
    backwards. `grasp.replace(wrench=w)` is the grasp under that load, and `GraspStream.update(wrench=w)` follows it.
    An environment's contacts are among the n: without their forces the load on the object is not known. What is left
    of components that cancel but for rounding is 0.
    Raises InputError for wrong shapes and numbers not finite.
    """
    spec = getattr(grasp, "spec", None)
    if not isinstance(spec, GraspSpec):
        raise InputError("grasp", "a Grasp", repr(grasp)[:80])
    n = spec.n
    f = check_array("forces", forces, (n, 3))
    t = np.zeros((n, 3)) if torques is None else check_array("torques", torques, (n, 3))
    p = spec.positions if positions is None else check_array("positions", positions, (n, 3))
    R = spec.frames if frames is None else validate.frames(frames, n)
    arms = p - spec.reference
    push = (R @ f[:, :, None])[:, :, 0]
    turn = (R @ t[:, :, None])[:, :, 0]
    twist = turn + cross_rows(arms, push)
    load = -np.concatenate([push.sum(axis=0), twist.sum(axis=0)])
    force, moment = abs(push).sum(), abs(turn).sum() + (np.sqrt((arms**2).sum(axis=1)) * abs(push).sum(axis=1)).sum()
    return read_only(np.where(abs(load) > _ROUNDING_SHARE * np.repeat([force, moment], 3), load, 0.0))
