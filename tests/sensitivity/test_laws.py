"""Derivatives of grasps without a hand: every friction law, on the cone and on pyramids; rows of the table."""

from dataclasses import replace

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch, ring
from tests.support.sensitivity import misses, three_pairs

LAWS = {
    "Coulomb": hl.Coulomb(0.5), "soft": hl.SoftFinger(0.5, 0.005, 2.0), "anisotropic": hl.AnisotropicCoulomb(0.6, 0.3),
}  # fmt: skip
SEEDS = (0, 3)


@pytest.mark.parametrize("faces", ["cone", 8])
@pytest.mark.parametrize(("law", "seed"), [(law, seed) for law in LAWS for seed in SEEDS])
def test_derivatives_are_those_of_whole_solves(law, seed, faces):
    contacts, args = ring(np.random.default_rng(seed), preload=0.003)
    g = hl.Grasp([hl.Contact(c.position, c.rotation[:, 2], LAWS[law]) for c in contacts], **args)
    s = g.solve(faces)
    found = s.sensitivity()
    assert not [k for k in found.kinks if not k.by]  # of all parameters
    entries = {
        "wrench": [(2,), (4,)], "squeeze": [(1,)], "pads": [(0,)], "positions": [(1, 0), (2, 2)],
        "normals": [(0, 0), (3, 1), (3, 2)], "friction": [(0,), (3,)],
    }  # fmt: skip
    for parameter, indices in entries.items():
        for index in indices:
            missed = misses(g, s, faces, parameter, index)
            assert max(missed.values()) < 1e-6, (parameter, index, missed)


def test_a_pinch_follows_its_closed_forms():
    """Two pads c, squeezed by s each: normal force s/c. The load is shared, and moves the object by c/2 each."""
    c, mu, squeeze = 1e-4, 0.5, 1e-3
    s = pinch(mu, squeeze).solve().sensitivity()
    assert s.forces_by_squeeze[:, 2] == pytest.approx(np.full((2, 2), 0.5 / c), rel=1e-9)
    assert s.displacement_by_wrench[2, 2] == pytest.approx(c / 2, rel=1e-9)
    assert s.forces_by_wrench[:, 0, 2] == pytest.approx([-0.5, -0.5], rel=1e-9)
    assert s.friction_margin_by_friction.diagonal() == pytest.approx([squeeze / c] * 2, rel=1e-9)
    assert s.friction_margin_by_pads == pytest.approx(np.full((2, 2), -mu * squeeze / c**2 / 2), rel=1e-9)


def test_what_the_answer_leaves_free_is_no_number():
    """Two points do not resist turning about the line between them, and bear no moment about it."""
    s = pinch().solve().sensitivity()
    assert s.free == 1
    assert np.isnan(s.displacement_by_wrench[3]).all()
    assert np.isnan(s.forces_by_wrench[..., 3]).all()
    assert np.isfinite(np.delete(s.forces_by_wrench, 3, axis=2)).all()


def test_the_motion_of_a_grasp_that_sticks_is_reciprocal():
    """Monotone laws have a symmetric tangent: the motion by the load is a symmetric matrix (Maxwell and Betti)."""
    for seed in range(3):
        contacts, args = ring(np.random.default_rng(seed), preload=0.01)
        sticky = [hl.Contact(c.position, c.rotation[:, 2], hl.Coulomb(5.0)) for c in contacts]
        s = hl.Grasp(sticky, **args).solve()
        assert set(s.contact_state) == {"sticking"}
        D = s.sensitivity().displacement_by_wrench
        assert abs(D - D.T).max() <= 1e-9 * abs(D).max()


def test_only_answers_have_derivatives():
    none = hl.Grasp([hl.Contact((0, 0, 0), (0, 0, 1), hl.Coulomb(0.5))], (0, 0, 5, 0, 0, 0)).solve(throw=False)
    with pytest.raises(hl.HandLCPError, match="held"):
        none.sensitivity()


# ---------------------------------------------------------------- the table of an answer's derivatives: rows are
HAND = hl.example_hand("three_finger", joint_stiffness=6.0)
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.3)


def test_a_row_of_friction_is_all_fingers_together():
    """One of three pairs slides: with less friction there the others bear more, and the object moves."""
    contacts = three_pairs(0.2)
    solution = hl.Grasp(contacts, (0, 0, -20.0, 0, 0, 0), flexibility=1e-4, preload=1e-3).solve()
    assert "sliding" in str(solution.contact_state)
    found = solution.sensitivity()
    drop = -0.1 * np.array([c.mu for c in contacts])
    moved = 1e3 * np.linalg.norm(found.displacement_by_friction[:3] @ drop)
    assert moved == pytest.approx(0.01, rel=1e-6)  # 2 · 0.2 N more, on four pads of 0.1 mm/N
    row = next(line for line in str(found).splitlines() if line.startswith("friction -10 %"))
    assert row.split()[-1] == f"{moved:.3g}"


def test_of_fingers_that_mirror_each_other_the_first_is_shown_whatever_rounding_says():
    solution = HAND.at(HAND.close_on(CUBE)).grasp(CUBE, friction=0.8, grip_force=6.0).solve()
    assert np.allclose(abs(solution.forces[1]), abs(solution.forces[2]), rtol=1e-9)
    said = set()
    for way in (1.0, -1.0):
        forces = solution.forces.copy()
        forces[1] *= 1.0 + way * 1e-12
        forces[2] *= 1.0 - way * 1e-12
        said.add(str(replace(solution, forces=forces).sensitivity()))
    assert len(said) == 1
    assert "to spare at finger_2_tip" in " ".join(said.pop().split())
