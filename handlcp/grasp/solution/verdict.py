"""`Verdict`: does it hold? One word, and the reasons for it.

| code | what it is about |
| --- | --- |
| `not_holdable`, `no_equilibrium` | no force within friction balances the load; no elastic equilibrium exists |
| `no_squeeze` | nothing was said that closes the hand, and the load is not held without |
| `lost` | the order of loading loses the object on its way |
| `slides_through` | the object slides through, or snaps, on its way: how far it jumps is not for statics to say |
| `steps_differ` | fewer and more steps of loading end differently |
| `solver_stopped`, `follow_stopped` | a solver, or the loading in steps, ended without an answer |
| `link_inside`, `joint_range` | a posture that the hand cannot take: a link inside the object, a joint past its range |
| `large_motion`, `followed_forces` | motions, or forces, that the equations of small motions miss |
| `torque_over_limit`, `torque`, `limit_unknown`, `limit_doubtful` | what the joints bear, and what is known of it |
| `tension_over_limit`, `tension`, `slack` | what tendons bear, and which of them hang slack |
| `closing_torque` | fingers that pull with less than was asked for, once the hand has closed |
| `overheats`, `closing_over_peak` | what motors of joints or tendons hold for a while; what closing takes beyond peak |
| `limit_shared` | limits of motors that are those of no joint alone: whether motors hold is not known |
| `hand_doubtful` | a serious doubt of the hand's audit that is not about torque limits |
| `unplaced` | a sample of a study that is no grasp, such as one with a contact past an edge |
| `rigid_tips` | fingertips without pads, where that may be why the object is lost |
| `torques_open` | between what and what torques are, where statics leaves forces open |
| `command_not_made` | a command that tendons, which only pull, or servos make in part alone |
| `out_of_reach` | a part of the squeeze that no command of the joints makes |
| `effect`, `contacts`, `motion` | bounds reached; what slides or lets go; how the object moves |
| `no_load` | neither a weight nor a wrench loads the object |
| `weight_left_out` | `replace(wrench=...)` gave the whole load, without the object's weight |
| `friction` | how much of their friction the contacts use that stick |
| `forces_open`, `loose`, `others` | what the equations leave open |
| `snaps` | the object leaves its place on the way, and comes to rest at another |
| `not_followed`, `only_followed` | the order of loading was not followed; one solve and the steps disagree |
| `advice` | a change that was tried, and holds; or that nothing tried does |
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from handlcp import words
from handlcp.check import Array, Bools, check_method_calls, read_only
from handlcp.errors import RequirementNotMet
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.status import SEPARATED, SLIDING, STICKING, ContactStatus, contact_statuses
from handlcp.grasp.solution.uniqueness import Uniqueness
from handlcp.lcp.problem import Status
from handlcp.record import Record
from handlcp.tolerances import MAX_FORCE_SHARE, NOTICED_SHARE
from handlcp.words import wrap_text

HELD, OVER_LIMIT, UNDECIDED, NOT_HELD = "HELD", "OVER LIMIT", "UNDECIDED", "NOT HELD"

_WORD_ORDER = (NOT_HELD, UNDECIDED, OVER_LIMIT)  # the first that a reason decides is the word
# The word of each code that may decide; of the others none does. `no_squeeze`, `lost`, `slides_through`,
# `steps_differ`, `follow_stopped` and `closing_over_peak` come from a loading that is followed (`check`), `unplaced`
# from a study.
_DECIDED_WORD = {
    "not_holdable": NOT_HELD,
    "no_equilibrium": NOT_HELD,
    "no_squeeze": NOT_HELD,
    "lost": NOT_HELD,
    "slides_through": NOT_HELD,
    "steps_differ": UNDECIDED,
    "solver_stopped": UNDECIDED,
    "follow_stopped": UNDECIDED,
    "link_inside": UNDECIDED,
    "joint_range": UNDECIDED,
    "large_motion": UNDECIDED,
    "torque_over_limit": OVER_LIMIT,
    "tension_over_limit": OVER_LIMIT,
    "overheats": OVER_LIMIT,
    "closing_over_peak": OVER_LIMIT,
    "unplaced": UNDECIDED,
    "command_not_made": UNDECIDED,
    "limit_shared": UNDECIDED,
}
_PARAGRAPH_HEADS = {"warning": "Warning", "advice": "Advice"}


@dataclass(frozen=True, slots=True)
class Reason:
    """One reason of a verdict.

    code : what it is about, see the top of this file. severity : "decides": with it the word cannot be HELD;
    "warning": a doubt about the word; "note": what is so; "advice": what would help. sentence : without a full stop.
    values : its numbers and names, SI units in the keys.
    """

    code: str
    severity: str
    sentence: str
    values: Mapping[str, Any] = field(default_factory=dict)


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
    """The verdict that these reasons make; of reasons with one sentence the first counts."""
    every = list({r.sentence: r for r in reversed(list(reasons))}.values())[::-1]
    deciding = [r for r in every if r.severity == "decides"]
    ranks = sorted(deciding, key=lambda r: _WORD_ORDER.index(_DECIDED_WORD[r.code]))
    word = _DECIDED_WORD[ranks[0].code] if ranks else HELD
    by_kind = [[r for r in every if r.severity == kind] for kind in ("note", "warning", "advice")]
    return Verdict(word, (*ranks, *by_kind[0], *by_kind[1], *by_kind[2]), loading)


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

    move : of the object's contact points, at most [m]. turn : of the object [rad].
    slip, squeeze : the largest [m]. size : R of the grasp [m].
    yielded : the largest, of a joint at its torque limit [rad]. adrift : see `is_adrift`.
    """

    move: float
    turn: float
    slip: float
    squeeze: float
    size: float
    yielded: float = 0.0
    adrift: bool = False

    @property
    def share(self) -> float:
        """By how much forces may be off, of their size."""
        return float(force_error_share(self.turn, self.move, self.slip, self.squeeze, self.size, self.yielded))

    @property
    def too_large(self) -> bool:
        """Whether the equations of small motions say nothing."""
        return bool(is_beyond_small_motions(self.share, self.adrift))

    @property
    def sentence(self) -> str:
        """What is large, and what that means for the forces; "" where nothing is."""
        parts = []
        if max(self.turn, self.move / self.size) > NOTICED_SHARE:
            parts.append(f"the object moves {words.format_length(self.move)} and turns {words.format_angle(self.turn)}")
        if self.slip > NOTICED_SHARE * self.size:
            parts.append(f"a contact slips {words.format_length(self.slip)}")
        if 0.1 * self.squeeze > NOTICED_SHARE * self.size:
            parts.append(f"the fingers squeeze by {words.format_length(self.squeeze)}")
        if 0.5 * self.yielded > NOTICED_SHARE:
            parts.append(f"a joint yields by {words.format_angle(self.yielded)}")
        if not parts:
            return ""
        if self.share >= MAX_FORCE_SHARE:
            return f"{', '.join(parts)}: the equations of small motions say nothing about that"
        if self.too_large:
            way = "everything that closing presses on the object slides or lets go: where it ends one solve cannot tell"
            return f"{', '.join(parts)}, and {way}; check() follows it"
        return (
            f"{', '.join(parts)}: the equations are of small motions, and forces may be off by about "
            f"{words.format_percent(self.share)}"
        )


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
# Why an answer holds or does not, in reasons of a verdict: status, friction, motions that are not small.


# ---------------------------------------------------------------- How much of its friction a contact uses.
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
_STILL_DISTANCE = 1e-7  # [m] an object that moves less is not said to move
_MAX_NAMED = 4  # contacts that are named one by one
_TWIST_TOLERANCE = 1e-4  # [rad] a soft finger that turns less on the object is not said to twist
_STATUS_CODES = {Status.NOT_HOLDABLE: "not_holdable", Status.NO_EQUILIBRIUM: "no_equilibrium"}


def solution_reasons(s: Any) -> Iterator[Reason]:
    """Of a `GraspSolution`, which imports this file."""
    if not s.held:
        yield equilibrium_reason(s.status, s.diagnosis)
    elif s.spec is not None and s.scene is not None:
        yield from no_load_reasons(s.spec)
        for e in s.spec.effects:  # which bounds are reached, and how far they give way
            for part in e.words(s.scene, s.names, s.extra):
                yield Reason("effect", "note", part, {"effect": e.title})
        yield _contact_reason(s)
        yield from friction_reasons(s.names, s.friction_used, contact_statuses(s.contact_state))
        yield motion_reason(s.object_displacement, s.scene.force, s.scene.units.length_unit)
        yield from open_reasons(s.uniqueness)
        yield from large_motion_reasons(solution_motions(s))


def equilibrium_reason(status: Status, diagnosis: str) -> Reason:
    """Why there is no answer."""
    if status is Status.UNDECIDED:
        why = "the solver stopped before it found an answer, which says nothing about the grasp"
        return Reason("solver_stopped", "decides", f"{why}; try another seed or number of faces")
    return Reason(_STATUS_CODES.get(status, "solver_stopped"), "decides", diagnosis, {"status": status.name})


def large_motion_reasons(found: MotionSizes) -> Iterator[Reason]:
    """Of motions that are too large for the equations of small ones."""
    if text := found.sentence:
        severity = "decides" if found.too_large else "warning"
        values = {
            "move_m": found.move,
            "turn_rad": found.turn,
            "slip_m": found.slip,
            "squeeze_m": found.squeeze,
            "size_m": found.size,
            "yield_rad": found.yielded,
            "force_error": found.share,
            "adrift": found.adrift,
        }
        yield Reason("large_motion", severity, text, values)


def _contact_reason(s: Any) -> Reason:
    """What the contacts of a `GraspSolution` do."""
    slips, states = np.hypot(*s.slip.T).tolist(), contact_statuses(s.contact_state)
    spins = np.zeros(len(slips)) if s.spin is None else abs(s.spin)
    sliding = {n: d for n, state, d in zip(s.names, states, slips, strict=True) if state == SLIDING}
    turns = {n: float(a) for n, a in zip(s.names, spins, strict=True) if a > _TWIST_TOLERANCE}
    apart = [n for n, state in zip(s.names, states, strict=True) if state == SEPARATED]
    return contacts_reason(s.spec, sliding, turns, apart)


def contacts_reason(
    spec: GraspSpec, sliding: Mapping[str, float], turns: Mapping[str, float], apart: Sequence[str]
) -> Reason:
    """Which contacts of a grasp slide [m], twist on the object [rad] or let go; "all stick" where none does."""
    parts, who, count = [], f"{spec.who}s", spec.n
    if sliding and len(sliding) == count > 1:
        parts.append(f"all {who} slide, up to {words.format_length(max(sliding.values()))}")
    elif sliding:
        parts.append(
            _describe_slides({n: d for n, d in sliding.items() if d > words.NEGLIGIBLE_LENGTH or not turns}, spec)
        )
    if turns and len(sliding) < max(count, 2):
        parts.append(", ".join(f"{n} twists by {words.format_angle(a)} on the object" for n, a in turns.items()))
    if apart:
        gone = words.group_by_link(apart, spec.links) if len(apart) > _MAX_NAMED else apart
        parts.append(f"{words.list_names(gone)} {'let' if len(apart) > 1 else 'lets'} go")
    text = "; ".join(p for p in parts if p) or f"all {who} stick"
    values = {"sliding_m": dict(sliding), "twisting_rad": dict(turns), "separated": list(apart)}
    return Reason("contacts", "note", text, values)


def _describe_slides(sliding: Mapping[str, float], spec: GraspSpec) -> str:
    """How far each of a few contacts slides [m]; of many those of one link together, or how many there are."""
    if len(sliding) <= _MAX_NAMED:
        ways = words.format_lengths(sliding.values())
        return ", ".join(f"{n} slides {way}" for n, way in zip(sliding, ways, strict=True))
    farthest = dict[str, list[float]]()
    for name, far in sliding.items():
        farthest.setdefault(spec.links.get(name, name), []).append(far)
    if len(farthest) > _MAX_NAMED:
        most = max(sliding, key=lambda name: sliding[name])
        return f"{len(sliding)} of {spec.n} {spec.who}s slide, up to {words.format_length(sliding[most])} ({most})"
    ways = words.format_lengths([max(far) for far in farthest.values()])
    named = zip(words.group_by_link(list(sliding), spec.links), farthest.values(), ways, strict=True)
    return ", ".join(f"{who} {'slides' if len(far) == 1 else 'slide up to'} {way}" for who, far, way in named)


def friction_reasons(
    names: Sequence[str], used: Array, states: Sequence[ContactStatus], when: str = ""
) -> Iterator[Reason]:
    """How near the contacts are to sliding; a warning where hardly any friction is left. used, states (n,). when : such
    as " at the end".
    """
    every = list(zip(names, used.tolist(), states, strict=True))
    sticks = [(x, n) for n, x, state in every if state == STICKING and x >= 0.0]
    slides = [n for n, x, state in every if state == SLIDING and x > 0.0]
    values = {"used": {n: x for n, x, _ in every if np.isfinite(x)}}
    if not sticks and slides:
        text = "friction is used up at every contact that pushes: nothing is left for a disturbance"
        yield Reason("friction", "warning", text, values)
    elif sticks and (most := max(x for x, _ in sticks)) > _UNNAMED_SHARE:
        who = next(n for x, n in sticks if x >= (1.0 - 1e-6) * most)  # the first of equals
        others = "of those that stick " if slides else ""
        text = f"friction {others}is used up to {words.format_percent(most)}{when} ({who})"
        if most >= LITTLE_MARGIN_SHARE:
            warning = f"{who} uses {words.format_percent(most)} of its friction: a little more load makes it slide"
            yield Reason("friction", "warning", warning, values)
        else:
            yield Reason("friction", "note", text, values)


def motion_reason(displacement: Array, load: Array, size: float) -> Reason:
    """How far the object moves (6,), how much of that along the load (3,), and how far it turns; size of the grasp."""
    u = displacement
    move, turn = float(np.linalg.norm(u[:3])), float(np.linalg.norm(u[3:]))
    strength, values = float(np.linalg.norm(load)), {"move_m": move, "turn_rad": turn}
    if max(move, turn * size) < words.NEGLIGIBLE_LENGTH:
        return Reason("motion", "note", "the object stays where it is", values)
    if max(move, turn * size) < _STILL_DISTANCE:
        return Reason("motion", "note", "the object does not move noticeably", values)
    along = float(u[:3] @ load) / strength if strength > 0 else 0.0
    moves, part = words.format_lengths([move, abs(along)])
    text = f"the object moves {moves}"
    if strength > 0:
        way = "along" if along >= 0 else "against"
        text += f" {way} the load" if part == moves else f", {part} of it {way} the load,"
    text = f"{text} and turns {words.format_angle(turn)}" if turn > 1e-4 else text.removesuffix(",")
    return Reason("motion", "note", text, values)


def no_load_reasons(spec: Any) -> Iterator[Reason]:
    """Of a grasp whose object nothing loads: a mass may have been forgotten."""
    if not spec.wrench.any():
        text = "no load: no weight acts on the object, and no wrench was given"
        yield Reason("no_load", "note", text)


def open_reasons(free: Uniqueness | None) -> Iterator[Reason]:
    """What the equations leave open."""
    if free is None:
        return
    if not free.forces_determined:
        given = "the smallest" if free.smallest else "those that the loading led to"
        text = f"other forces satisfy the same conditions; {given} are given"
        yield Reason("forces_open", "warning", text)
    if k := free.loose_motions:
        given = "the smallest motion is given" if free.smallest else "what the loading led to is given"
        text = f"the object can move freely in {k} direction{'s' if k > 1 else ''}; {given}"
        yield Reason("loose", "warning", text, {"directions": k})
    if free.others:
        text = "friction can hold the object in other ways, too; grasp.equilibria() lists them"
        yield Reason("others", "warning", text)
