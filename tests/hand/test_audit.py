"""The audit: every doubt about a URDF's numbers, and what to pass instead."""

from __future__ import annotations

import re

import numpy as np
import pytest

from handlcp import Contact, Coulomb
from handlcp.errors import UnknownName
from handlcp.geometry import Sphere
from handlcp.hand import Hand, example_hand
from handlcp.hand.library import SHIPPED_HANDS, allegro, psyonic, urdf
from handlcp.robot import audit_urdf
from tests.support.texts import says


def joint(
    name,
    limit='<limit lower="-1" upper="1" effort="2" velocity="1"/>',
    axis="0 0 1",
    kind="revolute",
    body='<inertial><mass value="1"/></inertial>',
):
    """A palm and one joint."""
    return (
        f'<link name="{name}_link">{body}</link><joint name="{name}" type="{kind}"><parent link="palm"/>'
        f'<child link="{name}_link"/><axis xyz="{axis}"/>{limit}</joint>'
    )


def audit(write, *joints):
    """The audit of a robot made of these joints."""
    return audit_urdf(write(f'<robot name="r"><link name="palm"/>{"".join(joints)}</robot>'))


def about(found, name):
    """Everything said about a joint."""
    return " | ".join(d.what for d in found.about(name))


@pytest.mark.parametrize("name", SHIPPED_HANDS)
def test_shipped_hands_leave_one_doubt(name):
    """Only that a URDF has no place for joint stiffness; a stiffness by name answers it."""
    (only,) = audit_urdf(urdf(name))
    says(only.what, "stiffness")
    says(only.advice, "joint_stiffness")
    hand = example_hand(name)
    assert [d.joint for d in hand.audit()] == ["hand"]
    assert not example_hand(name, joint_stiffness=dict.fromkeys(hand.joint_names, 2.0)).audit()


def test_allegro_s_fifteen_newton_metres_are_a_placeholder():
    """All sixteen joints at 15 N·m; passing torque limits answers it. joint_12.0 cannot stand at zero."""
    file, _ = allegro()
    found = audit_urdf(file)
    says(about(found, "joint_3.0"), "15 N·m")
    says(about(found, "joint_12.0"), "15 N·m", "0.263")
    assert "torque_limits" in str(found)
    assert "15 N·m" not in str(example_hand("allegro").audit())
    assert "15 N·m" in str(example_hand("allegro", torque_limits=None).audit())
    partly = example_hand("allegro", torque_limits={"joint_0.0": 0.7}).audit()
    assert not partly.about("joint_0.0")
    assert partly.about("joint_1.0")


def test_mimic_tags_are_reported_with_how_they_are_read():
    """The psyonic's tags name joints that do not exist; the audit says what they are taken for."""
    file, _ = psyonic()
    found = audit_urdf(file, base="LeftPsyonicAbilityBaseLink")
    (tag,) = found.about("Left_index_q2")
    says(str(tag), "'index_q1'", "1.05851", "Left_index_q1", "0.723498")
    assert tag.severity == "minor"
    assert "Right_" not in str(found)
    with pytest.raises(UnknownName, match="LeftPsyonicAbilityBaseLink"):
        audit_urdf(file, base="Hand")


def test_each_kind_of_doubt(write):
    """One broken number a joint: each is found, and only where it is."""
    found = audit(
        write,
        joint("fine"),
        joint("zero", '<limit lower="-1" upper="1" effort="0" velocity="1"/>'),
        joint("endless", '<limit lower="-1" upper="1" effort="inf" velocity="1"/>'),
        joint("silent", '<limit lower="-1" upper="1" velocity="1"/>'),
        joint("crossed", '<limit lower="1" upper="-1" effort="2" velocity="1"/>'),
        joint("stuck", '<limit lower="0" upper="0" effort="2" velocity="1"/>'),
        joint("wide", '<limit lower="-4" upper="4" effort="2" velocity="1"/>'),
        joint("away", '<limit lower="0.5" upper="1" effort="2" velocity="1"/>'),
        joint("flat", axis="0 0 0"),
        joint("odd", axis="0 0 north"),
        joint("long", axis="0 0 3"),
        joint("bare", body=""),
        joint("light", body='<inertial><mass value="0"/></inertial>'),
        joint("round", "", kind="continuous"),
    )
    facts = {"long": "3", "bare": "<inertial>"}
    names = [
        "zero",
        "endless",
        "silent",
        "crossed",
        "stuck",
        "wide",
        "away",
        "flat",
        "odd",
        "long",
        "bare",
        "light",
        "round",
    ]
    assert not found.about("fine")
    for name in names:
        assert found.about(name), name
        says(about(found, name), facts.get(name, ""))
    assert len(found) == len(list(found)) == len(found[:])


def test_placeholders_are_equal_and_round(write):
    """100 on every joint is a placeholder; 3.7 on every joint is a small doubt; 100 and 90, or one joint, are none."""

    def limit(effort):
        return f'<limit lower="-1" upper="1" effort="{effort}" velocity="1"/>'

    def doubts(*values):
        found = audit(write, *(joint(f"j{i}", limit(v)) for i, v in enumerate(values)))
        return [(d.what, d.severity) for d in found if d.about == "torque limit" and "every" in d.what]

    ((what, severity),) = doubts(100, 100)
    says(what, "100 N·m")
    assert severity == "serious"
    ((what, severity),) = doubts(3.7, 3.7)
    says(what, "3.7 N·m")
    assert severity == "minor"
    for others in ((100, 90), (3.7, 3.8), (100,)):
        assert not doubts(*others), others


@pytest.mark.parametrize(("efforts", "doubtful"), [((1000, 0.7), 1), ((15, 15), 2), ((0.7, 0.5), 0)])
def test_a_verdict_warns_of_limits_that_no_motor_of_a_finger_has(write, efforts, doubtful):
    """HELD at 0.0 % of 1000 N·m is worth nothing: the joints with such limits are named."""
    text = urdf("two_finger").read_text()
    for finger, effort in zip(("finger_1", "finger_2"), efforts, strict=True):
        for part in ("proximal", "distal"):
            head, tail = text.split(f'<joint name="{finger}_{part}"', 1)
            limit, rest = tail.split("effort=", 1)
            text = f'{head}<joint name="{finger}_{part}"{limit}effort="{effort}"{rest.split(chr(34), 2)[2]}'
    hand = Hand.from_urdf(write(text), joint_stiffness=6.0, pad_flexibility=1e-4, tip_radius=0.008)
    contacts = [Contact(p, (-np.sign(p[0]), 0, 0), Coulomb(0.8)) for p in hand.at(hand.neutral).tip_positions]
    v = hand.at(hand.neutral).grasp(contacts, preload=1e-3).solve().verdict
    named = {name for r in v.about("limit_doubtful") for name in r.values["joints"]}
    assert len(named) == 2 * doubtful
    assert all(r.severity == "warning" for r in v.about("limit_doubtful"))
    if doubtful:
        says(v.about("limit_doubtful")[0].sentence, "finger_1_proximal")


# ---------------------------------------------------------------- how much a doubt weighs
LEAD = '<limit lower="-1" upper="1" effort="0.5" velocity="1"/>'
AFTER = '<limit lower="-0.5" upper="0.5" effort="0.2" velocity="1"/><mimic joint="lead" multiplier="2"/>'


def test_the_most_serious_doubts_come_first(write):
    """Severities in order, in the sequence and in print, which says each heading once."""
    wide = joint("wide", '<limit lower="-4" upper="4" effort="0.3" velocity="1"/>')
    zero = joint("zero", '<limit lower="-1" upper="1" effort="0" velocity="1"/>')
    found = audit(write, wide, joint("lead", LEAD), joint("after", AFTER), zero)
    order = [d.severity for d in found]
    assert order == sorted(order, key=("serious", "minor", "information").index)
    assert set(order) == {"serious", "minor", "information"}
    text = str(found)
    assert text.index("Serious") < text.index("Minor") < text.index("Information")
    assert max(map(len, text.splitlines())) <= 80
    assert found.serious == tuple(d for d in found if d.severity == "serious")
    says(found.summary, "1 information")


def test_a_mimic_tag_that_is_right_is_no_doubt(write):
    """It is read as it is written: information. One that leads nowhere is serious."""
    (right,) = audit(write, joint("lead", LEAD), joint("after", AFTER)).about("after")
    assert right.severity == "information"
    says(right.what, "follow")
    (wrong,) = (d for d in audit(write, joint("after", AFTER)).about("after") if d.about == "coupling")
    assert wrong.severity == "serious"


@pytest.mark.parametrize(("own", "severity"), [("-3 3", None), ("-0.5 0.5", "minor"), ("4 5", "serious")])
def test_ranges_that_a_follower_narrows_are_doubts(write, own, severity):
    """q_after = 2 q_lead in its own limits: they leave q_lead all of its range, half of it, or none."""
    lower, upper = own.split()
    after = AFTER.replace('"-0.5"', f'"{lower}"').replace('"0.5"', f'"{upper}"')
    hand = Hand.from_urdf(
        write(f'<robot name="r"><link name="palm"/>{joint("lead", LEAD)}{joint("after", after)}</robot>'),
        ["lead_link"],
        joint_stiffness=1.0,
    )
    found = [d for d in hand.audit().about("lead") if d.about == "range"]
    assert [d.severity for d in found] == ([severity] if severity else [])
    if severity == "minor":
        says(found[0].what, "after", "-0.25, 0.25")


def test_what_geometry_lacks_is_a_doubt(tmp_path):
    """None at all: nobody sees links in the object. Of one link: that one. A mesh that is not there: which."""
    text = urdf("three_finger").read_text()
    collision = re.compile(r"<collision.*?</collision>", re.S)

    def doubts(changed):
        file = tmp_path / "changed.urdf"
        file.write_text(changed)
        found = [d for d in audit_urdf(file) if d.about == "geometry"]
        return {severity: [d.what for d in found if d.severity == severity] for severity in ("serious", "minor")}

    assert doubts(text) == {"serious": [], "minor": []}
    none = doubts(collision.sub("", text))
    says(none["serious"][0], "collision")
    one = doubts(collision.sub("", text, count=1))
    says(one["minor"][0], "collision")
    mesh = '<collision><geometry><mesh filename="package://no/where.stl"/></geometry></collision>'
    lost = doubts(collision.sub(mesh, text, count=1))
    says(lost["serious"][0], "package://no/where.stl")


def test_serious_doubts_stand_beside_the_verdict(write):
    """A range that is written the wrong way round, and links that nothing is known of; small doubts stay away."""
    text = re.sub(r"<collision.*?</collision>", "", urdf("two_finger").read_text(), flags=re.S)
    text = text.replace('lower="-0.5" upper="1.6"', 'lower="1.6" upper="-0.5"', 1)
    hand = Hand.from_urdf(write(text), joint_stiffness=6.0, pad_flexibility=1e-4, tip_radius=0.008)
    assert [d.about for d in hand.audit().serious] == ["range", "geometry"]
    tips = hand.at(np.zeros(4)).tip_positions
    ball = Sphere(0.5 * np.ptp(tips[:, 0]) - 0.008, (0, 0, tips[0, 2]))
    v = hand.at(np.zeros(4)).grasp(ball, preload=1e-3).solve(throw=False).verdict
    (doubtful,) = v.about("hand_doubtful")
    says(doubtful.sentence, "1.6")
    (blind,) = v.about("link_inside")
    assert {doubtful.severity, blind.severity} == {"warning"}
    says(blind.sentence, "collision")
