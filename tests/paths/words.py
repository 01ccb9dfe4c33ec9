"""What the three questions say of one load on one grasp: yes, no, or why there is no word."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import handlcp as hl
from tests.paths.corpus import Case
from tests.paths.recipes import FreeRecipe

# What makes `check` undecided, and is no matter of how much load is held
ELSEWHERE = {"link_inside", "large_motion", "solver_stopped"}
ORDERS = ("staged", "plain")  # squeeze, weight, then the load, as `load_limit` has it; or squeeze, then both at once
_SPARE = 1e-6  # of a torque limit


@dataclass(frozen=True)
class Word:
    """yes : whether the load is held; None: no word, for a reason that is no matter of the load. said : in words."""

    yes: bool | None
    said: str


def order_of(case: Case, load: np.ndarray, order: str = "staged") -> Any:
    """The stages. Bare contacts have no weight."""
    if order == "plain" or isinstance(case.recipe, FreeRecipe):
        return ("squeeze", "load")
    return ("squeeze", hl.Stage("weight", weight=1.0), hl.Stage("load", load=load, weight=1.0))


def limit_of(case: Case, way: np.ndarray, length: float = 1.0) -> Any:
    """The load limit of a case along a direction (6,). length : of a metre, in the units of the case."""
    return case.grasp.load_limit(way, geometry=case.geometry, faces=case.faces, max_slip=1e-3 * length)


def followed(case: Case, load: np.ndarray, order: str = "staged", **options: Any) -> tuple[Word, Any]:
    """`follow` with a load (6,): its word, and the loading. A motor over its limit in the last stage, or a joint past
    its range, counts as a no: `load_limit` ends there, too. So does a contact that slides too far.
    """
    h = case.grasp.follow(
        load, order=order_of(case, load, order), geometry=case.geometry, faces=case.faces, **options
    )  # fmt: skip
    if h.word == "UNDECIDED":
        return Word(None, f"undecided at {h.held_to:.4f}"), h
    if not h.in_place:
        lost = h.lost_stage is not None
        return Word(False, f"lost in {h.lost_stage} at {h.lost_at:.4f}" if lost else f"slides at {h.held_to:.4f}"), h
    if over := _over(case, h):
        return Word(False, f"reached, {over}"), h
    return Word(True, "reached"), h


def _over(case: Case, h: Any) -> str:
    """The first motor over its limit or joint past its range in the last stage."""
    if isinstance(case.recipe, FreeRecipe):
        return ""
    for e in h.events:
        if e.kind in ("over limit", "range end") and e.stage == h.stages[-1]:
            return f"{e.who} {e.kind} at {e.share:.4f}"
    hand = case.grasp.state.hand
    limits = np.asarray(hand.torque_limits)
    over = abs(np.asarray(h.steps.torques[-1])) > (1.0 + _SPARE) * limits
    return f"{hand.joint_names[int(np.argmax(over))]} over limit" if over.any() else ""


def checked(case: Case, load: np.ndarray, order: str = "staged") -> Word:
    """`check` of the grasp with this load beside its weight. A joint of which it warns that it is past its range, and
    which passes it in the last stage, counts as a no, as in `followed`.
    """
    bare = isinstance(case.recipe, FreeRecipe)
    loaded = case.grasp.replace(wrench=load) if bare else case.grasp.replace(load=load)
    verdict = loaded.check(order=order_of(case, load, order), faces=case.faces)
    deciding = sorted({r.code for r in verdict.reasons if r.severity == "decides"})
    said = f"{verdict.word} ({', '.join(deciding)})" if deciding else verdict.word
    if verdict.word == "UNDECIDED" and set(deciding) & ELSEWHERE:
        return Word(None, said)
    past = {r.values["joint"] for r in verdict.about("joint_range")}
    if verdict.ok and past & _ended(verdict.loading):
        return Word(False, f"{said}, past its range: {', '.join(sorted(past))}")
    return Word(verdict.ok, said)


def _ended(h: Any) -> set[str]:
    """Joints that pass the ends of their ranges in the last stage."""
    return {e.who for e in h.events if e.kind == "range end" and e.stage == h.stages[-1]}


def pressed(case: Case) -> float:
    """[N] sum of the normal forces once the grasp is squeezed and carries its weight: a size for loads."""
    h = case.grasp.follow(np.zeros(6), geometry=case.geometry, faces=case.faces)
    return float(h.steps.forces[-1, :, 2].sum())
