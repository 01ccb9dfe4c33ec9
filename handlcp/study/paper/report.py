"""The paper, reproduced: everything the command `handlcp paper` shows, as data."""

from __future__ import annotations

import json
import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from handlcp.grasp import GraspSolution
from handlcp.study.paper.data import source
from handlcp.study.paper.misses import Miss
from handlcp.study.paper.no_equilibrium import FORCE_BOUND, MOTION_BOUND, NoEquilibrium, no_equilibrium
from handlcp.study.paper.nsngrk_as_printed import CASES, RES, STEPS, Case, Run, run_case
from handlcp.study.paper.tables import Comparison, compare_all

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["PaperReport", "paper_command", "run"]


@dataclass(frozen=True, slots=True)
class PaperReport:
    """Ours beside Tables 1 to 10, Example 4 without an equilibrium, and NSNGRK as printed.

    seconds : what computing it took.
    """

    tables: tuple[Comparison, ...]
    example_4: NoEquilibrium
    nsngrk: tuple[Case, ...]
    seconds: float

    @property
    def ok(self) -> bool:
        """Whether every golden number is reproduced: Tables 1 and 2, the forces of Tables 3, 6 and 8."""
        return all(c.ok for c in self.tables)

    @property
    def verdicts(self) -> dict[int, str]:
        """Table number → its verdict in one sentence."""
        return {c.table.number: c.verdict for c in self.tables}

    def to_json(self) -> str:
        """Everything, SI units, printed numbers as text; NaN becomes null."""
        data = {
            "source": source(),
            "ok": self.ok,
            "seconds": self.seconds,
            "tables": {str(c.table.number): _table(c) for c in self.tables},
            "example_4": _example_4(self.example_4),
            "nsngrk_as_printed": [_case(c) for c in self.nsngrk],
        }
        return json.dumps(_plain(data), indent=1, ensure_ascii=False, allow_nan=False)


def run() -> PaperReport:
    """Compute the whole report; takes a few seconds."""
    start = time.perf_counter()
    tables = compare_all()
    cases = tuple(run_case(number, faces) for number, faces in CASES)
    return PaperReport(tables, no_equilibrium(), cases, time.perf_counter() - start)


def paper_command(json: bool = False, console: Console | None = None) -> int:
    """`handlcp paper`: print the report, or write it as JSON to the console's file. 0 if all golden numbers match."""
    from rich.console import Console

    from handlcp.study.paper.render import render

    console = Console() if console is None else console
    report = run()
    if json:
        console.file.write(report.to_json() + "\n")
    else:
        render(report, console)
    return 0 if report.ok else 1


def _table(c: Comparison) -> dict[str, Any]:
    return {
        "title": c.table.title,
        "golden": c.golden,
        "ok": c.ok,
        "level": c.level,
        "verdict": c.verdict,
        "remarks": c.remarks,
        "ours": _solution(c.solution) | {"what": c.ours},
        "rows": [
            {
                "column": r.column,
                "place": r.place,
                "printed": r.printed.text,
                "ours": r.ours,
                "difference": r.difference,
                "relative": r.relative,
                "mark": r.mark.name.lower(),
            }
            for r in c.rows
        ],
        "printed_forces_signed": None if c.evidence is None else c.evidence.signed.forces,
        "misses": [] if c.evidence is None else [_miss(m) for m in c.evidence.misses],
    }


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
    def runs(rs: tuple[Run, ...]) -> list[dict[str, Any]]:
        return [{"seed": r.seed, "steps": r.steps, "res": r.res, "normal_force": r.normal} for r in rs]

    return {
        "example": c.example,
        "faces": c.faces,
        "res": RES,
        "max_steps": STEPS,
        "as_printed": runs(c.printed),
        "natural_units": runs(c.natural),
        "ours": c.ours,
        "ours_steps": c.steps,
        "finger": c.finger + 1,
        "spread_as_printed": c.spread,
        "spread_natural_units": c.natural_spread,
    }


def _plain(x: Any) -> Any:
    """Arrays to lists, NaN to None."""
    if isinstance(x, dict):
        return {k: _plain(v) for k, v in x.items()}
    if isinstance(x, (list, tuple)):
        return [_plain(v) for v in x]
    if hasattr(x, "tolist"):
        return _plain(x.tolist())
    return None if isinstance(x, float) and not math.isfinite(x) else x
