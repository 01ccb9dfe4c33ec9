"""What common changes of a grasp do to the end of a path, in a table, to first order."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp.check import Array
from handlcp.text_table import TextTable, wrapped
from handlcp.words import first_largest

_SHARE = 0.1
_ROWS = {
    "friction": "friction", "joint_offset": "command of the joints", "squeeze": "squeeze",
    "stiffness": "stiffness of the joints", "pads": "flexibility of the pads", "torque_limits": "torque limits",
}  # fmt: skip


def path_table(s: Any, here: dict[str, Array]) -> str:
    """Of a `PathSensitivity`: each row a tenth more of a parameter, of all fingers or joints together."""
    rows, unclear = [], []
    for parameter, words in _ROWS.items():
        if parameter not in s.parameters or not (changes := s.of_share(parameter, _SHARE)):
            continue
        found = [_of_largest(here[name], change) for name, change in changes.items()]
        rows.append((f"{words} +10 %", *(_written(x) for x in found)))
        if not np.isfinite(found).all():
            unclear.append(words)
    now = [f"{abs(value).max(initial=0.0):.4g}" for value in here.values()]
    heads = ("all fingers, all joints", *here)
    lines = [str(TextTable(heads, (("now", *now), *rows), "<" + ">" * len(here)))]
    if any(value.ndim for value in here.values()):
        lines.append("Of each quantity its largest component, SI: its size, and the change of it.")
    if unclear:
        lines.append(wrapped(f"–: no derivative, for the end jumps or has a corner there ({', '.join(unclear)})."))
    return "\n".join(lines)


def _of_largest(here: Array, change: Array) -> float:
    """The change of the size of the largest component."""
    if not here.size:
        return 0.0
    flat = here.reshape(-1)
    k = first_largest(abs(flat))
    return float(change.reshape(-1)[k] * (-1.0 if flat[k] < 0.0 else 1.0))


def _written(x: float) -> str:
    return "–" if not np.isfinite(x) else "0" if x == 0.0 else f"{x:+.3g}"
