"""The table of an answer's derivatives: rows are changes of all fingers together, named as the user commanded them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import handlcp as hl

HAND = hl.example_hand("three_finger", joint_stiffness=6.0)
CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.3)


def pair(axis, mu, x=0.0):
    e, at = np.eye(3)[axis], np.array([x, 0.0, 0.0])
    return [hl.Contact(at - a * e, a * e, hl.Coulomb(mu), tangent=(0, 0, 1)) for a in (1.0, -1.0)]


def test_a_row_of_friction_is_all_fingers_together():
    """One of three pairs slides: with less friction there the others bear more, and the object moves."""
    contacts = [*pair(0, 0.2), *pair(1, 0.9, 0.5), *pair(1, 0.9, -0.5)]
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
