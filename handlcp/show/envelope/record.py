"""An envelope for machines: plain data, and the columns of a table."""

from __future__ import annotations

import platform
from typing import Any

import numpy as np

from handlcp.study.envelope import Envelope
from handlcp.study.envelope.result import Extreme
from handlcp.study.plain import plain
from handlcp.version import VERSION

_NAMES = {"force": "force_N", "torque": "torque_Nm", "gravity": "mass_kg", "wrench": "factor"}


def record(env: Envelope, title: str = "") -> dict[str, Any]:
    """Everything as one JSON object: SI units in the key names, null for what is infinite."""
    question, c = env.question, env.compliance
    held = _NAMES[env.of]
    found = {
        "title": title, "of": env.of, "geometry": question.geometry,
        "at_m": question.load.at if env.of in ("force", "gravity") else None,
        "object_mass_kg": question.load.mass, "motion_m": question.motion, "turn_rad": question.turn,
        "accuracy_asked": question.accuracy, "accuracy": env.accuracy,
        "plane": env.plane, "weakest": _extreme(env, env.weakest), "strongest": _extreme(env, env.strongest),
        "causes": [
            {"binds": _binds(x.binds), "says": x.says, "share": x.share, f"least_{held}": x.least,
             f"median_{held}": x.median} for x in env.causes
        ],
        "share_of_bound": {"median": c.median, "least": c.least, "direction": env.directions[c.number]},
        "directions": env.directions, "wrenches_N_Nm": env.wrenches, held: env.factors, f"bound_{held}": env.bound,
        "cause": env.cause, "share": env.shares, "triangles": env.triangles,
        "versions": {"handlcp": VERSION, "python": platform.python_version(), "numpy": np.__version__},
    }  # fmt: skip
    return dict(plain(found))


def columns(env: Envelope) -> dict[str, Any]:
    """A row for each direction."""
    held, ways = _NAMES[env.of], env.directions
    if env.of == "wrench":
        names = ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm")
        first = dict(zip(names, env.wrenches.T, strict=True))
    else:
        first = dict(zip("xyz", ways.T, strict=True))
    return first | {
        held: env.factors, f"bound_{held}": env.bound, "binds": [env.causes[k].says for k in env.cause],
        "share": env.shares,
    }  # fmt: skip


def _extreme(env: Envelope, e: Extreme) -> dict[str, Any]:
    """One direction."""
    return {
        "number": e.number, "direction": e.direction, _NAMES[env.of]: e.factor, "binds": _binds(e.binds),
        "says": env.causes[env.cause[e.number]].says,
    }  # fmt: skip


def _binds(binds: Any) -> list[dict[str, str]]:
    return [{"kind": b.kind, "who": b.who} for b in binds]
