"""The page of all effects: the text of `page.md` around a table of effects, then a section on each."""

from __future__ import annotations

import datetime
import os
import platform
import posixpath
import re
from collections.abc import Mapping
from importlib import resources
from pathlib import PurePosixPath

from handlcp.grasp.analysis.explanation import Description
from handlcp.grasp.effects.coulomb_friction import CoulombFriction
from handlcp.grasp.effects.object_balance import ObjectBalance
from handlcp.grasp.effects.unilateral_contact import UnilateralContact
from handlcp.study.catalogue.cost import Cost
from handlcp.study.catalogue.effects import entries

_WHERE = PurePosixPath("handlcp/grasp/effects")  # the page's folder in the repository

# The effects that bring the reference scene's unknowns
_THE_SCENE = (ObjectBalance.title, UnilateralContact.title, CoulombFriction.title)


def page(costs: Mapping[str, Cost], measured: str) -> str:
    """The whole page. costs : by title. measured : when and where, such as `here_and_now`."""
    text = resources.files(__package__).joinpath("page.md").read_text(encoding="utf-8")
    size = sum(costs[title].unknowns for title in _THE_SCENE)
    rows = "".join(_row(e, costs[e.title]) for e in entries())
    return text.format(rows=rows, unknowns=size, measured=measured) + "".join(map(_section, entries()))


def here_and_now() -> str:
    """Date and machine."""
    return f"{datetime.date.today().isoformat()} ({os.cpu_count()} cores, {platform.system()} {platform.machine()})"


def anchor(title: str) -> str:
    """GitHub's anchor of a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def _row(entry: Description, cost: Cost) -> str:
    """A line of the table of effects."""
    ask = "<br>".join(f"`{code}`" for code in (entry.in_short, *entry.file_keys) if code) or "every grasp has it"
    name = f"**[{entry.title}](#{anchor(entry.title)})**<br>{entry.when}"
    return f"| {name} | {ask} | {entry.brings} | {cost.more} | {cost} |\n"


def _section(entry: Description) -> str:
    file = PurePosixPath(*entry.module.split(".")).with_suffix(".py")
    law = entry.equation.replace(",  ", "\n")
    ask = ""
    if entry.in_python:
        written = "<br>".join(f"`{line}`" for line in entry.in_file.splitlines())
        ask = f"- Python: `{entry.in_python}`\n- Scene file: {written}\n"
    return (
        f"\n### {entry.title}\n\n{entry.when}\n\n```\n{law}\n```\n\n{ask}- Unknowns: {entry.brings}\n"
        f"- Source: {entry.source}\n- Code: [{file.name}]({posixpath.relpath(file, _WHERE)})\n"
    )
