"""How answers are shown: printed, as pictures and as data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.errors import InputError
from handlcp.keywords import helped_methods
from handlcp.record import Record, columns, data_frame
from handlcp.text_table import TextTable, wrapped
from handlcp.tolerances import CERTIFY
from handlcp.views import view

# ----------------------------------------------------------------
# What an answer looks like: a picture, plain data. Made by `handlcp.show`, which stands above this room.


@helped_methods
class Shown(Record):
    """Base of solutions that can be looked at."""

    def plot(self, path: Any = None, *, obj: Any = None, title: str = "", verdict: Any = None) -> Any:
        """The picture of the grasp: a matplotlib figure, or the file that it was written to.

        path : of a png, svg or pdf file; None: the figure itself, which a notebook shows. obj : what to draw as the
        object where the grasp knows none. verdict : of `grasp.check()`, and drawn is the end of the loading that it
        is about, where that is reached; None: what this solution alone says.
        Raises InputError for an unknown format or a missing folder, Unsupported without matplotlib.
        """
        return view("plot")(self, path, obj, title, verdict)

    def page(
        self, path: Any, *, obj: Any = None, title: str = "", verdict: Any = None, loading: Any = None
    ) -> Path:  # fmt: skip
        """A page to turn the grasp on: one HTML file that needs no network. Returns the file.

        path : it ends in .html. obj : as in `plot`. loading : what `grasp.follow()` returned, which the page shows step
        by step; None: the loading that the verdict is about, if any. verdict : of `grasp.check()`; None: whether the
        loading reached its end, or without a loading what this solution alone says.
        Raises InputError for a file that cannot be written, Unsupported without trimesh, which brings the viewer.
        """
        written: Path = view("page")(self, path, obj, title, verdict, loading)
        return written

    def to_dict(self) -> dict[str, Any]:
        """The whole answer as plain data: SI units in the key names, None for what is not a finite number."""
        found: dict[str, Any] = view("to_dict")(self)
        return found

    def to_frame(self, of: str = "contacts") -> Any:
        """A pandas table, indexed by name. SI units in the names of the columns; NaN where there is no answer.

        of : "contacts": state, normal_N, friction_N, friction_used, friction_margin_N, slip_m, gap_m, the force in
        contact axes (x_N, y_N, z_N) and in world axes, and of soft fingers the moment about the normal. "joints":
        torque_Nm, limit_Nm, utilisation, margin_Nm, yield_rad.
        Raises InputError for anything else, and for joints without a hand; Unsupported without pandas.
        """
        tables = self._tables()
        if of not in tables:
            without = "" if "joints" in tables else " for a grasp without a hand"
            raise InputError("of", " or ".join(f'"{name}"' for name in tables) + without, repr(of))
        return data_frame(*tables[of])

    def _tables(self) -> dict[str, tuple[dict[str, Any], list[str]]]:
        """Columns and index of each table, by its name."""
        return {"contacts": (contact_data(self), words.distinct(getattr(self, "names")))}  # noqa: B009

    def _repr_html_(self) -> str:
        """What a notebook shows: the verdict, the contacts, the joints."""
        text: str = view("html")(self)
        return text


def contact_data(s: Any) -> dict[str, Any]:
    """Columns of a table with a row for each contact."""
    found = columns(s, "state = contact_state", "normal_N = normal_force") | {
        "friction_N": np.hypot(*s.tangential_force.T), "friction_used": s.friction_used,
        "friction_margin_N": s.friction_margin, "slip_m": np.hypot(*s.slip.T), "gap_m": s.gap,
    }  # fmt: skip
    for which, forces in (("", s.forces), ("world_", s.forces_world)):
        found |= {f"{which}{axis}_N": forces[:, k] for k, axis in enumerate("xyz")}
    if s.torsion is not None:
        found |= columns(s, "moment_Nm = torsion", "spin_rad")
    return found


# ----------------------------------------------------------------
# A solution as text: the verdict, then a table of the contacts, then what the object does. In 80 columns.


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
    who = "finger" if s.spec is None else s.spec.who
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
