"""The command `handlcp paper`: the report for people, a table in the paper's own layout for each, or as JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console, JustifyMethod
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from handlcp.method.nsngrk import RES, STEPS
from handlcp.method.paper.data import raw, short
from handlcp.method.paper.misses import FORCE_BOUND, MOTION_BOUND, PRELOAD_FACES, Evidence, NoEquilibrium
from handlcp.method.paper.report import Case, PaperReport, run
from handlcp.method.paper.tables import Comparison, Mark, Row

_STYLE = {Mark.NO: "red", Mark.LOOSE: "yellow", Mark.OTHER: ""}  # the others fit: green
_LEVEL = {"reproduced": "bold green", "failed": "bold white on red", "not a solution": "bold red", "solution": "yellow"}
_SEEDS = (
    "example,\nfaces", "", "printed\nfrom [N]", "to [N]", "spread", "off by", "steps", "natural\n[N]", "spread",
    "steps", "ours",
)  # fmt: skip
_HEAD = {"force": "force [N]", "fingertip": "fingertip [m]", "slip": "slip [m]", "object": "object [m, rad]"}


def paper_command(console: Console, json: bool = False) -> int:
    """Print the report, or write it as JSON to the console's file. 0 if all golden numbers match."""
    report = run()
    if json:
        console.file.write(f"{report.to_json()}\n")
    else:
        render(report, console)
    return 0 if report.ok else 1


def render(report: PaperReport, console: Console) -> None:
    """Print it, readable at 80 columns."""
    console.print()
    console.print(Text("The paper, reproduced", style="bold"))
    console.print(Text(raw()["source"], style="dim"))
    console.print()
    console.print(_legend())
    shown = 0
    for c in report.tables:
        if c.example.number != shown:
            shown = c.example.number
            console.print()
            console.rule(f"[bold]Example {shown}[/]: {c.example.title}", align="left", style="dim")
            console.print(Text(c.example.note, style="dim"))
        _comparison(c, console)
        if c.table.number == 9:
            _no_equilibrium(report.example_4, console)
    _nsngrk(report.nsngrk, console)
    _summary(report, console)


def _legend() -> Text:
    t = Text("ours beside every printed number, magnitudes (the paper's text lost its minus signs): ")
    fits = {Mark.DIGITS: "every digit", Mark.LAST: "in the last digit", Mark.RESIDUE: "up to the paper's RES"}
    for mark, text in fits.items():
        t.append(f"{mark.value} ", "green").append(f"{text}  ")
    t.append("+4.2%", _STYLE[Mark.NO]).append(" differs by so much  ")
    t.append("~", _STYLE[Mark.LOOSE]).append(" left free by the equations, the smallest motion shown")
    return t


def _comparison(c: Comparison, console: Console) -> None:
    """One table of the paper, its misses and its verdict."""
    console.print()
    console.print(Text(c.table.title, style="bold"))
    motion = [r for r in c.rows if r.column == "object"]
    for rows in ([r for r in c.rows if r.column != "object"], motion):
        if rows:
            console.print(_numbers(rows))
    console.print(Text(f"ours: {c.ours}, worst relative residual {short(c.solution.residuals.worst)}", style="dim"))
    if c.evidence is not None:
        _misses(c.evidence, console)
    console.print(Text("verdict: ").append(c.verdict, _LEVEL[c.level]))
    for remark in c.remarks:
        console.print(Padding(Text(f"· {remark}", style="yellow" if c.golden else ""), (0, 0, 0, 2)))


def _numbers(rows: Sequence[Row]) -> Table:
    """Printed numbers and ours, side by side: what belongs to a finger, or the object's motion."""
    columns = [name for name in _HEAD if any(r.column == name for r in rows)]
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("", style="dim", no_wrap=True)
    for name in columns:
        table.add_column(Text(_HEAD[name]), justify="right", no_wrap=True)
        table.add_column("ours", justify="left", no_wrap=True)
    by = {(r.column, r.place): r for r in rows}
    for place in dict.fromkeys(r.place for r in rows):
        cells: list[str | Text] = [place]
        for name in columns:
            row = by.get((name, place))
            cells += ["", ""] if row is None else [row.printed.text, _ours(row)]
        table.add_row(*cells)
    return table


def _ours(row: Row) -> Text:
    """Our number with its mark, in the paper's format."""
    value, mark = abs(row.ours), row.mark
    nothing = value < 1e-13 or (mark.fits and value < 1e-9 and row.printed.value < 1e-5)
    mantissa, _, exponent = f"{value:.5e}".partition("e")
    number = "0" if nothing else f"{mantissa}e{int(exponent)}"
    signs = {Mark.OTHER: "", Mark.LOOSE: " ~", Mark.NO: f" {_percent(row.relative)}"}
    return Text(number + signs.get(mark, f" {mark.value}"), _STYLE.get(mark, "green"))


def _percent(x: float) -> str:
    if not math.isfinite(x):
        return "≠0"
    return f"×{1 + x:.3g}" if x > 0.995 else f"{100 * x:+.0f}%" if abs(x) > 0.0995 else f"{100 * x:+.1f}%"


def _misses(evidence: Evidence, console: Console) -> None:
    table = _grid("left", "left", "right", "right", "left")
    for m in evidence.misses:
        mark, style = ("✓", "green") if m.holds else ("✗", "red")
        sizes = Text(m.size, style), Text(m.percent, style)
        table.add_row(Text(mark, style), m.equation, *sizes, Text(m.comment, style="dim"))
    heading = "the printed numbers in the paper's equations (miss, share of the largest elastic motion):"
    console.print(Text(heading, style="dim"))
    console.print(table)


def _no_equilibrium(e: NoEquilibrium, console: Console) -> None:
    console.print()
    console.print(Text("Example 4 has no elastic equilibrium as printed", style="bold"))
    lines = [f"our default solver, 6 faces: {e.unloaded.status.name}, {len(e.unloaded.trace)} stages, none certified"]
    for E in dict.fromkeys(E for _, E, _ in e.searches):
        found = {faces: result for faces, value, result in e.searches if value == E}
        faces, pairs = ", ".join(map(str, found)), max(r.pairs for r in found.values())
        said = "no solution" if all(r.none_exists for r in found.values()) else "NOT excluded"
        lines.append(f"all active sets at E_T = {short(E)} m/N, {faces} faces (up to 2^{pairs}): {said}")
    bounds = f"forces up to {FORCE_BOUND:g} N, slips and gaps up to {1e3 * MOTION_BOUND:g} mm"
    lines.append(f"  … with {bounds} (mixed-integer search)")
    normal, control = (", ".join(f"{x:.5g}" for x in r_N) for r_N in (e.preloaded.normal_force, e.control_normal))
    preloaded = f"{e.preloaded.status.name}, r_N = ({normal}) N, {', '.join(dict.fromkeys(e.preloaded.contact_state))}"
    lines.append(f"5 µm preload on fingers 1 and 2, {PRELOAD_FACES} faces: {preloaded}")
    lines.append(f"  … the same search finds it, too: r_N = ({control}) N")
    cannot = "but compliance alone cannot create the squeeze"
    lines.append(f"so the cube can be held (these forces balance it within friction), {cannot}")
    for line in lines:
        console.print(Padding(Text(line), (0, 0, 0, 2)))


def _nsngrk(cases: tuple[Case, ...], console: Console) -> None:
    """Seeds of the algorithm as printed, beside natural units."""
    console.print()
    console.rule("[bold]NSNGRK as printed[/]: why seeds disagree", align="left", style="dim")
    console.print(Text(
        f"As printed: newtons and metres as they come, stop at RES < {short(RES)} or {STEPS} steps. In Examples 2 to 5 "
        "every displacement is about 1e-5 m, so the rule stops before any compliance is seen. In natural units the "
        "same algorithm finds one answer."
    ))  # fmt: skip
    table = Table(box=SIMPLE_HEAD, padding=0, pad_edge=False)  # eleven columns
    for k, name in enumerate(_SEEDS):
        table.add_column(name, justify="right" if k > 1 else "left", no_wrap=True)
    for c in cases:
        table.add_row(*_case(c))
    console.print(table)
    for c in cases:
        i, ours = c.finger, c.ours[c.finger]
        if (c.example, c.faces) == (3, 8):
            seeds = ", ".join(f"{r.normal[i]:.4f}" for r in c.printed)
            text = f"Example 3, 8 faces, r_N{i + 1} seed by seed: {seeds} N, each with RES < {short(RES)};"
            console.print(Text(f"{text} Table 6 and ours: {ours:.6f} N, Table 7: 0.945155 N."))
        if (c.example, c.faces) == (2, 16):
            text = f"Example 2, 16 faces: the seeds agree and are wrong together, {c.range[0]:.4f} N"
            console.print(Text(f"{text} instead of {ours:.4f} N; Table 5 prints 5.4684 and 5.4573 N."))
    text = "spread: largest minus smallest over the seeds; off by: worst force error over the largest force; "
    console.print(Text(f"{text}ours: the default solver's steps, ended by exact Newton steps.", style="dim"))


def _case(c: Case) -> list[str | Text]:
    """One row of the table of seeds."""

    def share(x: float) -> Text:
        return Text(f"{100 * x:.2g}%", "red") if x > 1e-3 else Text(f"{x:.0e}", "green")

    low, high = c.range
    return [
        f"{c.example}, {'planar' if c.example == 1 else c.faces}",
        f"r_N{c.finger + 1}",
        *(Text(f"{end:.5f}", "red" if c.off > 1e-3 else "green") for end in (low, high)),
        share(c.spread),
        share(c.off),
        f"{max(r.steps for r in c.printed)}",
        Text(f"{c.natural[0].normal[c.finger]:.5f}", "green"),
        Text(f"{c.natural_spread:.0e}", "green"),
        f"{max(r.steps for r in c.natural)}",
        f"{c.steps}",
    ]


def _summary(report: PaperReport, console: Console) -> None:
    console.print()
    console.rule("[bold]Verdicts[/]", align="left", style="dim")
    table = _grid("right", "left", "left")
    for c in report.tables:
        mark = {"reproduced": "✓", "solution": "·"}.get(c.level, "✗")
        style = _LEVEL[c.level]
        table.add_row(f"Table {c.table.number}", Text(mark, style), Text(c.verdict, style.replace("bold ", "")))
    console.print(table)
    console.print()
    said = ("all golden numbers reproduced", "bold green") if report.ok else ("GOLDEN NUMBERS MISSED", _LEVEL["failed"])
    which = f" (Tables 1 and 2; forces of Tables 3, 6 and 8) in {report.seconds:.1f} s"
    console.print(Text(*said).append(which, "default"))


def _grid(*sides: JustifyMethod) -> Table:
    """A table without lines and headings, its columns aligned to these sides."""
    table = Table(box=None, padding=(0, 1), pad_edge=False, show_header=False)
    for side in sides:
        table.add_column(justify=side, overflow="fold")
    return table
