"""`EnvelopeSurface`: a point along each direction, as far out as the factor, up to where it is cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.check import Array, Ints
from handlcp.errors import InputError
from handlcp.grasp.failure.failure_mode import EQUILIBRIUM, MOTION, OPENS, RANGE, SLIDES, SLIPS, TORQUE, UNDECIDED
from handlcp.studies.envelope import Envelope
from handlcp.studies.envelope.direction import Sector, weighted_median
from handlcp.viz.picture.overlay import nice_number

# ----------------------------------------------------------------
# A colour for each cause: its hue says what gives out (friction, a joint, a contact), its shade who.

NO_CAUSE_COLOUR, OTHER_CAUSES_COLOUR = "#D9DCE0", "#8E949B"  # nothing gives out; causes beyond those that have a colour
MAX_COLOURED_CAUSES = 10  # causes with a colour of their own
# One hue a kind; its shades differ in hue as well as in lightness, as the light on a surface changes lightness alone.
# Found by a search for the largest least distance (CIEDE2000), also as people see them who lack red or green cones.
CAUSE_SHADES = {
    SLIDES: ("#F7E552", "#A00024", "#E27563", "#BF6F02", "#B14920", "#E0A933"),
    SLIPS: ("#ED7BAE", "#CA4E65"),
    OPENS: ("#2F794E", "#88D882", "#68EEBD", "#63AF8A", "#134604"),
    TORQUE: ("#5AABE4", "#265C7E", "#AFCBFF", "#3C819F", "#222E4E"),
    RANGE: ("#8B3FBC", "#8B71E3", "#322FA6", "#5A4360"),
    EQUILIBRIUM: ("#43403E",),
    MOTION: ("#47C0C6",),
    UNDECIDED: ("#F3E6FF",),
}


@dataclass(frozen=True, slots=True)
class ColourKey:
    """One colour of the legend: which causes it stands for, and how much is held there.

    colour : "#rrggbb". says : the causes in words. share : of all directions. least : the smallest factor in these
    directions [N, N·m, kg], NaN where undecided. causes : their numbers in `Envelope.causes`.
    """

    colour: str
    says: str
    share: float
    least: float
    causes: tuple[int, ...]


def assign_colours(causes: Sequence[Sector]) -> tuple[tuple[ColourKey, ...], Ints]:
    """The colours, the most frequent cause first; and the number of the colour of each cause."""
    used = dict[str, int]()
    found, rest = list[ColourKey](), list[int]()
    for k, cause in enumerate(causes):
        colour: str | None = NO_CAUSE_COLOUR
        if cause.binds:  # the next shade of its hue, where some are left
            kind = cause.binds[0].kind
            used[kind] = used.get(kind, -1) + 1
            colour = next(iter(CAUSE_SHADES[kind][used[kind] :]), None)
        if colour is None or (len(found) == MAX_COLOURED_CAUSES and len(causes) > MAX_COLOURED_CAUSES + 1):
            rest.append(k)
        else:
            found.append(ColourKey(colour, cause.says, cause.share, cause.least, (k,)))
    if rest:
        share = sum(causes[k].share for k in rest)
        least = min([causes[k].least for k in rest], key=lambda x: (np.isnan(x), x))
        says = f"{len(rest)} other causes" if len(rest) > 1 else causes[rest[0]].says
        found.append(ColourKey(OTHER_CAUSES_COLOUR, says, share, least, tuple(rest)))
    number = np.zeros(len(causes), dtype=np.int64)
    for j, key in enumerate(found):
        number[list(key.causes)] = j
    return tuple(found), number


# ----------------------------------------------------------------

_REACH_IN_MEDIANS = 3.0  # so many medians are seen well beside the weak directions: what reaches farther is cut
_BOUND_REACH_FACTOR = 4.0  # reaches up to which the bound is known to its section


@dataclass(frozen=True, slots=True)
class EnvelopeSurface:
    """The surface of an envelope as it is drawn: a point along each direction, in units of the factors, world axes.

    reach : distance at which the surface is cut.
    cut : whether anything reaches farther.
    points (m, 3) : of the factors, cut at the reach; of the bound in directions that are undecided.
    factor_points (m, 3) : of the factors, cut four times as far out.
    bound_points (m, 3) : of the bound, cut four times as far out.
    cells (k, 3) : corners of triangles; (k, 2) : ends of segments.
    keys : the colours.
    cell_keys (k,) : number of the colour of each cell.
    """

    reach: float
    cut: bool
    points: Array
    factor_points: Array
    bound_points: Array
    cells: Ints
    keys: tuple[ColourKey, ...]
    cell_keys: Ints

    @property
    def has_visible_bound(self) -> bool:
        """Whether there is a bound to be drawn, apart from the surface."""
        off = np.linalg.norm(self.bound_points - self.factor_points, axis=1)
        return bool((off > 1e-3 * self.reach).any())


def make_surface(env: Envelope) -> EnvelopeSurface:
    """The surface of an envelope, cut where the weak directions can still be seen.

    Raises InputError for directions that lie neither all around nor in a plane.
    """
    if not len(env.grid.cells):
        expected = "directions all around or in a plane, for a picture"
        raise InputError("directions", expected, f"{len(env.factors)} that nothing joins")
    reach, cut = _choose_reach(env)
    keys, number = assign_colours(env.causes)
    cells, key, corners = divide_mixed_cells(env.grid.cells, number[env.cause])

    def points_at(factors: Array, most: float) -> Array:
        known = env.directions * np.minimum(factors, most)[:, None]
        return np.concatenate([known, known[corners].mean(axis=1)])

    far = _BOUND_REACH_FACTOR * reach
    factors = np.where(np.isnan(env.factors), env.bound, env.factors)
    points, own, bound = points_at(factors, reach), points_at(factors, far), points_at(env.bound, far)
    return EnvelopeSurface(reach, cut, points, own, bound, cells, keys, key)


def divide_mixed_cells(cells: Ints, own: Ints) -> tuple[Ints, Ints, Ints]:
    """Cells (k, c) divided where their corners, of kinds own (m,), differ, so that each part is of one kind: the cells,
    their kinds, and (p, 6) which of the m corners each further point is the mean of.
    """
    kinds = own[cells]
    mixed = (kinds != kinds[:, :1]).any(axis=1)
    new, names = dict[tuple[int, ...], int](), list[tuple[int, ...]]()

    def middle(*corners: int) -> int:
        where = tuple(sorted(corners))
        if where not in new:
            new[where] = len(own) + len(new)
            names.append(where)
        return new[where]

    parts = list[tuple[int, ...]]()
    key = list[int]()
    for cell in cells[mixed].tolist():
        for part, kind in _divide_cell(cell, own[cell].tolist(), middle):
            parts.append(part)
            key.append(kind)
    every = np.concatenate([cells[~mixed], np.array(parts, dtype=np.int64).reshape(-1, cells.shape[1])])
    corners = np.array([where * (6 // len(where)) for where in names], dtype=np.int64).reshape(-1, 6)
    return every, np.append(kinds[~mixed, 0], np.array(key, dtype=np.int64)), corners


def _divide_cell(cell: list[int], kinds: list[int], middle: Any) -> list[tuple[tuple[int, ...], int]]:
    """Of one cell with corners of several kinds: (corners, kind)."""
    if len(cell) == 2:
        (a, b), m = cell, middle(*cell)
        return [((a, m), kinds[0]), ((m, b), kinds[1])]
    while kinds[0] == kinds[1] or (kinds[0] == kinds[2]):  # turned until the first corner differs from the others
        cell, kinds = [*cell[1:], cell[0]], [*kinds[1:], kinds[0]]
    (a, b, c), (i, j, k) = cell, kinds
    ab, ca = middle(a, b), middle(a, c)
    if j == k:
        return [((a, ab, ca), i), ((ab, b, c), j), ((ab, c, ca), j)]
    bc, m = middle(b, c), middle(a, b, c)
    return [((a, ab, m), i), ((a, m, ca), i), ((b, bc, m), j), ((b, m, ab), j), ((c, ca, m), k), ((c, m, bc), k)]


def cut_by_plane(points: Array, cells: Ints, normal: Array) -> tuple[Array, Ints]:
    """Where a surface of triangles (k, 3) is cut by a plane through the origin: segments (s, 2, 3), and the number of
    the triangle of each (s,).
    """
    side = points @ normal
    side = np.where(abs(side) < 1e-9 * abs(points).max(initial=1e-300), 1e-9, side)
    high = side[cells] > 0.0
    here = np.flatnonzero(high.any(axis=1) & ~high.all(axis=1))
    own, high = cells[here], high[here]
    alone = np.where(high.sum(axis=1) == 1, high.argmax(axis=1), (~high).argmax(axis=1))
    row = np.arange(len(here))
    a = own[row, alone]
    ends = []
    for k in (1, 2):
        b = own[row, (alone + k) % 3]
        share = side[a] / (side[a] - side[b])
        ends.append(points[a] + share[:, None] * (points[b] - points[a]))
    return np.stack(ends, axis=1), here


def bound_lines(s: EnvelopeSurface) -> Array:
    """(s, 2, 3) lines on the bound, in nine planes through the origin; cut at the reach, as the surface is."""
    diagonals = [(1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]
    normals = np.concatenate([np.eye(3), np.array(diagonals, dtype=float)])
    lines = np.concatenate([cut_by_plane(s.bound_points, s.cells, n)[0] for n in normals])
    long = np.linalg.norm(lines, axis=2, keepdims=True)
    return np.asarray(lines * np.minimum(1.0, s.reach / np.maximum(long, 1e-300)))


def border_lines(s: EnvelopeSurface) -> Array:
    """(b, 2, 3) lines on the surface between cells of different colours."""
    if s.cells.shape[1] != 3:
        return np.zeros((0, 2, 3))
    edges = np.sort(s.cells[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    own = np.repeat(s.cell_keys, 3)
    order = np.lexsort(edges.T)
    edges, own = edges[order], own[order]
    between = (edges[1:] == edges[:-1]).all(axis=1) & (own[1:] != own[:-1])
    return np.asarray(s.points[edges[1:][between]])


def _choose_reach(env: Envelope) -> tuple[float, bool]:
    """How far the weaker half of the directions can still be seen well."""
    known = np.where(np.isnan(env.factors), env.bound, env.factors)
    finite = known[np.isfinite(known)]
    if not len(finite) or not finite.max() > 0.0:
        return 1.0, bool(np.isinf(known).any())
    middle = weighted_median(known, env.shares)
    most = _REACH_IN_MEDIANS * (middle if np.isfinite(middle) and middle > 0.0 else float(finite.max()))
    largest = float(known.max())
    cut = largest > 1.15 * most
    step = nice_number(most if cut else largest) / 5.0
    return float(np.ceil((most if cut else largest) / step - 1e-9) * step), cut
