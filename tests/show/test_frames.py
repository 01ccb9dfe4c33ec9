"""Answers as tables for pandas: columns with units, the numbers of the answer; and a typed error without pandas."""

import builtins
import sys

import numpy as np
import pytest

import handlcp as hl

pandas = pytest.importorskip("pandas")

BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)


def pinch(law=None, squeeze=1e-3):
    law = hl.Coulomb(0.5) if law is None else law
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), law) for s in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=squeeze)


@pytest.fixture(scope="module")
def grasp():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    return hand.at(hand.close_on(BOX)).grasp(BOX, hl.Coulomb(0.8), squeeze=5e-3)


def test_a_solution_is_a_table_of_its_contacts_and_one_of_its_joints(grasp):
    s = grasp.solve()
    contacts, joints = s.to_frame(), s.to_frame("joints")
    assert contacts.index.tolist() == list(s.names)
    np.testing.assert_array_equal(contacts[["x_N", "y_N", "z_N"]], s.forces)
    np.testing.assert_array_equal(contacts["friction_used"], s.friction_used)
    assert contacts["state"].tolist() == list(s.contact_state)
    assert joints.index.tolist() == list(grasp.state.hand.joint_names)
    np.testing.assert_array_equal(joints["torque_Nm"], s.torques)
    np.testing.assert_array_equal(joints["margin_Nm"], s.torque_margin)


def test_without_pandas_the_extra_is_named(monkeypatch):
    s, real = pinch().solve(), builtins.__import__

    def hidden(name, *rest, **more):
        if name.partition(".")[0] == "pandas":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.delitem(sys.modules, "pandas")
    monkeypatch.setattr(builtins, "__import__", hidden)
    with pytest.raises(hl.Unsupported, match=r"pip install .pandas"):
        s.to_frame()
