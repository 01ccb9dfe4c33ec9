"""The paper, reproduced: everything the command `handlcp paper` shows, as data."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import Any

from handlcp.grasp import GraspSolution
from handlcp.lcp.compiler.when import at_once
from handlcp.study.nsngrk import RES, STEPS
from handlcp.study.paper.data import raw
from handlcp.study.paper.misses import Miss
from handlcp.study.paper.no_equilibrium import FORCE_BOUND, MOTION_BOUND, NoEquilibrium, no_equilibrium
from handlcp.study.paper.nsngrk_as_printed import CASES, Case, run_case
from handlcp.study.paper.rows import Row
from handlcp.study.paper.tables import Comparison, compare_all
from handlcp.study.plain import pick, plain


@dataclass(frozen=True, slots=True)
class PaperReport:
    """Ours beside Tables 1 to 10, Example 4 without an equilibrium, NSNGRK as printed; computed in so many seconds."""

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
            "source": raw()["source"],
            "ok": self.ok,
            "seconds": self.seconds,
            "tables": {c.table.number: _table(c) for c in self.tables},
            "example_4": _example_4(self.example_4),
            "nsngrk_as_printed": [_case(c) for c in self.nsngrk],
        }
        return json.dumps(plain(data), indent=1, ensure_ascii=False, allow_nan=False)


@at_once()
def run() -> PaperReport:
    """Compute the whole report; takes a few seconds."""
    start = time.perf_counter()
    tables = compare_all()
    cases = tuple(run_case(number, faces) for number, faces in CASES)
    return PaperReport(tables, no_equilibrium(), cases, time.perf_counter() - start)


def _table(c: Comparison) -> dict[str, Any]:
    misses = () if c.evidence is None else c.evidence.misses
    return pick(c, "golden", "ok", "level", "verdict", "remarks") | {
        "title": c.table.title,
        "ours": _solution(c.solution) | {"what": c.ours},
        "rows": [_row(r) for r in c.rows],
        "printed_forces_signed": None if c.evidence is None else c.evidence.signed.forces,
        "misses": [_miss(m) for m in misses],
    }


def _row(r: Row) -> dict[str, Any]:
    found = pick(r, "column", "place", "ours", "difference", "relative")
    return found | {"printed": r.printed.text, "mark": r.mark.name.lower()}


def _miss(m: Miss) -> dict[str, Any]:
    found = pick(m, "equation", "amount", "holds", "comment", share_of_largest_elastic_displacement="share")
    unit, numbers = "N" if m.elastic is None else "m", "forces" if m.forces else "displacements"
    return found | {"unit": unit, "decided_by": numbers}


def _solution(s: GraspSolution) -> dict[str, Any]:
    loose = None if s.uniqueness is None else s.uniqueness.loose_motions
    found = pick(s, "forces", "slip", "gap", "object_displacement", states="contact_state")
    return found | {"status": s.status.name, "worst_residual": s.residuals.worst, "loose_motions": loose}


def _example_4(e: NoEquilibrium) -> dict[str, Any]:
    return {
        "without_preload": e.unloaded.status.name,
        "proved": e.proved,
        "force_bound": FORCE_BOUND,
        "motion_bound": MOTION_BOUND,
        "with_preload": _solution(e.preloaded),
        "control_normal_force": e.control_normal,
        "searches": [{"faces": f, "E_T": E} | pick(r, "pairs", "none_exists") for f, E, r in e.searches],
    }


def _case(c: Case) -> dict[str, Any]:
    found = pick(c, "example", "faces", "ours", ours_steps="steps", spread_as_printed="spread")
    return found | {
        "spread_natural_units": c.natural_spread,
        "res": RES,
        "max_steps": STEPS,
        "as_printed": [pick(r, "seed", "steps", "res", normal_force="normal") for r in c.printed],
        "natural_units": [pick(r, "seed", "steps", "res", normal_force="normal") for r in c.natural],
        "finger": c.finger + 1,
    }
