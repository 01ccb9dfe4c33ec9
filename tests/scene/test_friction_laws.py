"""Frictions of a scene file that are more than a coefficient."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.scene import read
from tests.support.texts import says

PINCH = """
[[contact]]
position_m = [-0.01, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
{first}
[[contact]]
position_m = [0.01, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
name = "thumb"
[grasp]
friction = {friction}
flexibility_m_per_N = 1e-4
preload_m = 1e-3
[load]
force_N = [0.0, 0.0, -1.0]
torque_Nm = [0.001, 0.0, 0.0]
"""


def scene(friction, first=""):
    return read(PINCH.format(friction=friction, first=first)).build()


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("{mu = 0.5, mu_torsion_m = 0.005}", hl.SoftFinger(0.5, 0.005)),
        ("{mu = 0.5, mu_torsion_m = 0.005, torsional_flexibility_rad_per_Nm = 3.0}", hl.SoftFinger(0.5, 0.005, 3.0)),
        ("{mu_x = 0.6, mu_y = 0.2}", hl.AnisotropicCoulomb(0.6, 0.2)),
        ("{mu_x = 0.6, mu_y = 0.2, along = [0.0, 0.0, 1.0]}", hl.AnisotropicCoulomb(0.6, 0.2, (0, 0, 1))),
    ],
)
def test_a_table_makes_the_law_of_all_fingers(text, law):
    g = scene(text)
    assert [repr(c.friction) for c in g.contacts] == [repr(law)] * 2
    same = [hl.Contact(c.position, c.normal, law, name=c.name) for c in g.contacts]
    other = hl.Grasp(same, (0, 0, -1, 0.001, 0, 0), flexibility=1e-4, preload=1e-3)
    np.testing.assert_array_equal(g.solve(throw=False).forces, other.solve(throw=False).forces)


def test_a_table_by_finger_may_hold_them():
    g = scene('{thumb = {mu = 0.5, mu_torsion_m = 0.005}, "finger 1" = 0.4}')
    assert g.contacts[1].friction == hl.SoftFinger(0.5, 0.005)
    assert g.contacts[0].friction == hl.Coulomb(0.4)


@pytest.mark.parametrize(
    "text",
    [
        "{mu = 0.5, torsion = 0.005}",
        "{mu_x = 0.6}",
        "{mu = 0.5, mu_torsion_m = -1.0}",
        '{mu = "a", mu_torsion_m = 1.0}',
    ],
)
def test_other_tables_are_refused_with_the_key(text):
    with pytest.raises(hl.InputError, match=r"friction(\.mu_torsion_m)?: expected"):
        scene(text)


def test_an_effect_refused_when_the_grasp_is_made_has_the_files_key():
    text = (
        PINCH.format(friction="0.5", first="")
        + """
[[effects.known_force]]
contact = 0
normal_N = 1.0
[[effects.prescribed_force]]
contact = 0
force_N = [0.0, 0.0, 1.0]
"""
    )
    with pytest.raises(hl.InputError, match=r"^effects\.known_force\.contact"):
        read(text).build()


def test_a_misspelt_finger_is_told_the_nearest_name():
    with pytest.raises(hl.InputError) as caught:
        scene("{thump = 0.5}")
    says(str(caught.value), "'thump'", "'thumb'")
