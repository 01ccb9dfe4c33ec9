"""The first stage of a solve, as one compiled call: scenes as rows of numbers, and what their answers say."""

from __future__ import annotations

import numpy as np

from handlcp.check import Array, read_only
from handlcp.grasp.answer import HEAD, Pattern, answer_width, answers, scene_width
from handlcp.grasp.assemble import design
from handlcp.grasp.candidate import Candidate
from handlcp.grasp.certify import Residuals, Verdict
from handlcp.grasp.pyramid import Section
from handlcp.grasp.scene import Scene
from handlcp.grasp.states import NAMES
from handlcp.lcp import Proposal
from handlcp.tolerances import CERTIFY, SOLVE

__all__ = ["NOWHERE", "Found", "Kind", "find", "kind_of", "pack", "start_at"]

NOWHERE = read_only(np.empty(0))  # the start of a solve that begins where every contact sticks


class Kind:
    """Scenes that differ in numbers alone: their effects and layout, the same for compiled code, widths of rows."""

    __slots__ = ("answer_width", "design", "n", "pattern", "scene_width")

    def __init__(self, scene: Scene, section: Section) -> None:
        shared = design(scene, section, ())
        at, n, size = shared.layout.at, scene.n, shared.layout.size
        normal, tangent, u = at.get("r_N", _NONE), at.get("r_T", _NONE), at["u"]
        self.n, self.design = n, shared
        self.scene_width, self.answer_width = scene_width(n, scene.dof), answer_width(n, size)
        self.pattern = Pattern(
            np.concatenate([scene.normal_index, scene.tangent_index]),
            scene.normal_index, scene.tangent_index, shared.rough, scene.governed_mask, shared.role, shared.blocks,
            np.array(section.normals), section.faces, scene.flexible, scene.dof,
            (normal.start, normal.stop - normal.start, tangent.start, u.start, size), size,
        )  # fmt: skip


_NONE = slice(0, 0)
_KINDS: dict[tuple[object, ...], Kind] = {}
_MOST_KINDS = 1024


def kind_of(scene: Scene, section: Section) -> Kind:
    """The kind of a scene whose effects follow from its data, with these cones; few are met again and again."""
    key = (section, scene.governed, scene.rough, scene.plane is None, scene.flexible)
    if (known := _KINDS.get(key)) is None:
        if len(_KINDS) >= _MOST_KINDS:
            _KINDS.clear()
        known = _KINDS[key] = Kind(scene, section)
    return known


def pack(scene: Scene, section: Section, row: Array) -> None:
    """Write the scene's numbers into a row, in the order in which `answers` reads them."""
    n = scene.n
    a, b = 3 * n, 12 * n
    c = b + 9 * n * n
    d = c + a
    row[:a], row[a:b], row[b:c] = scene.positions.reshape(-1), scene.frames.reshape(-1), scene.flexibility.reshape(-1)
    row[c:d] = scene.offset.reshape(-1)
    row[d : d + 3], row[d + 3 : d + 6] = scene.force, scene.moment
    row[d + 6 : d + 6 + n] = section.limit(scene.mu)
    row[d + 6 + n :] = _SPATIAL if scene.freedom is None else scene.freedom.reshape(-1)


_SPATIAL = np.eye(6).reshape(-1)


def find(scene: Scene, section: Section, seed: int, start: Array = NOWHERE) -> Found:
    """The first stage's answer, certified or not; start as in `start_at`."""
    kind = kind_of(scene, section)
    numbers, rows = np.empty((1, kind.scene_width)), np.empty((1, kind.answer_width))
    pack(scene, section, numbers[0])
    answers(read_only(numbers), kind.pattern, start, seed, rows)
    return Found(kind, rows[0])


def start_at(forces: Array, twist: Array, centre: Array) -> Array:
    """(3n + 9,) where to start: forces (n, 3) N, contact axes, and the twist (6,) about centre (3,), of another
    answer.
    """
    return read_only(np.concatenate([forces.reshape(-1), twist, centre]))


class Found:
    """An answer's row, read: SI, contact axes, read-only."""

    __slots__ = ("kind", "row")

    def __init__(self, kind: Kind, row: Array) -> None:
        row.flags.writeable = False
        self.kind, self.row = kind, row

    @property
    def passes(self) -> bool:
        """Whether the certifier calls it an answer; NaN never is."""
        _, _, _, _, _, balance, normal, cone, slip = self.row[:9].tolist()
        return bool(balance <= CERTIFY and normal <= CERTIFY and cone <= CERTIFY and slip <= CERTIFY)

    @property
    def unique(self) -> bool:
        """Whether it is an answer that leaves nothing free."""
        return bool(self.row[14] == 1.0)

    @property
    def residuals(self) -> Residuals:
        """How far it misses each law."""
        force, moment, balance, normal, cone, slip, size, motion = self.row[3:11].tolist()
        nothing = 0.0 * size  # no further effects; NaN where the answer is no number
        return Residuals(balance, normal, cone, slip, nothing, force, moment, size, motion)

    @property
    def iterations(self) -> int:
        """Kaczmarz steps."""
        return int(self.row[0])

    @property
    def outcome(self) -> str:
        """The solver's own words."""
        return f"{'converged' if self.row[2] <= SOLVE else 'budget spent'}, {int(self.row[1])} Newton steps"

    @property
    def forces(self) -> Array:
        """(n, 3) N."""
        return self._rows(0, 3)

    @property
    def twist(self) -> Array:
        """(6,) about `centre`."""
        at = HEAD + 3 * self.kind.n
        return self.row[at : at + 6]

    @property
    def centre(self) -> Array:
        """(3,) of the contacts [m], world axes."""
        at = HEAD + 3 * self.kind.n + 6
        return self.row[at : at + 3]

    @property
    def start(self) -> Array:
        """Where the solve of a nearby scene may start."""
        return self.row[HEAD : HEAD + 3 * self.kind.n + 9]

    @property
    def forces_world(self) -> Array:
        """(n, 3) N, world axes."""
        return self._rows(3 * self.kind.n + 9, 3)

    @property
    def motion(self) -> Array:
        """(n, 3) object minus fingertip [m]."""
        return self._rows(6 * self.kind.n + 9, 3)

    @property
    def states(self) -> tuple[str, ...]:
        """For each contact "separated", "sticking" or "sliding", where it is an answer."""
        at = HEAD + 9 * self.kind.n + 9
        return tuple([NAMES[int(k)] for k in self.row[at : at + self.kind.n].tolist()])

    @property
    def candidate(self) -> Candidate:
        """Forces and motion."""
        return Candidate(self.forces, self.twist, {})

    @property
    def verdict(self) -> Verdict:
        """The certifier's."""
        return Verdict(self.motion, self.residuals)

    @property
    def proposal(self) -> Proposal:
        """The same in natural units, as the solver says it."""
        return Proposal(self.row[-self.kind.design.layout.size :], self.iterations, self.outcome)

    def _rows(self, at: int, width: int) -> Array:
        return self.row[HEAD + at : HEAD + at + width * self.kind.n].reshape(-1, width)
