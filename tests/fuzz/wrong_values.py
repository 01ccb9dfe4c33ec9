"""Wrong values for each kind of parameter, and which of them a call must not take without a word.

A kind is what a parameter stands for: a number, an array of numbers, a word, a flag, names, a mapping, a path, a
function, an object. It follows from the parameter's name where the annotation is `Any`, else from the annotation.
"""

from __future__ import annotations

import re
from functools import cache

import numpy as np


class Odd:
    """Converts to nothing."""

    def __repr__(self):
        return "Odd()"


ODD = [None, Odd(), {}, [], (), b"x", 1j, {1: 2}, [[1, [2, 3]]], np.array([1.0, 2.0]), np.array(["a", "b"]), 10**400]
ODD += [np.array(None), np.zeros((0, 3)), np.datetime64("2026-01-01"), range(3), float, ..., {"a": 1}, {1, 2}]
NAN = float("nan")
LETTERS = "x" * 3000
DEEP: list = []
for _ in range(300):
    DEEP = [DEEP]

# What converts to a number, an array, or a truth value, and is none: taking it is a fault, as well
NO_NUMBER = [NAN, True, False, "1", "nan", b"1", np.bool_(True), np.array("1"), "inf", np.float64("nan")]
NUMBER = [*NO_NUMBER, *ODD, -1.0, 0.0, 1e300, -1e300, 1e-300, float("inf"), -float("inf"), [1.0, 2.0, 3.0], DEEP, 0.5]
NO_ARRAY = [[NAN] * 3, [NAN] * 6, ["1", "2", "3"], [True, False, True], "1", NAN, True, ["nan"] * 6, {"a": NAN}]
ARRAY = [*NO_ARRAY, *ODD, [None] * 3, np.zeros((2, 7)), [1.0, 2.0], [float("inf")] * 3, [1e300] * 6, 5, DEEP, -1.0]
WORD = [5, NAN, True, "no such word", "", LETTERS, "\0", ("tips", "all"), DEEP, *ODD]
NO_FLAG = [2, "yes", "True", 1, 0, NAN]
FLAG = [*NO_FLAG, np.array([True, False]), LETTERS, DEEP, *ODD]
NAMES = ["a", [5], ["no such name"], [None], [["a"]], [NAN], 5, True, ["a", "a"], DEEP, *ODD]
MAPPING = [5, "x", [1], {"no such name": 1.0}, {"a": NAN}, {"a": Odd()}, {None: None}, True, {"": ""}, DEEP, *ODD]
PATH = [5, NAN, True, "", "\0", "no/such/folder/file.x", ".", LETTERS, "x.unknown", DEEP, *ODD]
CALLABLE = [5, "x", NAN, True, DEEP, *[value for value in ODD if not callable(value)]]
OBJECT = [5, "x", NAN, True, LETTERS, DEEP, *ODD]
ANYTHING = [*NUMBER, *NO_ARRAY, "no such word", "", ["no such name"], {"no such name": 1.0}, LETTERS]

VALUES = {
    "number": NUMBER, "array": ARRAY, "word": WORD, "flag": FLAG, "names": NAMES, "mapping": MAPPING, "path": PATH,
    "callable": CALLABLE, "object": OBJECT, "anything": ANYTHING,
}  # fmt: skip
SILENT = {"number": NO_NUMBER, "array": NO_ARRAY, "flag": NO_FLAG}

# Parameters whose annotation says `Any`, or less than they are
NAMED = {
    "number": """
        acceleration accuracy budget closing_torque density diameter directions friction grip_force joint_friction
        joint_stiffness length limits link_radius mass max_gap most_force pad_flexibility palm_radius passive preload
        pretension radius rated_payload samples scale seconds size squeeze stiffness tilt tip_radius torque_limits
        weight
    """,
    "array": """
        M S along angle angles at direction flexibility force forces forward frames free gravity jacobian joint_offset
        link_lengths load loads moment_arms normal offset opening pads plane point position positions q q0 radii ranges
        reference root side tangent torque torques wrench
    """,
    "word": "name shape",
    "flag": "hold_object wrap",
    "names": "fingers grasps kinds links",
    "mapping": "changes coupling motors postures space spread",
    "path": "out package_dirs path resume",
    "callable": "make",
}
KINDS = {name: kind for kind, names in NAMED.items() for name in names.split()}
_ANNOTATED = {
    r"^bool\b": "flag", r"^(float|int)\b": "number", r"^str\b": "word", r"^(Sequence|Iterable|tuple)\[str": "names",
    r"^(Mapping|dict)": "mapping", r"Callable": "callable", r"^Array": "array",
}  # fmt: skip


@cache
def kind_of(name, annotation):
    """The kind of a parameter."""
    for pattern, kind in _ANNOTATED.items():
        if re.search(pattern, annotation):
            return kind
    return KINDS.get(name, "anything") if annotation.startswith("Any") else "object"


def shown(value, most=60):
    """A value's text, cut short."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):
        return f"<{type(value).__name__}>"
    return text if len(text) <= most else f"{text[:most]}..."
