"""The README names everything that is public, and every effect."""

from __future__ import annotations

import pathlib
import re

import handlcp as hl
from handlcp.study.catalogue import entries

README = (pathlib.Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def test_every_public_name_is_in_the_readmes_table_of_names_and_no_other():
    table = README.partition("\n## Names\n")[2].partition("\n## ")[0]
    named = {n for line in table.splitlines() if line.startswith("|") for n in re.findall(r"`(\w+)`", line)}
    assert named == set(hl.__all__)


def test_the_readmes_table_of_what_is_modelled_has_the_effects_of_the_catalogue_and_their_unknowns():
    part = README.partition("\n## What is modelled\n")[2].partition("\n## ")[0]
    assert "](handlcp/grasp/effects/README.md)" in part
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in part.splitlines() if line.startswith("|")][2:]
    for (effect, asked, unknowns), entry in zip(rows, entries(), strict=True):
        assert re.match(rf"{re.escape(entry.title)}\b", effect)
        assert unknowns == entry.brings
        for name in re.findall(r"^\w+(?==)|[A-Z]\w+(?=\()", entry.in_python):
            assert name in asked, f"{entry.title}: {name}"
