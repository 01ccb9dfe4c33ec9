"""A study of accuracy and cost as tables for the terminal. Readable from 80 columns on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich.table import Table
from rich.text import Text

from handlcp.studies.accuracy.cost import UNDETERMINED
from handlcp.studies.accuracy.methods import ROUNDING, microseconds, share
from handlcp.studies.accuracy.result import CERTIFIED, NOT_RUN, AccuracyCost, LeftOut, Row
from handlcp.viz.terminal_table import make_table

ERRORS = (1e-1, 1e-2, 1e-3, 1e-6, 1e-9)
TIMED = ("grasp.solve()", "NSNGRK polished", "Newton", "Lemke")
STYLE = {CERTIFIED: "green", NOT_RUN: "dim"}
HEADINGS = ("force\nerror", "slip\nerror", "torque\nerror")


def all_tables(cost: AccuracyCost) -> Sequence[Table]:
    """The tables for which the study has numbers."""
    found = (method_table(cost), price_table(cost), face_table(cost), left_out_table(cost))
    return [t for t in found if t is not None]


def price_table(cost: AccuracyCost) -> Table:
    """What each accuracy costs with each method: the time of the fastest setting that reaches it."""
    heads = "method", *map(share, ERRORS)
    rows = [(method, *(_time(cost.cheapest(error, method)) for error in ERRORS)) for method in cost.methods]
    note = "–: no setting of this method came so near"
    return make_table("Time for a force error of at most", heads, "|" + ">" * len(ERRORS), rows, note)


def method_table(cost: AccuracyCost) -> Table:
    """Each method at 8 faces, or the number nearest to it, with the tightest tolerance that it solved."""
    faces = {r.faces for r in cost.rows if r.faces is not None}
    near = min(faces, key=lambda m: (abs(m - 8), m), default=None)
    what = f"Methods at {near} faces, or on the exact cone" if near else "Methods, friction exact"
    rows = list[tuple[str | Text, ...]]()
    for method in cost.methods:
        at = [r for r in cost.of(method) if r.section == "exact" or r.faces == near]
        row = _tightest([r for r in at if r.section != "circumscribed"] or at)
        if row is not None:
            steps = "–" if row.iterations is None else str(row.iterations)
            status = Text(row.status, style=STYLE.get(row.status, "yellow"))
            rows.append((method, _time(row), _spread(row), *_errors(row), steps, status))
    note = "time: median ± half the interquartile range; errors against the certified exact answer"
    made = make_table(what, ("method", "time", "±", *HEADINGS, "steps", "status"), "|>>>>>><", rows, note)
    made.columns[-1].min_width = 9
    return made


def face_table(cost: AccuracyCost) -> Table | None:
    """What the number of faces does to error and time; None for a scene without pyramids."""
    inside, outside = dict(cost.pyramids("inscribed")), dict(cost.pyramids("circumscribed"))
    sides = sorted({r.faces for r in cost.rows if r.faces is not None})
    if not sides:
        return None
    law = cost.law()
    words = f"fitted: error ∝ 1/m^{law.exponent:.1f} (inscribed)" if law else ""
    if law is None and max([*inside.values(), *outside.values()], default=1.0) < ROUNDING:
        words = "faces make no difference here: each pyramid is as exact as the cone"
    timed = [m for m in TIMED if m in cost.methods]
    heads = ["faces", "inscribed\nforce error", "circumscr.\nforce error"]
    heads += [f"{method}\ntime".replace("NSNGRK polished", "NSNGRK") for method in timed]
    rows = []
    for m in sides:
        own = [r for r in cost.rows if r.faces == m and r.section == "inscribed"]
        times = (_time(_tightest(r for r in own if r.method == method)) for method in timed)
        rows.append((str(m), _share(inside.get(m)), _share(outside.get(m)), *times))
    return make_table("Faces of the friction pyramid", heads, ">" * len(heads), rows, words)


def left_out_table(cost: AccuracyCost) -> Table | None:
    """What goes wrong without each effect; None where that was not asked for."""
    if not cost.left_out:
        return None
    rows = list[tuple[str | Text, ...]]()
    for e in cost.left_out:
        note = "" if e.status == CERTIFIED else "not unique" if e.status == UNDETERMINED else e.status
        rows.append((e.effect, Text(e.instead, style="dim"), *_errors(e), Text(note, style="yellow")))
    return make_table("An effect left out", ("effect", "instead", *HEADINGS, ""), "<<>>><", rows)


def _tightest(rows: Iterable[Row]) -> Row | None:
    """The first row when sorted: certified before others, then by tolerance, then by force error."""
    return min(rows, key=lambda r: (r.status != CERTIFIED, r.tolerance or 0.0, r.cost[1]), default=None)


def _time(row: Row | None) -> str:
    return "–" if row is None or row.seconds is None else microseconds(row.seconds)


def _spread(row: Row) -> str:
    if row.seconds is None or row.seconds_low is None or row.seconds_high is None or row.runs < 2:
        return "–"
    return f"{50 * (row.seconds_high - row.seconds_low) / row.seconds:.0f} %"


def _errors(row: Row | LeftOut) -> list[str]:
    """Force, slip and torque error, as in `HEADINGS`."""
    return [_share(e) for e in (row.force_error, row.slip_error, row.torque_error)]


def _share(error: float | None) -> str:
    return "–" if error is None else share(error)
