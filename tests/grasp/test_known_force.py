"""Known components of a contact's force: what a fingertip reads, and how far its finger moves to read it."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.scene import read
from tests.grasp import scenes


def pinch(*known):
    return scenes.pinch(effects=known)


def ring(*known, squeeze=0.5e-3):
    rng, contacts = np.random.default_rng(4), []
    for k in range(4):
        a = 2 * np.pi * (k + 0.2 * rng.random()) / 4
        n = np.array([-np.cos(a), -np.sin(a), 0.2 * rng.standard_normal()])
        contacts.append(hl.Contact(-0.03 * n, n / np.linalg.norm(n), hl.Coulomb(0.5)))
    return hl.Grasp(contacts, (0.3, 0.2, -1, 0, 0.002, 0), flexibility=1e-4, preload=squeeze, effects=known)


@pytest.mark.parametrize("faces", [8, "cone"])
def test_a_known_squeeze_is_the_squeeze_and_the_finger_moves_by_both_flexibilities(faces):
    s = pinch(hl.KnownForce(0, (None, None, 4.0))).solve(faces)
    np.testing.assert_allclose(s.normal_force, 4.0, rtol=1e-9)
    np.testing.assert_allclose(s.extra["κ0⁺"] - s.extra["κ0⁻"], (10.0 - 4.0) * 2e-4, rtol=1e-9)


@pytest.mark.parametrize("faces", [8, "cone"])
@pytest.mark.parametrize("known", [(0,), (2,), (0, 1), (1, 2), (0, 1, 2)])
def test_readings_of_the_answer_itself_change_nothing(faces, known):
    free = ring().solve(faces)
    parts = [float(f) if k in known else None for k, f in enumerate(free.forces[1])]
    s = ring(hl.KnownForce(1, parts)).solve(faces)
    np.testing.assert_allclose(s.forces, free.forces, atol=1e-8)
    np.testing.assert_allclose(s.extra["κ1⁺"], s.extra["κ1⁻"], atol=1e-11)


@pytest.mark.parametrize("faces", [8, "cone"])
def test_another_reading_is_met_and_the_others_take_the_rest(faces):
    free = ring().solve(faces)
    more = float(free.forces[1, 2]) * 1.3
    s = ring(hl.KnownForce(1, (None, None, more)), hl.KnownForce(2, (None, 0.1, None))).solve(faces)
    np.testing.assert_allclose(s.forces[1, 2], more, rtol=1e-9)
    np.testing.assert_allclose(s.forces[2, 1], 0.1, rtol=1e-9)
    np.testing.assert_allclose(s.forces_world.sum(axis=0), (-0.3, -0.2, 1.0), atol=1e-9)


@pytest.mark.parametrize("faces", [8, "cone"])
def test_readings_that_no_balance_allows_are_proven_so(faces):
    """Each of two fingers bears half a newton across: one that reads 0.3 N cannot be."""
    s = pinch(hl.KnownForce(0, (0.3, 0.0, None))).solve(faces, throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    weak = pinch(hl.KnownForce(0, (None, None, 0.9))).solve(faces, throw=False)  # 0.5 N needs 1 N of squeeze
    assert weak.status is hl.Status.NO_EQUILIBRIUM


def test_anisotropic_friction_reads_in_newtons():
    law = hl.AnisotropicCoulomb(0.2, 0.6)
    contacts = [hl.Contact((s * 0.01, 0, 0), (-s, 0, 0), law, (0, 0, 1)) for s in (-1.0, 1.0)]
    readings = hl.KnownForce(0, (0.5, None, None))
    g = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3, effects=[readings])
    np.testing.assert_allclose(g.solve().forces[0], (0.5, 0.0, 10.0), atol=1e-9)


def test_a_scene_file_says_it_by_name_or_number():
    text = """
[[contact]]
position_m = [-0.01, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
[[contact]]
position_m = [0.01, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
name = "thumb"
[grasp]
flexibility_m_per_N = 1e-4
preload_m = 1e-3
[[effects.known_force]]
contact = "thumb"
normal_N = 4.0
"""
    np.testing.assert_allclose(read(text).build().solve().normal_force, 4.0, rtol=1e-9)
    with pytest.raises(hl.InputError, match=r"effects\.known_force\[0\]"):
        read(text.replace("normal_N = 4.0", "")).build()


def test_a_reading_of_a_contact_that_is_none_is_refused():
    with pytest.raises(hl.InputError, match=r"effects\[0\]\.contact"):
        pinch(hl.KnownForce(7, (1.0, None, None)))
