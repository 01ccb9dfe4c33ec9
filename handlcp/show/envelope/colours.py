"""A colour for each cause: its hue says what gives out (friction, a joint, a contact), its shade who."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handlcp.check import Ints
from handlcp.grasp.cause.judge import EQUILIBRIUM, MOTION, OPENS, RANGE, SLIDES, SLIPS, TORQUE, UNDECIDED
from handlcp.study.envelope.causes import Sector

NOTHING, OTHERS = "#D9DCE0", "#8E949B"  # nothing gives out; causes beyond those that have a colour
MOST = 10  # causes with a colour of their own
# One hue a kind; its shades differ in hue as well as in lightness, as the light on a surface changes lightness alone.
# Found by a search for the largest least distance (CIEDE2000), also as people see them who lack red or green cones.
SHADES = {
    SLIPS: ("#F7E552", "#A00024", "#E27563", "#BF6F02", "#B14920", "#CA4E65", "#E0A933"),
    OPENS: ("#2F794E", "#88D882", "#68EEBD", "#63AF8A", "#134604"),
    TORQUE: ("#5AABE4", "#265C7E", "#AFCBFF", "#3C819F", "#222E4E"),
    RANGE: ("#8B3FBC", "#8B71E3", "#322FA6", "#5A4360"),
    EQUILIBRIUM: ("#43403E",),
    MOTION: ("#47C0C6",),
    SLIDES: ("#ED7BAE",),
    UNDECIDED: ("#F3E6FF",),
}


@dataclass(frozen=True, slots=True)
class Key:
    """One colour: the causes that have it, in words, on which share of the directions, and the least factor there."""

    colour: str
    says: str
    share: float
    least: float
    causes: tuple[int, ...]


def keys_of(causes: Sequence[Sector]) -> tuple[tuple[Key, ...], Ints]:
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
    shades = SHADES[kind]
    k = used[kind] = used.get(kind, -1) + 1
    return shades[k] if k < len(shades) else None
