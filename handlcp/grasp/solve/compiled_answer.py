"""`CompiledAnswer`: scenes as rows of numbers for `compiled_solve`, and what their answers say."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.errors import InputError
from handlcp.grasp.assembly.problem import SolverCandidate, polyhedron_normals, problem_design
from handlcp.grasp.model.contact import SceneKind
from handlcp.grasp.model.flexibility import flexibility_matrix, stored_flexibility
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solve.compiled_solve import (
    END_OF_RESIDUALS,
    FIRST_RESIDUAL,
    HEADER_SIZE,
    KACZMARZ_STEPS,
    MAYBE_FREE,
    NONE_HOLDS,
    OUTCOME,
    UNIQUE,
    ScenePattern,
    row_width,
    solve_scenes,
    write_row,
)
from handlcp.grasp.solve.factored_solve import FactoredRow, solve_factored
from handlcp.grasp.verify.certifier import LawResiduals, Residuals
from handlcp.lcp import Proposal
from handlcp.lcp.solver import describe_outcome
from handlcp.tolerances import SOLVE_TOLERANCE

_NO_MATRIX = read_only(np.empty((0, 0)))
NO_START = read_only(np.empty(0))  # the start of a solve that begins where every contact sticks


class CompiledKind:
    """Scenes that differ in numbers alone: their effects and layout, the same for compiled code, widths of rows."""

    __slots__ = ("answer_width", "design", "pattern", "scene_kind", "scene_width")

    def __init__(self, scene: Scene, section: Section) -> None:
        kind, self.design = scene.kind, problem_design(scene, section, ())
        where, roles = self.design.layout, self.design.pattern
        self.scene_kind: SceneKind = kind
        self.scene_width = row_width(scene)
        self.answer_width = HEADER_SIZE + 2 * kind.components + 9 + kind.n + where.size
        self.pattern = ScenePattern(
            kind.contact_components,
            kind.index,
            roles.role,
            roles.order,
            roles.blocks,
            section.faces,
            polyhedron_normals(scene, section),
            kind.flexible,
            kind.dof,
            (*where.forces, where.at["u"].start, where.size),
            len(kind.soft),
        )


_KINDS: dict[tuple[Section, SceneKind], CompiledKind] = {}
_MAX_KINDS = 1024


def get_compiled_kind(scene: Scene, section: Section) -> CompiledKind:
    """The kind of a scene whose effects follow from its data, with these cones; few are met again and again."""
    key = (section, scene.kind)
    if (known := _KINDS.get(key)) is None:
        if len(_KINDS) >= _MAX_KINDS:
            _KINDS.clear()
        known = _KINDS[key] = CompiledKind(scene, section)
    return known


def solve_scene(scene: Scene, section: Section, seed: int, start: Array = NO_START) -> CompiledAnswer:
    """The first stage's answer, certified or not; start : made by `start_values`."""
    kind = get_compiled_kind(scene, section)
    if scene.kind.has_many_contacts and (E := scene.factor) is not None:
        row, given = np.empty(kind.answer_width), stored_flexibility(scene)
        loads = (scene.offset, scene.force, scene.moment, scene.freedom)
        parts = (scene.positions, scene.frames, *loads, *E.factor, scene.friction_coefficients(section))
        numbers, (joints, columns) = read_only(np.concatenate(parts, axis=None)), E.factor.root.shape
        matrix = _NO_MATRIX if given is E else flexibility_matrix(given)
        if solve_factored(FactoredRow(numbers, joints, columns, matrix), kind.pattern, start, row):
            return CompiledAnswer(kind, row)
    numbers, rows = np.empty((1, kind.scene_width)), np.empty((1, kind.answer_width))
    write_row(scene, section, numbers[0])
    solve_scenes(read_only(numbers), kind.pattern, start, seed, rows)
    return CompiledAnswer(kind, rows[0])


def start_values(value: Any, scene: Scene) -> Array:
    """(c + 9,) where to start, from a `GraspSolution` (or a stream's update) of as many contacts: forces in the laws'
    coordinates [N], twist (6,) and the point (3,) that it refers to. Empty for None, or one without an answer.
    """
    if value is None:
        return NO_START
    n = scene.n
    if not all(hasattr(value, part) for part in ("held", "forces", "object_displacement", "reference")):
        raise InputError("start", f"a GraspSolution of {n} contacts, or None", repr(value)[:80])
    if len(value.forces) != n:
        raise InputError("start", f"a GraspSolution of {n} contacts", f"one of {len(value.forces)}")
    if not value.held or value.reference is None:
        return NO_START
    torsion = getattr(value, "torsion", None)
    moments = np.zeros(len(scene.soft)) if torsion is None else torsion[list(scene.soft)]
    forces = scene.forces_to_law_axes(np.concatenate([value.forces.reshape(-1), moments]))
    return read_only(np.concatenate([forces, value.object_displacement, value.reference]))


class CompiledAnswer:
    """An answer's row, read: SI, in the coordinates of the scene's friction laws, read-only."""

    __slots__ = ("kind", "row")

    def __init__(self, kind: CompiledKind, row: Array) -> None:
        row.flags.writeable = False
        self.kind, self.row = kind, row

    @property
    def passes(self) -> bool:
        """Whether the certifier calls it an answer, as `Residuals.passes` says; no effect has a law of its own here."""
        return self.row.item(OUTCOME) >= MAYBE_FREE

    @property
    def is_unique(self) -> bool:
        """Whether it is an answer that leaves nothing free."""
        return self.row.item(OUTCOME) == UNIQUE

    @property
    def escape(self) -> Array | None:
        """(dof,) where it is proven that nothing holds the object: the motion in which it escapes, natural units."""
        at = HEADER_SIZE + self.kind.scene_kind.components
        return self.row[at : at + self.kind.scene_kind.dof] if self.row.item(OUTCOME) == NONE_HOLDS else None

    @property
    def residuals(self) -> Residuals:
        """How far it misses each law."""
        laws = LawResiduals(*self.row[FIRST_RESIDUAL:END_OF_RESIDUALS].tolist())
        return Residuals.from_law_residuals(laws, 0.0 * laws.force_size)  # NaN where it is no number

    @property
    def outcome(self) -> str:
        """The solver's own words."""
        steps, newton, residual = self.row[:FIRST_RESIDUAL].tolist()
        return describe_outcome(residual <= SOLVE_TOLERANCE, int(steps), int(newton))

    @property
    def iterations(self) -> int:
        """The number of Kaczmarz steps that the solver took."""
        return int(self.row.item(KACZMARZ_STEPS))

    @property
    def components(self) -> Array:
        """(c,) N, of all forces."""
        return self.row[HEADER_SIZE : HEADER_SIZE + self.kind.scene_kind.components]

    @property
    def twist(self) -> Array:
        """The object's motion (6,) about `centre` [m, rad]."""
        return self.next_start[-9:-3]

    @property
    def centre(self) -> Array:
        """(3,) of the contacts [m], world axes."""
        return self.next_start[-3:]

    @property
    def next_start(self) -> Array:
        """Where the solve of a nearby scene may start."""
        return self.row[HEADER_SIZE : HEADER_SIZE + self.kind.scene_kind.components + 9]

    @property
    def motion(self) -> Array:
        """The motion (c,) of the object minus that of the fingertip at each component [m]."""
        c = self.kind.scene_kind.components
        return self.row[HEADER_SIZE + c + 9 : HEADER_SIZE + 2 * c + 9]

    @property
    def states(self) -> Ints:
        """(n,) of `ContactStatus`, where it is an answer."""
        at, n = HEADER_SIZE + 2 * self.kind.scene_kind.components + 9, self.kind.scene_kind.n
        return self.row[at : at + n].astype(np.int64)

    @property
    def candidate(self) -> SolverCandidate:
        """The forces and the motion as a candidate for the certifier."""
        return SolverCandidate(self.components, self.twist, {}, len(self.kind.scene_kind.soft))

    @property
    def proposal(self) -> Proposal:
        """The same in natural units, as the solver says it."""
        return Proposal(self.row[-self.kind.design.layout.size :], self.iterations, self.outcome)
