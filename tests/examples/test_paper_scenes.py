"""The paper's rows as scenes: each gives the printed numbers, or where the paper has none, those of a closed form."""

import importlib.util
import pathlib
import re
from functools import cache

import numpy as np
import pytest

import handlcp as hl
from handlcp.scene import load
from handlcp.studies.paper import REPRODUCED, Mark, example, rows_of, table
from tests.support.grasp import arrays
from tests.support.texts import says

PAPER = pathlib.Path(__file__).parents[2] / "examples" / "paper"
E_T, E_N, MU, WEIGHT = 6e-6, 1.5e-6, 0.6, 5.0


@cache
def solved(name):
    scene = load(PAPER / f"{name}.toml")
    grasp = scene.build()
    return grasp, scene.solve()


def marks(number, grasp, solution):
    """Of the printed forces of a table."""
    rows = rows_of(table(number), grasp, solution)
    return [r.mark for r in rows if r.column == "force"]


def script():
    spec = importlib.util.spec_from_file_location("wrench_from_fingertips", PAPER / "wrench_from_fingertips.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("file", sorted(PAPER.glob("*.toml")), ids=lambda p: p.stem)
def test_each_scene_is_held_by_a_small_motion(file):
    _, s = solved(file.stem)
    v = s.verdict
    assert v.word == "HELD"
    assert s.residuals.worst < 1e-8
    assert len(v.warnings) == (s.uniqueness.loose_motions > 0), "no warning of a large motion or of other forces"
    for warning in v.warnings:
        says(warning.sentence, "smallest")


@pytest.mark.parametrize(
    ("name", "number", "faces"),
    [("planar_frictionless", 1, 8), ("partially_known_forces", 3, 4), ("hard_finger", 6, 8)],
)
def test_the_forces_are_the_tables_to_every_printed_digit(name, number, faces):
    grasp, s = solved(name)
    assert set(marks(number, grasp, s)) == {Mark.DIGITS}
    # Finger 1's force in Example 2 is written with six digits
    np.testing.assert_allclose(s.forces, example(table(number).example).grasp.solve(faces).forces, rtol=1e-7, atol=1e-9)


def test_with_sixteen_faces_the_hard_fingers_are_table_8s():
    grasp, _ = solved("hard_finger")
    assert all(mark in REPRODUCED for mark in marks(8, grasp, grasp.solve(16)))


def test_the_planar_object_moves_as_table_1_prints_in_mm_and_mrad():
    grasp, s = solved("planar_frictionless")
    printed = [x.value for x in table(1).object]
    # The paper's external wrench is what the fingers exert: its displacement is minus the object's
    np.testing.assert_allclose(s.object_displacement[[0, 1, 5]] * 1e3, np.multiply(printed, (-1, -1, 1)), rtol=1e-9)
    retreat = arrays(grasp).flexibility @ s.forces.ravel() * 1e3
    tips = [table(1).fingertip[k + 1][0].value for k in range(6)]
    np.testing.assert_allclose(retreat[2::3], tips, atol=1e-9)
    assert s.uniqueness.forces_determined


def test_on_the_exact_cone_the_prisms_fingers_stick_with_a_share_of_one_to_four():
    """E_N u_n and E_T u_t of one and the same point: r_T/r_N = E_N/E_T, below μ = 0.3."""
    grasp, s = solved("partially_known_forces")
    assert s.contact_state[1:] == ("sliding", "sliding")
    slip = E_N * s.forces[1, 2] - E_T * abs(s.forces[1, 1])  # the object goes as far along both fingers
    assert np.hypot(*s.slip[1]) == pytest.approx(slip, rel=1e-9) == pytest.approx(1.3e-6, abs=0.05e-6)
    exact = grasp.solve("cone")
    assert exact.contact_state[1:] == ("sticking", "sticking")
    np.testing.assert_allclose(exact.forces[1, 2], 7.07 / 1.25, rtol=1e-6)
    np.testing.assert_allclose(abs(exact.forces[1:, 1]) / exact.forces[1:, 2], E_N / E_T, rtol=1e-9)


def test_soft_fingers_share_weight_and_moment_and_turn_by_their_pads():
    _, s = solved("soft_finger")
    half, moment = WEIGHT / 2, WEIGHT * 0.25 / 2
    turn = 1e-3 * moment
    np.testing.assert_allclose(s.forces_world, [(0, -20, half), (0, 20, half)], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(s.torsion, (-moment, moment), rtol=1e-9)
    # The line through the fingers sinks by E_T · half; the centre, 0.25 m beside and below it, turns about it
    expected = [0.25 * turn, 0, -E_T * half - 0.25 * turn, 0, -turn, 0]
    np.testing.assert_allclose(s.object_displacement, expected, rtol=1e-9, atol=1e-15)
    assert s.contact_state == ("sticking", "sticking")


def test_soft_fingers_hold_until_force_and_moment_reach_the_ellipsoid():
    """Statics asks for half the weight of each finger, and of one of them for half the moment at least; the squeeze
    alone says how hard they press.
    """
    grasp, _ = solved("soft_finger")
    least = np.hypot(WEIGHT / 2 / MU, WEIGHT / 8 / 0.05)  # N
    assert least == pytest.approx(13.2, abs=0.05)
    barely = grasp.replace(preload=1.001 * least * E_N).solve("cone")
    assert barely.contact_state == ("sticking", "sticking")
    np.testing.assert_allclose(barely.normal_force, 1.001 * least, rtol=1e-9)
    assert grasp.replace(preload=0.999 * least * E_N).solve("cone", throw=False).status is not hl.Status.SOLVED


def test_hard_fingers_in_their_place_let_the_cube_swing_down():
    grasp, _ = solved("soft_finger")
    hard = [c.with_friction(hl.Coulomb(MU)) for c in grasp.contacts]
    swung = hl.Grasp(
        hard, (0, 0, -WEIGHT, 0, 0, 0), flexibility=(E_T, E_T, E_N), preload=3e-5, reference=grasp.reference
    ).solve("cone", throw=False)
    assert swung.status is hl.Status.NOT_HOLDABLE
    says(swung.diagnosis, "fingers 1 and 2")


def test_the_bounded_total_is_reached_and_opens_every_finger_alike():
    """All stick: E r + Gᵀu + d + z̄ e_N = 0 with G r + w = 0 and Σ r_N = 12 are linear in r, u and z̄."""
    grasp, s = solved("total_bound")
    maps = []
    for c in grasp.contacts:
        x, y, z = c.position - grasp.reference
        maps.append(np.vstack([np.eye(3), [(0, -z, y), (z, 0, -x), (-y, x, 0)]]) @ c.rotation)
    G, normal = np.hstack(maps), np.tile((0.0, 0.0, 1.0), 3)
    A = np.zeros((16, 16))
    A[:9, :9], A[:9, 9:15], A[:9, 15] = np.diag(np.tile((E_T, E_T, E_N), 3)), G.T, normal
    A[9:15, :9], A[15, :9] = G, normal
    b = np.concatenate([2e-5 * normal, (0, 0, WEIGHT, 0, 0, 0), [12.0]])
    x = np.linalg.solve(A, b)
    np.testing.assert_allclose(s.forces.ravel(), x[:9], rtol=1e-9)
    np.testing.assert_allclose(s.object_displacement, x[9:15], rtol=1e-9)
    np.testing.assert_allclose(s.extra["z̄"], 1.42e-5, rtol=1e-9)
    assert x[15] == pytest.approx(1.42e-5, rel=1e-9)
    assert s.contact_state == ("sticking",) * 3


def test_without_the_bound_example_4_presses_with_33_8_newtons_and_with_5_8_micrometres_as_within_it():
    _, s = solved("total_bound")
    free = example(4, preload=2e-5).grasp.solve(8)
    assert free.normal_force.sum() == pytest.approx(33.8, abs=0.05)
    np.testing.assert_allclose(example(4, preload=5.8e-6).grasp.solve(8).forces, s.forces, rtol=1e-9)


def test_the_scripts_grasp_is_the_papers_example_5():
    weight = np.array([0, 0, -WEIGHT, 0, 0, 0])
    ours = script().example_5().replace(wrench=weight).solve(6)
    np.testing.assert_allclose(ours.forces_world, example(5).grasp.solve(6).forces_world, rtol=1e-9, atol=1e-9)


def test_the_script_reads_the_wrench_back_and_a_hundred_readings_are_ten_times_better_than_one(capsys):
    module = script()
    assert module.main().held
    said = capsys.readouterr().out
    put, back, one, mean = (  # one a line, each in brackets
        np.array([float(x) for x in wrench.split(",")]) for wrench in re.findall(r"\(((?:[^,()]+,){5}[^,()]+)\)", said)
    )
    np.testing.assert_array_equal(put, module.WRENCH)
    np.testing.assert_array_equal(back, put)
    assert 0.01 < abs(one - put)[:3].max() < 4 * module.NOISE * 5**0.5
    assert 0 < abs(mean - put)[:3].max() < 4 * module.NOISE * (5 / 100) ** 0.5
    assert re.findall(r"± ([\d.]+) mN", said) == ["44.7", "4.5"]
    assert len(re.findall(r"finger \d (?:sliding|sticking), .*µm", said)) == 5
