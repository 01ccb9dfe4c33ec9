"""`Margins`: what is left of friction, of torque and of the load until a grasp fails, and the classic measures.

The first three are about one answer, with its springs and its squeeze, the others about contacts and friction alone.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import check_method_calls, check_number
from handlcp.contact.friction import Section
from handlcp.errors import InputError, Unsupported
from handlcp.grasp.failure.failure_mode import largest_share_index
from handlcp.grasp.failure.failure_text import describe_failures
from handlcp.grasp.limits.load_limit import load_limit
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.margins.wrench_space import Closure, WrenchSpace, force_closure, form_closure, wrench_space
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.lazy_property import lazy_property
from handlcp.record import Record, make_data_frame
from handlcp.words import TextTable, wrap_text

_SLIDING_SHARE = 1e-5  # share of friction: with less left a contact slides, as far as a solution is exact
_VECTOR_BREAK = re.compile(r"(?<=\d), (?=-?\d)")  # within a vector, where a line might end


@dataclass(frozen=True, slots=True)
class Least(Record):
    """The least of several margins. who : the finger or joint. amount : what is left, N or N·m; < 0 where it needs more
    than it has. share : of its limit. unit : of the amount.
    """

    who: str
    amount: float
    share: float
    unit: str

    def _entry_lines(self) -> tuple[str, ...]:
        return "who", f"amount_{self.unit.replace('·', '')} = amount", "share"


@check_method_calls
@dataclass(frozen=True, eq=False)
class Margins(Record):
    """Made by `Grasp.margins`; each number is worked out when it is first asked for.

    spec, section : of what, with which friction cones. solution : the answer that the first margins are about; held or
    not. length : that moments are divided by [m]; None: that of the grasp.
    """

    entries = ("held = solution.held", "safety", "friction", "torque", "force_closure", "form_closure", "wrench_space")

    spec: GraspSpec
    section: Section
    solution: GraspSolution
    length: float | None
    scene: Scene = field(repr=False)

    @lazy_property
    def friction(self) -> Least | None:
        """The contact that uses most of its friction: how much more it would bear [N], and as a share; None where no
        contact with friction presses, and without an answer.
        """
        used = self.solution.friction_used
        if not np.isfinite(used).any():
            return None
        k = largest_share_index(used)
        return Least(self.spec.names[k], float(self.solution.friction_margin[k]), 1.0 - float(used[k]), "N")

    @lazy_property
    def torque(self) -> Least | None:
        """The joint that is nearest to its torque limit: how much more it has [N·m], and as a share; None where no
        limit is known, and without an answer.
        """
        check = getattr(self.solution, "torque_check", None)
        if check is None or not self.solution.held or check.binding is None:
            return None
        row = check[check.binding]
        if not np.isfinite(row.limit):
            return None
        return Least(row.joint, row.limit - abs(row.torque), 1.0 - row.utilisation, row.unit)

    @lazy_property
    def load(self) -> LoadLimit | None:
        """How far the load beside the weight may grow, as `Grasp.load_limit` says; None where there is no such load, or
        no path to it is known (forces that are known or prescribed).
        """
        return None if isinstance(self._load, str) else self._load

    @lazy_property
    def _load(self) -> LoadLimit | str:
        """The limit, or what the reader may do about there being none."""
        try:
            return load_limit(self.spec, self.section, None, None, None, None)
        except InputError:
            return "say one: grasp.load_limit(wrench)"
        except Unsupported:
            return "not known: forces are given"

    @property
    def safety(self) -> float | None:
        """The safety factor on the load beside the weight; None as above."""
        return None if self.load is None else self.load.factor

    @lazy_property
    def force_closure(self) -> Closure:
        """Whether friction could balance any load."""
        return force_closure(self.spec, self.scene, self.section)

    @lazy_property
    def form_closure(self) -> Closure:
        """Whether the contacts would leave no motion, even without friction (first order)."""
        return form_closure(self.spec, self.scene)

    @lazy_property
    def wrench_space(self) -> WrenchSpace:
        """Of contacts whose normal forces add up to 1 N."""
        return wrench_space(self.scene, self.section, self.spec.reference, self.length)

    @property
    def epsilon(self) -> float:
        """Radius of the largest ball in the wrench space: see `WrenchSpace`."""
        return self.wrench_space.epsilon

    @property
    def volume(self) -> float:
        """Of the wrench space: see `WrenchSpace`."""
        return self.wrench_space.volume

    def to_frame(self) -> Any:
        """A pandas table, a row for each measure: value, unit, share, who. Raises Unsupported without pandas."""
        space, least = self.wrench_space, {"friction": self.friction, "torque": self.torque}
        rows = {name: (x.amount, x.unit, x.share, x.who) for name, x in least.items() if x is not None}
        found = {"safety": self.safety}
        for c in (self.force_closure, self.form_closure):
            found[f"{c.kind}_closure"] = np.nan if c.closed is None else float(c.closed)
        found |= {"epsilon": space.epsilon, "volume": space.volume}
        units = {"epsilon": "N/N"}
        rows |= {name: (x, units.get(name, ""), np.nan, "") for name, x in found.items() if x is not None}
        columns = zip(("value", "unit", "share", "who"), zip(*rows.values(), strict=True), strict=True)
        return make_data_frame(dict(columns), list(rows))

    def __str__(self) -> str:
        space, rows = self.wrench_space, list[tuple[str, ...]]()
        if (least := self.friction) is not None:
            slides = least.share < _SLIDING_SHARE
            left, share = (0.0, 0.0) if slides else (least.amount, least.share)
            who = f"{least.who}: slides already" if slides else least.who
            rows.append(("friction", words.format_force(left), words.format_percent(share), who))
        if self.torque is not None:
            t = self.torque
            rows.append(("torque", words.format_effort(t.amount, t.unit), words.format_percent(t.share), t.who))
        if isinstance(self._load, str):
            rows.append(("load", "–", "", self._load))
        else:
            factor = "∞" if np.isinf(self._load.factor) else f"× {self._load.factor:.3g}"
            rows.append(("load", factor, "", describe_failures(self._load.binds, self.spec, brief=True)))
        lines = [str(TextTable(("margin", "left", "of limit", "least at"), tuple(rows), "<>><"))]
        if not self.solution.held:
            lines.append("no margins of friction and torque: no equilibrium was found")
        for c in (self.force_closure, self.form_closure):
            word = {True: "yes", False: "no", None: "not told"}[c.closed]
            whole = _VECTOR_BREAK.sub(",\N{NO-BREAK SPACE}", f"{c.kind} closure: {word}, {c.sentence}")
            lines.append(wrap_text(whole, "  ").replace("\N{NO-BREAK SPACE}", " "))
        lines.append(wrap_text(_describe_space(space), "  "))
        return "\n".join(lines)


def make_margins(spec: GraspSpec, scene: Scene, section: Section, solution: Any, length: Any) -> Margins:
    """Gather how far a solution is from failing, as `Grasp.margins` documents."""
    if not isinstance(solution, GraspSolution) or len(solution.forces) != scene.n:
        raise InputError("solution", "a solution of this grasp, or None", repr(solution)[:80])
    L = None if length is None else check_number("length", length, above=0.0)
    return Margins(spec, section, solution, L, scene)


def _describe_space(space: WrenchSpace) -> str:
    """Describe the wrench space in one sentence."""
    if space.why:
        return f"wrench space: none, {space.why}"
    few = "" if space.dimension == space.of else f" in {space.dimension} of {space.of} dimensions"
    radius, volume = _format_range(space.epsilon, space.epsilon_most), _format_range(space.volume, space.volume_most)
    return (
        f"wrench space{few}: ε {radius}, volume {volume}, per newton of all normal forces, moments over "
        f"{words.format_length(space.length)}"
    )


def _format_range(low: float, high: float) -> str:
    one, other = f"{low:.3g}", f"{high:.3g}"
    return one if one == other else f"{one} to {other}"
