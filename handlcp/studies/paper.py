"""`PaperReport`: the paper, reproduced: Examples 1 to 5 and Tables 1 to 10 of Ai & Li, Sensors 2025, 25(7), 2309,
beside ours.

`handlcp paper` prints every number with ours beside it, and which of the paper's equations the printed forces miss:

    (1)            balance           G_N r_N + G_T r_T = F_ext
    (8)            friction limit    r_T in the polygon of apothem μ cos(π/m) r_N
    (2),(5),(13)   compatibility     Gᵀu + E r = slip; normal: 0 at contact, tangential: against the faces at the limit

Signs are lost in print: forces get those that balance best. `examples/paper/` has what goes deeper.
"""

from __future__ import annotations

import json
import math
import time
from dataclasses import dataclass, field
from enum import Enum
from functools import cache
from importlib import resources
from itertools import product
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BeforeValidator, TypeAdapter
from scipy.optimize import linprog

from handlcp.check import Array
from handlcp.grasp import Contact, Coulomb, Frictionless, Grasp, GraspSolution, PrescribedForce, Pyramid
from handlcp.lcp.compiler.compile_policy import compile_now
from handlcp.record import Record, pick_entries, to_plain
from handlcp.words import TextTable, wrap_text

# ----------------------------------------------------------------
# What is printed: magnitudes with their digits, and the misprints among them.

NUMBERS, AXES = tuple(range(1, 11)), ("n", "o", "t")
COLUMN = {"n": 2, "o": 0, "t": 1}  # the paper's (n, o, t) are our (z, x, y)


@dataclass(frozen=True, slots=True)
class Number:
    """A printed magnitude with its text, such as "5.83270e0", its value, and one unit of its last digit."""

    text: str
    value: float
    ulp: float

    @staticmethod
    def parse(text: str) -> Number:
        """Read the text of the data file."""
        mantissa, _, exponent = text.partition("e")
        decimals = len(mantissa.partition(".")[2])
        return Number(text, float(text), 10.0 ** (int(exponent or 0) - decimals))


Numbers = tuple[Annotated[Number, BeforeValidator(Number.parse)], ...]


class Reading(NamedTuple):
    """A force that must be a misprint: finger (from 1), axis "n" | "o" | "t", both texts, and why."""

    finger: int
    axis: str
    printed: str
    read: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperTable:
    """One table of the paper. Entries are magnitudes; fingers count from 1.

    example, faces (None: planar), method : what the paper ran.
    golden : the columns that must be reproduced, of "force", "fingertip", "object".
    force : finger → (n, o, t) or (n,). slip : finger → (o, t). fingertip : finger → (n,). object : 6 or 3 numbers.
    readings : misprints. overwritten : (finger, axis) of force entries in whose place a slip is printed.
    """

    number: int
    example: int
    faces: int | None
    method: str
    golden: tuple[str, ...]
    force: dict[int, Numbers]
    slip: dict[int, Numbers] = field(default_factory=dict)
    fingertip: dict[int, Numbers] = field(default_factory=dict)
    object: Numbers
    readings: tuple[Reading, ...]
    overwritten: tuple[tuple[int, str], ...]

    @property
    def title(self) -> str:
        """The heading of the table."""
        faces = "planar" if self.faces is None else f"{self.faces} faces"
        return f"Table {self.number}: Example {self.example}, {faces}, {self.method} method"

    def forces(self, contacts: int, read: bool = True) -> Array:
        """(n, 3) magnitudes in our contact axes (x, y, z) = (o, t, n); NaN: not printed. read : misprints."""
        out = np.full((contacts, 3), np.nan)
        for finger, numbers in self.force.items():
            for axis, number in zip(AXES, numbers, strict=False):
                out[finger - 1, COLUMN[axis]] = number.value
        for r in self.readings if read else ():
            out[r.finger - 1, COLUMN[r.axis]] = float(r.read)
        return out


@cache
def raw() -> dict[str, Any]:
    """The content of `paper.json`."""
    return dict(json.loads(resources.files("handlcp.studies").joinpath("paper.json").read_text(encoding="utf-8")))


@cache
def table(number: int) -> PaperTable:
    """Table 1 to 10."""
    return TypeAdapter(PaperTable).validate_python({"number": number} | raw()["tables"][str(number)])


# ----------------------------------------------------------------
# The paper's Examples 1 to 5 as grasps.
#
# The paper's contact frame (n, o, t) is our (z, x, y): `tangent` is its o axis. It writes G r = F_ext for the wrench
# that the fingers exert, so F_ext is minus our wrench and its object displacement minus our object's. Object
# displacements are about the world's origin, as in the paper: the tangential slips of its tables fit no other point.

PRELOAD = (5e-6, 5e-6, 0.0)  # [m] squeeze of fingers 1 and 2 with which Example 4 has an elastic equilibrium


@dataclass(frozen=True, slots=True)
class Example:
    """A grasp of the paper: its number, title, what had to be inferred about it, and the grasp."""

    number: int
    title: str
    note: str
    grasp: Grasp


def example(number: int, *, tangential: float | None = None, preload: Any = 0.0) -> Example:
    """Example 1 to 5. tangential : E_T [m/N] in place of the paper's; preload : as in `Grasp` [m]."""
    e = raw()["examples"][str(number)]
    planar, smooth = number == 1, e.get("frictionless", [])
    contacts = []
    for i, (position, n) in enumerate(zip(e["positions"], e["normals"], strict=True), 1):
        friction = Frictionless() if planar or i in smooth else Coulomb(e["mu"])
        normal, tangent = np.array(n, dtype=float), None if planar else e["o_axes"][i - 1]
        contacts.append(Contact(position, normal / np.linalg.norm(normal), friction, tangent, f"finger {i}"))
    if planar:
        load = [-float(x) for x in e["load"]]
        return Example(number, e["title"], e["note"], Grasp(contacts, load, flexibility=e["flexibility"]))
    wrench, effects = np.zeros(6), []
    if "weight" in e:
        wrench[2] = -e["weight"]
        wrench[3:] = np.cross(e["centre"], wrench[:3])
    if "known_force" in e:  # along the printed direction, whose components are rounded
        effects.append(PrescribedForce(0, (0.0, 0.0, e["known_force"] * float(np.linalg.norm(e["normals"][0])))))
    E_T, E_N = e["flexibility_tangential"] if tangential is None else tangential, e["flexibility_normal"]
    grasp = Grasp(contacts, wrench, flexibility=(E_T, E_T, E_N), preload=preload, effects=effects)
    return Example(number, e["title"], e["note"], grasp)


# ----------------------------------------------------------------
# One row per printed number: ours beside it, and a mark.

_ZERO, _NOISE, _RESIDUE = 1e-9, 1e-12, 1e-6  # shares of the table's largest force or motion
_PLANAR = {"u_x": 0, "u_y": 1, "φ": 5}  # names and numbers of the components of a motion
_SPATIAL = {"u_x": 0, "u_y": 1, "u_z": 2, "φ_x": 3, "φ_y": 4, "φ_z": 5}


class Mark(Enum):
    """How a printed number and ours compare; the value is what the report prints."""

    DIGITS = "✓"  # every printed digit
    LAST = "±1"  # to one unit of the last printed digit
    RESIDUE = "≈0"  # exactly zero, printed as the residual that the paper's stop rule permits
    LOOSE = "~"  # the solution leaves this component free
    OTHER = ""  # ours solves another problem (preloaded): shown, not compared
    NO = "✗"


REPRODUCED = (Mark.DIGITS, Mark.LAST, Mark.RESIDUE)


@dataclass(frozen=True, slots=True)
class PrintedRow:
    """A printed magnitude and ours, which has its sign. SI.

    column : "force" [N] | "slip" [m] | "fingertip" [m] | "object" [m, rad]. place : "1 n", "3 t", "u_x", …
    """

    column: str
    place: str
    printed: Number
    ours: float
    mark: Mark

    @property
    def relative(self) -> float:
        """|ours| minus printed, as a share of the printed number; NaN where that is zero."""
        return abs(self.ours) / self.printed.value - 1.0 if self.printed.value else math.nan

    @property
    def cells(self) -> tuple[str, ...]:
        """Place, printed number, ours in the paper's format, and how they compare."""
        mantissa, _, exponent = f"{abs(self.ours):.5e}".partition("e")
        off = f"{100 * self.relative:+.1f} %" if math.isfinite(self.relative) else "not 0"
        ours = f"{mantissa}e{int(exponent)}" if abs(self.ours) > 1e-13 else "0"
        return self.column, self.place, self.printed.text, ours, off if self.mark is Mark.NO else self.mark.value


def mark_of(printed: Number, ours: float, scale: float) -> Mark:
    """Compare the magnitudes of a printed number and ours.

    scale : the largest force or motion, beside which a number may count as zero.
    """
    size, off = abs(ours), abs(abs(ours) - printed.value)
    if printed.value <= _RESIDUE * scale and size <= _ZERO * scale:
        return Mark.DIGITS if printed.value <= _NOISE * scale else Mark.RESIDUE
    if printed.value == 0.0:
        return Mark.NO
    if off <= 0.5 * printed.ulp * (1 + 1e-6):
        return Mark.DIGITS
    return Mark.LAST if off < 1.5 * printed.ulp else Mark.NO


def rows_of(table: PaperTable, grasp: Grasp, solution: GraspSolution, other: bool = False) -> tuple[PrintedRow, ...]:
    """All rows of a table. other : ours solves another problem, so nothing is marked right or wrong."""
    scene = grasp.scene
    unique = solution.uniqueness
    free = np.zeros((0, 6)) if unique is None else unique.directions  # how the object may move
    moves = free[:, None, :3] + np.cross(free[:, None, 3:], scene.positions)
    slides = (scene.frames.transpose(0, 2, 1) @ moves[..., None])[..., :2, 0]
    loose_twist, loose_slip = ((abs(a) > 1e-6 * abs(free).max(initial=0.0)).any(axis=0) for a in (free, slides))
    entries: list[tuple[str, str, Number, Any, Any]] = []  # column, place, printed, ours, whether it is free
    for finger, numbers in table.force.items():
        for axis, number in zip(AXES, numbers, strict=False):
            entries.append(("force", f"{finger} {axis}", number, solution.forces[finger - 1, COLUMN[axis]], False))
    for finger, (number,) in table.fingertip.items():
        retreat = scene.flexibility[3 * finger - 1] @ solution.forces.ravel()
        entries.append(("fingertip", f"{finger} n", number, retreat, False))
    for finger, numbers in table.slip.items():
        for k, number in enumerate(numbers):
            at = finger - 1, k
            entries.append(("slip", f"{finger} {AXES[1 + k]}", number, solution.slip[at], loose_slip[at]))
    names = _PLANAR if len(table.object) == 3 else _SPATIAL
    for (name, k), number in zip(names.items(), table.object, strict=True):
        entries.append(("object", name, number, solution.object_displacement[k], loose_twist[k]))
    # Of a misprint, the number that it is read as is compared
    read = {("force", f"{r.finger} {r.axis}"): Number.parse(r.read) for r in table.readings}
    sizes = {True: 0.0, False: 0.0}  # the largest force, and the largest motion
    for column, place, number, ours, _ in entries:
        force = column == "force"
        sizes[force] = max(sizes[force], abs(ours), read.get((column, place), number).value)
    rows = []
    for column, place, number, ours, loose in entries:
        same = mark_of(read.get((column, place), number), ours, sizes[column == "force"])
        mark = Mark.OTHER if other else Mark.LOOSE if loose else same
        rows.append(PrintedRow(column, place, number, float(ours), mark))
    return tuple(rows)


# ----------------------------------------------------------------
# The printed forces in the paper's own equations: how far they miss each.

_LIMIT = 1e-3  # a force counts as on a face within this share of the largest force: generous to the printed numbers
_FITS = 1e-4  # a miss that is allowed, as a share of the largest elastic displacement


def signed_forces(grasp: Grasp, table: PaperTable, read: bool = True) -> tuple[Array, float]:
    """(n, 3) N in contact axes with the signs that balance best, and what is left [N], moments over the scene's length.
    read : misprints are read, and overwritten entries follow from balance.
    """
    scene = grasp.scene
    printed = np.nan_to_num(table.forces(scene.n, read)).ravel()
    for effect in grasp.effects:
        if isinstance(effect, PrescribedForce):
            printed[3 * effect.contact : 3 * effect.contact + 3] = effect.force
    missing = [3 * (finger - 1) + COLUMN[axis] for finger, axis in table.overwritten] if read else []
    printed[missing] = 0.0
    signed = [i for i in range(len(printed)) if i % 3 != 2 and printed[i] != 0.0]
    choices = np.tile(printed, (2 ** len(signed), 1))
    choices[:, signed] *= np.array(list(product((1.0, -1.0), repeat=len(signed)))).reshape(-1, len(signed))
    G, scale = scene.geometry.grasp_matrix, np.repeat([1.0, 1.0 / scene.units.length_unit], 3)
    if missing:
        left = (choices @ G.T + scene.geometry.wrench) * scale
        choices[:, missing] = -left @ np.linalg.pinv(scale[:, None] * G[:, missing]).T
    left = np.linalg.norm((choices @ G.T + scene.geometry.wrench) * scale, axis=1)
    return choices[left.argmin()].reshape(-1, 3), float(left.min())


def friction_excess(grasp: Grasp, faces: int, forces: Array) -> Array:
    """(n, faces) N by which each tangential force is beyond each face of its inscribed polygon; < 0 inside."""
    pyramid = Pyramid(faces)
    return np.asarray(forces[:, :2] @ pyramid.normals - pyramid.limit(grasp.scene.mu)[:, None] * forces[:, 2:])


def compatibility(grasp: Grasp, faces: int, forces: Array) -> tuple[float, float]:
    """How far printed forces are from compatible motions: (miss, largest elastic displacement) [m].

    The miss is the least worst residual of Gᵀu + E r + Nλ = 0 over all twists u and λ ≥ 0, in normals and tangents of
    fingers whose force is not prescribed. λ may act on the faces at the limit, also where the force is beyond it. A
    linear program.
    """
    scene = grasp.scene
    frictional = scene.force_unknown_mask & (scene.mu > 0)
    limit = friction_excess(grasp, faces, forces) >= -_LIMIT * float(abs(forces).max())
    elastic = scene.flexibility @ forces.ravel()
    rows = np.column_stack([frictional, frictional, scene.force_unknown_mask]).ravel()
    at, face = np.nonzero(limit & frictional[:, None])
    slides = np.zeros((len(at), scene.n, 3))
    slides[np.arange(len(at)), at, :2] = Pyramid(faces).normals.T[face]
    size = float(abs(elastic[rows]).max())
    A = np.column_stack([scene.geometry.grasp_matrix.T, slides.reshape(len(at), 3 * scene.n).T])[rows]
    b, k, one = -elastic[rows] / size, A.shape[1], -np.ones((len(A), 1))
    bounds = [(None, None)] * 6 + [(0.0, None)] * (k - 6 + 1)  # of u, of λ and of the worst residual, which is least
    lp = linprog(np.append(np.zeros(k), 1.0), np.block([[A, one], [-A, one]]), np.append(b, -b), bounds=bounds)
    return float(lp.fun) * size, size


@dataclass(frozen=True, slots=True)
class Miss:
    """How far the printed forces miss one equation. amount : [N], or [m] of displacements. elastic : the largest
    elastic displacement [m]; None: the equation is about forces. allowed : what the printed digits leave open.
    """

    equation: str
    amount: float
    elastic: float | None
    allowed: float
    comment: str = ""

    @property
    def share(self) -> float | None:
        """The amount as a share of the largest elastic displacement; None for forces."""
        return None if self.elastic is None else self.amount / self.elastic

    @property
    def is_satisfied(self) -> bool:
        """Whether the equation is satisfied as far as the printed digits tell."""
        return self.amount <= self.allowed

    def __str__(self) -> str:
        """The amount, such as "0.254 N", or "0.116 µm, 1.7 %"."""
        if self.share is None:
            return f"{short(self.amount)} N"
        return f"{short(self.amount * 1e6)} µm, {100 * self.share:.{0 if self.share >= 0.1 else 1}f} %"


def short(x: float) -> str:
    """A number in few characters, such as "1.5e-6" or "0.0494"."""
    return f"{x:.3g}".replace("e-0", "e-").replace("e+0", "e")


def misses_of(table: PaperTable) -> tuple[Miss, ...]:
    """How far the printed forces of a table with friction miss equations (1) to (13)."""
    grasp, faces, out = example(table.example).grasp, table.faces or 0, list[Miss]()
    digits = sum(x.ulp for column in table.force.values() for x in column)
    if table.readings or table.overwritten:
        out.append(Miss("balance (1)", signed_forces(grasp, table, read=False)[1], None, digits, "as printed"))
    forces, left = signed_forces(grasp, table)
    out.append(Miss("balance (1)", left, None, digits, "misprints read" if out else ""))
    over = friction_excess(grasp, faces, forces)[grasp.scene.force_unknown_mask & (grasp.scene.mu > 0)].max()
    out.append(Miss("friction limit (8)", max(float(over), 0.0), None, digits))
    E_T, _, E_N = grasp.scene.flexibility.diagonal()[:3].tolist()
    # Examples 3 to 5 come without flexibilities, and their printed slips fit E_T = E_N: both are tried
    for value in (E_T,) if table.example == 2 else (E_T, E_N):
        miss, size = compatibility(example(table.example, tangential=value).grasp, faces, forces)
        said = f"E_T = {short(value)} m/N"
        out.append(Miss("elastic compatibility (2), (5), (13)", miss, size, _FITS * size, said))
    return tuple(out)


# ----------------------------------------------------------------
# Tables 1 to 10: rows, misses, and a verdict each.


@dataclass(frozen=True, slots=True)
class TableComparison:
    """A table of the paper beside ours.

    table, example : what was printed, and the grasp. solution : our certified answer. ours : the problem that it
    solves, in words. rows : one per printed number. misses : of the printed forces; none for Tables 1 and 2.
    """

    table: PaperTable
    example: Example
    solution: GraspSolution
    ours: str
    rows: tuple[PrintedRow, ...]
    misses: tuple[Miss, ...]

    @property
    def golden_rows(self) -> tuple[PrintedRow, ...]:
        """The rows that must match."""
        return tuple(r for r in self.rows if r.column in self.table.golden)

    @property
    def ok(self) -> bool:
        """Whether all golden rows match; True for tables without any."""
        return all(r.mark in REPRODUCED for r in self.golden_rows)

    @property
    def level(self) -> str:
        """For a golden table "reproduced" or "failed", for another "solution" or "not a solution"."""
        if self.table.golden:
            return "reproduced" if self.ok else "failed"
        return "solution" if all(m.is_satisfied for m in self.misses) else "not a solution"

    @property
    def verdict(self) -> str:
        """One sentence that says whether the golden rows match, else which of the paper's equations the printed
        forces miss.
        """
        if not self.table.golden:
            lost = [m for m in self.misses if not m.is_satisfied]
            texts = [f"{m.equation} by {m} ({m.comment})".replace(" ()", "") for m in lost]
            said = f"not a solution of the paper's own model: misses {'; '.join(texts)}"
            return said if lost else "the printed forces satisfy the paper's own equations"
        if wrong := [f"{r.column} {r.place}" for r in self.golden_rows if r.mark not in REPRODUCED]:
            return f"NOT reproduced: {', '.join(wrong)}"
        counts = [sum(r.mark is m for r in self.golden_rows) for m in REPRODUCED]
        words = "to every printed digit", "to ±1 in the last one", "exactly 0 where a residual is printed"
        said = ", ".join(f"{count} {word}" for count, word in zip(counts, words, strict=True) if count)
        return f"{', '.join(self.table.golden)} reproduced: of {sum(counts)} numbers {said}"

    def __str__(self) -> str:
        rows = TextTable(("", "", "printed", "ours", ""), tuple([r.cells for r in self.rows]), "<<>><")
        rest = map(wrap_text, (f"verdict: {self.verdict}", *self.remarks))
        return "\n".join([wrap_text(f"{self.table.title}; ours: {self.ours}"), str(rows), *rest])

    @property
    def remarks(self) -> tuple[str, ...]:
        """Misprints, and how far the object is free."""
        text = "misprint: force {0.finger} {0.axis} = {0.printed} reads {0.read} ({0.why})"
        said = [text.format(reading) for reading in self.table.readings]
        if any(r.mark is Mark.LOOSE for r in self.rows):
            said.append("the object may move without a change of forces; ours is the smallest motion")
        return tuple(said)

    def to_dict(self) -> dict[str, Any]:
        """Everything, SI units, printed numbers as text."""
        ours = pick_entries(
            self.solution, "forces", "slip", "gap", "object_displacement", "states = contact_state", "status",
            "worst_residual = residuals.worst", "loose_motions = uniqueness.loose_motions",
        )  # fmt: skip
        row = "column", "place", "ours", "relative", "printed = printed.text"
        miss = "equation", "amount", "holds = is_satisfied", "comment", "share_of_largest_elastic_displacement = share"
        found = {"golden": bool(self.table.golden), "ours": ours | {"what": self.ours}}
        found["rows"] = [
            pick_entries(r, *row) | {"difference": abs(r.ours) - r.printed.value, "mark": r.mark.name.lower()}
            for r in self.rows
        ]
        found["misses"] = [pick_entries(m, *miss) | {"unit": "N" if m.elastic is None else "m"} for m in self.misses]
        return dict(to_plain(pick_entries(self, "ok", "level", "verdict", "remarks", "title = table.title") | found))


@cache
def compare(number: int) -> TableComparison:
    """Solve the example of Table `number` (1 to 10) and lay ours beside the printed numbers."""
    t = table(number)
    e, other = example(t.example), t.example == 4
    if other:  # no elastic equilibrium as printed: ours is the preloaded scene
        solution, ours = example(4, preload=PRELOAD).grasp.solve(8), "with 5 µm preload on fingers 1 and 2, 8 faces"
    else:
        solution, ours = e.grasp.solve(t.faces or 8), f"certified, {t.faces} faces" if t.faces else "certified"
    misses = misses_of(t) if t.faces else ()
    return TableComparison(t, e, solution, ours, rows_of(t, e.grasp, solution, other), misses)


@dataclass(frozen=True, slots=True)
class PaperReport(Record):
    """Ours beside Tables 1 to 10, computed in so many seconds. example_4 : ours without preload, as in the paper."""

    tables: tuple[TableComparison, ...]
    example_4: GraspSolution
    seconds: float

    @property
    def ok(self) -> bool:
        """Whether every golden number is reproduced: Tables 1 and 2, the forces of Tables 3, 6 and 8."""
        return all(c.ok for c in self.tables)

    def to_dict(self) -> dict[str, Any]:
        """Everything, SI units, printed numbers as text; None for what is not a number."""
        found = {"source": raw()["source"], **pick_entries(self, "ok", "seconds")}
        found["tables"] = {c.table.number: c.to_dict() for c in self.tables}
        return dict(to_plain(found | {"example_4": {"without_preload": self.example_4.status.name}}))

    def __str__(self) -> str:
        notes = dict.fromkeys(f"Example {c.example.number}: {c.example.title}. {c.example.note}" for c in self.tables)
        legend = "Magnitudes. ✓ every digit, ±1 in the last one, ≈0 up to RES, ~ left free (the smallest motion shown)"
        parts = [f"The paper, reproduced: {raw()['source']}", legend, *notes, *self.tables]
        parts.append(f"Example 4 as printed, without preload: {self.example_4.diagnosis}.")
        said = "all golden numbers reproduced" if self.ok else "GOLDEN NUMBERS MISSED"
        parts.append(f"{said} (Tables 1 and 2; forces of Tables 3, 6 and 8) in {self.seconds:.1f} s")
        return "\n\n".join(wrap_text(part) if isinstance(part, str) else str(part) for part in parts)


@compile_now()
def run() -> PaperReport:
    """Compute the whole report in a few seconds."""
    start = time.perf_counter()
    tables, unloaded = tuple(map(compare, NUMBERS)), example(4).grasp.solve(6, throw=False)
    return PaperReport(tables, unloaded, time.perf_counter() - start)
