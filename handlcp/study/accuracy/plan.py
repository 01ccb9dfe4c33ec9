"""Which settings the study runs: not every pair of faces and tolerances, unless both are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from handlcp.grasp import Pyramid
from handlcp.study.accuracy.methods import Method
from handlcp.tolerances import SOLVE

__all__ = ["FACES", "TOLERANCES", "Setting", "settings"]

FACES = (3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
TOLERANCES = tuple(10.0**-k for k in range(1, 13))
_SWEPT = (8, 16)  # faces at which all tolerances are tried


@dataclass(frozen=True, slots=True)
class Setting:
    """A method with its faces, the pyramid's section and a tolerance, as in `Row`."""

    method: Method
    faces: int | None
    section: str
    tolerance: float | None

    @property
    def asked(self) -> int | str | Pyramid:
        """What the grasp is assembled or solved with, as `faces`. A plain LCP of an exact scene ignores its number."""
        if self.faces is not None:
            return Pyramid(self.faces, inscribed=self.section == "inscribed")
        return 8 if self.method.form in ("LCP", "SI") else "cone"


def settings(
    methods: Sequence[Method], faces: tuple[tuple[int, ...], bool], tolerances: tuple[tuple[float, ...], bool],
    pyramids: bool,
) -> dict[Method, tuple[Setting, ...]]:  # fmt: skip
    """The settings of each method, in the order in which to run them.

    faces, tolerances : each with whether it was asked for. pyramids : whether the scene has any; without them LCPs are
    exact, too, and faces mean nothing.
    """
    (sides, wanted), (tols, asked) = faces, tolerances
    tight = min((t for t in tols if t >= SOLVE), default=min(tols))
    swept = sides if wanted else tuple(m for m in _SWEPT if m in sides)
    out: dict[Method, tuple[Setting, ...]] = {}
    for method in methods:
        if method.form == "grasp":
            cells = [Setting(method, None, "exact", None)]
            if pyramids:
                cells += [
                    Setting(method, m, section, None) for m in sides for section in ("inscribed", "circumscribed")
                ]
        elif not pyramids or method.form == "cone":
            cells = [Setting(method, None, "exact", t) for t in (tols if method.tolerant else (None,))]
        elif not method.tolerant:
            cells = [Setting(method, m, "inscribed", None) for m in sides]
        else:
            few = tols if asked else (method.own or tight,)
            cells = [Setting(method, m, "inscribed", t) for m in swept for t in tols]
            cells += [Setting(method, m, "inscribed", t) for m in sides for t in few]
        out[method] = tuple(dict.fromkeys(cells))
    return out
