"""A brief: the loads that a grasp has to hold, each multiplied by a safety factor, and the grasp under each of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, array, number, per_name
from handlcp.errors import InputError
from handlcp.grasp.model.spec import GraspSpec
from handlcp.hand.asked.change import hand_remade
from handlcp.hand.asked.load import weight_of
from handlcp.hand.design.changed import hand_of, with_limits

_PARTS = ("load", "mass", "gravity")
_ONE = "the load"


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One load of a brief. name : what it is called. spec : the grasp under this load times the safety factor, weight
    of the object included, without torque limits.
    """

    name: str
    spec: GraspSpec


def cases(spec: GraspSpec, loads: Any, safety: Any) -> tuple[Case, ...]:
    """The loads of a brief, as `HandGrasp.required_torque` takes them. Raises InputError, UnknownName."""
    factor = number("safety", safety, above=0.0)
    bare = with_limits(spec, np.full(len(hand_of(spec).names), np.inf))
    return tuple([Case(name, _under(bare, said, factor)) for name, said in _named(spec, loads)])


def _named(spec: GraspSpec, loads: Any) -> list[tuple[str, dict[str, Any]]]:
    """(name, what it says of load, mass and gravity) of each load."""
    if loads is None:
        return [(_ONE, {})]
    if isinstance(loads, Mapping):
        if not loads:
            raise InputError("loads", "at least one load", "none")
        return [(str(name), _said(f"loads[{name!r}]", value, spec)) for name, value in loads.items()]
    shapes = ((6,), (-1, 6)) if spec.plane is None else ((6,), (-1, 6), (3,), (-1, 3))
    rows = np.atleast_2d(array("loads", loads, *shapes, what="loads (m, 6) or by name: finite numbers"))
    if not len(rows):
        raise InputError("loads", "at least one load", "none")
    return [(f"load {k}" if len(rows) > 1 else _ONE, {"load": row}) for k, row in enumerate(rows, 1)]


def _said(argument: str, value: Any, spec: GraspSpec) -> dict[str, Any]:
    if isinstance(value, Mapping):
        return per_name(argument, value, _PARTS, "a part of a load")
    shapes = ((6,),) if spec.plane is None else ((6,), (3,))
    return {"load": array(argument, value, *shapes)}


def _under(spec: GraspSpec, said: dict[str, Any], factor: float) -> GraspSpec:
    """The grasp under this load times the factor; what is not said stays as the grasp has it."""
    mechanism = hand_of(spec)
    target = mechanism.target
    own: Array = spec.wrench - weight_of(target, mechanism.gravity, spec.reference)
    given: dict[str, Any] = {"load": factor * np.asarray(said.get("load", own), dtype=float)}
    mass = said.get("mass", None if target is None else target.mass)
    if "mass" in said or mass:
        given["mass"] = factor * number("mass", mass, minimum=0.0)
    if "gravity" in said:
        given["gravity"] = said["gravity"]
    return hand_remade(spec, given)
