"""The page of effects, written from the code: when to use each, how to ask for it, and what it costs, measured here.

Run it: `python examples/effects_page.py > handlcp/grasp/effects/README.md`, half a minute. A test keeps the page true.
`handlcp effects --measure` prints the same list in a terminal.
"""

from __future__ import annotations

import datetime
import os
import platform
import posixpath
import re
import sys
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from handlcp.studies.effect_catalogue import Cost, costs, entries

WHERE = PurePosixPath("handlcp/grasp/effects")  # the page's folder in the repository
THE_SCENE = ("object balance", "unilateral contact", "Coulomb friction")  # bring the reference scene's unknowns
TOP = """\
# Effects

What a grasp can be made of. The package's effects are in a few files, by what they act on; another may be a file of its
own. A scene without an effect has none of its unknowns and none of its rows. `grasp.explain()` says which of them a
scene has and why, `handlcp effects` prints this list. The page is written by `python examples/effects_page.py`; a test
keeps it true.

## Which one?

In the second column Python comes first, the keys of a scene file below. `joint_stiffness=` is an argument of the hand,
`mass=` of the object, `faces=` of `solve`, all others of `state.grasp` (`Grasp` takes most of them, too).

| effect, and when to use it | how to ask for it | unknowns | here | time |
| --- | --- | --- | ---: | ---: |
{rows}
**Here** and **time**: by how many unknowns the reference scene grows, and by what its time is multiplied. The scene is
a ball in five fingers with friction pyramids of 8 faces, {unknowns} unknowns in all; time is that of
`state.grasp(ball, …).solve()`, the best of many with the effect and without it in turns. Friction and finger
flexibility are in the scene from the start: theirs is the share that `explain(measure=True)` finds. Planar friction is
tried on two fingers in a plane, whatever has `faces="cone"` on the cone, soft fingers against points of contact. The
force bounds are reached there, the torque limits are not. –: every scene has it.

Measured on {measured}. Runs differ by a few percent; only the ratios carry over to other machines.

A contact with μ = 0, or `Frictionless()`, is no effect but the lack of one: it has no tangential unknowns at all.

## One by one

r are the contact forces in contact axes, normal part r_N, tangential part r_T; u the object's motion, w the load on it,
G the grasp matrix. ε = v = Gᵀu + E r + d is how far the object moves from a fingertip: ε_N the gap, ε_T the slip, d
what they are at the start. E is the flexibility of all contacts, J the Jacobian of the contact points, K the stiffness
of the joints, C its inverse, τ their torques. N holds the normals of a pyramid's faces, λ how far a contact slips
against each; z̄ and s are how far fingers and joints give way at their limits. 0 ≤ a ⟂ b ≥ 0: both are at least zero,
and one of them is zero. += is what an effect adds. Letters that only one effect has are explained in its file.

Ai & Li (2025) is [Sensors 25(7), 2309](https://doi.org/10.3390/s25072309), the paper this package started from.
"""


def page(costs: Mapping[str, Cost], measured: str) -> str:
    """The whole page. costs : by title. measured : when and where, such as `here_and_now`."""
    size = sum(costs[title].unknowns for title in THE_SCENE)
    rows = "".join(row(entry, costs[entry.title]) for entry in entries())
    return TOP.format(rows=rows, unknowns=size, measured=measured) + "".join(map(section, entries()))


def here_and_now() -> str:
    """Date and machine."""
    return f"{datetime.date.today().isoformat()} ({os.cpu_count()} cores, {platform.system()} {platform.machine()})"


def anchor(title: str) -> str:
    """GitHub's anchor of a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def row(entry: Any, cost: Cost) -> str:
    """A line of the table of effects."""
    ask = "<br>".join(f"`{code}`" for code in (entry.in_short, *entry.file_keys) if code) or "every grasp has it"
    name = f"**[{entry.title}](#{anchor(entry.title)})**<br>{entry.when}"
    return f"| {name} | {ask} | {entry.brings} | {cost.more} | {cost} |\n"


def section(entry: Any) -> str:
    """All that there is to say of an effect."""
    file = PurePosixPath(*entry.module.split(".")).with_suffix(".py")
    law = entry.equation.replace(",  ", "\n")
    ask = ""
    if entry.in_python:
        written = "<br>".join(f"`{line}`" for line in entry.in_file.splitlines())
        ask = f"- Python: `{entry.in_python}`\n- Scene file: {written}\n"
    return (
        f"\n### {entry.title}\n\n{entry.when}\n\n```\n{law}\n```\n\n{ask}- Unknowns: {entry.brings}\n"
        f"- Source: {entry.source}\n- Code: [{file.name}]({posixpath.relpath(file, WHERE)})\n"
    )


if __name__ == "__main__":
    sys.stdout.write(page(costs(), here_and_now()))
