"""Whether a sweep is the one that a file was begun with: what its numbers hang on, in a few words and digests."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from types import CodeType, FunctionType, MethodType
from typing import Any

import numpy as np

from handlcp.contact.friction import as_law
from handlcp.design.brief import Brief
from handlcp.errors import InputError
from handlcp.hand.hand import Hand
from handlcp.record import to_plain
from handlcp.version import VERSION

ROWS = "every design is searched"  # how rows come about; before, most began from other designs' grasps alone
_MOST = 3  # parameters that a message names
_DESCRIBED = "mass_kg", "size_m", "joints", "fingertips", "touching", "couplings", "tendons", "links"
_SAID = {
    "handlcp": "the version of handlcp", "space": "the space", "sampling": "the sampling", "samples": "the samples",
    "seed": "the seed", "make": "how hands are made", "brief": "the brief",
}  # fmt: skip


def description(space: Mapping[str, Any], sampling: str, samples: Any, seed: int, make: Any, brief: Any) -> Any:
    """Plain data. Of hands and briefs, and of functions that make them, a digest: of a function that of its own code,
    not of what it calls.
    """
    kept = {"handlcp": VERSION, "rows": ROWS, "space": space, "sampling": sampling, "samples": samples, "seed": seed}
    return to_plain(kept | {"make": digest(make), "brief": digest(brief)})


def check_same(file: str, before: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Raises InputError for another sweep than that of the file, with what differs; for an old one that it is."""
    if why := too_old(before):
        raise InputError("out", "a new file, or that of the same sweep", f"{file!r}: {why}")
    if unlike := [key for key in _SAID if json.dumps(before.get(key)) != json.dumps(now[key])]:  # in the same order
        plainly = [key for key in unlike if key not in ("make", "brief")]
        told = [f"{_SAID[key]} ({_apart(before.get(key), now[key])})" for key in plainly]
        told += [_SAID[key] for key in unlike if key not in plainly]
        raise InputError(
            "out", "a new file, or that of the same sweep", f"{file!r}, which differs in {', '.join(told)}"
        )


def too_old(sweep: Mapping[str, Any]) -> str:
    """Why rows of what a sweep was are not like those of today, in words; "" where they are."""
    if "handlcp" not in sweep or sweep.get("rows") == ROWS:
        return ""
    return "its rows are old: most began from other designs' grasps alone, and may be far too low; sweep anew"


def _apart(before: Any, now: Any) -> str:
    """What was and is; of mappings only where they differ."""
    if not (isinstance(before, Mapping) and isinstance(now, Mapping)):
        return f"{_short(before)}, now {_short(now)}"
    names = [name for name in {**before, **now} if before.get(name) != now.get(name)]
    told = [f"{name}: {_apart(before.get(name), now.get(name))}" for name in names[:_MOST]]
    told += ["…"] if len(names) > _MOST else ["another order"] if not names else []
    return "; ".join(told)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 120 else f"{text[:117]}..."


def digest(value: Any) -> str:
    """The same for what is the same, in every process."""
    made = hashlib.sha256()
    _feed(made, value)
    return made.hexdigest()[:16]


def _feed(into: Any, value: Any) -> None:
    """Everything that a value is made of."""
    into.update(f"<{type(value).__qualname__}>".encode())
    if isinstance(value, Hand):
        value = _numbers(value)
    elif isinstance(value, Brief):
        value = _asked(value)
    if value is None or isinstance(value, str | bool | int | float | bytes | np.generic):
        into.update(repr(value).encode())
    elif isinstance(value, np.ndarray):
        into.update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, Mapping):
        for key, one in value.items():
            _feed(into, key)
            _feed(into, one)
    elif isinstance(value, list | tuple | set | frozenset):
        for one in sorted(value, key=repr) if isinstance(value, set | frozenset) else value:
            _feed(into, one)
    elif isinstance(value, FunctionType):
        _feed(into, [value.__code__, value.__defaults__, value.__kwdefaults__])
        for cell in value.__closure__ or ():
            _feed(into, cell.cell_contents)
    elif isinstance(value, CodeType):  # without its lines and file: a comment more is no other sweep
        _feed(into, [value.co_code, value.co_names, value.co_consts, value.co_varnames])
    elif isinstance(value, partial):
        _feed(into, [value.func, value.args, value.keywords])
    elif isinstance(value, MethodType):
        _feed(into, [value.__func__, value.__self__])
    elif isinstance(value, Path):  # a mesh, wherever it is
        into.update(value.read_bytes() if value.is_file() else str(value).encode())
    elif hasattr(value, "homogeneous"):  # a pin.SE3
        _feed(into, np.array(value.homogeneous))
    elif is_dataclass(value) and not isinstance(value, type):
        _feed(into, [getattr(value, field.name) for field in fields(value)])
    else:
        own = "__reduce__" in {name for kind in type(value).__mro__[:-1] for name in vars(kind)}
        _feed(into, list(value.__reduce__()[1:2]) if own else [])  # what it is made of, where it says so
        if callable(value) and not isinstance(value, type):  # an object that makes hands: its attributes, and how
            _feed(into, [getattr(value, "__dict__", {}), vars(type(value)).get("__call__")])


def _asked(brief: Brief) -> list[Any]:
    """Of a brief, as its file has it: laws, numbers as floats, objects wherever they are."""
    own = {field.name: getattr(brief, field.name) for field in fields(brief)}
    objects = {name: obj.moved_to(np.zeros(3)) for name, obj in brief.objects.items()}
    closing = {name: _floats(value) for name, value in brief.closing.items()}
    return list((own | {"friction": as_law(brief.friction), "objects": objects} | closing).values())


def _floats(value: Any) -> Any:
    """Numbers, also in mappings and rows."""
    if isinstance(value, Mapping):
        return {str(name): _floats(one) for name, one in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_floats(one) for one in value]
    return float(value) if isinstance(value, int | float | np.generic) else value


def _numbers(hand: Hand) -> list[Any]:
    """Of a hand: what it can do, in the middle of its joints' ranges, and what it is described by, shapes among it."""
    state, described = hand.at(hand.neutral), hand.describe().to_dict()
    return [
        {key: described[key] for key in _DESCRIBED},
        [[shape.radius for shape in hand.tip_shapes(i)] for i in range(len(hand.fingertips))],
        list(hand.joint_names), list(hand.fingertips), hand.lower, hand.upper, hand.torque_limits, hand.joint_friction,
        state.tip_positions, state.jacobian, state.flexibility,
    ]  # fmt: skip
