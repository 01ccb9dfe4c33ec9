"""The solution that a row of numbers stands for, its fields made when they are asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from handlcp.check import Array, read_only
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.uniqueness import describe
from handlcp.grasp.friction import Section
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.model.vectors import shifted
from handlcp.grasp.solve.compiled_answer import CompiledAnswer
from handlcp.grasp.verify.contact_laws import in_world
from handlcp.lcp import FIRST_STAGE, Status, stage_line


def lazy_solution(spec: GraspSpec, scene: Scene, section: Section, found: CompiledAnswer) -> GraspSolution:
    """SOLVED, from an answer that passes and leaves nothing free, of a scene without soft or anisotropic contacts."""
    kind: type[GraspSolution] = GraspSolution if spec.mechanism is None else spec.mechanism.solution
    return kind.deferred(
        _Fields(spec, scene, found), status=Status.SOLVED, certificate=None, extra={}, yielding={}, scene=scene,
        reference=spec.reference, spec=spec, section=section,
    )  # fmt: skip


def trace_of(found: CompiledAnswer) -> tuple[str, ...]:
    """The one line of the one stage."""
    return (stage_line(FIRST_STAGE, found.outcome, found.iterations, found.residuals.worst),)


class _Fields:
    """Makes fields of a solution by name."""

    __slots__ = ("found", "scene", "spec")

    def __init__(self, spec: GraspSpec, scene: Scene, found: CompiledAnswer) -> None:
        self.spec, self.scene, self.found = spec, scene, found

    def __call__(self, name: str) -> dict[str, Any]:
        made = _MADE.get(name)
        return self.joints(name) if made is None else {name: made(self)}

    @property
    def forces(self) -> Array:
        """(n, 3)."""
        return self.found.components.reshape(-1, 3)

    @property
    def arm(self) -> Array:
        """(3,) from the point that the answer's twist refers to to the grasp's reference [m]."""
        return self.spec.reference - self.found.centre

    def joints(self, name: str) -> dict[str, Any]:
        """What the mechanism adds; torques are asked for most, and often alone."""
        mechanism, effects = self.spec.mechanism, self.spec.effects
        assert mechanism is not None  # only its solutions have more fields
        if name == "torques" and not effects:
            return {name: mechanism.torques(self.scene, self.forces)}
        return mechanism.read(self.scene, effects, self.forces, None, {})


_MADE: dict[str, Callable[[_Fields], Any]] = {
    "names": lambda f: f.spec.names,
    "forces": lambda f: f.forces,
    "forces_world": lambda f: read_only(in_world(f.scene.frames, f.found.components)),
    "gap": lambda f: f.found.motion[2::3],
    "slip": lambda f: f.found.motion.reshape(-1, 3)[:, :2],
    "object_displacement": lambda f: read_only(shifted(f.found.twist, f.arm)),
    "contact_state": lambda f: f.found.states,
    "residuals": lambda f: f.found.residuals,
    "uniqueness": lambda f: describe(f.scene, (), f.arm),
    "iterations": lambda f: f.found.iterations,
    "trace": lambda f: trace_of(f.found),
}
