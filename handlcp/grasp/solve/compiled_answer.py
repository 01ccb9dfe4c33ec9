"""`CompiledAnswer`: what `compiled_solve` found, one scene or many of one kind, and the way there from a `Scene`."""

from __future__ import annotations

from collections.abc import Sequence
from inspect import unwrap
from operator import attrgetter
from typing import Any

import numpy as np

from handlcp.check import Array, Bools, Ints, read_only
from handlcp.contact.friction import Section
from handlcp.errors import InputError
from handlcp.grasp.assembly.problem import SolverCandidate, polyhedron_normals, problem_design
from handlcp.grasp.model.contact import SceneKind
from handlcp.grasp.model.flexibility import Flexibility, FlexibilityFactor, stored_flexibility
from handlcp.grasp.model.scene import GraspArrays, Scene
from handlcp.grasp.solve.compiled_solve import (
    END_OF_RESIDUALS,
    FIRST_RESIDUAL,
    HEADER_SIZE,
    KACZMARZ_STEPS,
    MAYBE_FREE,
    NONE_HOLDS,
    OUTCOME,
    UNIQUE,
    SceneNumbers,
    ScenePattern,
    read_scene,
    solve_scenes,
)
from handlcp.grasp.verify.certifier import LawResiduals, Residuals
from handlcp.lcp import Proposal
from handlcp.lcp.solver import describe_outcome
from handlcp.tolerances import SOLVE_TOLERANCE

_NO_MATRIX = read_only(np.empty((0, 0)))
NO_START = read_only(np.empty(0))  # the start of a solve that begins where every contact sticks

# ----------------------------------------------------------------
# Scenes of one kind as the rows of a matrix.


class CompiledKind:
    """Scenes that differ in numbers alone: their effects and layout, the same for compiled code, and where the forces
    (c), twist (6), centre (3), motions (c), contact states (n) and unknowns (N) of an answer stand in its row.
    """

    __slots__ = (
        "centre",
        "design",
        "forces",
        "motion",
        "pattern",
        "scene_kind",
        "states",
        "twist",
        "unknowns",
        "width",
    )

    def __init__(self, scene: Scene, section: Section, shape: tuple[int, int, int, int]) -> None:
        kind, self.design = scene.kind, problem_design(scene, section, ())
        where, roles = self.design.layout, self.design.pattern
        self.scene_kind: SceneKind = kind
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
            shape,
        )
        self.width = row_width(self.pattern)  # of a scene
        ends = np.cumsum([HEADER_SIZE, kind.components, 6, 3, kind.components, kind.n, where.size]).tolist()
        self.forces, self.twist, self.centre, self.motion, self.states, self.unknowns = map(slice, ends, ends[1:])


_KINDS: dict[tuple[object, ...], CompiledKind] = {}
_MAX_KINDS = 1024


def get_compiled_kind(scene: Scene, section: Section, factor: Flexibility | None = None) -> CompiledKind:
    """The kind of a scene whose effects follow from its data, with these cones; few are met again and again.

    factor : of its flexibility, that contacts are eliminated with; None: all unknowns are solved for at once.
    """
    key = (section, scene.kind, shape := flexibility_shape(scene, factor))
    if (known := _KINDS.get(key)) is None:
        if len(_KINDS) >= _MAX_KINDS:
            _KINDS.clear()
        known = _KINDS[key] = CompiledKind(scene, section, shape)
    return known


def factor_to_eliminate(scene: Scene) -> Flexibility | None:
    """The factor that the contacts of a scene are eliminated with; None: they are not."""
    return scene.factor if scene.kind.has_many_contacts else None


def flexibility_shape(scene: Scene, factor: Flexibility | None) -> tuple[int, int, int, int]:
    """Rows of the flexibility as a matrix, 0 where the factor was given in its place; how many pads the factor has, 0
    where there is none, and its numbers of joints and columns.
    """
    rows = 0 if factor is stored_flexibility(scene) else scene.components
    return (rows, 0, 0, 0) if factor is None else (rows, len(factor.factor.pads), *factor.factor.root.shape)


def row_width(p: ScenePattern) -> int:
    """How many numbers a scene is."""
    n, (rows, pads, joints, columns) = len(p.contacts), p.flexibility
    components = 3 * n + p.torsional
    of_factor = 3 * pads * (joints + 3) + joints * columns
    return 13 * n + rows * rows + 2 * components + 3 * p.torsional + 6 + 6 * p.dof + of_factor


def scene_views(row: Array, p: ScenePattern) -> GraspArrays:
    """The arrays that `read_scene` reads, of a row that is written to."""
    found: SceneNumbers = unwrap(read_scene)(row, p)
    return found.arrays


def write_row(scene: Scene, section: Section, factor: Flexibility | None, row: Array) -> None:
    """Write a scene's numbers, and a factor of its flexibility if there is one, into a row."""
    arrays = scene.arrays if factor is not stored_flexibility(scene) else scene.arrays_with(_NO_MATRIX)
    parts = (*arrays, scene.friction_coefficients(section), *(() if factor is None else factor.factor))
    np.concatenate(parts, axis=None, out=row)


def write_rows(count: int, width: int, **fields: Sequence[Array] | Array) -> Array:
    """Write the rows (m, width) of m scenes, field by field. Read-only.

    Each field of `GraspArrays`, `friction`, and each of `FlexibilityFactor`, is an array (m, …), or one for each scene;
    where all of these are one and the same, as after `replace`, it is copied once. One that has no numbers may be left
    out.
    """
    out, at = np.empty((count, width)), 0
    names = (*GraspArrays._fields, "friction", *FlexibilityFactor._fields)
    for own in [fields[name] for name in names if name in fields]:
        first = own[0]
        if isinstance(own, np.ndarray):
            whole = own.reshape(count, -1)
        elif all([a is first for a in own]):
            whole = first.reshape(1, -1)
        else:
            whole = np.concatenate(own).reshape(count, -1)
        out[:, at : at + first.size] = whole
        at += first.size
    return read_only(out)


_READ_FIELDS = attrgetter("positions", "frames", "offset", "prescribed", "force", "moment", "mu")
_SPATIAL_FREEDOM = np.eye(6)


def scene_rows(scenes: Sequence[Scene], kind: CompiledKind, section: Section) -> Array:
    """The rows (m, width) of scenes of one kind, written field by field for all at once, in a third of the time.
    Read-only.
    """
    m, soft, (matrix, pads, *_) = len(scenes), kind.scene_kind.soft, kind.pattern.flexibility
    positions, frames, offset, known, force, moment, mu = zip(*map(_READ_FIELDS, scenes), strict=True)
    none = np.zeros(kind.scene_kind.components)
    fields: dict[str, Any] = {}
    if matrix:
        fields["flexibility"] = [s.flexibility for s in scenes]
    if soft:
        fields["spin"] = [s.arrays.spin for s in scenes]
    if pads:
        factors = [E.factor for s in scenes if (E := s.factor) is not None]
        fields |= zip(("rows", "root", "pads"), zip(*factors, strict=True), strict=True)
    return write_rows(
        m,
        kind.width,
        positions=positions,
        frames=frames,
        offset=offset,
        prescribed=[none if a is None else a for a in known],
        force=force,
        moment=moment,
        freedom=[s.freedom for s in scenes] if kind.scene_kind.planar else [_SPATIAL_FREEDOM] * m,
        friction=[s.friction_coefficients(section) for s in scenes] if soft else np.array(mu) * section.share,
        **fields,
    )


def solve_scene(scene: Scene, section: Section, seed: int, start: Array = NO_START) -> CompiledAnswer:
    """The first stage's answer, certified or not; start : made by `start_values`."""
    factor = factor_to_eliminate(scene)
    kind = get_compiled_kind(scene, section, factor)
    numbers = np.empty((1, kind.width))
    write_row(scene, section, factor, numbers[0])
    return CompiledAnswer(kind, solve_scenes(numbers, kind.pattern, start, seed)[0])


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


# ----------------------------------------------------------------


class CompiledAnswer:
    """The answer to one scene, or to several of a kind, read off rows (..., width): SI, in the coordinates of the
    scenes' friction laws, read-only. What is said of one answer alone is said in words.
    """

    __slots__ = ("kind", "rows")

    def __init__(self, kind: CompiledKind, rows: Array) -> None:
        rows.flags.writeable = False
        self.kind, self.rows = kind, rows

    def __getitem__(self, some: Any) -> CompiledAnswer:
        """Some of several, or one."""
        return CompiledAnswer(self.kind, self.rows[some])

    @property
    def passes(self) -> Bools:
        """Whether the certifier calls it an answer, as `Residuals.passes` says; no effect has a law of its own here."""
        return np.asarray(self.rows[..., OUTCOME] >= MAYBE_FREE)

    @property
    def is_unique(self) -> Bools:
        """Whether it is an answer that leaves nothing free."""
        return np.asarray(self.rows[..., OUTCOME] == UNIQUE)

    @property
    def escapes(self) -> Bools:
        """Whether it is proven that nothing holds the object."""
        return np.asarray(self.rows[..., OUTCOME] == NONE_HOLDS)

    @property
    def escape(self) -> Array | None:
        """(dof,) where it is proven that nothing holds the object: the motion in which it escapes, natural units."""
        at = self.kind.twist.start
        return self.rows[at : at + self.kind.scene_kind.dof] if self.escapes else None

    @property
    def residuals(self) -> Residuals:
        """How far one misses each law."""
        laws = LawResiduals(*self.rows[FIRST_RESIDUAL:END_OF_RESIDUALS].tolist())
        return Residuals.from_law_residuals(laws, 0.0 * laws.force_size)  # NaN where it is no number

    @property
    def outcome(self) -> str:
        """The solver's own words of one."""
        steps, newton, residual = self.rows[:FIRST_RESIDUAL].tolist()
        return describe_outcome(residual <= SOLVE_TOLERANCE, int(steps), int(newton))

    @property
    def iterations(self) -> int:
        """The number of Kaczmarz steps that the solver took for one."""
        return int(self.rows.item(KACZMARZ_STEPS))

    @property
    def components(self) -> Array:
        """(..., c) N, of all forces."""
        return self.rows[..., self.kind.forces]

    @property
    def twist(self) -> Array:
        """The object's motion (..., 6) about `centre` [m, rad]."""
        return self.rows[..., self.kind.twist]

    @property
    def centre(self) -> Array:
        """(..., 3) of the contacts [m], world axes."""
        return self.rows[..., self.kind.centre]

    @property
    def next_start(self) -> Array:
        """Where the solve of a nearby scene may start."""
        return self.rows[..., self.kind.forces.start : self.kind.centre.stop]

    @property
    def motion(self) -> Array:
        """The motion (..., c) of the object minus that of the fingertip at each component [m]."""
        return self.rows[..., self.kind.motion]

    @property
    def states(self) -> Ints:
        """(..., n) of `ContactStatus`, where it is an answer."""
        return self.rows[..., self.kind.states].astype(np.int64)

    @property
    def candidate(self) -> SolverCandidate:
        """The forces and the motion of one as a candidate for the certifier."""
        return SolverCandidate(self.components, self.twist, {}, len(self.kind.scene_kind.soft))

    @property
    def proposal(self) -> Proposal:
        """The same in natural units, as the solver says it."""
        return Proposal(self.rows[self.kind.unknowns], self.iterations, self.outcome)
