"""Candidates of a search for a grasp, and what a search has found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np

from handlcp import words
from handlcp.check import Array, check_method_calls
from handlcp.contact.friction import as_section
from handlcp.geometry.object import Object
from handlcp.grasp.failure.failure_mode import UNDECIDED
from handlcp.grasp.model.status import SEPARATED, contact_statuses
from handlcp.grasp.path.advance import ACCURACY, PATIENT, Patience
from handlcp.grasp.path.follow import follow
from handlcp.grasp.solution.solution import GraspSolution
from handlcp.grasp.solution.verdict import Verdict
from handlcp.grasp.verdict.check import STEPS_PER_STAGE, judge_grasp
from handlcp.hand.find.held import solved
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.lazy_property import lazy_property
from handlcp.record import Record, columns_from_rows, make_data_frame, pick_entries
from handlcp.robot.hand_model import HandPosture
from handlcp.words import wrap_text

_STAGES = "squeeze", "load"
_NO_FORCE = 0.005  # [N] a link that presses with less is not named
_BRIEFLY = Patience(250, snaps=False)
_ALIKE = 0.05  # of the way an object goes: as far apart may two ends be that are called the same

# ----------------------------------------------------------------
# A grasp that was found: the posture, the object where it is, and how far it is from being lost.


@dataclass(frozen=True, eq=False)
class Candidate(Record):
    """One grasp. Immutable.

    grasp : as `state.grasp` makes it. solution : its one solve.
    friction_reserve : 1 - Σ |f_t| / Σ μ f_n over all fingers [-], what is left of all the friction there is. A finger
        that slides has used up its own, and the others still hold.
    torque_reserve : 1 - |τ| / limit, the smallest of all joints with a known limit [-]; 1 where none is known.
    held_force : the largest force that is held beside the load in the worst of six directions, along the world's axes
        [N]. Of a grasp that a search found each push was followed, while the hand closes, is loaded and then pushed; of
        one that is cradled, against its load alone. Before that each is solved in this posture, with all of the load at
        once, which may say far more: nothing moves there that slips, rolls and turns on the way.
    cradled : the object is held by its weight, which presses it onto fingers: turned round, the weight is not held.
    kind : "pinch" or "power".
    gives_out : what gives out first under that force, in words; "" where it was not followed.
    """

    entries = (
        "kind", "q (nv,)", "object = _object", "object_position_m (3,) = object.frame.1",
        "object_rotation (3, 3) = object.frame.0", "held_force_N", "cradled", "margin", "friction_reserve",
        "torque_reserve", "pressing", "normal_force_N", "gives_out",
    )  # fmt: skip

    grasp: HandGrasp
    solution: Any
    friction_reserve: float
    torque_reserve: float
    held_force: float
    cradled: bool
    kind: str = "pinch"
    gives_out: str = ""

    @property
    def margin(self) -> float:
        """The smaller of the two reserves [-]: by what share friction, or the motors, could be weaker."""
        return min(self.friction_reserve, self.torque_reserve)

    @property
    def pressing(self) -> int:
        """How many of the fingers press on the object; the others only touch it, or let go under the load."""
        return sum(s != SEPARATED for s in contact_statuses(self.solution.contact_state[: self.grasp.spec.of_hand]))

    @property
    def rank(self) -> float:
        """What grasps are sorted by, the smallest first: minus the force that is held in the worst direction [N]. Those
        that only lie there, or use more than their torque, come after all others, the larger margin first.
        """
        if self.cradled or self.held_force <= 0.0 or self.margin <= 0.0:
            return 2.0 - self.margin
        return -self.held_force

    @property
    def state(self) -> HandPosture:
        """The hand in the posture that touches."""
        return self.grasp.state

    @property
    def q(self) -> Array:
        """(nv,) that posture [rad, m]."""
        return self.state.q

    @property
    def object(self) -> Object:
        """The object where it was placed."""
        target = self.grasp.target
        assert target is not None  # the search had one
        return target

    @lazy_property
    def verdict(self) -> Verdict:
        """As `grasp.check()` says it, without advice; made when it is first asked for. A pinch that snaps elsewhere, or
        slips and lets go again and again, is given up there: it is none that a search looks for.
        """
        section = as_section("cone", planar=False)
        return judge_grasp(self.grasp.spec, self.grasp.scene, section, _STAGES, self.solution, patience=self.patience)

    @property
    def patience(self) -> Patience:
        """With which a search follows it."""
        return _BRIEFLY if self.kind == "pinch" else PATIENT

    @property
    def sure(self) -> bool:
        """Whether the verdict is HELD, by a loading that was followed and on which the object never snapped elsewhere:
        where a snap ends depends on the steps.
        """
        path = self.verdict.loading
        return self.verdict.ok and path is not None and all(event.kind != "snaps" for event in path.events)

    @property
    def settles(self) -> bool:
        """Whether the verdict is HELD, and the object may snap on the way, but ends at the same place with finer
        steps. An object that was kept in place until the hand has closed often snaps by millimetres when it is let go.
        """
        path, section = self.verdict.loading, as_section("cone", planar=False)
        if not self.verdict.ok or path is None:
            return False
        finer = follow(self.grasp.spec, section, None, _STAGES, None, 2 * STEPS_PER_STAGE, None, 0.1 * ACCURACY)
        if not finer.in_place or len(finer.steps.states) <= len(path.steps.states):  # a check may take as many
            return False
        end, other = path.displacement.reshape(2, 3), finer.displacement.reshape(2, 3)  # moved [m] and turned [rad]
        return bool((abs(other - end).max(axis=1) <= _ALIKE * abs(end).max(axis=1)).all())

    @property
    def doubt(self) -> str:
        """Why the verdict is not sure, in words; the verdict's text where it is not HELD."""
        if not self.verdict.ok:
            return f"{self.verdict.word} says the check of it: {self.verdict.text}"
        told = self.verdict.about("not_followed")
        return told[0].sentence if told else "the object snaps elsewhere while it is loaded"

    @property
    def _object(self) -> str:
        return repr(self.object)

    @property
    def normal_force(self) -> dict[str, float]:
        """How hard each finger presses, by name [N]."""
        pressed: dict[str, float] = self.solution.pressed
        return pressed

    @property
    def largest_force(self) -> float:
        """The largest of these [N]."""
        return float(self.solution.normal_force.max())

    def __str__(self) -> str:
        then = f", where {self.gives_out}" if self.gives_out else ""
        if self.gives_out == UNDECIDED:
            then = ", and nothing is known beyond"
        only = ", cradled: the object only lies there" if self.cradled else ""
        how = "" if self.gives_out else " by one solve"
        return (
            f"{self.kind}: {words.format_force(self.held_force)} in the worst direction{how}{then}{only}; margin "
            f"{100 * self.margin:.0f} % (friction {100 * self.friction_reserve:.0f} %, "
            f"torque {100 * self.torque_reserve:.0f} %), {self._forces}"
        )

    @property
    def _forces(self) -> str:
        """In words: of a pinch finger by finger, of a power grasp the links that press hardest."""
        if self.kind != "power":
            return f"forces {', '.join(f'{f:.2g}' for f in self.solution.normal_force)} N"
        by_link, links = dict[str, float](), self.grasp.mechanism.report.links
        for name, force in self.normal_force.items():
            link = links.get(name, name)
            by_link[link] = by_link.get(link, 0.0) + force
        hardest = sorted(by_link.items(), key=lambda one: -one[1])
        pressing = [f"{link} {force:.2g} N" for link, force in hardest if force > _NO_FORCE]
        return f"pressing: {words.list_names(pressing) or 'nothing'}"

    def __repr__(self) -> str:
        return f"Candidate(margin={self.margin:.3f}, q={np.round(self.q, 4).tolist()}, object={self.object!r})"


def candidate_of(kind: str, grasp: HandGrasp, solution: GraspSolution) -> Candidate:
    """With its reserves, and what single solves hold."""
    held = solved(grasp, solution)
    return Candidate(grasp, solution, *reserves(grasp, solution), held.force, held.cradled, kind)


def reserves(grasp: HandGrasp, solution: GraspSolution) -> tuple[float, float]:
    """Of friction and of torque, as in `Candidate`; solution : an answer of the grasp."""
    scene, k = grasp.scene, grasp.spec.of_hand
    soft = list(scene.soft)
    moments = np.zeros(scene.n) if solution.torsion is None else solution.torsion
    forces, turning = np.split(scene.forces_to_law_axes(np.append(solution.forces, moments[soft])), [3 * scene.n])
    spin = np.zeros(scene.n)
    spin[soft] = turning
    x, y, z = forces.reshape(-1, 3).T
    used = float(np.hypot(np.hypot(x, y), spin)[:k].sum())
    there = float((scene.mu * z)[:k].sum())
    friction = 1.0 - used / there if there > 0.0 else 1.0
    torque = float(getattr(solution, "torque_check").utilisation.max(initial=0.0))  # noqa: B009
    return friction, 1.0 - torque


# ---------------------------------------------------------------- What a search for grasps gives back.

_COLUMNS = "margin", "friction_reserve", "torque_reserve", "pressing", "largest_force_N", "held_force_N", "kind"
_STEPS = {
    "laid": "against the palm", "tried": "placements tried",
    "touching": "touched by all fingers, without a link inside", "enclosing": "closed round the object",
    "balanced": "where forces within friction hold the object", "clear": "without links in each other, solved",
    "held": "held by one solve", "checked": "checked", "followed": "followed in all directions",
}  # fmt: skip


_STOPPED = {  # what is said where no placement came as far
    "touching": "nowhere do all fingers touch it without a link inside",
    "balanced": "where they touch it, no forces within friction hold it",
    "clear": "where they would hold it, links are in each other",
    "held": "one solve holds it nowhere",
}


@check_method_calls
class Found(Record, Sequence[Candidate]):
    """Grasps, sorted by `Candidate.rank`, the best first. Each is checked, its verdict is HELD, and followed. Prints in
    lines of at most 80 columns, with the warnings of the best one's verdict.

    tried : how many placements came how far: "sampled", "tried", "touching", "balanced", "clear", "held", "checked",
        "followed"; of power grasps "sampled", "laid", "tried", "settled", "enclosing", "clear", and so on.
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
        told = [reason.sentence for reason in self[0].verdict.warnings] if self else []
        warnings = [f"Warning: {sentence}." for sentence in (*self._weak(), *told)]
        grasps = [wrap_text(f"{k}: {one}", "   ") for k, one in enumerate(self)]
        return "\n".join([wrap_text(f"{self.why}."), *map(wrap_text, warnings), *grasps])

    def _weak(self) -> Iterator[str]:
        """A warning of power grasps the best of which does not hold as much as its load in every direction."""
        best = next((one for one in self if one.kind == "power"), None)
        load = 0.0 if best is None else float(np.linalg.norm(best.grasp.spec.wrench[:3]))
        if best is not None and best.held_force < load:
            most = words.format_force(best.held_force)
            held = f"the best power grasp holds {most} in the worst direction, less than its"
            yield f"{held} load of {words.format_force(load)}: the hand may lose the object when it is turned"

    def to_dict(self) -> dict[str, Any]:
        """Plain data, SI units in the keys: what became of the search, and each grasp as its own `to_dict` says it, the
        best with its verdict.
        """
        grasps = [one.to_dict() for one in self]
        if grasps:
            grasps[0]["verdict"] = self[0].verdict.to_dict()
        return pick_entries(self, "why", "tried") | {"grasps": grasps}

    def to_frame(self) -> Any:
        """A pandas table with a row for each grasp: margin, friction_reserve, torque_reserve, pressing, the largest
        normal force largest_force_N, held_force_N and kind. Raises Unsupported without pandas.
        """
        return make_data_frame(columns_from_rows(self, *_COLUMNS))

    def __repr__(self) -> str:
        return f"Found({len(self)} grasps)"


def stopped(tried: Mapping[str, int]) -> str:
    """Which step of a search no placement passed, in words."""
    return next((why for key, why in _STOPPED.items() if not tried.get(key)), "none is held to the end of its loading")


def told(tried: Mapping[str, int]) -> str:
    """How far a search came, in words."""
    parts = [f"{tried[key]} {words}" for key, words in _STEPS.items() if tried.get(key)]
    return f"{tried['sampled']} sampled, {', '.join(parts)}"
