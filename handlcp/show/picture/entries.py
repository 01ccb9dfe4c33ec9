"""What is written of a picture's content: the legend, the labels of contacts, and which state is drawn."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.show.picture.content import ESCAPE, LOAD, NO_MOMENT, SLIP, STATE, UNKNOWN, Content
from handlcp.show.picture.panel import Entry

GHOST = "#7A5A10"


class Unseen(NamedTuple):
    """What is too small to draw: contacts with such a slip, and whether the load is."""

    slips: list[int]
    load: bool


Said = tuple[tuple[int, ...], str, str]  # contacts that share a label, its name, and what stands below the name

_STILL = 1e-4  # [rad] an object that turns less is not said to turn
_NUMBER = re.compile(r"[\s_]*\d+$")


def state_drawn(shown: Content, path: Any, at_end: bool) -> str:
    """A sentence or two. path : the loading that the verdict is about, or None; at_end : whether its end is drawn."""
    if at_end:
        u = path.displacement
        far = words.length(float(np.linalg.norm(u[:3])))
        what = "end" if path.reached else "last step"
        return f"Drawn: the {what} of the loading. The object has moved {far}{_turned(u)}."
    hand = getattr(shown.grasp, "state", None) is not None
    where, squeeze = ("in the given posture", "squeeze") if hand else ("with the given contacts", "preload")
    if not shown.solution.held:
        return f"Drawn: the grasp {where}, without forces, as no equilibrium was found."
    drawn = f"Drawn: one solve {where}, {squeeze} and load at once"
    return f"{drawn}." if path is None else f"{drawn}. The verdict follows the loading in steps."


def _turned(u: Array) -> str:
    """Of a motion (6,), for a list; "" for a turn that nobody sees."""
    turned = float(np.linalg.norm(u[3:]))
    return f" and turned {words.angle(turned)}" if turned > _STILL else ""


def contact_labels(shown: Content, room: int) -> list[Said]:
    """One label for each contact; where there is no room for so many, one for all contacts of a name and a state, the
    largest such groups first.
    """
    names, states = shown.solution.names, shown.solution.contact_state
    single = {i: ((i,), name, _detail(shown, i)) for i, name in enumerate(names)}
    groups: dict[tuple[str, str], list[int]] = {}
    for i, (name, state) in enumerate(zip(names, states, strict=True)):
        groups.setdefault((_NUMBER.sub("", name), state if shown.solution.held else ""), []).append(i)
    out, count = list[Said](), len(names)
    for (stem, state), members in sorted(groups.items(), key=lambda group: -len(group[1])):
        if count > room and len(members) > 1:
            count -= len(members) - 1
            out.append((tuple(members), f"{stem}: {len(members)} contacts", _together(shown, members, state)))
        else:
            out += [single[i] for i in members]
    return sorted(out)


def _together(shown: Content, members: Sequence[int], state: str) -> str:
    """What a label of several contacts says below its name."""
    if state in ("", "separated"):
        return "let go" if state else ""
    forces = shown.solution.normal_force[list(members)]
    low, high = words.force(float(forces.min())), words.force(float(forces.max()))
    each = f"{low} each" if low == high else f"{low.removesuffix(' N')} to {high}"
    return f"{each}, {'stick' if state == 'sticking' else 'slide'}"


def _detail(shown: Content, i: int) -> str:
    """What a contact's label says below its name."""
    s = shown.solution
    if not s.held:
        return f"μ = {shown.grasp.contacts[i].mu:g}" if shown.grasp.contacts[i].mu else "frictionless"
    if s.contact_state[i] == "separated":
        return f"lets go, gap {words.length(float(s.gap[i]))}"
    normal, friction = float(s.normal_force[i]), float(np.linalg.norm(s.tangential_force[i]))
    push = words.push(normal, friction)
    # A moment is written in place of the state, which the colour shows: a longer line would shrink the picture
    if s.torsion is not None and abs(s.torsion[i]) > NO_MOMENT:
        return f"{push}, {words.torque(abs(float(s.torsion[i])))}"
    return f"{push}, {'sticks' if s.contact_state[i] == 'sticking' else 'slides'}"


def entries(shown: Content, unseen: Unseen, hidden: bool) -> list[Entry]:
    """The legend. hidden : whether a contact point is behind object or hand."""
    return [
        *_bodies(shown),
        *_contacts(shown, hidden),
        *_load(shown, unseen.load),
        *_motion(shown, unseen.slips),
    ]


def _bodies(shown: Content) -> Iterator[Entry]:
    if shown.glass is not None:
        yield "patch", "#C08A2B", shown.glass.label
    if shown.inside:
        most, names = words.length(max(shown.inside.values())), list(shown.inside)
        who = names[0] if len(names) == 1 else f"{len(names)} links"
        yield "hatch", STATE["sliding"], f"inside the object: {who}, {'' if len(names) == 1 else 'up to '}{most}"
    if shown.tips:
        yield "outline", LOAD, "fingertip shape that finds the contact"


def _contacts(shown: Content, hidden: bool) -> Iterator[Entry]:
    s, scene = shown.solution, shown.grasp.scene
    who = "contact" if scene.environment else "finger"
    for state in ("sticking", "sliding"):
        if s.held and state in s.contact_state:
            yield "line", STATE[state], f"{who} force, {state}"
    if s.held and "separated" in s.contact_state:
        yield "dot", STATE["separated"], f"{who} that lets go"
    if hidden:
        yield "ring", UNKNOWN, "contact seen through object or hand"
    if any(shown.cone_height(i) > 0.0 for i in range(scene.n)):
        sense = "moments take their part of it" if s.torsion is not None else "an arrow at its rim slides"
        text = f"friction cone, to the forces' scale:\n{sense}" if s.held else "friction cone"
        yield "cone", STATE["sticking"] if s.held else UNKNOWN, text
    if s.held and scene.frictional:
        yield "none", UNKNOWN, "labels: normal force + friction"
    if shown.turns:
        yield "turn", STATE["sticking"], f"moment of a {who} about its normal, longer for larger"


def _load(shown: Content, unseen: bool) -> Iterator[Entry]:
    if shown.load > 0:
        much = words.force(shown.load)
        yield "line", LOAD, f"load on the object, {much}{', too small to draw' if unseen else ''}"
    if shown.turn is not None:
        yield "turn", LOAD, f"torque on the object, {words.torque(float(np.linalg.norm(shown.twist)))}"


def _motion(shown: Content, unseen: Sequence[int]) -> Iterator[Entry]:
    s = shown.solution
    largest = max((float(np.hypot(*s.slip[i])) for i in shown.slips), default=0.0)
    if any(i not in unseen for i in shown.slips):
        factor = shown.slip_factor
        times = f"× {factor:g}" if factor >= 1 else f"÷ {1 / factor:g}"
        yield "line", SLIP, f"slip of the object, {times}\n(up to {words.length(largest)})"
    if unseen:
        most = max(float(np.hypot(*s.slip[i])) for i in unseen)
        below = f"at most {words.length(most)}" if most > words.NOTHING else "zero"
        yield "none", SLIP, f"slip not drawn, {below}:\n{words.listed([s.names[i] for i in unseen])}"
    if shown.ghost is not None:
        u = s.object_displacement
        also = _turned(u)
        yield (
            "dashed-thin",
            GHOST,
            f"object after its motion:\nmoved {words.length(float(np.linalg.norm(u[:3])))}{also}",
        )
    if shown.escape.any():
        yield "dashed", ESCAPE, "the way the object escapes"
    if shown.escape_turn is not None:
        yield "turn", ESCAPE, "the way the object turns out" if not shown.escape.any() else "and turns as it escapes"
