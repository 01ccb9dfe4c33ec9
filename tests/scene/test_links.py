"""Contacts on links, as a scene file asks for them: each key is the argument of its name, or refused by its name."""

import numpy as np
import pytest

from handlcp.errors import InputError, NotReached, SceneFileError, UnknownName
from handlcp.geometry import Sphere
from handlcp.hand import example_hand
from handlcp.scene import read
from tests.support.scene_texts import BOX_IN_TWO_FINGERS, TWO_CONTACTS

BALL = """
[hand]
name = "five_finger"
joint_stiffness_Nm_per_rad = 6.0
{hand}
[object]
shape = "sphere"
radius_m = 0.03
position_m = [0.0, 0.0, 0.035]
mass_kg = 0.3
{more}
[grasp]
"""
PROXIMAL, DISTAL = "finger_1_proximal_link", "finger_1_distal_link"


def ball(line, hand="", more=""):
    return read(BALL.format(hand=hand, more=more) + line).build()


def told(pads=1e-4, **arguments):
    hand = example_hand("five_finger", joint_stiffness=6.0, pad_flexibility=pads)
    return hand.at(hand.neutral).grasp(Sphere(0.03, (0, 0, 0.035), mass=0.3), **arguments)


def same(grasp, expected):
    assert [c.name for c in grasp.contacts] == [c.name for c in expected.contacts]
    np.testing.assert_array_equal(grasp.state.q, expected.state.q)
    np.testing.assert_array_equal(grasp.joint_offset, expected.joint_offset)
    np.testing.assert_array_equal(grasp.offset, expected.offset)
    np.testing.assert_array_equal(grasp.flexibility, expected.flexibility)
    assert [c.mu for c in grasp.contacts] == [c.mu for c in expected.contacts]


@pytest.mark.parametrize(
    ("line", "arguments"),
    [
        ('links = "all"\nclosing_torque_Nm = 0.2', {"links": "all", "closing_torque": 0.2}),
        (
            f'links = ["{PROXIMAL}", "finger_3_distal_link"]\nclosing_torque_Nm = 0.2',
            {"links": [PROXIMAL, "finger_3_distal_link"], "closing_torque": 0.2},
        ),
        (
            'links = "all"\nhold_object = true\n'
            "closing_torque_Nm = { finger_1_proximal = 0.3, finger_3_proximal = 0.2 }",
            {
                "links": "all",
                "hold_object": True,
                "closing_torque": {"finger_1_proximal": 0.3, "finger_3_proximal": 0.2},
            },
        ),
        (
            f'links = "all"\nclosing_torque_Nm = 0.2\nfriction = {{ {PROXIMAL} = 0.9 }}',
            {"links": "all", "closing_torque": 0.2, "friction": {PROXIMAL: 0.9}},
        ),
        (
            'links = "all"\njoint_offset_rad = { finger_1_proximal = 1.0, finger_3_proximal = 1.0 }',
            {"links": "all", "joint_offset": {"finger_1_proximal": 1.0, "finger_3_proximal": 1.0}},
        ),
        (
            f'links = "all"\nclosing_torque_Nm = 0.2\npreload_m = {{ {DISTAL} = 1e-4 }}',
            {"links": "all", "closing_torque": 0.2, "preload": [0, 0, 1e-4, *8 * [0]]},
        ),
    ],
)
def test_each_key_is_the_argument_of_its_name(line, arguments):
    same(ball(line), told(**arguments))


def test_pads_are_said_by_link():
    pads = {PROXIMAL: 3e-4, "palm": 2e-5}
    written = f"pad_flexibility_m_per_N = {{ {PROXIMAL} = 3e-4, palm = 2e-5 }}"
    line = 'links = "all"\nclosing_torque_Nm = 0.2'
    same(ball(line, written), told(pads, links="all", closing_torque=0.2))


def test_without_a_command_the_whole_hand_closes_on_the_object_unless_told_not_to():
    hand = example_hand("five_finger", joint_stiffness=6.0)
    obj = Sphere(0.03, (0, 0, 0.035), mass=0.3)
    closed = hand.at(hand.close_on(obj, wrap=True))
    same(ball('links = "all"\nsqueeze_m = 0.001'), closed.grasp(obj, links="all", squeeze=0.001))
    with pytest.raises(NotReached):
        ball('links = "all"', more="[posture]\nclose = false")


def test_an_effect_names_contacts_on_links():
    line = f'links = "all"\nclosing_torque_Nm = 0.2\n[effects]\nfinger_force_bound_N = {{ {DISTAL} = 5.0 }}'
    assert [type(e).__name__ for e in ball(line).spec.effects].count("FingerForceBound") == 1


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('[grasp]\nlinks = "palm"', "grasp.links"),
        ("[grasp]\nlinks = []", "grasp.links"),
        ("[grasp]\nclosing_torque_Nm = -0.1", "grasp.closing_torque_Nm"),
        ("[grasp]\nclosing_torque_Nm = 'hard'", "grasp.closing_torque_Nm"),
        ("[grasp]\nsqueeze_m = 0.001\nclosing_torque_Nm = 0.1", "grasp.closing_torque_Nm"),
        ('[grasp]\nlinks = "all"\n[posture]\nsqueeze_m = 0.001', "posture.squeeze_m"),
        ("[grasp]\nhold_object = 1", "grasp.hold_object"),
    ],
)
def test_what_contradicts_itself_or_makes_no_sense_is_refused_by_its_key(text, key):
    with pytest.raises(SceneFileError) as e:
        read(BOX_IN_TWO_FINGERS + text)
    assert e.value.argument == key


@pytest.mark.parametrize(
    ("line", "key", "kind"),
    [
        ('links = ["thumb"]', "grasp.links", UnknownName),
        ('links = "all"\nfingers = ["finger_1_tip"]\nclosing_torque_Nm = 0.2', "grasp.fingers", InputError),
        ('links = "all"\nclosing_torque_Nm = { thumb = 0.2 }', "grasp.closing_torque_Nm", UnknownName),
        ('links = "all"\nclosing_torque_Nm = [0.2]', "grasp.closing_torque_Nm", InputError),
        ('links = "all"\nclosing_torque_Nm = 0.2\nfriction = { thumb = 0.9 }', "grasp.friction", UnknownName),
        ('links = "all"\nclosing_torque_Nm = 0.2\npreload_m = { thumb = 1e-4 }', "grasp.preload_m", UnknownName),
        ('links = "all"\nhold_object = true', "grasp.hold_object", InputError),
    ],
)
def test_refusals_of_the_package_name_the_key(line, key, kind):
    with pytest.raises(kind) as e:
        ball(line)
    assert e.value.argument == key
    assert str(e.value).startswith(f"{key}: ")


def test_an_object_inside_a_link_is_refused_by_its_table():
    text = BOX_IN_TWO_FINGERS + '[grasp]\nlinks = "all"\nclosing_torque_Nm = 0.2'
    inside = text.replace("0.08]", "0.0]")
    assert inside != text
    with pytest.raises(InputError) as e:
        read(inside).build()
    assert e.value.argument == "object"


@pytest.mark.parametrize("line", ['links = "all"', "hold_object = true", "closing_torque_Nm = 0.1"])
def test_only_a_hand_has_links_and_closes(line):
    with pytest.raises(SceneFileError) as e:
        read(f"{TWO_CONTACTS}[grasp]\n{line}")
    assert e.value.argument == f"grasp.{line.split()[0]}"
