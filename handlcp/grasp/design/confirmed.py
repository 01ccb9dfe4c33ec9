"""Least friction and least preload: found by single solves, then judged as `check` does, by following the loading."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from handlcp.errors import Unsupported
from handlcp.grasp.analysis.required import Required, required_friction, required_preload, with_friction
from handlcp.grasp.design.followed import Changed, least_value, word
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec

_LITTLE = 1e-3  # of the largest value tried: where the search starts that single solves say needs nothing


def confirmed_friction(spec: GraspSpec, section: Section, tolerance: float) -> Required:
    """See `Grasp.required_friction`."""
    found = required_friction(spec, section, tolerance)
    return _confirmed(found, lambda mu: with_friction(spec, mu), section)


def confirmed_preload(spec: GraspSpec, section: Section, tolerance: float) -> Required:
    """See `Grasp.required_preload`."""
    found = required_preload(spec, section, tolerance)
    return _confirmed(found, spec.squeezed, section)


def _confirmed(found: Required, make: Callable[[float], GraspSpec], section: Section) -> Required:
    """The same with what `check` says of it. Where contacts move as the hand does, what `check` says counts: unless
    the grasp holds at the value, and not below, it is searched for anew from there, by following.
    """
    if found.value is None:
        return found
    changed = Changed(make, section)
    try:
        there = changed.path(found.value)
    except Unsupported:  # such as known forces
        return found
    agrees = there.held and (found.fails is None or not changed.holds(found.fails))
    if agrees or not there.steps.geometry.follows:
        return replace(found, verdict=word(make(found.value), section))
    start = found.value or _LITTLE * found.limit
    again = least_value(changed, start, found.limit, found.tolerance, found.unit)
    return replace(again, checked=(*found.checked, *again.checked))
