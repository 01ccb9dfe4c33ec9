"""Suggestions: effects left out, each evaluated once, against solving with them."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.texts import says, without_numbers

BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)


def held(stiffness=6.0, limits=None, preload=0.005, **more):
    hand = hl.example_hand("three_finger", joint_stiffness=stiffness, torque_limits=limits)
    return hand.at(hand.close_on(BOX)).grasp(BOX, hl.Coulomb(0.8), preload=preload, **more)


def change(before, after):
    size = np.linalg.norm(before.forces, axis=1).max()
    return (np.linalg.norm(after.forces - before.forces, axis=1) / size).max()


def judged(suggestions):
    return dict(suggestions.small) | {s.effect: s.change for s in suggestions}


def test_every_change_is_that_of_the_grasp_with_the_effect():
    g = held(stiffness=2.0, preload=0.02)
    s = g.solve(8)
    found = judged(g.suggest(s, 8, least=0.0))
    cone = change(s, g.solve("cone", start=s))
    assert found["exact friction cone"] == pytest.approx(cone, rel=1e-6, abs=1e-12)
    heavy = held(stiffness=2.0, preload=0.02, finger_weight=True)
    by_force = change(s, heavy.solve(8, start=s))
    by_torque = abs(heavy.gravity_torque).max() / abs(s.torques).max()
    assert found["finger weight"] == pytest.approx(max(by_force, by_torque), rel=1e-6)
    assert found["geometric stiffness"] == pytest.approx(g.geometric_change(s, 8).max(), rel=1e-12)


def test_a_joint_beyond_its_limit_is_named_with_what_yielding_changes():
    g = held(limits=0.27)
    s = g.solve()
    found = g.suggest(s)
    (first,) = (each for each in found if each.effect == "torque saturation")
    worst = max(s.torque_check, key=lambda r: r.utilisation)
    yielding = held(limits=0.27, effects=[hl.TorqueSaturation()]).solve(start=s)
    assert first.change == pytest.approx(max(change(s, yielding), worst.utilisation - 1.0), rel=1e-6)
    assert worst.joint in first.words or first.words.startswith("finger_")
    assert "TorqueSaturation" in first.ask


def test_fingers_that_buckle_are_an_endless_change():
    g = held(stiffness=0.3, preload=0.1)
    assert judged(g.suggest())["geometric stiffness"] == np.inf
    (bent,) = (s for s in g.suggest() if s.effect == "geometric stiffness")
    says(without_numbers(bent.words), "equilibrium")
    assert bent.words in " ".join(str(g.suggest()).split())


def test_a_grasp_without_a_hand_is_told_of_the_cone_alone():
    contacts = [hl.Contact((s * 0.01, 0, 0), (-s, 0, 0), hl.Coulomb(0.5)) for s in (-1.0, 1.0)]
    g = hl.Grasp(contacts, (0, 0.3, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    assert set(judged(g.suggest(faces=8, least=0.0))) == {"exact friction cone"}
    assert not judged(g.suggest(least=0.0)), "solved on the cone already"
    assert not len(g.suggest(faces=8))
    says(without_numbers(str(g.suggest(faces=8))), "normal-force")


def test_a_grasp_that_fails_is_told_what_was_tried_and_holds_it():
    """Without a squeeze nothing presses; what is advised holds when it is done."""
    g = held(preload=0.0)
    s = g.solve(throw=False)
    assert not s.held
    found = g.suggest(s)
    assert found.word == "NOT HELD"
    (squeeze,) = (each for each in found if each.effect == "squeeze")
    assert squeeze.change == np.inf
    depth = float(squeeze.ask.split()[-3])
    assert f"{1e3 * depth:g} mm" in squeeze.words, "as printed"
    assert g.replace(squeeze=depth).check().word == "HELD"
    assert found.to_dict()["found"][0]["change"] is None
