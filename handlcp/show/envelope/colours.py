"""A colour for each cause: its hue says what gives out (friction, a joint, a contact), its shade who."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Ints
from handlcp.grasp.limits.result import EQUILIBRIUM, MOTION, OPENS, RANGE, SLIPS, TORQUE
from handlcp.study.envelope.causes import UNDECIDED, Cause

__all__ = ["NOTHING", "OTHERS", "Key", "keys_of"]

NOTHING, OTHERS = "#E3E5E8", "#8E949B"  # nothing gives out; causes beyond those that have a colour
MOST = 10  # causes with a colour of their own
# From dark to light, so that neighbours on the surface differ; hues after Okabe and Ito
_SHADES = {
    SLIPS: ("#D55E00", "#F0A050", "#A33C00", "#FFC98B", "#7A2E05", "#E87F2B", "#FFDDB5"),
    OPENS: ("#009E73", "#6CCBA9", "#00694C", "#A8E3CC", "#014A36", "#37B48C"),
    TORQUE: ("#0072B2", "#86C5EA", "#4A45A0", "#B4AEE8", "#1B4A73", "#3FA7C9", "#7C8FD8", "#D2E6F5"),
    RANGE: ("#A0307A", "#D58ABB", "#6F1B54", "#EBBBDA", "#8B4C9E", "#C56AA5"),
    EQUILIBRIUM: ("#767B82", "#4A4E54", "#9A8F80", "#5E5346"),
    MOTION: ("#B8A000", "#E3CF4A", "#857300", "#F2E69B"),
    UNDECIDED: ("#F4F0FA",),
}


@dataclass(frozen=True, slots=True)
class Key:
    """One colour: the causes that have it, in words, on which share of the directions, and the least factor there."""

    colour: str
    says: str
    share: float
    least: float
    causes: tuple[int, ...]


def keys_of(causes: Sequence[Cause]) -> tuple[tuple[Key, ...], Ints]:
    """The colours, the most frequent cause first; and the number of the colour of each cause."""
    used = dict[str, int]()
    found, rest = list[Key](), list[int]()
    for k, cause in enumerate(causes):
        colour = NOTHING if not cause.binds else _next(cause.binds[0].kind, used)
        if colour is None or (len(found) == MOST and len(causes) > MOST + 1):
            rest.append(k)
        else:
            found.append(Key(colour, cause.says, cause.share, cause.least, (k,)))
    if rest:
        share, least = (
            sum(causes[k].share for k in rest),
            min([causes[k].least for k in rest], key=lambda x: (np.isnan(x), x)),
        )
        found.append(Key(OTHERS, f"{len(rest)} other causes" if len(rest) > 1 else causes[rest[0]].says, share, least,
                         tuple(rest)))  # fmt: skip
    number = np.zeros(len(causes), dtype=np.int64)
    for j, key in enumerate(found):
        number[list(key.causes)] = j
    return tuple(found), number


def _next(kind: str, used: dict[str, int]) -> str | None:
    """The next shade of a hue; None where all have been given away."""
    shades = _SHADES[kind]
    k = used[kind] = used.get(kind, -1) + 1
    return shades[k] if k < len(shades) else None
