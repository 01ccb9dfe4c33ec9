"""The verdict says what was certified, and nothing more."""

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import handlcp as hl
from handlcp import Contact, Coulomb, FingerForceBound, Frictionless, Grasp, KnownForce, PrescribedForce
from handlcp.geometry import Box
from handlcp.hand import Hand, example_hand
from handlcp.hand.library import urdf
from handlcp.lcp import NSNGRK, Status
from tests.support.grasp import changed
from tests.support.texts import same, says, without_numbers

BOX = Box(0.05, (0, 0, 0.08), 0.2)


def pinch(mu=0.6, squeeze=5e-3, force=-1.0, friction=None):
    law = Coulomb(mu) if friction is None else friction
    contacts = [
        Contact((0.03, 0, 0), (-1, 0, 0), law, name="thumb"),
        Contact((-0.03, 0.01, 0), (1, 0, 0), law),
        Contact((-0.03, -0.01, 0), (1, 0, 0), law),
    ]
    return Grasp(contacts, (0, 0, force, 0, 0, 0), flexibility=1e-3, preload=squeeze)


def cube(**words):
    hand = example_hand("three_finger", joint_stiffness=6.0, **words)
    return hand.at(hand.close_on(BOX)).grasp(BOX, Coulomb(0.8), preload=5e-3)


def test_held_names_the_binding_joint_and_its_share():
    grasp = cube()
    v = grasp.solve().verdict
    assert (v.word, v.ok) == ("HELD", True)
    same("grasp/test_verdict: held", v.text, "finger_2_proximal", "38 % of 0.8 N·m")


def test_a_joint_over_its_limit_is_not_held():
    grasp = cube(torque_limits=0.2)
    s = grasp.solve()
    assert s.held, "the contacts could"
    v = s.verdict
    assert (v.word, v.ok) == ("OVER LIMIT", False)
    same("grasp/test_verdict: over its limit", v.text, "finger_2_proximal", "0.301 N·m", "0.2 N·m")


def test_limits_that_are_not_known_are_not_judged_and_that_is_said(tmp_path):
    file = tmp_path / "hand.urdf"
    file.write_text(urdf("three_finger").read_text().replace('effort="0.4"', 'effort="0"'))
    hand = Hand.from_urdf(file, joint_stiffness=6.0, pad_flexibility=1e-4)
    grasp = hand.at(hand.close_on(BOX)).grasp(BOX, Coulomb(0.8), preload=5e-3)
    v = grasp.solve().verdict
    assert v.word == "HELD"
    (note,) = (r.sentence for r in v.about("limit_unknown"))
    says(note, "finger_2_distal", "finger_3_distal")


def test_not_holdable_says_where_the_object_goes():
    grasp = pinch(friction=Frictionless())
    s = grasp.solve(throw=False)
    v = s.verdict
    assert (v.word, v.ok, v.text) == ("NOT HELD", False, s.diagnosis)
    same("grasp/test_verdict: where the object goes", without_numbers(v.text))


def test_undecided_claims_nothing_about_the_scene():
    grasp = pinch()
    lazy = NSNGRK(max_iterations=1, polish=False, tol=1e-10)
    s = grasp.solve(8, lazy, throw=False)
    assert s.status is Status.UNDECIDED
    v = s.verdict
    assert (v.word, v.ok) == ("UNDECIDED", False)
    says(v.text, "another")
    for claim in ("not held", "slides", "escapes", "cannot"):
        assert claim not in str(v).lower().replace("claims", "")


def test_no_equilibrium_says_which_squeeze_would_hold():
    grasp = pinch(squeeze=0.0)
    s = grasp.solve(throw=False)
    assert s.status is Status.NO_EQUILIBRIUM
    v = s.verdict
    assert (v.word, v.text) == ("NOT HELD", s.diagnosis)
    same("grasp/test_verdict: no squeeze", v.text)
    enough = pinch(squeeze=1.01 * s.required_preload)
    assert enough.solve().verdict.word == "HELD"


def test_motions_beyond_the_linear_model_are_flagged():
    grasp = pinch(mu=0.6, squeeze=20e-3, force=-5.0)
    s = grasp.solve()
    big = replace(s, object_displacement=np.array([0, 0, -0.02, 0.3, 0, 0]))
    (found,) = big.verdict.about("large_motion")
    same("grasp/test_verdict: beyond small motions", found.sentence)
    assert found.severity == "warning"
    assert found.values["turn_rad"] == pytest.approx(0.3)
    assert found.values["force_error"] >= 0.3, "a turn turns forces with it"


def test_a_displacement_beyond_reason_is_named_in_python_too():
    """Fingers a million times as soft as usual: the equations have an answer, 24 m away."""
    contacts = pinch().contacts
    s = Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=100.0, preload=500.0).solve()
    assert s.held
    assert np.linalg.norm(s.object_displacement[:3]) > 10.0
    v = s.verdict
    assert v.word == "UNDECIDED"
    (found,) = v.about("large_motion")
    says(found.sentence, "171 m")
    assert found.sentence in s.diagnosis
    assert found.sentence in " ".join(str(s).split())


def test_what_bounds_and_readings_do_to_fingers_is_said_with_their_names():
    free = pinch().solve()
    bounded = changed(pinch(), effects=(FingerForceBound(0.9 * float(free.normal_force[0])),))
    text = bounded.solve().verdict.text
    says(text, "per-finger force bound", "thumb")
    known = changed(pinch(), effects=(KnownForce(0, (None, None, 0.9 * float(free.normal_force[0]))),))
    says(known.solve().verdict.text, "thumb")
    four = [*pinch().contacts, Contact((0, 0.03, 0), (0, -1, 0), Coulomb(0.6))]
    load, suction = (0, 0, -1, 0, 0, 0), [PrescribedForce(3, (0, 0, -0.01))]
    pulls = Grasp(four, load, flexibility=1e-3, preload=5e-3, effects=suction)
    says(pulls.solve().verdict.text, "finger 4")


# ---------------------------------------------------------------- A verdict says in one line what decides it, and may

CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
_SHOWN = 240  # characters of a value that pytest shows of a failed assertion


@cache
def verdict(limits):
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, torque_limits=limits)
    return hand.at(hand.close_on(CUBE)).grasp(CUBE, friction=0.8, squeeze=0.005).check()


def test_the_repr_is_the_sentence_and_what_decides_stands_where_pytest_cuts():
    v = verdict(0.2)
    (decides,) = [r for r in v.reasons if r.severity == "decides"]
    assert repr(v).startswith(f"OVER LIMIT: {decides.sentence}")
    assert "finger_1_proximal" in repr(v)[: _SHOWN // 2]
    assert "\n" not in repr(v)
    assert repr(verdict(0.8)).startswith("HELD: ")


def test_one_that_is_not_held_raises_with_its_sentence_and_advice():
    v = verdict(0.2)
    with pytest.raises(hl.RequirementNotMet, match=r"^OVER LIMIT: the contacts could hold the object") as caught:
        v.require()
    assert isinstance(caught.value, hl.HandLCPError)
    assert "Advice: " in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
