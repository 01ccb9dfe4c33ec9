"""What a search for grasps gives back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import overload

from handlcp.hand.find.candidate import Candidate

__all__ = ["Found", "told"]

_STEPS = {
    "tried": "placements tried", "touching": "touched by all fingers, without a link inside",
    "balanced": "where forces within friction hold the object", "clear": "without links in each other, solved",
    "held": "held by one solve", "checked": "checked",
}  # fmt: skip


class Found(Sequence[Candidate]):
    """Grasps, sorted by `Candidate.rank`, the best first. That one is checked: its verdict is HELD.

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
        return "\n".join([self.why, *(f"{k}: {one}" for k, one in enumerate(self))])

    def __repr__(self) -> str:
        return f"Found({len(self)} grasps)"


def told(tried: Mapping[str, int]) -> str:
    """How far a search came, in words."""
    parts = [f"{tried[key]} {words}" for key, words in _STEPS.items() if tried.get(key)]
    return f"{tried['sampled']} sampled, {', '.join(parts)}"
