"""The verdict says what was certified, and nothing more."""

from __future__ import annotations

import pathlib
from dataclasses import replace

import numpy as np

from handlcp import Contact, Coulomb, FingerForceBound, Frictionless, Grasp, KnownForce, PrescribedForce
from handlcp.hand import Box, Hand, example_hand
from handlcp.lcp import NSNGRK, Status
from handlcp.scene import load
from handlcp.show import verdict
from tests.support.grasp import changed
from tests.support.hand import urdf
from tests.support.texts import same, without_numbers

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
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
    v = verdict(grasp, grasp.solve())
    assert (v.word, v.exit_code, v.colour) == ("HELD", 0, "green")
    same("show/test_verdict: held", v.text, "finger_2_proximal", "38 % of 0.8 N·m")


def test_a_joint_over_its_limit_is_not_held():
    grasp = cube(torque_limits=0.2)
    s = grasp.solve()
    assert s.held, "the contacts could"
    v = verdict(grasp, s)
    assert (v.word, v.exit_code, v.colour) == ("OVER LIMIT", 1, "red")
    same("show/test_verdict: over its limit", v.text, "finger_2_proximal", "0.301 N·m", "0.2 N·m")


def test_limits_that_are_not_known_are_not_judged_and_that_is_said(tmp_path):
    file = tmp_path / "hand.urdf"
    file.write_text(urdf("three_finger").read_text().replace('effort="0.4"', 'effort="0"'))
    hand = Hand.from_urdf(file, joint_stiffness=6.0, pad_flexibility=1e-4)
    grasp = hand.at(hand.close_on(BOX)).grasp(BOX, Coulomb(0.8), preload=5e-3)
    v = verdict(grasp, grasp.solve())
    assert v.word == "HELD"
    (note,) = (n for n in v.notes if "finger_1_distal" in n)
    same("show/test_verdict: limits that are not known", note, "finger_2_distal", "finger_3_distal")


def test_not_holdable_says_where_the_object_goes():
    grasp = pinch(friction=Frictionless())
    s = grasp.solve(throw=False)
    v = verdict(grasp, s)
    assert (v.word, v.exit_code, v.text) == ("NOT HELD", 1, s.diagnosis)
    same("show/test_verdict: where the object goes", without_numbers(v.text))


def test_undecided_claims_nothing_about_the_scene():
    grasp = pinch()
    lazy = NSNGRK(max_iterations=1, polish=False, tol=1e-10)
    s = grasp.solve(solver=lazy, throw=False)
    assert s.status is Status.UNDECIDED
    v = verdict(grasp, s)
    assert (v.word, v.exit_code, v.colour) == ("UNDECIDED", 1, "yellow")
    same("show/test_verdict: undecided", v.text)
    for claim in ("not held", "slides", "escapes", "cannot"):
        assert claim not in str(v).lower().replace("claims", "")


def test_no_equilibrium_says_which_squeeze_would_hold():
    grasp = pinch(squeeze=0.0)
    s = grasp.solve(throw=False)
    assert s.status is Status.NO_EQUILIBRIUM
    v = verdict(grasp, s)
    assert (v.word, v.text) == ("NOT HELD", s.diagnosis)
    same("show/test_verdict: no squeeze", v.text)
    enough = pinch(squeeze=1.01 * s.required_preload)
    assert verdict(enough, enough.solve()).word == "HELD"


def test_other_ways_to_hold_are_mentioned():
    grasp = pinch()
    s = grasp.solve()
    notes = {
        others: verdict(grasp, replace(s, uniqueness=replace(s.uniqueness, others=others))).notes
        for others in (True, False, None)
    }
    (said,) = set(notes[True]) - set(notes[False])
    same("show/test_verdict: in other ways", said)
    assert said not in notes[None]


def test_slips_and_motion_are_told_with_a_fitting_unit():
    grasp = load(EXAMPLES / "psyonic_grasp.toml").build()
    text = verdict(grasp, grasp.solve()).text
    same("show/test_verdict: slips and motion", text, "Left_ring_anchor", "0.11 mm", "Left_middle_anchor", "24 µm")
    assert all(length in text for length in ("0.91 mm", "0.42 mm", "1.2°")), "the object's motion, part of it, its turn"


def test_motions_beyond_the_linear_model_are_flagged():
    grasp = pinch(mu=0.6, squeeze=20e-3, force=-5.0)
    s = grasp.solve()
    big = replace(s, object_displacement=np.array([0, 0, -0.02, 0.3, 0, 0]))
    (note,) = set(verdict(grasp, big).notes) - set(verdict(grasp, s).notes)
    same("show/test_verdict: beyond small motions", note)


def test_a_finger_that_lets_go_is_named():
    grasp = pinch()
    s = replace(grasp.solve(), contact_state=("sticking", "separated", "sticking"))
    same("show/test_verdict: a finger lets go", verdict(grasp, s).text, "finger 2")


def test_without_a_load_there_is_nothing_to_move_along():
    grasp = pinch(force=0.0)
    text = verdict(grasp, grasp.solve()).text
    same("show/test_verdict: no load", text)
    assert "load" not in text


def test_what_bounds_and_readings_do_to_fingers_is_said_with_their_names():
    free = pinch().solve()
    bounded = changed(pinch(), effects=(FingerForceBound(0.9 * float(free.normal_force[0])),))
    text = verdict(bounded, bounded.solve()).text
    same("show/test_verdict: a bound is reached", text, "per-finger force bound", "thumb")
    known = changed(pinch(), effects=(KnownForce(0, (None, None, 0.9 * float(free.normal_force[0]))),))
    same("show/test_verdict: a reading moves a finger", verdict(known, known.solve()).text, "thumb")
    four = [*pinch().contacts, Contact((0, 0.03, 0), (0, -1, 0), Coulomb(0.6))]
    load, suction = (0, 0, -1, 0, 0, 0), [PrescribedForce(3, (0, 0, -0.01))]
    pulls = Grasp(four, load, flexibility=1e-3, preload=5e-3, effects=suction)
    same("show/test_verdict: a finger pulls", verdict(pulls, pulls.solve()).text, "finger 4")


def test_a_squeeze_too_large_for_small_motions_is_noted():
    grasp = pinch(squeeze=0.03)
    (note,) = (n for n in verdict(grasp, grasp.solve()).notes if "30 mm" in n)
    same("show/test_verdict: a large squeeze", note)


def test_a_hands_diagnosis_names_the_joint_that_would_need_more():
    s = cube(torque_limits=0.2).solve()
    worst = max(s.torque_check, key=lambda r: r.utilisation)
    assert s.held
    same("show/test_verdict: the joint that would need more", s.diagnosis, worst.joint)
    assert worst.joint not in cube().solve().diagnosis
