"""Keys of the dictionaries, columns of the tables and JSON of the commands, read off answers to small questions.

What stands under a key is said by its kind: "text", "number", "yes or no", "nothing" for None, and lists of them by
"[…]"; a key within another is joined to it by a dot, and "[]" stands for each of several. Numbers themselves are the
affair of `tests/paths` and of the tests beside each answer.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app

__all__ = ["ANSWERS", "COMMANDS", "answer_keys", "json_keys"]

ROOT = Path(__file__).parents[2]
SCENE = str(ROOT / "examples" / "cube_three_fingers.toml")
PUSH = (1.0, 0, 0, 0, 0, 0)


@cache
def pinch() -> hl.Grasp:
    """Two points that press on an object along x, and have no hand."""
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(0.5)) for s in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)


@cache
def held() -> hl.HandGrasp:
    """The cube of the README in three fingers."""
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    return hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)


@cache
def two_fingers() -> hl.Hand:
    return hl.example_hand("two_finger", joint_stiffness=6.0, torque_limits=3.0)


def ball() -> hl.HandGrasp:
    """A ball in two fingers with soft pads, which has few paths to follow."""
    hand, sphere = two_fingers(), hl.Sphere(0.03, (0, 0, 0.08), mass=0.1)
    return hand.at(hand.close_on(sphere)).grasp(sphere, hl.SoftFinger(0.8, 0.005), grip_force=5.0)


def brief(force: float = 1.0) -> hl.Brief:
    """A ball, with a load beside its weight."""
    loads = {"pull": (0.5 * force, 0, 0, 0, 0, 0)}
    return hl.Brief(hl.Sphere(0.03, mass=0.1 * force), loads=loads, friction=0.6, grip_force=5.0 * force, tries=2)


def make(force: float) -> hl.Hand:
    """A hand whose forces at the same angles are so many times as large."""
    return hl.finger_hand(joint_stiffness=4.0 * force, torque_limits=5.0 * force, pad_flexibility=1e-4 / force)


def study() -> hl.Study:
    return hl.sweep(make, {"force": (0.5, 2.0)}, brief, samples=2, executor="serial", progress=False)


def tendons() -> hl.HandGraspSolution:
    """The cube held by joints that tendons pull at."""
    names = hl.example_hand("three_finger").joint_names
    pulled = hl.Tendons({f"tendon {k}": {name: 0.01} for k, name in enumerate(names)}, 1e3, 6.0)
    hand = hl.example_hand("three_finger", joint_stiffness=pulled)
    cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    return hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005).solve()


ANSWERS: dict[str, Callable[[], Any]] = {
    "a solution": lambda: pinch().solve(),
    "a solution of a hand": lambda: held().solve(),
    "a solution of a hand with tendons": tendons,
    "a verdict, HELD": lambda: held().check(),
    "a verdict, NOT HELD": lambda: held().replace(mass=1.0).check(),
    "a torque check": lambda: held().solve().torque_check,
    "a loading": lambda: held().follow(PUSH),
    "a loading without a hand": lambda: pinch().follow(steps=4),
    "a load limit": lambda: held().load_limit((0, 0, -1, 0, 0, 0)),
    "a load limit without a hand": lambda: pinch().load_limit(PUSH),
    "an envelope": lambda: hl.envelope(held(), 6, adaptive=0, geometry="fixed", progress=False),
    "a payload": lambda: held().payload(geometry="fixed"),
    "an evaluation": lambda: hl.evaluate(make(1.0), brief()),
    "rows of a sweep": study,
    "reliability": lambda: hl.reliability(held(), {"friction": 0.1, "mass": 0.1}, 64, workers=1, progress=False),
    "bounds of forces": lambda: held().solve().force_bounds(),
    "a sensitivity": lambda: held().solve().sensitivity(),
    "a sensitivity of a path": lambda: pinch().follow(steps=4).sensitivity(),
    "an audit": lambda: hl.example_hand("psyonic").audit(),
    "a description": lambda: held().state.hand.describe(),
    "margins": lambda: held().margins(),
    "a required preload": lambda: pinch().required_preload(tolerance=0.5),
    "a required stiffness": lambda: pinch().required_stiffness(2e-3, tolerance=0.5),
    "required torque": lambda: ball().required_torque({"push": PUSH}, tolerance=0.5, progress=False),
    "the best change": lambda: held().best_change(PUSH, geometry="fixed"),
    "suggestions": lambda: pinch().suggest(),
    "an explanation": lambda: held().explain(),
    "equilibria": lambda: pinch().equilibria(faces=4),
    "grasps that were found": lambda: hl.find_grasp(two_fingers(), hl.Sphere(0.03, mass=0.1), friction=0.8, tries=8),
    "solutions of many": lambda: hl.solve_many([pinch(), pinch()]),
    "strength of fingers": lambda: hl.finger_strength(make(1.0)),
    "slip resistance": lambda: hl.slip_resistance(pinch(), (0, 0, 1)),
    "derivatives by numbers of a hand": lambda: hl.slopes(held(), ["finger_1_tip.pad"]),
}

COMMANDS = {
    "handlcp solve": ("solve", SCENE),
    "handlcp solve, explained": ("solve", SCENE, "--explain", "--suggest"),
    "handlcp follow": ("follow", SCENE),
    "handlcp limits": ("limits", SCENE, "--direction", "-z", "--fixed"),
    "handlcp payload": ("payload", SCENE, "--fixed"),
    "handlcp hands": ("hands",),
    "handlcp audit": ("audit", str(ROOT / "urdf" / "three_finger.urdf")),
    "handlcp effects": ("effects",),
    "handlcp keys": ("keys",),
}


def answer_keys(name: str) -> dict[str, Any]:
    """{"dictionary": {key: kind}, "columns": those of its table} of one of `ANSWERS`, as far as it has them."""
    answer = ANSWERS[name]()
    found: dict[str, Any] = {}
    if hasattr(answer, "to_dict"):
        found["dictionary"] = dict(flat(json.loads(json.dumps(answer.to_dict(), default=lambda array: array.tolist()))))
    if hasattr(answer, "to_frame"):
        try:
            found["columns"] = list(map(str, answer.to_frame().columns))
        except hl.InputError:  # a sensitivity, which has a table for each quantity and parameter
            found["columns"] = list(map(str, answer.to_frame("forces", "friction").columns))
    return found


def json_keys(name: str) -> dict[str, str]:
    """{key: kind} of what one of `COMMANDS` prints with --json."""
    done = CliRunner().invoke(app, [*COMMANDS[name], "--json"])
    assert done.exit_code in (0, 1), done.output
    return dict(flat(json.loads(done.stdout)))


def flat(value: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """(key, kind) of everything within. Entries of a list of dictionaries count once, and those of lists of lists."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from flat(inner, f"{key}.{name}" if key else name)
    elif isinstance(value, list) and any(isinstance(inner, dict) for inner in value):
        kinds: dict[str, set[str]] = {}
        for inner in value:
            for name, kind in flat(inner, f"{key}[]"):
                kinds.setdefault(name, set()).add(kind)
        yield from ((name, " or ".join(sorted(found))) for name, found in kinds.items())
    else:
        yield key, kind_of(value)


def kind_of(value: Any) -> str:
    """What stands under a key."""
    if isinstance(value, list):
        return f"[{' or '.join(sorted({kind_of(inner) for inner in value}))}]"
    if value is None:
        return "nothing"
    return {bool: "yes or no", str: "text", int: "number", float: "number"}[type(value)]
