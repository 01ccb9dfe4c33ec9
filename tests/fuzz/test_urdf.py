"""URDFs that went through the wars: each is refused with a typed error or makes a hand that can be used.

Read in a process of their own, so that a crash of a C++ parser fails the test instead of ending it.
"""

import copy
import os
import random
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tests.fuzz.mutations import mutated, truncated, with_one_of
from tests.support.messages import without_compiling

HARD = os.environ.get("HANDLCP_HARD") == "1"
COUNT = 3000 if HARD else 80
HANGS = 3600  # s: whoever has not come back by then never will
SHIPPED = Path(__file__).parents[2] / "urdf"
CHECKOUT = Path(__file__).parents[2]
VALUES = ["nan", "inf", "-inf", "1e400", "-1e300", "1e300", "0", "-1", "", " ", "x", "1 2", "1,5", "0x10", "1e-320",
          "9" * 400, "٣", "true", "&lt;", "1;2", "+", "-", ".", "1e", "\u00a01"]  # fmt: skip
ATTRIBUTE = re.compile(r'(\w+)="([^"]*)"')
ELEMENT = re.compile(r"<(\w+)([^<>]*?)(/?)>")


def one_value(rng, text):
    """An attribute gets a value that is none, or an absurd one; of three numbers, one of them."""
    m = rng.choice(list(ATTRIBUTE.finditer(text)))
    parts, value = m[2].split(), rng.choice(VALUES)
    if len(parts) == 3 and rng.random() < 0.7:
        parts[rng.randrange(3)] = value
        value = " ".join(parts)
    return text[: m.start(2)] + value + text[m.end(2) :]


def no_attribute(rng, text):
    m = rng.choice(list(ATTRIBUTE.finditer(text)))
    return text[: m.start()] + text[m.end() :]


def _family(rng, text):
    """The tree, some element of it, and its parent."""
    root = ET.fromstring(text)
    pairs = [(parent, child) for parent in root.iter() for child in parent]
    return root, *rng.choice(pairs)


def no_element(rng, text):
    root, parent, child = _family(rng, text)
    parent.remove(child)
    return ET.tostring(root, encoding="unicode")


def twice(rng, text):
    root, parent, child = _family(rng, text)
    parent.insert(rng.randrange(len(parent) + 1), copy.deepcopy(child))
    return ET.tostring(root, encoding="unicode")


def moved(rng, text):
    root, parent, child = _family(rng, text)
    _, other, _ = _family(rng, text)
    parent.remove(child)
    rng.choice([e for e in root.iter() if e.tag == other.tag] or [root]).append(child)
    return ET.tostring(root, encoding="unicode")


def other_tag(rng, text):
    m = rng.choice(list(ELEMENT.finditer(text)))
    new = rng.choice(["joint", "link", "robot", "mimic", "limit", "nothing", "axis", "dynamics"])
    return re.sub(rf"(</?){m[1]}\b", rf"\g<1>{new}", text)


def one_tag(rng, text):
    root, _, child = _family(rng, text)
    child.tag = rng.choice(["joint", "link", "robot", "mimic", "limit", "nothing", "axis", "geometry", "box"])
    return ET.tostring(root, encoding="unicode")


def other_name(rng, text):
    """A name elsewhere takes the place of this one: duplicates, circles, orphans."""
    names = [m for m in ATTRIBUTE.finditer(text) if m[1] in ("name", "link", "joint")]
    m, other = rng.choice(names), rng.choice(names)
    return text[: m.start(2)] + other[2] + text[m.end(2) :]


def other_type(rng, text):
    types = [m for m in ATTRIBUTE.finditer(text) if m[1] == "type"]
    m = rng.choice(types)
    kind = rng.choice(["fixed", "floating", "planar", "continuous", "prismatic", "revolute", "spherical", "hinge", ""])
    return text[: m.start(2)] + kind + text[m.end(2) :]


def mimicked(rng, text):
    """Some joint follows some other, by whatever factor: chains, circles, itself, nobody."""
    joints = re.findall(r'<joint name="([^"]+)"', text)
    m = rng.choice(list(re.finditer(r"</joint>", text)))
    who = rng.choice([*joints, "nobody"])
    tag = f'<mimic joint="{who}" multiplier="{rng.choice(VALUES)}" offset="{rng.choice(VALUES)}"/>'
    return text[: m.start()] + tag + text[m.start() :]


def noise(rng, text):
    return with_one_of(rng, text, ["<", ">", "&", '"', "\x00", "<!--", "-->", "<![CDATA[", "é", "&#0;"])


MUTATIONS = (truncated, one_value, one_value, one_value, no_attribute, no_attribute, no_element, no_element,
             twice, moved, other_tag, one_tag,
             other_name, other_name, other_type, mimicked, noise)  # fmt: skip
FIXED = {
    "empty": "",
    "blank": "  \n",
    "only_robot": "<robot/>",
    "nameless": "<robot><link/></robot>",
    "self_parent": '<robot name="r"><link name="a"/><joint name="j" type="revolute"><parent link="a"/>'
    '<child link="a"/><axis xyz="0 0 1"/><limit effort="1" lower="0" upper="1" velocity="1"/></joint></robot>',
    "two_roots": '<robot name="r"><link name="a"/><link name="b_tip"/></robot>',
    "circle": '<robot name="r"><link name="a"/><link name="b"/>'
    + "".join(
        f'<joint name="{p}{c}" type="revolute"><parent link="{p}"/><child link="{c}"/><axis xyz="0 0 1"/>'
        '<limit effort="1" lower="0" upper="1" velocity="1"/></joint>'
        for p, c in ("ab", "ba")
    )
    + "</robot>",
    "deep": "<robot>" + "<link>" * 5000 + "</link>" * 5000 + "</robot>",
    "laughs": '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]><robot name="&b;"/>',
    "external": '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///dev/zero">]><robot name="&x;"/>',
    "utf16": "<?xml version='1.0' encoding='utf-16'?><robot/>",
    "wrong_encoding": "<?xml version='1.0' encoding='no-such'?><robot/>",
}


def mutants(count):
    """(name, text) of so many mutants of the shipped hands, one to three mutations each, and the fixed ones."""
    hands = [p.read_text() for p in sorted(SHIPPED.glob("*.urdf"))]
    rng = random.Random(0)
    for i in range(count):
        text, done = mutated(rng, rng.choice(hands), MUTATIONS)
        yield f"{i:05d}_{'_'.join(done)}", text
    yield from FIXED.items()


def read(folder, count):
    """What became of so many mutants, and of the fixed ones, in a process of their own."""
    for name, text in mutants(count):
        (folder / f"{name}.urdf").write_text(text, encoding="utf-8", errors="surrogatepass")
    command = [sys.executable, "-m", "tests.fuzz.read_hands", str(folder)]
    return subprocess.run(command, cwd=CHECKOUT, capture_output=True, text=True, timeout=HANGS)


def test_every_mutant_is_refused_or_a_usable_hand(tmp_path):
    run = read(tmp_path, COUNT)
    lines = run.stdout.splitlines()
    assert run.returncode == 0, f"the interpreter ended with {run.returncode} after {lines[-1:]}: {run.stderr[-500:]}"
    bad = [line for line in lines if re.search(r": (WRONG|NAN)", line)]
    assert not bad, "\n".join(bad)
    assert len(lines) == COUNT + len(FIXED)
    assert sum(": hand" in line for line in lines) > COUNT / 8, "part of them reaches beyond the parser"
    assert without_compiling(run.stderr) == ""


@pytest.mark.bench
def test_no_mutant_takes_more_than_ten_seconds(tmp_path):
    slow = [line for line in read(tmp_path, COUNT).stdout.splitlines() if "SLOW" in line]
    assert not slow, "\n".join(slow)
