"""The report for people: one table a paper table, in the paper's own layout, readable at 100 columns."""

from __future__ import annotations

import math

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from handlcp.study.paper.data import short, source
from handlcp.study.paper.no_equilibrium import FORCE_BOUND, MOTION_BOUND, PRELOAD_FACES, NoEquilibrium
from handlcp.study.paper.nsngrk_as_printed import RES, STEPS, Case
from handlcp.study.paper.report import PaperReport
from handlcp.study.paper.rows import Mark, Row
from handlcp.study.paper.tables import Comparison

__all__ = ["render"]

_STYLE = {
    Mark.DIGITS: "green",
    Mark.LAST: "green",
    Mark.RESIDUE: "green",
    Mark.NO: "red",
    Mark.LOOSE: "yellow",
    Mark.OTHER: "",
}
_LEVEL = {"reproduced": "bold green", "failed": "bold white on red", "not a solution": "bold red", "solution": "yellow"}
_HEAD = {"force": "force [N]", "fingertip": "fingertip [m]", "slip": "slip [m]", "object": "object [m, rad]"}


def render(report: PaperReport, console: Console) -> None:
    """Print the report."""
    console.print()
    console.print(Text("The paper, reproduced", style="bold"))
    console.print(Text(source(), style="dim"))
    console.print(Padding(_legend(), (1, 0, 0, 0)))
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
    console.print()
    _nsngrk(report.nsngrk, console)
    console.print()
    _summary(report, console)


def _legend() -> Text:
    t = Text("ours beside every printed number, magnitudes (the paper's text lost its minus signs): ")
    for mark, text in (
        (Mark.DIGITS, "every digit"),
        (Mark.LAST, "in the last digit"),
        (Mark.RESIDUE, "up to the paper's RES"),
    ):
        t.append(f"{mark.value} ", _STYLE[mark]).append(f"{text}  ")
    t.append("+4.2%", _STYLE[Mark.NO]).append(" differs by so much  ")
    t.append("~", _STYLE[Mark.LOOSE]).append(" left free by the equations, the smallest motion shown")
    return t


def _comparison(c: Comparison, console: Console) -> None:
    columns = [name for name in _HEAD if any(r.column == name for r in c.rows)]
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("", style="dim", no_wrap=True)
    for name in columns:
        if name == "object":
            table.add_column("", style="dim", no_wrap=True)
        table.add_column(_HEAD[name], justify="right", no_wrap=True)
        table.add_column("ours", justify="left", no_wrap=True)
    places = [r.place for r in c.rows if r.column == "force"]
    objects = [r for r in c.rows if r.column == "object"]
    by = {(r.column, r.place): r for r in c.rows}
    for k, place in enumerate(places):
        cells: list[str | Text] = [place]
        for name in columns:
            row = (objects[k] if k < len(objects) else None) if name == "object" else by.get((name, place))
            if name == "object":
                cells.append("" if row is None else row.place)
            cells += ["", ""] if row is None else [row.printed.text, _ours(row)]
        table.add_row(*cells)
    console.print()
    console.print(Text(c.table.title, style="bold"))
    console.print(table)
    console.print(Text(f"ours: {c.ours}, worst relative residual {short(c.solution.residuals.worst)}", style="dim"))
    _misses(c, console)
    console.print(Text("verdict: ").append(c.verdict, _LEVEL[c.level]))
    for remark in c.remarks:
        console.print(Padding(Text(f"· {remark}", style="yellow" if c.golden else ""), (0, 0, 0, 2)))


def _ours(row: Row) -> Text:
    value, mark = abs(row.ours), row.mark
    nothing = value < 1e-13 or (mark.fits and value < 1e-9 and row.printed.value < 1e-5)
    digits = "0" if nothing else f"{value:.5e}"
    mantissa, _, exponent = digits.partition("e")
    text = Text(f"{mantissa}e{int(exponent)}" if exponent else digits, _STYLE[mark])
    if mark.fits:
        return text.append(f" {mark.value}")
    if mark is Mark.LOOSE:
        return text.append(" ~")
    if mark is Mark.NO:
        return text.append(f" {_percent(row.relative)}")
    return text


def _percent(x: float) -> str:
    if not math.isfinite(x):
        return "≠0"
    return f"×{1 + x:.3g}" if x > 0.995 else f"{100 * x:+.0f}%" if abs(x) > 0.0995 else f"{100 * x:+.1f}%"


def _misses(c: Comparison, console: Console) -> None:
    if c.evidence is None:
        return
    table = Table(box=None, padding=(0, 1), pad_edge=False, show_header=False)
    for right in (False, False, True, True, False):
        table.add_column(justify="right" if right else "left")
    for m in c.evidence.misses:
        style = "green" if m.holds else "red"
        table.add_row(
            Text("✓" if m.holds else "✗", style),
            m.equation,
            Text(m.size, style),
            Text(m.percent, style),
            Text(m.comment, style="dim"),
        )
    console.print(
        Text("the printed numbers in the paper's equations (miss, share of the largest elastic motion):", style="dim")
    )
    console.print(table)


def _no_equilibrium(e: NoEquilibrium, console: Console) -> None:
    console.print()
    console.print(Text("Example 4 has no elastic equilibrium as printed", style="bold"))
    lines = [f"our default solver, 6 faces: {e.unloaded.status.name}, {len(e.unloaded.trace)} stages, none certified"]
    for E in dict.fromkeys(E for _, E, _ in e.searches):
        found = [(f, r) for f, E_, r in e.searches if E_ == E]
        none = all(r.none_exists for _, r in found)
        lines.append(
            f"all active sets at E_T = {short(E)} m/N, {', '.join(str(f) for f, _ in found)} faces "
            f"(up to 2^{max(r.pairs for _, r in found)}): {'no solution' if none else 'NOT excluded'}"
        )
    bounds = f"forces up to {FORCE_BOUND:g} N, slips and gaps up to {1e3 * MOTION_BOUND:g} mm"
    lines.append(f"  … with {bounds} (mixed-integer search)")
    normal = ", ".join(f"{x:.5g}" for x in e.preloaded.normal_force)
    lines.append(
        f"5 µm preload on fingers 1 and 2, {PRELOAD_FACES} faces: {e.preloaded.status.name}, "
        f"r_N = ({normal}) N, {', '.join(dict.fromkeys(e.preloaded.contact_state))}"
    )
    lines.append(f"  … the same search finds it, too: r_N = ({', '.join(f'{x:.5g}' for x in e.control_normal)}) N")
    lines.append(
        "so the cube can be held (these forces balance it within friction), but compliance alone cannot "
        "create the squeeze"
    )
    for line in lines:
        console.print(Padding(Text(line), (0, 0, 0, 2)))


def _nsngrk(cases: tuple[Case, ...], console: Console) -> None:
    console.rule("[bold]NSNGRK as printed[/]: why seeds disagree", align="left", style="dim")
    console.print(
        Text(
            f"As printed: newtons and metres as they come, stop at RES < {short(RES)} or {STEPS} steps. In "
            "Examples 2 to 5 every displacement is about 1e-5 m, so the rule stops before any compliance is seen. In "
            "natural units the same algorithm finds one answer."
        )
    )
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("example", no_wrap=True)
    table.add_column("", no_wrap=True)
    for name in ("as printed [N]", "spread", "off by", "steps", "natural [N]", "spread", "steps", "ours"):
        table.add_column(name, justify="right", no_wrap=True)
    for c in cases:
        low, high = c.range
        bad, apart = c.off > 1e-3, c.spread > 1e-3
        natural = [r.normal[c.finger] for r in c.natural]
        faces = "planar" if c.example == 1 else f"{c.faces} faces"
        table.add_row(
            f"{c.example}, {faces}",
            f"r_N{c.finger + 1}",
            Text(f"{low:.5f} … {high:.5f}", "red" if bad else "green"),
            Text(f"{100 * c.spread:.2g}%" if apart else f"{c.spread:.0e}", "red" if apart else "green"),
            Text(f"{100 * c.off:.2g}%" if bad else f"{c.off:.0e}", "red" if bad else "green"),
            f"{max(r.steps for r in c.printed)}",
            Text(f"{natural[0]:.5f}", "green"),
            Text(f"{c.natural_spread:.0e}", "green"),
            f"{max(r.steps for r in c.natural)}",
            f"{c.steps}",
        )
    console.print(table)
    for c in cases:
        if (c.example, c.faces) == (3, 8):
            seeds = ", ".join(f"{r.normal[c.finger]:.4f}" for r in c.printed)
            console.print(
                Text(
                    f"Example 3, 8 faces, r_N{c.finger + 1} seed by seed: {seeds} N, each with RES < "
                    f"{short(RES)}; Table 6 and ours: {c.ours[c.finger]:.6f} N, Table 7: 0.945155 N."
                )
            )
        if (c.example, c.faces) == (2, 16):
            console.print(
                Text(
                    f"Example 2, 16 faces: the seeds agree and are wrong together, {c.range[0]:.4f} N "
                    f"instead of {c.ours[c.finger]:.4f} N; Table 5 prints 5.4684 and 5.4573 N."
                )
            )
    console.print(
        Text(
            "spread: largest minus smallest over the seeds; off by: worst force error over the largest "
            "force; ours: the default solver's steps, ended by exact Newton steps.",
            style="dim",
        )
    )


def _summary(report: PaperReport, console: Console) -> None:
    console.rule("[bold]Verdicts[/]", align="left", style="dim")
    table = Table(box=None, padding=(0, 1), pad_edge=False, show_header=False)
    table.add_column(justify="right")
    table.add_column()
    table.add_column(overflow="fold")
    for c in report.tables:
        mark = {"reproduced": "✓", "solution": "·"}.get(c.level, "✗")
        style = _LEVEL[c.level]
        table.add_row(f"Table {c.table.number}", Text(mark, style), Text(c.verdict, style.replace("bold ", "")))
    console.print(table)
    golden = "all golden numbers reproduced" if report.ok else "GOLDEN NUMBERS MISSED"
    console.print()
    console.print(
        Text(golden, "bold green" if report.ok else "bold white on red").append(
            f" (Tables 1 and 2; forces of Tables 3, 6 and 8) in {report.seconds:.1f} s", "default"
        )
    )
