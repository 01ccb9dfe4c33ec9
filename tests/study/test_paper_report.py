"""The command: every printed number within 80 columns, strict JSON, and 0 only when the golden numbers match."""

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from handlcp.cli import app
from handlcp.studies.paper import Mark, run
from tests.support import patches


@pytest.fixture(scope="module")
def report():
    return run()


def test_every_table_is_printed_with_every_printed_number_and_ours(report):
    out = str(report)
    assert max(map(len, out.splitlines())) <= 80
    for c in report.tables:
        assert str(c) in out
        for row in c.rows:
            place = [row.column, *row.place.split()]
            (line,) = [found for line in str(c).splitlines() if (found := line.split())[: len(place)] == place]
            assert line[len(place)] == row.printed.text
            assert float(line[len(place) + 1]) == pytest.approx(abs(row.ours), rel=1e-5, abs=1e-13)
    assert out.count("verdict: ") == 10
    assert "Example 4 as printed, without preload:" in out


def test_the_record_is_complete(report):
    data = json.loads(report.to_json())
    assert data["ok"] is True
    assert list(data["tables"]) == [str(k) for k in range(1, 11)]
    assert all(t["verdict"] and t["rows"] for t in data["tables"].values())
    assert data["example_4"]["without_preload"] in ("UNDECIDED", "NO_EQUILIBRIUM"), "held by friction"
    force = data["tables"]["4"]["rows"][0]
    assert force["difference"] == pytest.approx(abs(force["ours"]) - float(force["printed"]))
    assert force["mark"] == "no"
    assert {m["unit"] for m in data["tables"]["4"]["misses"]} == {"N", "m"}


def test_the_exit_status_is_0_only_where_every_golden_number_is_reproduced(report, monkeypatch):
    patches.paper_report(monkeypatch, lambda: report)
    done = CliRunner().invoke(app, ["paper", "--json"])
    assert done.exit_code == 0
    assert json.loads(done.stdout)["ok"] is True
    golden, *others = report.tables
    row = golden.rows[1]
    spoiled = replace(golden, rows=(golden.rows[0], replace(row, mark=Mark.NO), *golden.rows[2:]))
    assert spoiled.level == "failed"
    assert spoiled.verdict.endswith(f"{row.column} {row.place}")
    patches.paper_report(monkeypatch, lambda: replace(report, tables=(spoiled, *others)))
    done = CliRunner().invoke(app, ["paper"])
    assert done.exit_code == 1
    assert spoiled.verdict in done.stdout


@pytest.mark.bench
def test_fast_enough(report):
    assert report.seconds < 20
