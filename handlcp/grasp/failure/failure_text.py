"""`describe_failures`: the words for what gives out, and for how an object is lost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.failure.failure_mode import (
    EQUILIBRIUM,
    MOTION,
    OPENS,
    RANGE,
    SLIDES,
    SLIPS,
    TENSION,
    TORQUE,
    UNDECIDED,
    FailureMode,
)
from handlcp.grasp.model.request import GraspSpec
from handlcp.grasp.model.status import SEPARATED, SLIDING, ContactStatus, PathStatus

# ---------------------------------------------------------------- Why an object is lost, in one sentence.

_SENTENCES = {
    PathStatus.RUNS_AWAY: "the object runs away{}: the fingers give way faster than their forces grow",
    PathStatus.UNSTABLE: "the object is in balance, but a small push{} drives it away: it tips over, or the fingers "
    "are too soft for their forces",
    PathStatus.PUSHED_OUT: "the squeeze pushes the object out from between the fingers",
    PathStatus.LOOSE: "no finger holds the object any more",
    PathStatus.NO_FORCES: "the fingers do not create the forces that would balance the load",
    PathStatus.TOO_FAR: "no balance was found near the last one, however small the step: the object would have to jump",
    PathStatus.LEAPS: "no balance was found near the last one, however small the step: the object would have to jump",
    PathStatus.JUMPS: "no balance was found near the last one, however small the step: the object would have to jump",
}
_NO_BALANCE_IN_PLACE = (
    "no balance of the fingers was found on an object that is kept in place: they press too hard, or slip off it"
)


def explain_loss(
    status: PathStatus, spec: GraspSpec, kinds: Sequence[ContactStatus], motion: Array | None = None, kept: bool = False
) -> str:
    """How a loading loses the object, and what the contacts last did, in one sentence.

    status : how the loading ends. kinds (n,) : of the contacts at the last state. motion (6,) : in which the object
    runs away, or a small push grows; None: not known. kept : whether the object is kept in place there, and only the
    fingers can fail.
    """
    open_, sliding = (
        [name for name, kind in zip(spec.names, kinds, strict=True) if kind == what] for what in (SEPARATED, SLIDING)
    )
    state = []
    if sliding:
        state.append(f"{describe_names(sliding, spec)} {'slide' if len(sliding) > 1 else 'slides'}")
    if open_:
        state.append(f"{describe_names(open_, spec)} {'have' if len(open_) > 1 else 'has'} let go")
    text = (
        _NO_BALANCE_IN_PLACE
        if kept
        else _SENTENCES[status].format("" if motion is None else describe_direction(motion))
    )
    return f"{text} ({' and '.join(state)})" if state else text


def explain_giving_up(status: PathStatus, who: str = "") -> str:
    """Why a path was given up, though nothing says that the object is lost. who : a tendon and a body, in words."""
    if status == PathStatus.CROSSES:
        way = "pass the side (Around.side) on which it lies in all these postures, or route it between"
        return f"there tendon {who.replace(' the ', ' goes over to the other side of the ', 1)}: {way}"
    if status == PathStatus.STUCK:
        return "forces balance the load up to there, and no next state is found"
    if status == PathStatus.SNAPS:
        return "the object snaps elsewhere there"
    return "contacts touch, slip and let go so often there that hundreds of short steps do not lead on"


def describe_load_share(now: Array, end: Array) -> str:
    """Such as ", under 3.1 N of 6.7 N": load and weight (6,) of the object together [N, N·m], and at the end of the
    stage: their moments where a moment alone grows. "" without any.
    """
    forces, moments = ([float(np.linalg.norm(w[part])) for w in (now, end)] for part in (slice(3), slice(3, 6)))
    turns = max(moments) > 0.0 and (not max(forces) > 0.0 or np.allclose(now[:3], end[:3], rtol=1e-9, atol=0.0))
    if turns:
        return f", under {' of '.join(words.format_torques(moments))}"
    return f", under {words.format_force(forces[0])} of {words.format_force(forces[1])}" if max(forces) > 0.0 else ""


def describe_direction(twist: Array) -> str:
    """Such as " along -z", of a motion (6,); "" for one that only turns."""
    if not np.isfinite(twist).all() or not abs(twist[:3]).max() > 0.0:
        return ""
    axis = int(abs(twist[:3]).argmax())
    return f" along {'+' if twist[axis] > 0 else '-'}{'xyz'[axis]}"


# ----------------------------------------------------------------
# The table of words for what gives out and what happens on the way, and the sentences that are made with it.

NOTHING_FAILS = "nothing gives out"
_FAILURE_PHRASES = {  # of one, of several
    SLIPS: ("slips", "slip"),
    SLIDES: ("has slid as far as it may", "have slid as far as they may"),
    OPENS: ("lets go", "let go"),
    TORQUE: ("reaches its torque limit", "reach their torque limits"),
    TENSION: ("reaches the limit of its tension", "reach the limits of their tensions"),
    RANGE: ("reaches the end of its range", "reach the ends of their ranges"),
}
_OBJECT_PHRASES = {
    EQUILIBRIUM: "no forces balance more load",
    MOTION: "the object moves farther than allowed",
    UNDECIDED: "undecided",
}
_EVENT_PHRASES = {  # of one, of several
    "slips": ("begins to slip", "begin to slip"),
    "sticks": ("sticks again", "stick again"),
    "slips by turns": ("slips and sticks by turns", "slip and stick by turns"),
    "opens": ("lets go", "let go"),
    "touches": ("touches the object", "touch the object"),
    "opens by turns": ("lets go and touches by turns", "let go and touch by turns"),
    "over limit": ("needs more than its torque limit", "need more than their torque limits"),
    "within limit": ("is within its torque limit again", "are within their torque limits again"),
    "over limit by turns": (
        "goes over its torque limit and back by turns",
        "go over their torque limits and back by turns",
    ),
    "over tension": ("pulls with more than its limit", "pull with more than their limits"),
    "within tension": ("is within its limit again", "are within their limits again"),
    "over tension by turns": ("goes over its limit and back by turns", "go over their limits and back by turns"),
    "slackens": ("goes slack", "go slack"),
    "tightens": ("is taut again", "are taut again"),
    "slackens by turns": ("goes slack and taut by turns", "go slack and taut by turns"),
    "yields": ("yields at its torque limit", "yield at their torque limits"),
    "holds": ("holds again, below its torque limit", "hold again, below their torque limits"),
    "yields by turns": ("yields and holds by turns", "yield and hold by turns"),
    "range end": ("passes the end of its range", "pass the ends of their ranges"),
    "range": ("is within its range again", "are within their ranges again"),
    "range end by turns": ("leaves its range and returns by turns", "leave their ranges and return by turns"),
    "slides": _FAILURE_PHRASES[SLIDES],
    "snaps": ("snaps to another place", "snap to another place"),
    "snaps by turns": ("snaps to other places, several times", "snap to other places, several times"),
}
BY_TURNS = " by turns"
_JOINT_EVENTS = ("over limit", "within limit", "yields", "holds", "range end", "range", TORQUE)
_TENDON_EVENTS = ("over tension", "within tension", "slackens", "tightens", TENSION)
_MAX_PAD_DEPTH = 5e-3  # [m] pads are not pressed in by more than this without being doubted
_MAX_NAMED = 4  # contacts that are named one by one
_ACROSS_TOLERANCE = 1e-9  # of a load: less of it across an axis is none


def describe_failures(causes: Sequence[FailureMode], spec: GraspSpec | None = None, *, brief: bool = False) -> str:
    """What gives out, such as "finger 1 and finger 2 slip"; "nothing gives out" for no causes.

    spec : of the grasp, by which all of its fingers are "all 3 fingers". brief : of several of a kind the first, and
    how many more.
    """
    if not causes:
        return NOTHING_FAILS
    kinds = dict[str, list[str]]()
    for c in causes:
        kinds.setdefault(c.kind, []).append(c.who)
    parts = []
    for kind, who in kinds.items():
        names = describe_names(who, spec, TORQUE if kind == RANGE else kind)
        if brief and len(who) > 1 and names == words.join_names(who):
            names = f"{who[0]} and {len(who) - 1} more"
        parts.append(_OBJECT_PHRASES.get(kind) or f"{names} {_FAILURE_PHRASES[kind][len(who) > 1]}")
    return "; ".join(parts)


def explain_limit(
    causes: Sequence[FailureMode], factor: float, wrench: Array, spec: GraspSpec | None = None, then: str = ""
) -> str:
    """Say in one sentence what ends the growth of a load at this factor on a wrench (6,) [N, N·m].

    then : what the object does there, such as "snaps to another place"; "": no more load is balanced.
    """
    if not causes:
        return f"{NOTHING_FAILS}, however large the load"
    text, kind = describe_failures(causes, spec), causes[0].kind
    if then:
        text = f"{text}, and the object {then}" if kind in (SLIPS, OPENS) else f"the object {then}"
    elif kind in (SLIPS, OPENS):
        text += ", and nothing else balances more load"
    if factor > 0.0:
        load = describe_load(factor * wrench)
        own = "" if spec is None else describe_own_wrench(spec)
        where = f"at {factor:.4g} times the load{f', {load}' if load else ''}{f' {own}' if own else ''}"
        return f"{where}: {text}"
    if kind in (TORQUE, TENSION, RANGE):
        return f"before there is any load, {text}"
    return f"it holds nothing of this load: {text.replace('more load', 'it')}"


def describe_slip(names: Sequence[str], far: float) -> str:
    """That contacts have slid so far [m], such as "finger_1 has slid 1 mm"."""
    return f"{words.join_names(names)} {'has' if len(names) == 1 else 'have'} slid {words.format_length(far)}"


def describe_own_wrench(spec: GraspSpec) -> str:
    """What contacts without a hand bear beside a load that grows, such as "beside the grasp's own 10 N along -z";
    "" where that is nothing, and of a hand, where the weight of its object goes without saying.
    """
    own = "" if spec.mechanism is not None else describe_load(spec.wrench)
    return f"beside the grasp's own {own}" if own else ""


def describe_pad_depth(give: Array, normals: Array, names: Sequence[str]) -> str:
    """Of a pad that gives way farther than real ones do: give (n, 3) [m], against normals (n, 3) into the object, world
    axes. "" where none does.
    """
    deep = -np.einsum("ix,ix->i", give, normals)
    if not deep.max(initial=0.0) > _MAX_PAD_DEPTH:
        return ""
    k = int(deep.argmax())
    springs = "pads are springs here however far they give way, and real ones are a few millimetres thick"
    return f"the pad at {names[k]} is pressed in by {words.format_length(float(deep[k]))}: {springs}"


def describe_event(kind: str, who: Sequence[str], spec: GraspSpec | None = None) -> str:
    """What happens on the way, such as "all 5 fingers begin to slip". kind : of an event, or with " by turns"."""
    return f"{describe_names(who, spec, kind)} {_EVENT_PHRASES[kind][len(who) > 1]}"


def describe_torque_excess(joints: Sequence[str], spec: GraspSpec | None = None) -> str:
    """Of joints beyond their torque limits, such as "finger_1_proximal needs more than its torque limit"."""
    return describe_event("over limit", joints, spec)


def describe_names(who: Sequence[str], spec: GraspSpec | None, kind: str = "") -> str:
    """Several names in a sentence; "both fingers", "all 3 contacts", "all 6 joints" where these are all of the grasp's.

    kind : of what they do, which tells joints from contacts.
    """
    if spec is not None and len(who) > 1:
        names, k = spec.names, spec.of_hand
        groups = [(names[:k], "contacts" if spec.links else "fingers"), (names, "contacts")]
        if kind.removesuffix(BY_TURNS) in _JOINT_EVENTS:
            groups = [(() if spec.mechanism is None else spec.mechanism.names, "joints")]
        if kind.removesuffix(BY_TURNS) in _TENDON_EVENTS:
            cables = None if spec.mechanism is None else spec.mechanism.joint_model.cables
            groups = [(() if cables is None else cables.names, "tendons")]
        for group, plural in groups:
            if len(who) == len(group) and set(who) == set(group):
                return f"{'both' if len(who) == 2 else f'all {len(who)}'} {plural}"
        if len(who) > _MAX_NAMED:
            who = words.group_by_link(who, spec.links)
    return words.join_names(who)


def describe_load(load: Array) -> str:
    """Such as "12.3 N along +x", "3 N and 0.4 N·m about -z"; "" for no load. load (6,) [N, N·m]."""
    parts = []
    for part, of, how in ((load[:3], words.format_force, "along"), (load[3:], words.format_torque, "about")):
        if (size := float(np.linalg.norm(part))) > 0.0:
            axis = int(abs(part).argmax())
            straight = abs(part[axis]) >= (1.0 - _ACROSS_TOLERANCE) * size
            where = f" {how} {'+' if part[axis] > 0 else '-'}{'xyz'[axis]}" if straight else ""
            if not (text := of(size)).startswith("0 "):  # beside the rest of the load
                parts.append(f"{text}{where}")
    return " and ".join(parts)
