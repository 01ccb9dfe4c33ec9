"""Load limits with the geometry followed, as answers: of one load, and of many that share squeeze and weight."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.friction import Section
from handlcp.grasp.limits.binds import why_of
from handlcp.grasp.limits.followed.cause import events_of, way_to
from handlcp.grasp.limits.followed.limit import Ended, ended, ready
from handlcp.grasp.limits.result import EQUILIBRIUM, OBJECT, Bind, Later, LimitPath, LoadLimit
from handlcp.grasp.loading.state import State
from handlcp.grasp.loading.step import Stepper
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.solve.solve_spec import solve_spec

__all__ = ["followed_limit", "followed_limits"]

_NOTHING = (Bind(EQUILIBRIUM, OBJECT),)


def followed_limit(spec: GraspSpec, section: Section, wrench: Array, most: tuple[float, float]) -> LoadLimit:
    """Of a load (6,). most : motion [m] and turn [rad] of the object that are allowed. Raises Unsupported."""
    held = ready(spec, section)
    stepper = held.stepper
    if held.state is None:
        first = held.last
        later = Later(
            lambda: _path(stepper, [(0.0, first)]), lambda: _solution(stepper, section, first), lambda bound: 0.0
        )
        return LoadLimit(0.0, wrench, _NOTHING, held.why, (), "followed", later)
    end = ended(held, wrench, most)
    events = events_of(end.path, end.at)
    way = [(p.factor, p.state) for p in way_to(end.at)]
    later = Later(
        lambda: _path(stepper, way), lambda: _solution(stepper, section, end.at.state), lambda bound: end.most
    )
    why = why_of(end.factor, wrench, end.binds)
    return LoadLimit(end.factor, wrench, end.binds, why, events, "followed", later)


def followed_limits(spec: GraspSpec, section: Section, wrenches: Array, most: tuple[float, float]) -> list[Ended]:
    """Of loads (m, 6); other arguments as in `followed_limit`. Empty where squeeze or weight alone are not held."""
    held = ready(spec, section)
    return [] if held.state is None else [ended(held, wrench, most) for wrench in wrenches]


def _solution(stepper: Stepper, section: Section, state: State) -> GraspSolution:
    """A state as a certified solution of its own grasp, as `Loading.solution` has it."""
    made = stepper.grasp.made(state.look, state.loads)
    return solve_spec(made, section, start=state.start, proof=False)


def _path(stepper: Stepper, way: list[tuple[float, State]]) -> LimitPath:
    """Of (factor, state) of each point. The displacement counts from before the squeeze."""
    states, displacement = [s for _, s in way], stepper.geometry.displacement
    return LimitPath(
        read_only(np.array([factor for factor, _ in way])), read_only(np.array([s.read.forces for s in states])),
        read_only(np.array([s.read.torque for s in states])),
        read_only(np.array([displacement(s.where.pose) for s in states])),
    )  # fmt: skip
