"""`Reason`: one reason of a verdict, and where its sentence is made of a code and numbers.

A sentence that is one field alone was made before, with what it is about, such as a doubt of the audit.

| code | what it is about |
| --- | --- |
| `not_holdable`, `no_equilibrium` | no force within friction balances the load; no elastic equilibrium exists |
| `no_squeeze` | nothing was said that closes the hand, and the load is not held without |
| `lost` | the order of loading loses the object on its way |
| `slides` | a contact slides farther than it may, or the loaded object snaps: how far it jumps inertia decides |
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
| `pressed_in` | a pad that gives way farther than real ones do |
| `torques_open` | between what and what torques are, where statics leaves forces open |
| `command_not_made` | a command that tendons, which only pull, or servos make in part alone |
| `out_of_reach` | a part of the squeeze that no command of the joints makes |
| `effect`, `contacts`, `motion` | bounds reached; what slides or lets go; how the object moves |
| `object_kept` | the object stays in place until the hand has closed |
| `no_load` | neither a weight nor a wrench loads the object |
| `weight_left_out` | `replace(wrench=...)` gave the whole load, without the object's weight |
| `friction` | how much of their friction the contacts use that stick |
| `forces_open`, `loose`, `others` | what the equations leave open |
| `snaps` | the object leaves its place on the way, and comes to rest at another |
| `not_followed`, `only_followed` | the order of loading was not followed; one solve and the steps disagree |
| `advice` | a change that was tried, and holds; or that nothing tried does |
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from string import Formatter
from typing import Any

import numpy as np

from handlcp import words
from handlcp.tolerances import MAX_FORCE_SHARE, NOTICED_SHARE

Values = Mapping[str, Any]


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


def make_reason(code: str, severity: str, values: Values | None = None, case: str = "", **beside: Any) -> Reason:
    """The reason with this code and the sentence that its values make.

    case : which of the sentences of a code. beside : what the sentence says besides, and programs do not read.
    """
    values = values or {}
    sentence, known = _SENTENCES[f"{code}: {case}" if case else code], {**values, **beside}
    text = _FORMATTER.vformat(sentence, (), known) if isinstance(sentence, str) else sentence(known)
    return Reason(code, severity, text, values)


def format_span(least: float, most: float) -> str:
    """Of a limit, such as "40 to 120 %"."""
    low, high = words.format_percent(least), words.format_percent(most)
    if not np.isfinite(most):
        return f"{low} to ∞" if np.isfinite(least) else "∞"
    return low if low == high else f"{low.removesuffix(' %')} to {high}"


# ----------------------------------------------------------------
# What stands behind the colon of a field in a sentence: how its value is written. "a|b" is a for one and b for several.


def _list_efforts(rows: Sequence[tuple[str, float, float, str]], needs: str = "") -> str:
    """Of rows (name, effort, limit, unit), such as "finger_1 0.21 N·m of 0.2 N·m"."""
    return words.list_names(
        [f"{name} {needs}{' of '.join(words.format_efforts((x, limit), unit))}" for name, x, limit, unit in rows]
    )


def _mention_others(count: int) -> str:
    if count == 1:
        return ", and 1 more joint may need more than its limit"
    return f", and {count} more may need more than their limits" if count else ""


_WRITERS: dict[str, Callable[[Any], str]] = {
    "percent": words.format_percent,
    "length": words.format_length,
    "angle": words.format_angle,
    "duration": words.format_duration,
    "names": words.list_names,
    "behind": lambda word: f" {word}" if word else "",
    "or": words.join_alternatives,
    "span": lambda both: format_span(*both),
    "effort": lambda both: words.format_effort(*both),
    "efforts": _list_efforts,
    "needs": lambda rows: _list_efforts(rows, "needs "),
    "with": lambda rows: words.list_names([f"{name} with {words.format_effort(*both)}" for name, *both in rows]),
    "gives": lambda rows: words.list_names(
        [f"{name} gives {words.format_percent(x)} of continuous" for name, x in rows]
    ),
    "others": _mention_others,
    "inside": lambda links: words.join_names(
        [f"{words.format_length(one['depth_m'])} inside {one['link']}" for one in links]
    ),
}


class _SentenceFormatter(Formatter):
    """Writes the fields of a sentence with `_WRITERS`."""

    def format_field(self, value: Any, format_spec: str) -> str:
        one, several, many = format_spec.partition("|")
        if several:
            return many if (value if isinstance(value, int) else len(value)) > 1 else one
        return _WRITERS[format_spec](value) if format_spec else str(value)


_FORMATTER = _SentenceFormatter()

# ---------------------------------------------------------------- Sentences that are put together of parts.

_MAX_NAMED = 4  # contacts that are named one by one
_NO_POSTURE = "the hand cannot take this posture"
_STILL_DISTANCE = 1e-7  # [m] an object that moves less is not said to move


def _describe_contacts(v: Values) -> str:
    """With what contacts are called (who), how many there are (count), and on which link each is (links)."""
    sliding, turns, apart, who = v["sliding_m"], v["twisting_rad"], v["separated"], f"{v['who']}s"
    parts = []
    if sliding and len(sliding) == v["count"] > 1:
        parts.append(f"all {who} slide, up to {words.format_length(max(sliding.values()))}")
    elif sliding:
        far = {n: d for n, d in sliding.items() if d > words.NEGLIGIBLE_LENGTH or not turns}
        parts.append(_describe_slides(far, v))
    if turns and len(sliding) < max(v["count"], 2):
        parts.append(", ".join(f"{n} twists by {words.format_angle(a)} on the object" for n, a in turns.items()))
    if apart:
        gone = words.group_by_link(apart, v["links"]) if len(apart) > _MAX_NAMED else apart
        parts.append(f"{words.list_names(gone)} {'let' if len(apart) > 1 else 'lets'} go")
    return "; ".join(p for p in parts if p) or f"all {who} stick"


def _describe_slides(sliding: Mapping[str, float], v: Values) -> str:
    """How far each of a few contacts slides [m]; of many those of one link together, or how many there are."""
    if len(sliding) <= _MAX_NAMED:
        ways = words.format_lengths(sliding.values())
        return ", ".join(f"{n} slides {way}" for n, way in zip(sliding, ways, strict=True))
    farthest = dict[str, list[float]]()
    for name, far in sliding.items():
        farthest.setdefault(v["links"].get(name, name), []).append(far)
    if len(farthest) > _MAX_NAMED:
        most = max(sliding, key=lambda name: sliding[name])
        up_to = f"up to {words.format_length(sliding[most])} ({most})"
        return f"{len(sliding)} of {v['count']} {v['who']}s slide, {up_to}"
    ways = words.format_lengths([max(far) for far in farthest.values()])
    named = zip(words.group_by_link(list(sliding), v["links"]), farthest.values(), ways, strict=True)
    return ", ".join(f"{who} {'slides' if len(far) == 1 else 'slide up to'} {way}" for who, far, way in named)


def _describe_motion(v: Values) -> str:
    """With the part of the motion that is along the load [m], None without one, and the size of the grasp [m]."""
    move, turn, along = v["move_m"], v["turn_rad"], v["along"]
    if max(move, turn * v["size"]) < words.NEGLIGIBLE_LENGTH:
        return "the object stays where it is"
    if max(move, turn * v["size"]) < _STILL_DISTANCE:
        return "the object does not move noticeably"
    moves, part = words.format_lengths([move, abs(along or 0.0)])
    text = f"the object moves {moves}"
    if along is not None:
        way = "along" if along >= 0 else "against"
        text += f" {way} the load" if part == moves else f", {part} of it {way} the load,"
    return f"{text} and turns {words.format_angle(turn)}" if turn > 1e-4 else text.removesuffix(",")


def _describe_penetration(v: Values) -> str:
    """Of links that are alike, the deepest first; whether fingertips alone may touch, whether `links=` leaves the links
    out, and whether they are so deep (far) that the hand cannot be there.
    """
    first, more = v["links"][0], len(v["links"]) - 1
    depth, tip = words.format_length(first["depth_m"]), first["fingertip"]
    who = f"{first['link']} and {more} more link{'s' if more > 1 else ''} are up to" if more else f"{first['link']} is"
    if tip is not None:
        kind = "fingertip" if v["tips_alone"] else "contact"
        than = f"their {kind}s" if more else f"its {kind} {tip}"
        text = f"{v['when']}, {who} {depth} deeper in the object than {than}"
    else:
        text = f"{v['when']}, {who} {depth} inside the object"
    if not v["tips_alone"] and tip is None:
        them = "them" if more else "it"
        lets = f"links= leaves {them} out" if v["left_out"] else f"a larger max_gap lets {them} touch"
        return f"{text}, and {'they are' if more else 'it is'} not among the contacts: {lets}"
    if v["far"]:
        return f"{text}: {_NO_POSTURE}"
    return f"{text}: only fingertips are taken to touch it" if v["tips_alone"] else text


def describe_large_motion(v: Values) -> str:
    """What is large of motions whose `force_error` is noticed, and what that means for the forces."""
    move, turn, slip, squeeze, size = (v[key] for key in ("move_m", "turn_rad", "slip_m", "squeeze_m", "size_m"))
    parts = []
    if max(turn, move / size) > NOTICED_SHARE:
        parts.append(f"the object moves {words.format_length(move)} and turns {words.format_angle(turn)}")
    if slip / size > NOTICED_SHARE:
        parts.append(f"a contact slips {words.format_length(slip)}")
    if 0.1 * squeeze / size > NOTICED_SHARE:
        parts.append(f"the fingers squeeze by {words.format_length(squeeze)}")
    if 0.5 * v["yield_rad"] > NOTICED_SHARE:
        parts.append(f"a joint yields by {words.format_angle(v['yield_rad'])}")
    if v["force_error"] >= MAX_FORCE_SHARE:
        return f"{', '.join(parts)}: the equations of small motions say nothing about that"
    if v["adrift"]:
        way = "everything that closing presses on the object slides or lets go: where it ends one solve cannot tell"
        return f"{', '.join(parts)}, and {way}; check() follows it"
    off = f"forces may be off by about {words.format_percent(v['force_error'])}"
    return f"{', '.join(parts)}: the equations are of small motions, and {off}"


# ---------------------------------------------------------------- The table: a sentence, or what makes it.

_ONE_SOLVE = "one solve, with squeeze and load at once in this posture"
_LISTED = "grasp.equilibria() lists them"
_SLIDES_ON = "loaded slowly it moves by {moved_m:length} and {turned_rad:angle} in all; a sudden load moves it farther"
_NO_PADS = (
    "no pads: where joints do not give way nothing does, and small differences decide what slips; "
    "pass pad_flexibility, such as 1e-4 m/N for rubber"
)
_PULLS_LESS = "where the hand has closed, fingers pull with less than the closing torque: {rows:efforts}"
_OVERHEATS = "the hand holds the object, but not for good: {shares:gives}; "
_NEAREST = "the {member} closest to its limit is {name} at {utilisation:percent} of {limit:effort}{held_by:behind}"

_SENTENCES: dict[str, str | Callable[[Values], str]] = {
    "not_holdable": "{diagnosis}",
    "no_equilibrium": "{diagnosis}",
    "no_squeeze": "{text}",
    "lost": "the object is {why}",
    "lost: after it slides": "the object is {why}; {slid} at {slides_at:percent} of stage {through!r} already",
    "slides": "{slid} at {share:percent} of stage {stage!r}, as far as it may; loaded on slowly, the object moves "
    "{moved_m:length} and turns {turned_rad:angle} in all",
    "slides: snaps": "the object snaps from {share:percent} of stage {stage!r} on: it jumps to another place; "
    f"{_SLIDES_ON}",
    "solver_stopped": "the solver stopped before it found an answer, which says nothing about the grasp; try another "
    "seed or number of faces",
    "follow_stopped": "the loading was {why}",
    "link_inside": "the object begins {links:inside}: move it out by as much",
    "link_inside: posture": _describe_penetration,
    "link_inside: unknown": "whether links are inside the object is not known: {error}",
    "link_inside: no geometry": "no link has collision geometry: whether links are inside the object is not checked",
    "joint_range": "{when}, {joint} is {past} past the end of its range",
    "joint_range: far": f"{{when}}, {{joint}} is {{past}} past the end of its range: {_NO_POSTURE}",
    "large_motion": describe_large_motion,
    "followed_forces": f"{_ONE_SOLVE}, finds an equilibrium, which this loading does not reach",
    "followed_forces: differ": f"{_ONE_SOLVE}, is off by {{force_error:percent}} of the largest force ({{finger}})",
    "torque_over_limit": "the contacts could hold the object, the motors cannot: {rows:needs}",
    "torque": _NEAREST,
    "torque: no limit": "{unlimited}",
    "torque: yields": "{yielding:names} {yielding:yields|yield} at the limit",
    "limit_unknown": "torque limits not known, torques not judged: {joints:names}",
    "limit_doubtful": "{doubt}",
    "tension_over_limit": "the contacts could hold the object, the tendons cannot: {rows:needs}",
    "tension": _NEAREST,
    "slack": "{tendons:names} {tendons:hangs|hang} slack at the end",
    "closing_torque": _PULLS_LESS,
    "closing_torque: drives others": f"{_PULLS_LESS}; turning on, they would drive {{beyond:names}} farther beyond "
    "{beyond:its|their} closing torque",
    "closing_torque: stuck": f"{_PULLS_LESS}; no state was found in which they press harder, and what stops them is "
    "not known",
    "overheats": f"{_OVERHEATS}begun cold, the first motor overheats after {{lasts_s:duration}}",
    "overheats: no time": f"{_OVERHEATS}not for longer than the motor's thermal time",
    "closing_over_peak": "closing takes more than the motors give (peak): {rows:needs}",
    "closing_over_peak: rubs": "closing takes more than the motors give (peak less dry friction): {rows:needs}",
    "limit_shared": "{doubt}",
    "hand_doubtful": "{doubt}",
    "unplaced": "{why}",
    "rigid_tips": f"{{names:names}} {{names:has|have}} {_NO_PADS}",
    "rigid_tips: together": f"the contacts have together {_NO_PADS}",
    "pressed_in": "{text}",
    "torques_open": "{joint} may carry {both:span} of its limit{more:others}: no statics can tell",
    "torques_open: no end": "{joint} may carry {least:percent} of its limit, or any amount more{more:others}: no "
    "statics can tell",
    "torques_open: none": "the forces that are open change no joint's torque",
    "torques_open: within": "whatever the forces that are open are, no joint needs more than {most:percent} of its "
    "limit ({joint})",
    "command_not_made": "no actuators make this command: it takes others to turn {rows:with}",
    "command_not_made: tendons": "no tendons make this command by pulling: it takes more tendons to turn {rows:with}",
    "command_not_made: opposite tendons": "no tendons make this command by pulling: it takes tendons that pull the "
    "other way to turn {rows:with}",
    "out_of_reach": "{reach}",
    "effect": "{text}",
    "contacts": _describe_contacts,
    "contacts: far": "the object slides {slid_m:length} past {finger} before it comes to rest: it is held, but not "
    "where the hand gripped it",
    "motion": _describe_motion,
    "object_kept": "the object is kept in place until the hand has closed",
    "no_load": "no load: no weight acts on the object, and no wrench was given",
    "weight_left_out": "{text}",
    "friction": "friction is used up to {most:percent}{when} ({finger})",
    "friction: some slide": "friction of those that stick is used up to {most:percent}{when} ({finger})",
    "friction: little": "{finger} uses {most:percent} of its friction: a little more load makes it slide",
    "friction: none": "friction is used up at every contact that pushes: nothing is left for a disturbance",
    "forces_open": "other forces satisfy the same conditions; the smallest are given",
    "forces_open: followed": "other forces satisfy the same conditions; those that the loading led to are given",
    "loose": "the object can move freely in {directions} direction{directions:|s}; the smallest motion is given",
    "loose: followed": "the object can move freely in {directions} direction{directions:|s}; what the loading led to "
    "is given",
    "others": f"friction can hold the object in other ways, too; {_LISTED}",
    "others: near": "friction can hold the object in other ways, too, with forces that differ by "
    f"{{forces_differ:percent}} ({_LISTED})",
    "others: far": f"the equations have other answers, too, with motions too large for them ({_LISTED})",
    "snaps": "{event}: where it comes to rest depends on how fast and how evenly the hand closes",
    "not_followed": "the loading was not followed: {why}",
    "only_followed": f"{_ONE_SOLVE}, finds no equilibrium: the grasp holds as it moves",
    "advice": "{text} would hold it{within}{snap}",
    "advice: none": "nothing that was tried would hold it{within}, not even {tried:or}",
}
