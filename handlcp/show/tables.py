"""Tables for the terminal: effects, contacts, joint torques, hands, scene keys. Readable from 80 columns on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from handlcp.grasp import Explanation, Grasp, GraspSolution
from handlcp.grasp.entry import Entry
from handlcp.grasp.explain import EffectLine
from handlcp.grasp.limit_surface import limit_surface
from handlcp.grasp.pyramid import Pyramid
from handlcp.show import units

__all__ = [
    "catalogue_table",
    "contact_table",
    "effect_table",
    "effort_table",
    "friction_used",
    "hand_table",
    "key_table",
    "plain",
    "torque_table",
]

STATE = {"sticking": "green", "sliding": "yellow", "separated": "dim"}
BAR = 10  # cells of a full torque bar


def effect_table(explanation: Explanation) -> Table:
    """Which effects are on and off, why, and what each costs."""
    e = explanation
    solved = f"{e.unknowns} unknowns, of which the solver sees {e.size}" if e.eliminated else f"{e.unknowns} unknowns"
    measured = e.seconds is not None
    if e.seconds is not None:
        solved += f"; {1e6 * e.seconds:.0f} µs from the numbers to a certified answer, started at the answer"
        if any((line.share or 0.0) <= -0.02 for line in e.effects if line.on):
            solved += '; "saves": without it a solve takes longer'
    table = plain("Effects", caption=solved)
    for heading in ("", "effect", "why"):
        table.add_column(heading, no_wrap=heading == "")
    table.add_column("unknowns", justify="right", no_wrap=True)
    if measured:
        table.add_column("of time", justify="right", no_wrap=True)
    for line in e.effects:
        brings = "  ".join(f"{name} {count}" for name, count, _ in line.unknowns) or ("none" if line.on else "")
        mark = Text("on", style="green") if line.on else Text("–", style="dim")
        share = _share(line) if line.on else ""
        cells = [brings, share] if measured else [brings]
        table.add_row(mark, Text(line.title), Text(line.why), *cells, style=None if line.on else "dim")
    return table


def contact_table(grasp: Grasp, solution: GraspSolution, faces: Any = 8) -> Table:
    """Finger by finger, then the environment's contacts: state, forces, share of the friction limit, slip and gap."""
    slips = np.hypot(*solution.slip.T)
    slip, gap = units.length_unit(slips.tolist()), units.length_unit(solution.gap.tolist())
    table = plain("Contacts", caption=_limit_note(grasp, faces))
    table.add_column("contact" if grasp.scene.environment else "finger", overflow="fold")
    table.add_column("state", no_wrap=True)
    moments = solution.torsion
    headings = ["normal\nN", "friction\nN", "of limit\n", f"slip\n{slip.name}", f"gap\n{gap.name}"]
    if moments is not None:
        headings.insert(2, "moment\nmN·m")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    used = friction_used(grasp, solution)
    for i, (name, state) in enumerate(zip(solution.names, solution.contact_state, strict=True)):
        f = solution.forces[i]
        table.add_row(
            Text(name),
            Text(state, style=STATE.get(state, "dim")),
            _number(f[2]),
            _number(float(np.hypot(f[0], f[1]))),
            *([] if moments is None else [_number(1e3 * float(moments[i]))]),
            units.percent(used[i]),
            slip(float(slips[i])),
            gap(float(solution.gap[i])),
        )
    return table


def friction_used(grasp: Grasp, solution: GraspSolution) -> list[float]:
    """(n) |r_T| / (μ r_N), of ellipses and ellipsoids in units of their half-axes; NaN where there is no friction or no
    force.
    """
    out, scene = [], grasp.scene
    moments = np.zeros(scene.n) if solution.torsion is None else solution.torsion
    for i, (contact, f) in enumerate(zip(grasp.contacts, scene.lawful(solution.forces), strict=True)):
        limit, lever = scene.mu[i] * f[2], contact.friction.lever
        moment = moments[i] / lever if lever > 0.0 else 0.0
        out.append(float(np.hypot(np.hypot(f[0], f[1]), moment) / limit) if limit > 0 else float("nan"))
    return out


def torque_table(check: Any) -> Table:
    """Joint by joint; `check` is a `TorqueCheck`."""
    table = plain("Joint torques")
    table.add_column("joint", overflow="fold")
    for heading in ("torque\nN·m", "limit\nN·m", "of limit\n"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for r in check:
        finite = r.known and np.isfinite(r.limit)
        over, binding = finite and r.utilisation > 1.0, r.joint == check.binding
        style = "bold red" if over else "bold" if binding else None
        limit = f"{r.limit:.3g}" if finite else "none" if r.known else "unknown"
        share = units.percent(r.utilisation) if finite else "–"
        mark = " over limit" if over else " binding" if binding and finite else ""
        bar = Text(_bar(r.utilisation) if finite else "", style="red" if over else "cyan") + Text(mark)
        table.add_row(Text(r.joint), _number(r.torque, 4), limit, share, bar, style=style)
    return table


def effort_table(effort: Any) -> Table:
    """Tendon by tendon, or actuator by actuator; `effort` is an `Effort`."""
    table = plain("Tendons" if effort.unit == "N" else "Actuators")
    table.add_column(effort.kind.split()[0], overflow="fold")
    table.add_column(f"{effort.kind.split()[1]}\n{effort.unit}", justify="right", no_wrap=True)
    for name, value in zip(effort.names, effort.values.tolist(), strict=True):
        table.add_row(Text(name), _number(value, 4))
    return table


def hand_table(rows: Sequence[tuple[str, Sequence[str], Sequence[str], str]]) -> Table:
    """Hands to use: (name, joints, fingertips, note)."""
    table = plain("Hands")
    table.add_column("name", no_wrap=True)
    for heading in ("joints", "fingertips", "limits\nN·m"):
        table.add_column(heading)
    for name, joints, tips, note in rows:
        title = Text.assemble((name, "bold"), f"\n{len(joints)} joints\n{len(tips)} fingers")
        table.add_row(title, Text(", ".join(joints)), Text(", ".join(tips)), note)
        table.add_section()
    return table


def key_table(keys: Sequence[Any]) -> Table:
    """The keys of scene files; `keys` are `handlcp.scene.Key`s."""
    table = plain("Keys of a scene file")
    for heading in ("key", "what it holds", "meaning"):
        table.add_column(heading, no_wrap=heading == "key")
    last = ""
    for k in keys:
        if k.table != last:
            table.add_section()
            many = k.table in ("contact", "environment", "effects.prescribed_force", "effects.known_force")
            table.add_row(Text(f"[[{k.table}]]" if many else f"[{k.table}]", style="bold cyan"))
        last = k.table
        only = f" (shape {k.shape})" if k.shape else ""
        left_out = "; needed" if k.required else f"; left out: {k.default}" if k.default not in ("", '""') else ""
        name = Text(k.key, style="bold" if k.required else "")
        table.add_row(name, Text(k.expected), Text(f"{k.meaning}{only}{left_out}"))
    return table


def catalogue_table(entries: Sequence[Entry], costs: Mapping[str, Any] | None = None) -> Table:
    """All effects there are; `costs` are `handlcp.study.catalogue.Cost`s by title, None: not measured."""
    note = "here, time: unknowns more, and how many times as long, beside the reference scene without"
    table = plain("All effects", caption=None if costs is None else note)
    table.add_column("effect\nunknowns")
    table.add_column("when to use it\nin Python; in a scene file", overflow="fold")
    for heading in ("here", "time") if costs is not None else ():
        table.add_column(heading, justify="right", no_wrap=True)
    for e in entries:
        ask = [(f"\n{e.in_short}", "cyan"), (f"\n{', '.join(e.file_keys)}", "dim")] if e.in_python else []
        cells = [Text.assemble((e.title, "bold"), f"\n{e.brings}"), Text.assemble(e.when, *ask)]
        if costs is not None:
            cells += [Text(costs[e.title].more), Text(str(costs[e.title]))]
        table.add_row(*cells)
        table.add_section()
    return table


def plain(title: str, caption: str | None = None) -> Table:
    """An empty table as all of ours look."""
    return Table(
        title=title,
        title_justify="left",
        title_style="bold",
        caption=caption,
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1),
    )


def _share(line: EffectLine) -> str:
    if line.share is None:
        return "–"
    return f"{round(100 * max(line.share, 0.0))} %" if line.share > -0.02 else "saves"


def _number(value: float, digits: int = 3) -> str:
    if not np.isfinite(value):
        return "–"
    return f"{round(value, digits) + 0.0:.{digits}f}" if abs(value) < 100 else f"{value:.1f}"


def _bar(share: float) -> str:
    filled = round(min(share, 1.0) * BAR)
    return "█" * filled + "·" * (BAR - filled)


def _limit_note(grasp: Grasp, faces: Any) -> str | None:
    """What 100 % of the friction limit means with a pyramid."""
    if grasp.scene.plane is not None or not grasp.scene.frictional or not isinstance(faces, int):
        return None
    if grasp.scene.soft:
        least = units.percent(min(float(np.cos(np.pi / faces)), limit_surface(Pyramid(faces)).share))
        return f"of limit: friction and moment within the limit surface; a contact slides from {least} on"
    least, who = units.percent(float(np.cos(np.pi / faces))), "contact" if grasp.scene.environment else "finger"
    return f"of limit: friction / (μ · normal); {faces} faces inside the cone let a {who} slide from {least} on"
