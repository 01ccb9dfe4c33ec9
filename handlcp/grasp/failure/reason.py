"""`Reason`: one reason of a verdict, and the one place where its sentence is made of a code and numbers.

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


def make_reason(code: str, severity: str, values: Mapping[str, Any] | None = None, **beside: Any) -> Reason:
    """The reason with this code and the sentence that its values make. beside : what the sentence says, too, and
    programs do not read, by the names that `_SENTENCES` has.
    """
    values = values or {}
    sentence, known = _SENTENCES[code], {**values, **beside}
    return Reason(code, severity, sentence.format_map(known) if isinstance(sentence, str) else sentence(known), values)


_ONE_SOLVE = "one solve, with squeeze and load at once in this posture"
_MAX_NAMED = 4  # contacts that are named one by one
_STILL_DISTANCE = 1e-7  # [m] an object that moves less is not said to move


def _agree(names: Sequence[Any], one: str, many: str) -> str:
    """The form of a verb that agrees with so many names."""
    return many if len(names) > 1 else one


# ---------------------------------------------------------------- Of one solve.


def _describe_contacts(v: Values) -> str:
    """With what contacts are called (who), how many there are (count), and on which link each is (links)."""
    if "finger" in v:
        past = f"the object slides {words.format_length(v['slid_m'])} past {v['finger']}"
        return f"{past} before it comes to rest: it is held, but not where the hand gripped it"
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
        parts.append(f"{words.list_names(gone)} {_agree(apart, 'lets', 'let')} go")
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
    return ", ".join(f"{who} {_agree(far, 'slides', 'slide up to')} {way}" for who, far, way in named)


def _describe_friction(v: Values) -> str:
    """With the largest share that a contact uses which sticks, `most` of `finger`, and whether others slide (some)."""
    if v["most"] is None:
        return "friction is used up at every contact that pushes: nothing is left for a disturbance"
    share, who = words.format_percent(v["most"]), v["finger"]
    if v["little"]:
        return f"{who} uses {share} of its friction: a little more load makes it slide"
    return f"friction {'of those that stick ' * v['some']}is used up to {share}{v['when']} ({who})"


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


def _describe_open(v: Values) -> str:
    """Of forces, or of motions in some directions, of which the smallest, or those of a loading, are given."""
    if k := v.get("directions"):
        given = "the smallest motion" if v["smallest"] else "what the loading led to"
        return f"the object can move freely in {k} direction{'s' if k > 1 else ''}; {given} is given"
    given = "the smallest" if v["smallest"] else "those that the loading led to"
    return f"other forces satisfy the same conditions; {given} are given"


def _describe_others(v: Values) -> str:
    """With whether motions of the others are too large for the equations (far)."""
    lists = "grasp.equilibria() lists them"
    if "forces_differ" not in v:
        return f"friction can hold the object in other ways, too; {lists}"
    if v["far"]:
        return f"the equations have other answers, too, with motions too large for them ({lists})"
    by = words.format_percent(v["forces_differ"])
    return f"friction can hold the object in other ways, too, with forces that differ by {by} ({lists})"


# ---------------------------------------------------------------- Of a loading that is followed.


def _describe_loss(v: Values) -> str:
    """With the loading's own words, and the stage in which the object slides through before."""
    if "slides_at" not in v:
        return f"the object is {v['why']}"
    at = words.format_percent(v["slides_at"])
    return f"the object is {v['why']}; it slides through from {at} of stage {v['through']!r} on"


def _describe_sliding_through(v: Values) -> str:
    at = f"from {words.format_percent(v['share'])} of stage {v['stage']!r} on"
    far = f"{words.format_length(v['moved_m'])} and {words.format_angle(v['turned_rad'])}"
    end = f"loaded slowly it moves by {far} in all; a sudden load moves it farther"
    if v["jumps"]:
        return f"the object snaps {at}: it jumps to another place; {end}"
    return f"the object slides through {at}: no finger that presses sticks any more; {end}"


def _describe_rigid_tips(v: Values) -> str:
    names = v["names"]
    who = f"{words.list_names(names)} {_agree(names, 'has', 'have')}" if names else "the contacts have together"
    text = f"{who} no pads: where joints do not give way nothing does, and small differences decide what slips"
    return f"{text}; pass pad_flexibility, such as 1e-4 m/N for rubber"


def _describe_followed_forces(v: Values) -> str:
    if "finger" not in v:
        return f"{_ONE_SOLVE}, finds an equilibrium, which this loading does not reach"
    off_by = f"{words.format_percent(v['force_error'])} of the largest force ({v['finger']})"
    return f"{_ONE_SOLVE}, is off by {off_by}"


def _describe_advice(v: Values) -> str:
    """With the change in words, " within the torque limits" where there are any, and how the object snaps then."""
    if "tried" in v:
        return f"nothing that was tried would hold it{v['within']}, not even {words.join_alternatives(v['tried'])}"
    return f"{v['text']} would hold it{v['within']}{v['snap']}"


# ---------------------------------------------------------------- Of joints, tendons and motors.
# A sentence about efforts is given `rows` of (name, effort, limit, unit).


def _list_efforts(rows: Sequence[tuple[str, float, float, str]], needs: str = "needs ") -> str:
    """Such as "finger_1 needs 0.21 N·m of 0.2 N·m"."""
    return words.list_names(
        [f"{name} {needs}{' of '.join(words.format_efforts((x, limit), unit))}" for name, x, limit, unit in rows]
    )


def _describe_over_limit(v: Values) -> str:
    needs = _list_efforts(v["rows"])
    if "rubs" in v:  # whether dry friction takes some of what the motors give while the hand closes
        return f"closing takes more than the motors give (peak{' less dry friction' * v['rubs']}): {needs}"
    return f"the contacts could hold the object, the {'motors' if 'joints' in v else 'tendons'} cannot: {needs}"


def _describe_overheating(v: Values) -> str:
    gives = [f"{name} gives {words.format_percent(share)} of continuous" for name, share in v["shares"]]
    least = "not for longer than the motor's thermal time"
    if v["lasts_s"] is not None:
        least = f"begun cold, the first motor overheats after {words.format_duration(v['lasts_s'])}"
    return f"the hand holds the object, but not for good: {words.list_names(gives)}; {least}"


def _describe_nearest_limit(v: Values) -> str:
    """With what is said where no limit is finite, and what of a motor the limit is (held_by)."""
    if yielding := v.get("yielding"):
        return f"{words.list_names(yielding)} {_agree(yielding, 'yields', 'yield')} at the limit"
    if v["unlimited"]:
        return str(v["unlimited"])
    member = "joint" if "joint" in v else "tendon"
    limit = words.format_effort(v["limit_Nm" if member == "joint" else "limit_N"], v["unit"])
    of = f"{limit}{f' {held_by}' if (held_by := v['held_by']) else ''}"
    share = words.format_percent(v["utilisation"])
    return f"the {member} closest to its limit is {v[member]} at {share} of {of}"


def _describe_unmade_command(v: Values) -> str:
    """With what would make it, of `_UNMADE_COMMANDS`, and the units of the torques."""
    efforts = zip(v["joints"], v["torques_Nm"], v["units"], strict=True)
    turn = words.list_names([f"{name} with {words.format_effort(t, unit)}" for name, t, unit in efforts])
    return f"{_UNMADE_COMMANDS[v['takes']]} to turn {turn}"


_UNMADE_COMMANDS = {
    "actuators": "no actuators make this command: it takes others",
    "tendons": "no tendons make this command by pulling: it takes more tendons",
    "opposite tendons": "no tendons make this command by pulling: it takes tendons that pull the other way",
}


def _describe_closing_torque(v: Values) -> str:
    """With joints that would be driven farther (beyond), and whether no state with more was found (stuck)."""
    needs = _list_efforts(v["rows"], "")
    text = f"where the hand has closed, fingers pull with less than the closing torque: {needs}"
    if beyond := v["beyond"]:
        drive = f"they would drive {words.list_names(beyond)} farther beyond {_agree(beyond, 'its', 'their')}"
        return f"{text}; turning on, {drive} closing torque"
    if v["stuck"]:
        return f"{text}; no state was found in which they press harder, and what stops them is not known"
    return text


def _describe_open_torques(v: Values) -> str:
    """With the joint that may need most, None where none is open, shares of its limit, and how many more may exceed
    theirs, None where it does not, either.
    """
    if v["joint"] is None:
        return "the forces that are open change no joint's torque"
    if v["more"] is None:
        share = words.format_percent(v["most"])
        return f"whatever the forces that are open are, no joint needs more than {share} of its limit ({v['joint']})"
    text = f"{v['joint']} may carry {words.format_percent(v['least'])} of its limit, or any amount more"
    if np.isfinite(v["most"]):
        text = f"{v['joint']} may carry {format_span(v['least'], v['most'])} of its limit"
    if (more := v["more"]) == 1:
        text += ", and 1 more joint may need more than its limit"
    elif more:
        text += f", and {more} more may need more than their limits"
    return f"{text}: no statics can tell"


def format_span(least: float, most: float) -> str:
    """Of a limit, such as "40 to 120 %"."""
    low, high = words.format_percent(least), words.format_percent(most)
    if not np.isfinite(most):
        return f"{low} to ∞" if np.isfinite(least) else "∞"
    return low if low == high else f"{low.removesuffix(' %')} to {high}"


def _describe_start_inside(v: Values) -> str:
    inside = [f"{words.format_length(one['depth_m'])} inside {one['link']}" for one in v["links"]]
    return f"the object begins {words.join_names(inside)}: move it out by as much"


# ---------------------------------------------------------------- The table: a template, or what makes the sentence.

_SENTENCES: dict[str, str | Callable[[Values], str]] = {
    "not_holdable": "{diagnosis}",
    "no_equilibrium": "{diagnosis}",
    "no_squeeze": "{text}",
    "lost": _describe_loss,
    "slides_through": _describe_sliding_through,
    "steps_differ": "fewer and more steps of loading end differently: one says that it holds, another that it does not",
    "solver_stopped": "the solver stopped before it found an answer, which says nothing about the grasp; try another "
    "seed or number of faces",
    "follow_stopped": "the loading was {why}",
    "link_inside": _describe_start_inside,
    "large_motion": describe_large_motion,
    "followed_forces": _describe_followed_forces,
    "torque_over_limit": _describe_over_limit,
    "torque": _describe_nearest_limit,
    "limit_unknown": lambda v: f"torque limits not known, torques not judged: {words.list_names(v['joints'])}",
    "limit_doubtful": "{doubt}",
    "tension_over_limit": _describe_over_limit,
    "tension": _describe_nearest_limit,
    "slack": lambda v: f"{words.list_names(v['tendons'])} {_agree(v['tendons'], 'hangs', 'hang')} slack at the end",
    "closing_torque": _describe_closing_torque,
    "overheats": _describe_overheating,
    "closing_over_peak": _describe_over_limit,
    "limit_shared": "{doubt}",
    "hand_doubtful": "{doubt}",
    "unplaced": "{why}",
    "rigid_tips": _describe_rigid_tips,
    "pressed_in": "{text}",
    "torques_open": _describe_open_torques,
    "command_not_made": _describe_unmade_command,
    "out_of_reach": "{reach}",
    "effect": "{text}",
    "contacts": _describe_contacts,
    "motion": _describe_motion,
    "object_kept": "the object is kept in place until the hand has closed",
    "no_load": "no load: no weight acts on the object, and no wrench was given",
    "weight_left_out": "{text}",
    "friction": _describe_friction,
    "forces_open": _describe_open,
    "loose": _describe_open,
    "others": _describe_others,
    "snaps": "{event}: where it comes to rest depends on how fast and how evenly the hand closes",
    "not_followed": "the loading was not followed: {why}",
    "only_followed": f"{_ONE_SOLVE}, finds no equilibrium: the grasp holds as it moves",
    "advice": _describe_advice,
}
