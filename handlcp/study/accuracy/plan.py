"""Which settings the study runs: not every pair of everything, unless it is asked for."""

from __future__ import annotations

from collections.abc import Sequence

from handlcp.study.accuracy.measure import Setting
from handlcp.study.accuracy.methods import Method
from handlcp.tolerances import SOLVE

__all__ = ["FACES", "TOLERANCES", "settings"]

FACES = (3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
TOLERANCES = tuple(10.0**-k for k in range(1, 13))
_SWEPT = (8, 16)  # faces at which all tolerances are tried


def settings(
    methods: Sequence[Method], faces: tuple[tuple[int, ...], bool], tolerances: tuple[tuple[float, ...], bool],
    pyramids: bool,
) -> dict[Method, tuple[Setting, ...]]:  # fmt: skip
    """The settings of each method, in the order in which to run them; lists come with whether they were asked for.

    pyramids : whether the scene has any; where it has not, LCPs are exact, too, and faces mean nothing.
    """
    (sides, wanted), (tols, asked) = faces, tolerances
    tight = min((t for t in tols if t >= SOLVE), default=min(tols))
    swept = sides if wanted else tuple(m for m in _SWEPT if m in sides)
    out: dict[Method, tuple[Setting, ...]] = {}
    for method in methods:
        if method.form == "grasp":
            cells = [Setting(method, None, None, None)]
            if pyramids:
                cells += [Setting(method, m, inside, None) for m in sides for inside in (True, False)]
        elif not pyramids or method.form == "cone":
            cells = [Setting(method, None, None, t) for t in (tols if method.tolerant else (None,))]
        elif not method.tolerant:
            cells = [Setting(method, m, True, None) for m in sides]
        else:
            cells = [Setting(method, m, True, t) for m in swept for t in tols]
            cells += [Setting(method, m, True, t) for m in sides for t in (tols if asked else (method.own or tight,))]
        out[method] = tuple(dict.fromkeys(cells))
    return out
