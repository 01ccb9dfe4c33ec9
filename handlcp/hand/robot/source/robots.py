"""Whether a file holds several robots: two arms on a stand, or a left and a right hand in one world."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from handlcp.hand.robot.joints import Doubt
from handlcp.hand.robot.urdf import link_of

_FINGERS = 2  # ends of chains below a link: with as many it carries a hand of its own
_ARM = 6  # movable joints one after the other: no finger has as many


def several_robots(root: ET.Element) -> Iterator[Doubt]:
    """A doubt where the first link that branches carries two or more robots. root : the <robot> as it is read."""
    below = dict[str, list[ET.Element]]()
    for joint in root.findall("joint"):
        below.setdefault(link_of(joint, "parent"), []).append(joint)
    moved = {link_of(joint, "child") for joint in root.findall("joint")}
    links = [name for link in root.findall("link") if (name := link.get("name", "")) not in moved]
    seen = set[str]()
    while len(links) == 1 and links[0] not in seen:  # a circle is said where the model is built
        seen.add(links[0])
        children = [(joint, link_of(joint, "child")) for joint in below.get(links[0], ())]
        links = [child for joint, child in children if _moves(joint) or _chains(child, below)[0]]
    robots = [name for name in links if _is_robot(name, below)]
    if len(robots) > 1:
        what = f"the file holds several robots, which are read as one hand: {', '.join(robots)}"
        yield Doubt("hand", what, f"base={robots[0]!r}, or another link that carries one hand", "serious", "robots")


def _is_robot(link: str, below: dict[str, list[ET.Element]]) -> bool:
    ends, longest = _chains(link, below)
    return ends >= _FINGERS or longest >= _ARM - 1  # the joint that moves this link itself is one more


def _chains(link: str, below: dict[str, list[ET.Element]]) -> tuple[int, int]:
    """How many movable joints below a link have none below themselves, and the most of them in a row."""
    stack, seen = list[tuple[str, tuple[str, ...], int]]([(link, (), 0)]), {link}
    every, inner, longest = set[str](), set[str](), 0
    while stack:
        at, last, count = stack.pop()
        longest = max(longest, count)
        for joint in below.get(at, ()):
            child, name = link_of(joint, "child"), joint.get("name", "")
            if child in seen:
                continue
            seen.add(child)
            if _moves(joint):
                every.add(name)
                inner.update(last)
            stack.append((child, (name,) if _moves(joint) else last, count + _moves(joint)))
    return len(every - inner), longest


def _moves(joint: ET.Element) -> bool:
    return joint.get("type") not in (None, "fixed")
