"""What a search for grasps gives back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, overload

from handlcp.grasp.answer.shown import Data
from handlcp.hand.find.candidate import Candidate
from handlcp.text_table import wrapped
from handlcp.views import view

_STEPS = {
    "tried": "placements tried", "touching": "touched by all fingers, without a link inside",
    "balanced": "where forces within friction hold the object", "clear": "without links in each other, solved",
    "held": "held by one solve", "checked": "checked",
}  # fmt: skip


class Found(Data, Sequence[Candidate]):
    """Grasps, sorted by `Candidate.rank`, the best first. That one is checked: its verdict is HELD. Prints in lines of
    at most 80 columns, with the warnings of that verdict.

    tried : how many placements came how far: "sampled", "tried", "touching", "balanced", "clear", "held", "checked".
    why : what became of the search in one sentence.
    """

    def __init__(self, candidates: Sequence[Candidate], tried: Mapping[str, int], why: str) -> None:
        self._candidates, self.tried, self.why = tuple(candidates), dict(tried), why

    def __len__(self) -> int:
        return len(self._candidates)

    @overload
    def __getitem__(self, at: int) -> Candidate: ...
    @overload
    def __getitem__(self, at: slice) -> Sequence[Candidate]: ...
    def __getitem__(self, at: int | slice) -> Candidate | Sequence[Candidate]:
        return self._candidates[at]

    def __str__(self) -> str:
        warnings = [f"Warning: {reason.sentence}." for reason in self[0].verdict.warnings] if self else []
        grasps = [wrapped(f"{k}: {one}", "   ") for k, one in enumerate(self)]
        return "\n".join([wrapped(f"{self.why}."), *map(wrapped, warnings), *grasps])

    def to_dict(self) -> dict[str, Any]:
        """Plain data, SI units in the keys: what became of the search, and its grasps as `Candidate.to_dict` has them,
        the best with its verdict.
        """
        grasps = [one.to_dict() for one in self]
        if grasps:
            grasps[0]["verdict"] = self[0].verdict.to_dict()
        return {"why": self.why, "tried": dict(self.tried), "grasps": grasps}

    def to_frame(self) -> Any:
        """A pandas table with a row for each grasp: margin, friction_reserve, torque_reserve, pressing, and the largest
        normal force largest_force_N. Raises Unsupported without pandas.
        """
        keys = "margin", "friction_reserve", "torque_reserve", "pressing"
        columns: dict[str, Any] = {key: [getattr(one, key) for one in self] for key in keys}
        columns["largest_force_N"] = [float(one.solution.normal_force.max()) for one in self]
        return view("data_frame")(columns)

    def __repr__(self) -> str:
        return f"Found({len(self)} grasps)"


def told(tried: Mapping[str, int]) -> str:
    """How far a search came, in words."""
    parts = [f"{tried[key]} {words}" for key, words in _STEPS.items() if tried.get(key)]
    return f"{tried['sampled']} sampled, {', '.join(parts)}"
