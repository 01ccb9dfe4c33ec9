"""The paper, reproduced: everything the command `handlcp paper` shows, as data."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from handlcp.grasp import GraspSolution
from handlcp.study.paper.data import source
from handlcp.study.paper.misses import Miss
from handlcp.study.paper.no_equilibrium import FORCE_BOUND, MOTION_BOUND, NoEquilibrium, no_equilibrium
from handlcp.study.paper.nsngrk_as_printed import CASES, RES, STEPS, Case, Run, run_case
from handlcp.study.paper.rows import Row
from handlcp.study.paper.tables import Comparison, compare_all
from handlcp.study.plain import plain

__all__ = ["PaperReport", "run"]


@dataclass(frozen=True, slots=True)
class PaperReport:
    """Ours beside Tables 1 to 10, Example 4 without an equilibrium, and NSNGRK as printed.

    seconds : computing time.
    """

    tables: tuple[Comparison, ...]
    example_4: NoEquilibrium
    nsngrk: tuple[Case, ...]
    seconds: float

    @property
    def ok(self) -> bool:
        """Whether every golden number is reproduced: Tables 1 and 2, the forces of Tables 3, 6 and 8."""
        return all(c.ok for c in self.tables)

    def to_json(self) -> str:
        """Everything, SI units, printed numbers as text; NaN becomes null."""
        data = {
            "source": source(),
            "ok": self.ok,
            "seconds": self.seconds,
            "tables": {c.table.number: _table(c) for c in self.tables},
            "example_4": _example_4(self.example_4),
            "nsngrk_as_printed": [_case(c) for c in self.nsngrk],
        }
        return json.dumps(plain(data), indent=1, ensure_ascii=False, allow_nan=False)


def run() -> PaperReport:
    """Compute the whole report; takes a few seconds."""
    start = time.perf_counter()
    tables = compare_all()
    cases = tuple(run_case(number, faces) for number, faces in CASES)
    return PaperReport(tables, no_equilibrium(), cases, time.perf_counter() - start)


def _table(c: Comparison) -> dict[str, Any]:
    judged = {"golden": c.golden, "ok": c.ok, "level": c.level, "verdict": c.verdict, "remarks": c.remarks}
    return {
        "title": c.table.title,
        **judged,
        "ours": _solution(c.solution) | {"what": c.ours},
        "rows": [_row(r) for r in c.rows],
        "printed_forces_signed": None if c.evidence is None else c.evidence.signed.forces,
        "misses": [] if c.evidence is None else [_miss(m) for m in c.evidence.misses],
    }


def _row(r: Row) -> dict[str, Any]:
    found = {"column": r.column, "place": r.place, "printed": r.printed.text, "ours": r.ours}
    return found | {"difference": r.difference, "relative": r.relative, "mark": r.mark.name.lower()}


def _miss(m: Miss) -> dict[str, Any]:
    return {
        "equation": m.equation,
        "amount": m.amount,
        "unit": m.unit,
        "share_of_largest_elastic_displacement": m.share,
        "holds": m.holds,
        "decided_by": "forces" if m.forces else "displacements",
        "comment": m.comment,
    }


def _solution(s: GraspSolution) -> dict[str, Any]:
    return {
        "status": s.status.name,
        "forces": s.forces,
        "slip": s.slip,
        "gap": s.gap,
        "states": s.contact_state,
        "object_displacement": s.object_displacement,
        "worst_residual": s.residuals.worst,
        "loose_motions": None if s.uniqueness is None else s.uniqueness.loose_motions,
    }


def _example_4(e: NoEquilibrium) -> dict[str, Any]:
    return {
        "without_preload": e.unloaded.status.name,
        "proved": e.proved,
        "force_bound": FORCE_BOUND,
        "motion_bound": MOTION_BOUND,
        "with_preload": _solution(e.preloaded),
        "control_normal_force": e.control_normal,
        "searches": [{"faces": f, "E_T": E, "pairs": r.pairs, "none_exists": r.none_exists} for f, E, r in e.searches],
    }


def _case(c: Case) -> dict[str, Any]:
    return {
        "example": c.example,
        "faces": c.faces,
        "res": RES,
        "max_steps": STEPS,
        "as_printed": _runs(c.printed),
        "natural_units": _runs(c.natural),
        "ours": c.ours,
        "ours_steps": c.steps,
        "finger": c.finger + 1,
        "spread_as_printed": c.spread,
        "spread_natural_units": c.natural_spread,
    }


def _runs(runs: Sequence[Run]) -> list[dict[str, Any]]:
    return [{"seed": r.seed, "steps": r.steps, "res": r.res, "normal_force": r.normal} for r in runs]
