"""Tables for the terminal: effects, contacts, joint torques, hands, scene keys. Readable from 80 columns on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from handlcp import words
from handlcp.grasp import Explanation, GraspSolution
from handlcp.grasp.analysis.explanation import Description, EffectLine
from handlcp.grasp.answer.printed import contact_columns
from handlcp.grasp.friction import Pyramid, limit_set
from handlcp.hand import Hand
from handlcp.text_table import TextTable

STATE = {"sticking": "green", "sliding": "yellow", "separated": "dim"}
BAR = 10  # cells of a full torque bar
SAVES = -0.02  # an effect with a share of the time below this saves time


def effect_table(explanation: Explanation) -> Table:
    """Which effects are on and off, why, and what each costs."""
    e = explanation
    solved = f"{e.unknowns} unknowns, of which the solver sees {e.size}" if e.eliminated else f"{e.unknowns} unknowns"
    if e.seconds is not None:
        solved += f"; {1e6 * e.seconds:.0f} µs from the numbers to a certified answer, started at the answer"
        if any((line.share or 0.0) <= SAVES for line in e.effects if line.on):
            solved += '; "saves": without it a solve takes longer'
    table = empty("Effects", solved)
    for heading in ("", "effect", "why"):
        table.add_column(heading, no_wrap=heading == "")
    numbers(table, "unknowns", *(["of time"] if e.seconds is not None else []))
    for line in e.effects:
        brings = "  ".join(f"{name} {count}" for name, count, _ in line.unknowns) or ("none" if line.on else "")
        mark = Text("on", style="green") if line.on else Text("–", style="dim")
        cells = [brings, _share(line)][: 1 if e.seconds is None else 2]
        table.add_row(mark, Text(line.title), Text(line.why), *cells, style=None if line.on else "dim")
    return table


def contact_table(solution: GraspSolution, title: str = "Contacts", note: str = "") -> Table:
    """Finger by finger, then the environment's contacts: state, forces, share of the friction limit, slip and gap.

    note : stands under the table, beside what pyramids in place of the friction cones do.
    """
    columns, notes = contact_columns(solution), [_limit_note(solution), note]
    table = _filled(columns, title, "; ".join(n for n in notes if n))
    for row, state in zip(columns.rows, solution.contact_state, strict=True):
        name, _, *values = row
        table.add_row(Text(name), Text(state, style=STATE.get(state, "dim")), *values)
    return table


def torque_table(check: Any, title: str = "Joint torques") -> Table:
    """Joint by joint, from a `TorqueCheck`."""
    table = _filled(check.table, title)
    for row, r in zip(check.table.rows, check, strict=True):
        finite = r.known and np.isfinite(r.limit)
        over = finite and r.over
        style = "bold red" if over else "bold" if row[-1] else None
        filled = round(min(r.utilisation, 1.0) * BAR) if finite else 0
        bar = Text("█" * filled + "·" * (BAR - filled) if finite else "", style="red" if over else "cyan")
        mark = Text(f" {row[-1]}" if row[-1] else "")
        table.add_row(Text(row[0]), *row[1:-1], bar + mark, style=style)
    return table


def _filled(columns: TextTable, title: str, note: str = "") -> Table:
    """The heads of a text table."""
    table = empty(title, note or None)
    for k, (head, way) in enumerate(zip(columns.heads, columns.align, strict=True)):
        if way == ">":
            numbers(table, head if "\n" in head else f"{head}\n")
        else:
            table.add_column(head, overflow="fold", no_wrap=k > 0)
    return table


def effort_table(effort: Any) -> Table:
    """Tendon by tendon, or actuator by actuator, from an `Effort`."""
    table = empty("Tendons" if effort.unit == "N" else "Actuators")
    who, what = effort.kind.split()[:2]
    table.add_column(who, overflow="fold")
    numbers(table, f"{what}\n{effort.unit}")
    for name, value in zip(effort.names, words.column(effort.values.tolist()), strict=True):
        table.add_row(Text(name), value)
    return table


def hand_table(hands: Mapping[str, Hand]) -> Table:
    """Hands to use, by name: joints, fingertips, torque limits."""
    table = empty("Hands")
    table.add_column("name", no_wrap=True)
    table.add_column("", no_wrap=True, style="dim")
    table.add_column("", overflow="fold")
    for name, hand in hands.items():
        joints, tips = hand.joint_names, hand.fingertips
        limits = ", ".join(f"{x:g}" for x in dict.fromkeys(hand.torque_limits.tolist()))
        table.add_row(Text(name, style="bold"), f"{len(joints)} joints", Text(", ".join(joints)))
        table.add_row("", f"{len(tips)} fingertips", Text(", ".join(tips)))
        table.add_row("", "torque limits", Text(f"{limits} N·m"))
        table.add_section()
    return table


def key_table(keys: Sequence[Any]) -> Table:
    """The keys of scene files, from `handlcp.scene.Key`s."""
    table = empty("Keys of a scene file")
    table.add_column("key", no_wrap=True)
    table.add_column("what it holds\nwhat it means", overflow="fold")
    last = ""
    for k in keys:
        if k.table != last:
            table.add_section()
            table.add_row(Text(f"[[{k.table}]]" if k.many else f"[{k.table}]", style="bold cyan"))
        last = k.table
        only = f" (shape {k.shape})" if k.shape else ""
        left_out = "; needed" if k.required else f"; left out: {k.default}" if k.default not in ("", '""') else ""
        name = Text(k.key, style="bold" if k.required else "")
        table.add_row(name, Text.assemble((f"{k.expected}\n", "cyan"), f"{k.meaning}{only}{left_out}"))
    return table


def catalogue_table(entries: Sequence[Description], costs: Mapping[str, Any] | None = None) -> Table:
    """All effects. costs : `handlcp.method.catalogue.Cost`s by title; None: not measured."""
    note = "here, time: unknowns more, and how many times as long, beside the reference scene without"
    table = empty("All effects", None if costs is None else note)
    table.add_column("effect\nunknowns", max_width=26)
    table.add_column("when to use it\nin Python; in a scene file", overflow="fold")
    if costs is not None:
        numbers(table, "here", "time")
    for e in entries:
        ask = [(f"\n{e.in_short}", "cyan"), (f"\n{', '.join(e.file_keys)}", "dim")] if e.in_python else []
        cells = [Text.assemble((e.title, "bold"), f"\n{e.brings}"), Text.assemble(e.when, *ask)]
        if costs is not None:
            cells += [Text(costs[e.title].more), Text(str(costs[e.title]))]
        table.add_row(*cells)
        table.add_section()
    return table


def empty(title: str, caption: str | None = None) -> Table:
    """A table in the style of all others, without columns."""
    style: dict[str, Any] = {"title_justify": "left", "title_style": "bold", "caption_justify": "left"}
    return Table(title=title, caption=caption, box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1), **style)


def numbers(table: Table, *headings: str) -> None:
    """Add columns of numbers: aligned on the right, never wrapped."""
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)


def _share(line: EffectLine) -> str:
    if not line.on:
        return ""
    if line.share is None:
        return "–"
    return f"{round(100 * max(line.share, 0.0))} %" if line.share > SAVES else "saves"


def _limit_note(solution: GraspSolution) -> str:
    """The share of the friction limit at which a contact in a pyramid may slide; "" without pyramids."""
    scene, section = solution.scene, solution.section
    if scene is None or not scene.frictional or not isinstance(section, Pyramid) or not section.inscribed:
        return ""
    if scene.soft:
        least = words.percent(min(section.share, limit_set(section, 3).share))
        return f"of limit: friction and moment within the limit surface; a contact slides from {least} on"
    least, who = words.percent(section.share), "contact" if scene.environment else "finger"
    return f"of limit: friction / (μ · normal); {section.faces} faces inside the cone let a {who} slide from {least} on"
