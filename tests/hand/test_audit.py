"""The audit: every doubt about a file's numbers, and what to pass instead."""

import re

import numpy as np
import pytest

import handlcp as hl
from handlcp import Contact, Coulomb
from handlcp.errors import UnknownName
from handlcp.geometry import Sphere
from handlcp.hand import Hand, example_hand
from handlcp.hand.library import SHIPPED_HANDS, allegro, psyonic, urdf
from handlcp.robot import audit_urdf
from handlcp.robot.audit import doubt_reasons
from tests.support.texts import says


def limits(lower=-1, upper=1, effort="2"):
    return f'<limit lower="{lower}" upper="{upper}" effort="{effort}" velocity="1"/>'


LIMIT, BODY = limits(), '<inertial><mass value="1"/></inertial>'


def joint(name, limit=LIMIT, axis="0 0 1", kind="revolute", body=BODY):
    """One joint on a palm, and its link."""
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


BROKEN = {
    "zero": {"limit": limits(effort=0)}, "endless": {"limit": limits(effort="inf")},
    "silent": {"limit": '<limit lower="-1" upper="1" velocity="1"/>'}, "crossed": {"limit": limits(1, -1)},
    "stuck": {"limit": limits(0, 0)}, "wide": {"limit": limits(-4, 4)}, "away": {"limit": limits(0.5, 1)},
    "flat": {"axis": "0 0 0"}, "odd": {"axis": "0 0 north"}, "long": {"axis": "0 0 3"}, "bare": {"body": ""},
    "light": {"body": '<inertial><mass value="0"/></inertial>'}, "round": {"limit": "", "kind": "continuous"},
}  # fmt: skip


def test_each_kind_of_doubt(write):
    """One broken number a joint: each is found, and only where it is."""
    found = audit(write, joint("fine"), *(joint(name, **wrong) for name, wrong in BROKEN.items()))
    assert not found.about("fine")
    for name in BROKEN:
        assert found.about(name), name
    assert all(d.advice for d in found)


def test_placeholders_are_equal_and_round(write):
    """100 on every joint is a placeholder; 3.7 on every joint is a small doubt; 100 and 90, or one joint, are none."""

    def doubts(*values):
        found = audit(write, *(joint(f"j{i}", limits(effort=v)) for i, v in enumerate(values)))
        return [(d.what, d.severity) for d in found if d.about == "torque limit" and "every" in d.what]

    for effort, weight in ((100, "serious"), (3.7, "minor")):
        ((what, severity),) = doubts(effort, effort)
        says(what, f"{effort} N·m")
        assert severity == weight
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
LEAD = limits(effort=0.5)
AFTER = limits(-0.5, 0.5, 0.2) + '<mimic joint="lead" multiplier="2"/>'


def test_the_most_serious_doubts_come_first(write):
    """Severities in order, in the sequence and in print, which says each heading once."""
    wide, zero = joint("wide", limits(-4, 4, 0.3)), joint("zero", limits(effort=0))
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
    text = f'<robot name="r"><link name="palm"/>{joint("lead", LEAD)}{joint("after", after)}</robot>'
    hand = Hand.from_urdf(text, ["lead_link"], joint_stiffness=1.0)
    found = [d for d in hand.audit().about("lead") if d.about == "range"]
    assert [d.severity for d in found] == ([severity] if severity else [])
    if severity == "minor":
        says(found[0].what, "after", "-0.25, 0.25")


def test_what_geometry_lacks_is_a_doubt(write):
    """None at all: nobody sees links in the object. Of one link: that one. A mesh that is not there: which."""
    text = urdf("three_finger").read_text()
    mesh = '<collision><geometry><mesh filename="package://no/where.stl"/></geometry></collision>'

    def doubts(shape="", count=0):
        changed = write(re.sub(r"<collision.*?</collision>", shape, text, count=count, flags=re.S))
        return {d.severity: d.what for d in reversed(audit_urdf(changed)) if d.about == "geometry"}

    assert not {d.severity for d in audit_urdf(write(text)) if d.about == "geometry"} & {"serious", "minor"}
    says(doubts()["serious"], "collision")
    says(doubts(count=1)["minor"], "collision")
    says(doubts(mesh, 1)["serious"], "package://no/where.stl")


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


# ---------------------------------------------------------------- doubts about tendons: arms and places that are
JOINT, LINKS = "finger_1_distal", ("finger_1_proximal_link", "finger_1_distal_link")


def route(*points):
    return hl.Route([hl.Site(link, (x, 0.0, 0.01)) for link, x in points])


def doubts(row):
    tendons = hl.Tendons({"pull": row, "good": {JOINT: 0.01}}, 2e4, 4.0)
    return [d for d in hl.example_hand("three_finger", joint_stiffness=tendons).audit() if d.about == "tendon arms"]


@pytest.mark.parametrize(
    ("row", "severity", "words"),
    [
        ({JOINT: -12.0}, "serious", "a moment arm of 12 m"),
        (route((LINKS[0], 20.0), (LINKS[1], 20.0)), "serious", "a place 20 m from the frame of its link"),
        (route((LINKS[0], 0.01), (LINKS[0], 0.02)), "minor", "moves no joint"),
    ],
)
def test_tendons_that_cannot_be_meant_are_doubted(row, severity, words):
    found = doubts(row)
    assert {(d.joint, d.severity) for d in found} == {("pull", severity)}
    assert any(words in d.what for d in found)


@pytest.mark.parametrize("row", [{JOINT: -0.15}, route((LINKS[0], 0.01), (LINKS[1], 0.01))])
def test_tendons_of_hands_are_not(row):
    assert not doubts(row)


def test_such_arms_are_a_warning_beside_a_verdict():
    hand = hl.example_hand("three_finger", joint_stiffness=hl.Tendons({"pull": {JOINT: 10.0}}, 2e4, 4.0))
    (reason,) = doubt_reasons(hand.doubts)
    assert (reason.code, reason.severity) == ("hand_doubtful", "warning")
    assert "pull: a moment arm of 10 m, as if millimetres were taken for metres" in reason.sentence


# ---------------------------------------------------------------- hands whose joints slide: newtons and N/m in audits
LINK = """<link name="{n}"><inertial><mass value="0.05"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0"
iyz="0"/></inertial><collision><origin xyz="0 0 {z}"/><geometry><sphere radius="0.01"/></geometry></collision></link>"""
SLIDE = """<joint name="{n}_slide" type="prismatic"><parent link="palm"/><child link="{n}"/>
<origin xyz="{x} 0 0.05"/><axis xyz="{way} 0 0"/><limit lower="0" upper="0.04" effort="{effort}" velocity="1"/>
</joint>"""
HINGE = """<joint name="h_hinge" type="revolute"><parent link="palm"/><child link="h"/><origin xyz="0 0.04 0"/>
<axis xyz="1 0 0"/><limit lower="-0.5" upper="1.2" effort="0.8" velocity="1"/></joint>""" + LINK.format(n="h", z=0.05)
BOX = hl.Box(0.04, (0, 0, 0.05), mass=0.1)


def text(effort=60.0, hinge=False):
    slide = SLIDE + LINK.replace("{z}", "0")
    slides = "".join(slide.format(n=n, x=-0.04 * way, way=way, effort=effort) for n, way in (("l", 1), ("r", -1)))
    palm = '<link name="palm"><collision><geometry><box size="0.1 0.02 0.01"/></geometry></collision></link>'
    return f'<robot name="slides">{palm}{slides}{HINGE if hinge else ""}</robot>'


def gripper(stiffness=1e4, **more):
    return hl.Hand.from_urdf(text(**more), ["l", "r"], joint_stiffness=stiffness)


def test_newton_metres_for_the_spring_of_a_slide_are_a_serious_doubt():
    (doubt,) = (d for d in gripper(6.0).audit().serious if d.about == "slide")
    assert doubt.joint == "l_slide, r_slide"
    assert "6 N/m lets a slide give way by 167 mm under 1 N" in doubt.what
    assert not [d for d in gripper().audit().serious if d.about == "slide"]
    mixed = hl.Hand.from_urdf(text(hinge=True), ["l", "r", "h"], joint_stiffness=6.0).audit()
    assert [d.joint for d in mixed.serious if d.about == "slide"] == ["l_slide, r_slide"]


@pytest.mark.parametrize("effort", [60.0, 0.0])
def test_the_audit_speaks_of_newtons(effort):
    """No "N·m" in a doubt about a hand whose joints all slide."""
    for audit in (hl.audit_urdf(text(effort)), gripper(effort=effort).audit()):
        said = [f"{d.what} {d.advice}" for d in audit if d.about in ("torque limit", "limit unknown", "stiffness")]
        assert said
        assert not [one for one in said if "N·m" in one]
    both = hl.audit_urdf(text(effort=0.0, hinge=True))
    assert [d.advice for d in both if d.about == "limit unknown"] == ["torque_limits with the actuator's force [N]"]


def test_required_torque_has_newtons_of_slides():
    """In the heads where all joints slide; beside each number where others turn."""
    hand = gripper()
    found = hand.at(hand.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=5.0).required_torque()
    assert found.confirmed
    assert "N·m" not in str(found)
    assert "limit\nN" in found.table.heads[3]
    mixed = hl.Hand.from_urdf(text(hinge=True), ["l", "r"], joint_stiffness=1e4)
    table = mixed.at(mixed.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=5.0).required_torque()
    rows = {row[0]: row for row in table.rows}
    assert rows["l_slide"][3] == "60 N"
    assert rows["h_hinge"][3] == "0.8"
    assert table.table.heads[3] == "limit\nN·m"


def test_a_verdict_speaks_of_newtons():
    hand = gripper(effort=3.0)
    grasp = hand.at(hand.close_on(BOX)).grasp(BOX, friction=0.8, grip_force=5.0)
    verdict = grasp.check()
    assert verdict.word == "OVER LIMIT"
    assert "N of 3 N" in str(verdict)
    assert "N·m" not in str(verdict)
