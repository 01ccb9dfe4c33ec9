"""The README names everything that is public."""

from __future__ import annotations

import pathlib
import re

import handlcp as hl

README = (pathlib.Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def test_every_public_name_is_in_the_readmes_table_of_names_and_no_other():
    table = README.partition("\n## Names\n")[2].partition("\n## ")[0]
    named = {n for line in table.splitlines() if line.startswith("|") for n in re.findall(r"`(\w+)`", line)}
    assert named == set(hl.__all__)
