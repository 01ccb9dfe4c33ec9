"""A solution as text: the verdict, then a table of the contacts, then what the object does. In 80 columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.text_table import TextTable, wrapped
from handlcp.tolerances import CERTIFY


def printed(s: Any, tables: Sequence[Any]) -> str:
    """Of a `GraspSolution`, which imports this file; tables : what else stands under the contacts, with `str`."""
    if not s.held:
        return str(s.verdict)
    parts = [str(s.verdict), str(contact_columns(s)), *(str(t) for t in tables)]
    free = s.uniqueness or "what is left free was not examined"
    told = [_motion(s), wrapped(f"Certified: {free}.", "  ")]
    if s.accuracy is not None:
        told.append(wrapped(f"Accuracy: {s.accuracy}.", "  "))
    return "\n\n".join([*parts, "\n".join(told)])


def contact_columns(s: Any) -> TextTable:
    """Finger by finger, then the environment's contacts: state, forces, share of the friction limit, slip and gap."""
    least = CERTIFY * s.residuals.motion_scale
    slips, gaps = (np.where(abs(a) > least, a, 0.0) for a in (np.hypot(*s.slip.T), s.gap))
    unit, moments = words.length_unit([*slips.tolist(), *gaps.tolist()]), s.torsion
    who = "contact" if s.scene is not None and s.scene.environment else "finger"
    heads, columns = [who, "state"], [list(s.names), list(s.contact_state)]
    noise = CERTIFY * s.residuals.force_scale
    normal, friction = (np.where(abs(a) > noise, a, 0.0) for a in (s.normal_force, np.hypot(*s.tangential_force.T)))
    name, size = words.prefixed("N", [*normal.tolist(), *friction.tolist()])
    heads += [f"normal\n{name}", f"friction\n{name}"]
    columns += [words.column((a / size).tolist()) for a in (normal, friction)]
    if moments is not None:
        name, size = words.prefixed("N·m", (moments / 10.0).tolist())  # half a newton-metre is 500 mN·m
        heads.append(f"moment\n{name}")
        columns.append(words.column((moments / size).tolist()))
    heads += ["of limit", f"slip\n{unit.name}", f"gap\n{unit.name}"]
    columns += [[words.percent(x) for x in s.friction_used.tolist()]]
    columns += [[unit(x) for x in a.tolist()] for a in (slips, gaps)]
    return TextTable(tuple(heads), tuple(zip(*columns, strict=True)), "<<" + ">" * (len(heads) - 2))


def _motion(s: Any) -> str:
    """Of the object, along and about the world's axes."""
    u = np.where(abs(s.object_displacement) > CERTIFY * s.residuals.motion_scale, s.object_displacement, 0.0)
    unit = words.length_unit(u[:3].tolist())
    moves, turns = ", ".join(unit(x) for x in u[:3].tolist()), ", ".join(_degrees(u[3:]))
    return wrapped(f"Object: moves ({moves}) {unit.name}, turns ({turns})°.", "  ")


def _degrees(turn: Array) -> list[str]:
    """Each with three digits of the largest; a bare 0 for what is nothing beside it."""
    angles = np.degrees(turn)
    largest = float(abs(angles).max(initial=0.0))
    if largest < 1e-4:
        return ["0"] * len(angles)
    decimals = max(0, 2 - int(np.floor(np.log10(largest))))
    return [f"{round(x, decimals) + 0.0:.{decimals}f}" if abs(x) > 1e-4 * largest else "0" for x in angles.tolist()]
