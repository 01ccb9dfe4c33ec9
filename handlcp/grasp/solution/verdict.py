"""`Verdict`: does it hold? One word, and the reasons for it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np

from handlcp.check import Array, Bools, check_method_calls, read_only
from handlcp.errors import RequirementNotMet
from handlcp.grasp.effects import Effect
from handlcp.grasp.failure.reason import Reason as Reason, make_reason
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.status import SEPARATED, SLIDING, STICKING, ContactStatus, contact_statuses
from handlcp.grasp.solution.uniqueness import Uniqueness
from handlcp.lcp.problem import Status
from handlcp.record import Record
from handlcp.tolerances import MAX_FORCE_SHARE, NOTICED_SHARE
from handlcp.words import wrap_text

HELD, OVER_LIMIT, UNDECIDED, NOT_HELD = "HELD", "OVER LIMIT", "UNDECIDED", "NOT HELD"

_GRAVEST_FIRST = (NOT_HELD, UNDECIDED, OVER_LIMIT)  # the first that a reason decides is the word
# The word of each code that may decide; of the others none does. `no_squeeze`, `lost`, `slides`, `follow_stopped` and
# `closing_over_peak` come from a loading that is followed (`check`), `unplaced` from a study.
_DECIDED_WORD = {
    **dict.fromkeys(("not_holdable", "no_equilibrium", "no_squeeze", "lost", "slides"), NOT_HELD),
    **dict.fromkeys(("solver_stopped", "follow_stopped", "unplaced"), UNDECIDED),
    **dict.fromkeys(("link_inside", "joint_range", "large_motion", "command_not_made", "limit_shared"), UNDECIDED),
    **dict.fromkeys(("torque_over_limit", "tension_over_limit", "overheats", "closing_over_peak"), OVER_LIMIT),
}
_PARAGRAPH_HEADS = {"warning": "Warning", "advice": "Advice"}


@check_method_calls
@dataclass(frozen=True, slots=True)
class Verdict(Record):
    """Does it hold? Prints as the word and the reasons, in lines of at most 80 columns; its `repr` is the word and what
    decides it, on one line, so that pytest says why `assert grasp.check().ok` fails.

    word : "HELD"; "OVER LIMIT": the contacts hold, some motor cannot; "NOT HELD"; "UNDECIDED": no
    verdict can be given, since a solver stopped or the model does not hold there.
    reasons : those that decide the word first, then notes, warnings and advice.
    loading : the `Loading` that `grasp.check()` followed, whose last step the reasons are about; None where none was.
    """

    entries = ("word", "ok", "reasons")

    word: str
    reasons: tuple[Reason, ...]
    loading: Any = field(default=None, repr=False, compare=False)

    @property
    def ok(self) -> bool:
        """Whether the word is HELD."""
        return self.word == HELD

    @property
    def text(self) -> str:
        """What decides and what is so, in one sentence without the word and a full stop."""
        return "; ".join(r.sentence for r in self.reasons if r.severity not in _PARAGRAPH_HEADS)

    @property
    def warnings(self) -> tuple[Reason, ...]:
        """The doubts about the word."""
        return tuple(r for r in self.reasons if r.severity == "warning")

    @property
    def paragraphs(self) -> tuple[tuple[str, str], ...]:
        """(head, sentence) of each printed paragraph: the word, then "Warning"s and "Advice"."""
        rest = [(_PARAGRAPH_HEADS[r.severity], r.sentence) for r in self.reasons if r.severity in _PARAGRAPH_HEADS]
        return ((self.word, self.text), *rest)

    def require(self) -> Self:
        """This verdict, where it is HELD. Raises RequirementNotMet with all that it says, what decides first."""
        __tracebackhide__ = True  # of pytest, which shows the test that asks, and what is not met
        if not self.ok:
            raise RequirementNotMet([f"{head}: {sentence}." for head, sentence in self.paragraphs])
        return self

    def about(self, code: str) -> tuple[Reason, ...]:
        """The reasons with this code."""
        return tuple(r for r in self.reasons if r.code == code)

    def __repr__(self) -> str:
        return f"{self.word}: {self.text}." if self.text else f"{self.word}."

    def __str__(self) -> str:
        said = (f"{head}: {sentence}." if sentence else f"{head}." for head, sentence in self.paragraphs)
        return "\n".join(wrap_text(line) for line in said)


def make_verdict(reasons: Iterable[Reason], loading: Any = None) -> Verdict:
    """The verdict that these reasons make: the gravest that decides gives the word, HELD where none decides. Of reasons
    with one sentence the first counts.
    """
    every = list({r.sentence: r for r in reversed(list(reasons))}.values())[::-1]
    deciding = [r for r in every if r.severity == "decides"]
    deciding.sort(key=lambda r: _GRAVEST_FIRST.index(_DECIDED_WORD[r.code]))
    word = _DECIDED_WORD[deciding[0].code] if deciding else HELD
    others = [r for kind in ("note", "warning", "advice") for r in every if r.severity == kind]
    return Verdict(word, (*deciding, *others), loading)


# ----------------------------------------------------------------
# How far an answer goes beyond the equations of small motions, and by how much its forces may be off.
#
# share = max(turn, move / R, slip / R, squeeze / 10R, yield / 2)
#
# A contact that shifts by δ over a surface of radius R turns its normal by δ / R, and an object that turns by ω turns
# all its contacts by ω. Forces turn with them, by that share of their size. R is the distance of the contacts from
# their centre, which is the radius of a ball, and about that of other objects. The fingers give way to a squeeze, and
# the tips stay: it bends fingers that are several times as long as R. A joint that yields at its torque limit changes
# levers by half its angle or less.
#
# Of an object that nothing keeps where it was gripped, every contact that the squeeze presses on it slides or lets
# go. Where it comes to rest then hangs on its way there, on what the fingers touch while they close on, and on
# contacts that were never looked for, since it was elsewhere. So the share from which an answer says nothing is less
# there.


def force_error_share(turn: Any, move: Any, slip: Any, squeeze: Any, size: Any, yielded: Any = 0.0) -> Any:
    """By how much forces may be off, of their size: of one answer, or of many (m,). [rad, m, m, m, m, rad]"""
    way = np.maximum(np.maximum(move, slip), 0.1 * np.asarray(squeeze)) / size
    return np.maximum(np.maximum(turn, way), 0.5 * np.asarray(yielded))


def is_adrift(offset: Array, sticks: Bools, slides: Bools, mu: Array) -> Any:
    """Whether every finger that the squeeze presses on the object slides or has let go, and there are such fingers.

    offset (…, n) of fingers along the normals, below 0 where they are pressed [m]. sticks, slides, mu (…, n) : states
    and friction; what has none slides without being overcome.
    """
    pressed, keeps = offset < 0.0, sticks | (slides & (mu == 0.0))
    return pressed.any(axis=-1) & ~(pressed & keeps).any(axis=-1)


def is_beyond_small_motions(share: Any, adrift: Any) -> Any:
    """Whether the equations of small motions say nothing of an answer, or of which of many (m,)."""
    return np.asarray(share) >= np.where(adrift, NOTICED_SHARE, MAX_FORCE_SHARE)


@dataclass(frozen=True, slots=True)
class MotionSizes:
    """How large the motions of an answer are, beside what equations of small motions can say.

    move_m : of the object's contact points, at most. turn_rad : of the object. slip_m, squeeze_m : the largest.
    size_m : R of the grasp. yield_rad : the largest, of a joint at its torque limit. adrift : see `is_adrift`.
    """

    move_m: float
    turn_rad: float
    slip_m: float
    squeeze_m: float
    size_m: float
    yield_rad: float = 0.0
    adrift: bool = False

    @property
    def share(self) -> float:
        """By how much forces may be off, of their size."""
        way = self.slip_m, self.squeeze_m, self.size_m
        return float(force_error_share(self.turn_rad, self.move_m, *way, self.yield_rad))

    @property
    def too_large(self) -> bool:
        """Whether the equations of small motions say nothing."""
        return bool(is_beyond_small_motions(self.share, self.adrift))

    @property
    def values(self) -> dict[str, Any]:
        """What a reason says of them."""
        *sizes, adrift = asdict(self).items()
        return dict([*sizes, ("force_error", self.share), adrift])


def solution_motions(s: Any) -> MotionSizes:
    """Of a `GraspSolution` with an answer."""
    scene, size, fingers = s.scene, s.scene.units.length_unit, s.scene.n - s.scene.environment
    shift, turn = (float(np.linalg.norm(part)) for part in (s.object_displacement[:3], s.object_displacement[3:]))
    offset = scene.motions_to_contact_axes(scene.offset)[2 : 3 * scene.n : 3]
    slip, yielded = float(np.hypot(*s.slip.T).max(initial=0.0)), getattr(s, "joint_yield", np.zeros(1))
    sticks, slides = (
        np.array([now == state for now in contact_statuses(s.contact_state)]) for state in (STICKING, SLIDING)
    )
    adrift = is_adrift(offset[:fingers], sticks[:fingers], slides[:fingers], scene.mu[:fingers])
    squeeze = -float(offset.min(initial=0.0))
    return MotionSizes(
        max(shift, turn * size), turn, slip, squeeze, size, float(abs(yielded).max(initial=0.0)), bool(adrift)
    )


# ----------------------------------------------------------------
# How much of its friction a contact uses.
#
# used = |r̂_T| / (μ r_N)        margin = μ r_N - |r̂_T|
#
# r̂_T are the tangential forces in the coordinates of the friction law (`contact/friction/law.py`), the moment of a soft
# finger among them, so that used = 1 is the limit of every law.


def friction_used(scene: Scene, forces: Array, torsion: Array | None) -> Array:
    """(n,) from forces (n, 3) in contact axes [N] and moments (n,) about the normals [N·m]; NaN where there is no
    friction, or no normal force.
    """
    tangential, limit = _friction_and_limit(scene, forces, torsion)
    return read_only(tangential / np.where(limit > 0.0, limit, np.nan))


def friction_margin(scene: Scene, forces: Array, torsion: Array | None) -> Array:
    """(n,) N, arguments as above; NaN where there is no friction."""
    tangential, limit = _friction_and_limit(scene, forces, torsion)
    return read_only(np.where(scene.mu > 0.0, limit - tangential, np.nan))


def _friction_and_limit(scene: Scene, forces: Array, torsion: Array | None) -> tuple[Array, Array]:
    """Friction force |r̂_T| and its limit μ r_N of each contact, (n,) each [N]."""
    soft = list(scene.soft)
    moments = np.zeros(scene.n) if torsion is None else torsion[soft]
    lawful, turning = np.split(scene.forces_to_law_axes(np.append(forces, moments if soft else [])), [3 * scene.n])
    moment = np.zeros(scene.n)
    moment[soft] = turning
    x, y, z = lawful.reshape(-1, 3).T
    return np.hypot(np.hypot(x, y), moment), scene.mu * z


# ----------------------------------------------------------------
# What one solution says about holding the object, as the reasons of a verdict.

LITTLE_MARGIN_SHARE = 0.95  # of the friction limit: a contact that uses more has hardly any margin
_UNNAMED_SHARE = 5e-4  # of the friction limit: less is not worth a word
_TWIST_TOLERANCE = 1e-4  # [rad] a soft finger that turns less on the object is not said to twist


def solution_reasons(s: Any) -> Iterator[Reason]:
    """Of a `GraspSolution`, which imports this file."""
    if not s.held:
        yield equilibrium_reason(s.status, s.diagnosis)
    elif s.spec is not None and s.scene is not None:
        yield from load_reasons(s.spec)
        yield from effect_reasons(s.spec.effects, s)
        slips, states = np.hypot(*s.slip.T).tolist(), contact_statuses(s.contact_state)
        spins = np.zeros(len(slips)) if s.spin is None else abs(s.spin)
        sliding = {n: d for n, state, d in zip(s.names, states, slips, strict=True) if state == SLIDING}
        turns = {n: float(a) for n, a in zip(s.names, spins, strict=True) if a > _TWIST_TOLERANCE}
        apart = [n for n, state in zip(s.names, states, strict=True) if state == SEPARATED]
        yield contacts_reason(s.spec, sliding, turns, apart)
        yield from friction_reasons(s.names, s.friction_used, states)
        yield motion_reason(s.object_displacement, s.scene.force, s.scene.units.length_unit)
        yield from open_reasons(s.uniqueness)
        yield from large_motion_reasons(solution_motions(s))


def equilibrium_reason(status: Status, diagnosis: str) -> Reason:
    """Why there is no answer."""
    if status is Status.UNDECIDED:
        return make_reason("solver_stopped", "decides")
    code = "not_holdable" if status is Status.NOT_HOLDABLE else "no_equilibrium"
    return make_reason(code, "decides", {"status": status.name}, diagnosis=diagnosis)


def effect_reasons(effects: Iterable[Effect], s: Any) -> Iterator[Reason]:
    """Which bounds of effects are reached at a solution, and how far they give way."""
    for e in effects:
        for part in e.words(s.scene, s.names, s.extra):
            yield make_reason("effect", "note", {"effect": e.title}, text=part)


def large_motion_reasons(found: MotionSizes) -> Iterator[Reason]:
    """Of motions that are too large for the equations of small ones."""
    if found.share > NOTICED_SHARE:
        yield make_reason("large_motion", "decides" if found.too_large else "warning", found.values)


def contacts_reason(
    spec: GraspSpec, sliding: Mapping[str, float], turns: Mapping[str, float], apart: Sequence[str]
) -> Reason:
    """Which contacts of a grasp slide [m], twist on the object [rad] or let go."""
    values = {"sliding_m": dict(sliding), "twisting_rad": dict(turns), "separated": list(apart)}
    return make_reason("contacts", "note", values, who=spec.who, count=spec.n, links=spec.links)


def friction_reasons(
    names: Sequence[str], used: Array, states: Sequence[ContactStatus], when: str = ""
) -> Iterator[Reason]:
    """How near the contacts are to sliding; a warning where hardly any friction is left. used, states (n,). when : such
    as " at the end".
    """
    every = list(zip(names, used.tolist(), states, strict=True))
    sticks = [(x, n) for n, x, state in every if state == STICKING and x >= 0.0]
    slides = any(state == SLIDING and x > 0.0 for _, x, state in every)
    values = {"used": {n: x for n, x, _ in every if np.isfinite(x)}}
    if not sticks and slides:
        yield make_reason("friction", "warning", values, "none")
    elif sticks and (most := max(x for x, _ in sticks)) > _UNNAMED_SHARE:
        who = next(n for x, n in sticks if x >= (1.0 - 1e-6) * most)  # the first of equals
        case = "little" if most >= LITTLE_MARGIN_SHARE else "some slide" if slides else ""
        severity = "warning" if case == "little" else "note"
        yield make_reason("friction", severity, values, case, most=most, finger=who, when=when)


def motion_reason(displacement: Array, load: Array, size: float) -> Reason:
    """How far the object moves (6,), how much of that along the load (3,), and how far it turns; size of the grasp."""
    move, turn, strength = (float(np.linalg.norm(part)) for part in (displacement[:3], displacement[3:], load))
    along = float(displacement[:3] @ load) / strength if strength > 0 else None
    return make_reason("motion", "note", {"move_m": move, "turn_rad": turn}, along=along, size=size)


def load_reasons(spec: GraspSpec) -> Iterator[Reason]:
    """Of a grasp whose object nothing loads: a mass may have been forgotten."""
    if not spec.wrench.any():
        yield make_reason("no_load", "note")


def open_reasons(free: Uniqueness | None) -> Iterator[Reason]:
    """What the equations leave open."""
    if free is None:
        return
    case = "" if free.smallest else "followed"
    if not free.forces_determined:
        yield make_reason("forces_open", "warning", case=case)
    if k := free.loose_motions:
        yield make_reason("loose", "warning", {"directions": k}, case)
    if free.others:
        yield make_reason("others", "warning")
