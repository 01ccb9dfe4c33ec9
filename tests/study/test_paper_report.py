"""The command: renders within 100 columns, writes strict JSON, and exits 0 only when the golden numbers match."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from io import StringIO

import pytest
from rich.console import Console

from handlcp.method.paper import PaperReport, paper_command, run
from tests.support import patches
from tests.support.study import Mark, render
from tests.support.texts import says


@pytest.fixture(scope="module")
def report() -> PaperReport:
    return run()


def wide(width: int = 100) -> Console:
    return Console(file=StringIO(), width=width, color_system=None)


def text(console: Console) -> str:
    assert isinstance(console.file, StringIO)
    return console.file.getvalue()


def closing(out: str) -> str:
    """The last paragraph, without the time it took."""
    return " ".join(out.rstrip().split("\n\n")[-1].split()).rpartition(" in ")[0]


def test_every_table_is_rendered_with_every_printed_number(report: PaperReport) -> None:
    console = wide()
    render(report, console)
    out = text(console)
    assert max(map(len, out.splitlines())) <= 100
    assert "…   " not in out, "no column is cut off"
    for c in report.tables:
        assert c.table.title in out
        block = out.split(c.table.title)[1].split("verdict:")[0]
        for row in c.rows:
            assert row.printed.text in block
    assert len(re.findall(r"^verdict: ", out, re.MULTILINE)) == 10
    says(closing(out), "reproduced")


def test_no_digit_is_lost_at_80_columns(report: PaperReport) -> None:
    """Words and numbers, without rules, are those of a screen without end."""
    narrow, roomy = wide(80), wide(1000)
    for console in (narrow, roomy):
        render(report, console)
    found = [Counter(w for w in text(c).split() if set(w) != {"─"}) for c in (narrow, roomy)]
    assert found[0] == found[1]
    assert max(map(len, text(narrow).splitlines())) <= 80


def test_the_record_is_complete(report: PaperReport) -> None:
    data = report.to_dict()
    assert data["ok"] is True
    assert list(data["tables"]) == [str(k) for k in range(1, 11)]
    assert all(t["verdict"] and t["rows"] for t in data["tables"].values())
    assert data["example_4"]["proved"] is True
    assert len(data["nsngrk_as_printed"][0]["as_printed"]) >= 5


def test_exit_codes(report: PaperReport, monkeypatch: pytest.MonkeyPatch) -> None:
    patches.paper_report(monkeypatch, lambda: report)
    console = wide()
    assert paper_command(json=True, console=console) == 0
    assert json.loads(text(console))["ok"] is True
    golden, *others = report.tables
    row = golden.rows[1]
    spoiled = replace(golden, rows=(golden.rows[0], replace(row, mark=Mark.NO), *golden.rows[2:]))
    patches.paper_report(monkeypatch, lambda: replace(report, tables=(spoiled, *others)))
    console = wide()
    assert paper_command(console=console) == 1
    out = text(console)
    says(closing(out), "NUMBERS")
    says(spoiled.verdict, f"{row.column}s {row.place}")
    assert all(word in out for word in spoiled.verdict.split())


@pytest.mark.bench
def test_fast_enough(report: PaperReport) -> None:
    assert report.seconds < 20
