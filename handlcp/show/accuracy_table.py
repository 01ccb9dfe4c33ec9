"""A study of accuracy and cost in the terminal. Readable from 80 columns on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from rich.table import Table
from rich.text import Text

from handlcp.show.tables import plain
from handlcp.study.accuracy.left_out import UNDETERMINED
from handlcp.study.accuracy.result import CERTIFIED, NOT_RUN, AccuracyCost, Row
from handlcp.study.accuracy.words import ROUNDING, microseconds, share

__all__ = ["all_tables", "face_table", "left_out_table", "method_table", "price_table"]

ERRORS = (1e-1, 1e-2, 1e-3, 1e-6, 1e-9)
TIMED = ("grasp.solve()", "NSNGRK polished", "Newton", "Lemke")
STYLE = {CERTIFIED: "green", NOT_RUN: "dim"}


def all_tables(cost: AccuracyCost) -> Sequence[Table]:
    """Those that the study has something for."""
    found = (method_table(cost), price_table(cost), face_table(cost), left_out_table(cost))
    return [t for t in found if t is not None]


def price_table(cost: AccuracyCost) -> Table:
    """What each accuracy costs with each method: the fastest of its settings that reaches it."""
    table = plain("Time for a force error of at most", "–: no setting of this method came so near")
    table.add_column("method", no_wrap=True)
    for error in ERRORS:
        table.add_column(share(error), justify="right", no_wrap=True)
    for method in cost.methods:
        cheapest = [cost.cheapest(error, method) for error in ERRORS]
        table.add_row(method, *(_time(r) for r in cheapest))
    return table


def method_table(cost: AccuracyCost) -> Table:
    """Each method at 8 faces, or the number nearest to it, with the tightest tolerance that it solved."""
    faces = {r.faces for r in cost.rows if r.faces is not None}
    near = min(faces, key=lambda m: (abs(m - 8), m), default=None)
    what = f"Methods at {near} faces, or on the exact cone" if near else "Methods, friction exact"
    table = plain(what, "time: median ± half the interquartile range; errors against the certified exact answer")
    table.add_column("method", no_wrap=True)
    for heading in ("time", "±", "force\nerror", "slip\nerror", "torque\nerror", "steps"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("status", min_width=9)
    for method in cost.methods:
        at = [r for r in cost.of(method) if r.section == "exact" or r.faces == near]
        at = [r for r in at if r.section != "circumscribed"] or at
        row = min(at, key=_tightest, default=None)
        if row is not None:
            errors = (_share(e) for e in (row.force_error, row.slip_error, row.torque_error))
            steps = "–" if row.iterations is None else str(row.iterations)
            table.add_row(
                method,
                _time(row),
                _spread(row),
                *errors,
                steps,
                Text(row.status, style=STYLE.get(row.status, "yellow")),
            )
    return table


def face_table(cost: AccuracyCost) -> Table | None:
    """What the number of faces does to error and time; None for a scene without pyramids."""
    inside, outside = dict(cost.pyramids("inscribed")), dict(cost.pyramids("circumscribed"))
    sides = sorted({r.faces for r in cost.rows if r.faces is not None})
    if not sides:
        return None
    law = cost.law()
    words = f"fitted: error ∝ 1/m^{law.exponent:.1f} (inscribed)" if law else None
    if law is None and max([*inside.values(), *outside.values()], default=1.0) < ROUNDING:
        words = "faces make no difference here: each pyramid is as exact as the cone"
    table = plain("Faces of the friction pyramid", words)
    table.add_column("faces", justify="right", no_wrap=True)
    for heading in ("inscribed\nforce error", "circumscr.\nforce error"):
        table.add_column(heading, justify="right", no_wrap=True)
    timed = [m for m in TIMED if m in cost.methods]
    for method in timed:
        table.add_column(f"{method}\ntime".replace("NSNGRK polished", "NSNGRK"), justify="right", no_wrap=True)
    for m in sides:
        times = (_time(min(_inscribed(cost, method, m), key=_tightest, default=None)) for method in timed)
        table.add_row(str(m), _share(inside.get(m)), _share(outside.get(m)), *times)
    return table


def left_out_table(cost: AccuracyCost) -> Table | None:
    """What goes wrong without each effect; None where that was not asked for."""
    if not cost.left_out:
        return None
    table = plain("An effect left out")
    table.add_column("effect", overflow="fold")
    table.add_column("instead", overflow="fold", style="dim")
    for heading in ("force\nerror", "slip\nerror", "torque\nerror"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("", overflow="fold")
    for e in cost.left_out:
        note = "" if e.status == CERTIFIED else "not unique" if e.status == UNDETERMINED else e.status
        errors = (_share(x) for x in (e.force_error, e.slip_error, e.torque_error))
        table.add_row(e.effect, e.instead, *errors, Text(note, style="yellow"))
    return table


def _inscribed(cost: AccuracyCost, method: str, faces: int) -> Iterable[Row]:
    return (r for r in cost.of(method) if r.faces == faces and r.section == "inscribed")


def _tightest(r: Row) -> tuple[bool, float, float]:
    """Certified rows first, then tight tolerances, then those with less error."""
    error = np.inf if r.force_error is None else r.force_error
    return r.status != CERTIFIED, r.tolerance or 0.0, error


def _time(row: Row | None) -> str:
    return "–" if row is None or row.seconds is None else microseconds(row.seconds)


def _spread(row: Row) -> str:
    if row.seconds is None or row.seconds_low is None or row.seconds_high is None or row.runs < 2:
        return "–"
    return f"{50 * (row.seconds_high - row.seconds_low) / row.seconds:.0f} %"


def _share(error: float | None) -> str:
    return "–" if error is None else share(error)
