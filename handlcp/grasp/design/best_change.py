"""`best_change`: which single change buys most: grip, friction, stiffness or torque limits, each by the same share.

Each is made and the load limit found anew, so that what then binds counts too. The best is judged by `check` under a
load between the old limit and the new one: with the change that is held, without it is not.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handlcp.check import Array, check_number
from handlcp.contact.friction import Section
from handlcp.errors import InputError
from handlcp.grasp.derivatives.parameter import parameters_by_effort
from handlcp.grasp.derivatives.parameter.load import with_load
from handlcp.grasp.design.required_value import verdict_on
from handlcp.grasp.failure.failure_mode import UNDECIDED
from handlcp.grasp.failure.failure_text import NOTHING_FAILS, describe_failures
from handlcp.grasp.limits.load_limit import load_limit
from handlcp.grasp.limits.result import LoadLimit
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.solution.verdict import HELD
from handlcp.progress import track_progress
from handlcp.record import Record
from handlcp.words import TextTable, wrap_text


@dataclass(frozen=True, slots=True)
class TriedChange(Record):
    """One change of a grasp, and how much load is held with it.

    what : the change in words.
    factor : on the load, that the grasp holds then.
    gain : factor over that without the change, minus 1; negative where it costs load.
    limit : its `LoadLimit`.
    """

    entries = ("change = what", "factor", "gain", "why = limit.why")

    what: str
    factor: float
    gain: float
    limit: LoadLimit = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class BestChange(Record):
    """What each change does to the load that a grasp holds, the best first.

    wrench (6,) : the load that grows [N, N·m], as in `LoadLimit`. share : of every change. before : the load limit
    without a change. tried : the changes; empty where nothing binds before. between : factor on the load, between the
    limits before and after the best change, at which `check()` was asked; NaN where no change buys anything.
    verdicts : its words there, with the best change and without; why_not : why the first is not HELD, "" where it is.
    of_weight : whether the load that grows is added to the object's weight and acts as that does, because no load was
    given and the grasp has none.
    """

    entries = (
        "load_N_Nm (6,) = wrench",
        "share",
        "factor_before = before.factor",
        "tried",
        "checked_at_factor = between",
        "verdict_with = verdicts.0",
        "verdict_without = verdicts.1",
        "why_not",
    )

    wrench: Array
    share: float
    before: LoadLimit
    tried: tuple[TriedChange, ...]
    between: float
    verdicts: tuple[str, str]
    of_weight: bool = False
    why_not: str = ""

    @property
    def best(self) -> TriedChange | None:
        """The change that buys most; None where none buys anything."""
        return self.tried[0] if self.tried and self.tried[0].factor > self.before.factor else None

    @property
    def confirmed(self) -> bool:
        """Whether `check()` holds the load in between with the best change, and does not without it."""
        return self.verdicts[0] == HELD and self.verdicts[1] not in ("", HELD)

    @property
    def table(self) -> TextTable:
        """The table of the changes that were tried, one a row."""
        rows = [("as it is", _format_factor(self.before.factor), "", _describe_limit(self.before))]
        rows += [(t.what, _format_factor(t.factor), _format_gain(t.gain), _describe_limit(t.limit)) for t in self.tried]
        return TextTable(
            ("change", "holds extra\n× weight" if self.of_weight else "holds\n× load", "gain", "then gives out"),
            tuple(rows),
            "<>><",
        )

    def __str__(self) -> str:
        return f"{self.table}\n{self.sentence}" if self.tried else self.sentence

    @property
    def sentence(self) -> str:
        """The best change, and what `check` says."""
        if not self.tried:
            return f"{NOTHING_FAILS}, however large the load: no change buys anything"
        if (best := self.best) is None:
            none = "none of these changes buys load"
            undecided = any(bind.kind == UNDECIDED for bind in self.before.binds)
            return wrap_text(f"{none}; as it is: {self.before.why}") if undecided else none
        told, load = f"{best.what} buys most: {_format_gain(best.gain)} load", "the load"
        if self.of_weight:
            load, has = "extra weight", f"{self.before.factor:.4g} × the weight in addition"
            told = f"no load was given, so weight is added to the object's own: as it is, the grasp holds {has}; {told}"
        if self.confirmed:
            return wrap_text(
                f"{told}; at {self.between:.4g} × {load} check() says HELD with the change, and not without"
            )
        given = f"{self.verdicts[0]} with the change and {self.verdicts[1]} without"
        why = f": {self.why_not}" if self.why_not else ""
        return wrap_text(f"NOT CONFIRMED: {told}; but at {self.between:.4g} × {load} check() says {given}{why}")


@track_progress("load limits with each change")
def best_change(spec: GraspSpec, section: Section, wrench: Any, share: Any, geometry: Any) -> BestChange:
    """Find which change of the grasp buys most load, as `Grasp.best_change` documents."""
    part = check_number("share", share, above=0.0)
    if part >= 1.0:
        raise InputError("share", "a share below 1, such as 0.1", share)
    asked = spec.load_beside_weight if wrench is None else wrench
    of_weight = wrench is None and not asked.any()
    grows = spec.mechanism is None and wrench is None  # contacts' own wrench, from nothing
    load = None if grows else spec.wrench if of_weight else asked
    before = load_limit(spec, section, load, geometry, None, None)
    if np.isinf(before.factor):
        return BestChange(before.wrench, part, before, (), np.nan, ("", ""), of_weight)
    made = {what: other for p in parameters_by_effort() for what, other in p.shares(spec, part) if other is not None}
    found = {what: load_limit(other, section, load, geometry, None, None) for what, other in made.items()}
    base = before.factor or np.nan
    tried = [TriedChange(what, limit.factor, limit.factor / base - 1.0, limit) for what, limit in found.items()]
    tried.sort(key=lambda t: -t.factor)
    between, verdicts, why_not = np.nan, ("", ""), ""
    if tried and tried[0].factor > before.factor:
        most = min(tried[0].factor, 2.0 * before.factor or 1.0)
        between = 0.5 * (before.factor + most)
        rests = spec.wrench if spec.mechanism is None and not grows else np.zeros(6)
        ends = [with_load(s, rests + between * before.wrench) for s in (made[tried[0].what], spec)]
        changed = verdict_on(ends[0], section)
        verdicts = (changed.word, verdict_on(ends[1], section).word)
        why_not = "; ".join([r.sentence for r in changed.reasons if r.severity == "decides"])
    return BestChange(before.wrench, part, before, tuple(tried), between, verdicts, of_weight, why_not)


# ---------------------------------------------------------------- words
def _format_factor(factor: float) -> str:
    return f"{factor:.4g}" if np.isfinite(factor) else "∞"


def _format_gain(gain: float) -> str:
    return f"{100 * gain:+.1f} %" if np.isfinite(gain) else "–"


def _describe_limit(limit: LoadLimit) -> str:
    return describe_failures(limit.binds, brief=True) if limit.binds else "nothing"
