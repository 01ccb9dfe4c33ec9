"""The stability measure as a table, its totals, and every scene that stands out by name."""

from __future__ import annotations

import os
import platform
import subprocess
from collections import Counter
from collections.abc import Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

import handlcp as hl
from tests.benchmarks.corpus import Faces
from tests.benchmarks.stability import Record

__all__ = ["conditions", "opened", "plain_table", "print_stability", "totals"]

OURS = (
    ("solved", "solved"),
    ("no equilibrium", "no equi-\nlibrium"),
    ("not holdable", "not\nholdable"),
    ("undecided", "un-\ndecided"),
)
MEASURES = ("solved", "loose", "wrong", "undecided though solvable", '"no" without proof', "undecided")


def opened(width: int) -> Console:
    """The console, of this width where it is no terminal that has its own."""
    console = Console()
    return console if console.is_terminal else Console(width=width)


def conditions() -> str:
    """What the numbers hold for. Searches with a time budget get further on an idle machine."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    load = os.getloadavg()[0]
    where = f"{platform.machine()}, {os.cpu_count()} processors, load {load:.1f} at the start"
    return f"handlcp {hl.__version__} {commit.stdout.strip()}, Python {platform.python_version()}, {where}"


def plain_table(title: str, *headings: str, caption: str | None = None) -> Table:
    """The first column to the left, numbers to the right."""
    table = Table(
        title=title, title_justify="left", title_style="bold", caption=caption, caption_justify="left",
        box=box.SIMPLE_HEAD, pad_edge=False, collapse_padding=True, padding=(0, 1),
    )  # fmt: skip
    for k, heading in enumerate(headings):
        table.add_column(heading, justify="right" if k else "left", no_wrap=True)
    return table


def totals(records: Sequence[Record]) -> dict[str, int]:
    """The counts that the issue asks for. wrong: answers and refuted "no"s."""
    values = (
        sum(r.outcome == "solved" for r in records),
        sum(r.outcome == "loose" for r in records),
        sum(r.wrong for r in records),
        sum(r.missed for r in records),
        sum(r.unproven for r in records),
        sum(r.outcome == "undecided" for r in records),
    )
    return dict(zip(MEASURES, values, strict=True))


def stability_table(records: Sequence[Record]) -> Table:
    """Families by row in a section for each number of faces; ours first, then the oracle and the peers."""
    peers = list(dict.fromkeys(p for r in records for p in r.peers))
    table = plain_table(
        "Stability on the peers' corpus",
        "family", "scenes", *(heading for _, heading in OURS), "loose", "wrong", "missed", "oracle\nyes/no/?",
        *(p.replace("-", "\n") for p in peers),
        caption="missed: undecided though the oracle or a peer has an answer. wrong: a wrong answer, or a “no” where "
        "they have one. Peers: solved, and claimed though the checker finds them loose (l) or wrong (w). –: not asked.",
    )  # fmt: skip
    for faces in dict.fromkeys(r.faces for r in records):
        table.add_section()
        table.add_row(f"{faces} faces" if faces != "cone" else "exact cone", style="bold cyan")
        here = [r for r in records if r.faces == faces]
        for family in dict.fromkeys(r.family for r in here):
            _row(table, family, [r for r in here if r.family == family], peers)
        _row(table, "all", here, peers, style="bold")
    return table


def _row(table: Table, name: str, records: Sequence[Record], peers: Sequence[str], **style: Any) -> None:
    said = Counter(r.outcome for r in records)
    count = totals(records)
    ours = [str(said[key]) for key, _ in OURS] + [str(count["loose"]), str(count["wrong"]), str(count[MEASURES[3]])]
    verdicts = Counter(r.oracle for r in records if r.oracle is not None)
    oracle = "/".join(str(verdicts[v]) for v in ("solvable", "none", "unknown")) if verdicts else "–"
    table.add_row(name, str(len(records)), *ours, oracle, *(_peer(records, p) for p in peers), **style)


def _peer(records: Sequence[Record], peer: str) -> str:
    said = Counter(r.peers[peer] for r in records if peer in r.peers)
    if not said:
        return "–"
    more = "".join(f" +{said[v]}{v[0]}" for v in ("loose", "wrong", "died") if said[v])
    return f"{said['solved']}{more}"


def print_stability(console: Console, records: Sequence[Record]) -> None:
    """Table, totals, and the scenes behind them."""
    console.print(stability_table(records))
    sections: list[Faces] = list(dict.fromkeys(r.faces for r in records))
    table = plain_table("Totals", "measure", *map(str, sections), "all", "limit")
    by_section = [totals([r for r in records if r.faces == f]) for f in sections]
    for name, total in totals(records).items():
        limit = "0" if name in MEASURES[2:5] else ""
        met = "" if not limit else " met" if total == 0 else f" missed by {total}"
        table.add_row(name, *(str(t[name]) for t in by_section), str(total), limit + met)
    console.print(table)
    for heading, chosen in (
        ("wrong", [r for r in records if r.wrong]),
        ("loose", [r for r in records if r.outcome == "loose"]),
        ("undecided though solvable", [r for r in records if r.missed]),
        ('"no" without proof', [r for r in records if r.unproven]),
    ):
        if chosen:
            console.print(f"[bold]{heading}[/bold]")
            for record in chosen:
                console.print(f"  {record}", highlight=False, markup=False)
    for faces in sections:
        names = [r.name for r in records if r.faces == faces and r.outcome == "undecided" and not r.missed]
        if names:
            console.print(f"[bold]undecided, and nobody else has an answer, {faces}:[/bold] {', '.join(names)}")
