"""A grasp to load, here and in MuJoCo, and how near the two have to be."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlcp.simulator import compare, to_mujoco

# Of the largest force or torque. A jump is fast: where friction ends behind it is no question of statics.
NEAR = {"sticks": 0.01, "slides": 0.03, "jumps": 0.1}
LIMIT = 0.03  # of the load at which the object is lost


@dataclass(frozen=True)
class Case:
    """kind : "sticks", "slides" and "jumps" are held, and compared at the end; "lost": both lose it, in the same stage;
    "limit": at the same load, too.

    make : the grasp. load (6,), order : of `follow`, when given. seconds : of each stage in MuJoCo.
    short : whether the default suite runs it.
    """

    name: str
    hand: str
    kind: str
    make: Callable[[], Any]
    load: Any = None
    order: Any = ("squeeze", "load")
    seconds: float = 2.0
    short: bool = False

    @property
    def title(self):
        """Its name."""
        return self.name

    def run(self, seconds=None):
        """Both, MuJoCo with so many seconds for each stage, or its own."""
        time = self.seconds if seconds is None else seconds
        return compare(self.make(), self.load, self.order, seconds=time)


def misses(case, found):
    """What is not as it has to be, in words; nothing where all is well."""
    ours, theirs = found.loading, found.simulation
    held = case.kind in NEAR
    wrong = [f"{who} {'lost' if held else 'held'} it" for who, h in (("handlcp", ours.held), ("MuJoCo", theirs.held))
             if h != held]  # fmt: skip
    if wrong:
        return wrong
    if held:
        near = NEAR[case.kind]
        errors = {"forces": found.force_error, "torques": found.torque_error}
        return [f"{what} {100 * e:.2g} % off" for what, e in errors.items() if not e <= near]
    if ours.lost_stage != theirs.lost_stage:
        return [f"handlcp lost it in {ours.lost_stage!r}, MuJoCo in {theirs.lost_stage!r}"]
    if case.kind == "limit" and not abs(limit_error(found)) <= LIMIT:
        return [f"load limit {100 * limit_error(found):+.2g} % off"]
    return []


def limit_error(found):
    """By how much the share of the load is off at which handlcp loses the object; NaN where one holds it."""
    ours, theirs = found.loading.lost_at, found.simulation.lost_at
    return float("nan") if ours is None or theirs is None else (ours - theirs) / max(theirs, 1e-9)


def chosen(cases, words):
    """Cases whose titles hold one of the words; all without words."""
    return [case for case in cases if not words or any(word in case.title for word in words)]


def started(grasp, squeeze=0.0, load=0.0, settings=None):
    """MuJoCo's model and data of a grasp, at its start, and the state."""
    import mujoco  # cases can be listed without it

    xml, state = to_mujoco(grasp, settings)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    state.put(model, data, squeeze, load)
    return model, data, state


def read_rows(file):
    """By title; nothing without the file."""
    found = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    return found.get("rows", found)


def write_rows(file, rows, made_with=None):
    """A line for each, under what they were made with, if that is said."""
    text = ",\n".join(f"{json.dumps(key)}: {json.dumps(row)}" for key, row in rows.items())
    text = f"{{\n{text}\n}}"
    head = "" if made_with is None else f'{{"made_with": {json.dumps(made_with)},\n"rows": '
    file.write_text(f"{head}{text}{'}' * bool(head)}\n", encoding="utf-8")


def closing(grasp, depth):
    """The same with joints commanded so that the tips would move so far along their normals [m], the smallest way."""
    k = len(grasp.fingertips)
    normal = grasp.jacobian[2 : 3 * k : 3]
    return grasp.replace(joint_offset=np.linalg.lstsq(normal, np.full(k, depth), rcond=None)[0])
