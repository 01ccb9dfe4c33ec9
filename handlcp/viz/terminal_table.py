"""`make_table`: tables for the terminal, readable from 80 columns on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from handlcp import words
from handlcp.contact.friction import Pyramid, limit_set
from handlcp.grasp import Explanation, GraspSolution
from handlcp.grasp.analysis.explanation import EffectDescription
from handlcp.grasp.failure.failure_mode import is_exceeded
from handlcp.grasp.model.status import SLIDING, STICKING, contact_statuses
from handlcp.grasp.solution.solution import contact_text_table
from handlcp.hand import Hand
from handlcp.words import TextTable

STATUS_STYLES = {STICKING: "green", SLIDING: "yellow"}  # the rest is dim
BAR_CELLS = 10  # cells of a full torque bar
SAVING_SHARE = -0.02  # an effect with a share of the time below this saves time


def effect_table(explanation: Explanation) -> Table:
    """Which effects are on and off, why, and what each costs."""
    e = explanation
    solved = f"{e.unknowns} unknowns, of which the solver sees {e.size}" if e.eliminated else f"{e.unknowns} unknowns"
    if e.seconds is not None:
        solved += f"; {1e6 * e.seconds:.0f} µs from the numbers to a certified answer, started at the answer"
        if any((line.share or 0.0) <= SAVING_SHARE for line in e.effects if line.on):
            solved += '; "saves": without it a solve takes longer'
    solved = "; ".join([solved, *e.notes])
    heads = ("", "effect", "why", "unknowns", *(() if e.seconds is None else ("of time",)))
    made = make_table("Effects", heads, "|<<>>"[: len(heads)], note=solved)
    for line in e.effects:
        brings = "  ".join(f"{name} {count}" for name, count, _ in line.unknowns) or ("none" if line.on else "")
        mark = Text("on", style="green") if line.on else Text("–", style="dim")
        share = "" if not line.on else "–"
        if line.on and line.share is not None:
            share = f"{round(100 * max(line.share, 0.0))} %" if line.share > SAVING_SHARE else "saves"
        cells = [brings] if e.seconds is None else [brings, share]
        why = Text(f"{line.why}{f' ({line.answers})' if line.answers and line.on else ''}")
        made.add_row(mark, Text(line.title), why, *cells, style=None if line.on else "dim")
    return made


def contact_table(solution: GraspSolution, title: str = "Contacts", note: str = "") -> Table:
    """Finger by finger, then the environment's contacts: state, forces, share of the friction limit, slip and gap.

    note : stands under the table, beside what pyramids in place of the friction cones do.
    """
    columns, notes = contact_text_table(solution), [_pyramid_note(solution), note]
    made = _table_with_heads(columns, title, "; ".join(n for n in notes if n))
    for (name, word, *values), status in zip(columns.rows, contact_statuses(solution.contact_state), strict=True):
        made.add_row(Text(name), Text(word, style=STATUS_STYLES.get(status, "dim")), *values)
    return made


def torque_table(check: Any, title: str = "Joint torques") -> Table:
    """The torque of each joint beside its limit, from a `TorqueCheck`."""
    made = _table_with_heads(check.table, title)
    for row, r in zip(check.table.rows, check, strict=True):
        finite = r.known and np.isfinite(r.limit)
        over = finite and r.over
        style = "bold red" if over else "bold" if row[-1] else None
        filled = round(min(r.utilisation, 1.0) * BAR_CELLS) if finite else 0
        bar = Text("█" * filled + "·" * (BAR_CELLS - filled) if finite else "", style="red" if over else "cyan")
        mark = Text(f" {row[-1]}" if row[-1] else "")
        made.add_row(Text(row[0]), *row[1:-1], bar + mark, style=style)
    return made


def _table_with_heads(columns: TextTable, title: str, note: str = "") -> Table:
    """A table with the heads of a text table, and no rows yet."""
    ways = columns.align[0] + columns.align[1:].replace("<", "|")
    heads = [head if way != ">" or "\n" in head else f"{head}\n" for head, way in zip(columns.heads, ways, strict=True)]
    return make_table(title, heads, ways, note=note)


def effort_table(effort: Any) -> Table:
    """The force of each tendon, or the effort of each actuator, beside its limit, from an `Effort`."""
    columns, (who, what) = effort.table, effort.kind.split()[:2]
    heads = (who, f"{what}\n{effort.unit}", *columns.heads[2:])
    made = _table_with_heads(replace(columns, heads=heads), "Tendons" if effort.unit == "N" else "Actuators")
    for row, used in zip(columns.rows, effort.used.tolist(), strict=True):
        made.add_row(Text(row[0]), *row[1:], style="bold red" if is_exceeded(used) else None)
    return made


def hand_table(hands: Mapping[str, Hand]) -> Table:
    """Hands to use, by name: joints, fingertips, torque limits."""
    made = make_table("Hands", ("name", "", ""), "||<")
    made.columns[1].style = "dim"
    for name, hand in hands.items():
        joints, tips = hand.joint_names, hand.fingertips
        limits = ", ".join(f"{x:g}" for x in dict.fromkeys(hand.torque_limits.tolist()))
        unit = words.unit_of_joints(words.effort_unit, [name in hand.sliding for name in joints])
        made.add_row(Text(name, style="bold"), f"{len(joints)} joints", Text(", ".join(joints)))
        made.add_row("", f"{len(tips)} fingertips", Text(", ".join(tips)))
        made.add_row("", "torque limits", Text(f"{limits} {unit}"))
        made.add_section()
    return made


def key_table(keys: Sequence[Any], file: str) -> Table:
    """The keys of a kind of `file`, such as "a scene file", from `handlcp.scene.Key`s."""
    made = make_table(f"Keys of {file}", ("key", "what it holds\nwhat it means"), "|<")
    last = ""
    for k in keys:
        if k.table != last:
            made.add_section()
            made.add_row(Text(f"[[{k.table}]]" if k.many else f"[{k.table}]", style="bold cyan"))
        last = k.table
        only = f" (shape {k.shape})" if k.shape else ""
        left_out = "; needed" if k.required else f"; left out: {k.default}" if k.default not in ("", '""') else ""
        name = Text(k.key, style="bold" if k.required else "")
        made.add_row(name, Text.assemble((f"{k.expected}\n", "cyan"), f"{k.meaning}{only}{left_out}"))
    return made


def catalogue_table(entries: Sequence[EffectDescription], costs: Mapping[str, Any] | None = None) -> Table:
    """A row for each effect that the package has.

    costs : `handlcp.studies.effect_catalogue.Cost`s by title; None: not measured.
    """
    note = "here, time: unknowns more, and how many times as long, beside the reference scene without"
    heads = ["effect\nunknowns", "when to use it\nin Python; in a scene file"]
    heads += [] if costs is None else ["here", "time"]
    made = make_table("All effects", heads, "<<>>"[: len(heads)], note="" if costs is None else note)
    made.columns[0].max_width, made.columns[0].overflow = 26, "ellipsis"
    for e in entries:
        ask = [(f"\n{e.in_short}", "cyan"), (f"\n{', '.join(e.file_keys)}", "dim")] if e.in_python else []
        cells = [Text.assemble((e.title, "bold"), f"\n{e.brings}"), Text.assemble(e.when, *ask)]
        if costs is not None:
            cells += [Text(costs[e.title].more), Text(str(costs[e.title]))]
        made.add_row(*cells)
        made.add_section()
    return made


def make_table(
    title: str, heads: Sequence[str], ways: str, rows: Iterable[Sequence[str | Text]] = (), note: str = ""
) -> Table:
    """A table in the style of all others. ways : of each column, "<" for words, "|" for words that are never broken,
    ">" for numbers, on the right and never broken. note : stands below it.
    """
    style: dict[str, Any] = {"title_justify": "left", "title_style": "bold", "caption_justify": "left"}
    made = Table(title=title, caption=note or None, box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1), **style)
    for head, way in zip(heads, ways, strict=True):
        made.add_column(head, justify="right" if way == ">" else "left", no_wrap=way != "<", overflow="fold")
    for row in rows:
        made.add_row(*[Text(cell) if isinstance(cell, str) else cell for cell in row])
    return made


def _pyramid_note(solution: GraspSolution) -> str:
    """The share of the friction limit at which a contact in a pyramid may slide; "" without pyramids."""
    scene, section = solution.scene, solution.section
    if scene is None or not scene.frictional or not isinstance(section, Pyramid) or not section.inscribed:
        return ""
    if scene.soft:
        least = words.format_percent(min(section.share, limit_set(section, 3).share))
        return f"of limit: friction and moment within the limit surface; a contact slides from {least} on"
    least, who = words.format_percent(section.share), "finger" if solution.spec is None else solution.spec.who
    return f"of limit: friction / (μ · normal); {section.faces} faces inside the cone let a {who} slide from {least} on"
