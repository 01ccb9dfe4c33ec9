"""All equilibria of a grasp: closed forms with one and with three, the independent checker's word, none missed."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch, ring
from tests.grasp.test_equilibria import exists
from tests.hard_cases.scenes import ENOUGH, Case
from tests.support import patches
from tests.support.grasp import arrays
from tests.support.laws import of_case
from tests.support.search import from_seeds
from tests.support.texts import says, without_numbers

KEY = "grasp/test_uniqueness"


@pytest.fixture(autouse=True)
def _the_same_time_for_all(monkeypatch):
    """What a search comes to does not depend on how busy the machine is."""
    patches.ticks_of_equilibria(monkeypatch)


def hook(mu, a=1e-3, b=0.9e-3, e=0.05e-3, stuck=(-1.3, 1.0)):
    """Planar. Finger 1 pushes up at the origin; its flexibility couples normal and tangent. Fingers 2 and 3, without
    friction, push towards the origin along the diagonals: e times the unit matrix for the origin. So with
    C = [[a, b], [b, a]] for (tangent, normal)

        v = C (r - stuck)

    is the motion of contact 1 under its force r, and `stuck` is its force as long as it sticks.
    """
    contacts = [
        hl.Contact((0, 0), (0, 1), hl.Coulomb(mu)),
        hl.Contact((-1, 1), np.array([1, -1]) / np.sqrt(2), hl.Frictionless()),
        hl.Contact((1, 1), np.array([-1, -1]) / np.sqrt(2), hl.Frictionless()),
    ]
    sign = contacts[0].rotation[0, 0]  # of the contact's x axis in the world's
    C = np.array([[a, sign * b], [sign * b, a]])
    E = np.zeros((9, 9))
    E[np.ix_([0, 2], [0, 2])] = C - e * np.eye(2)
    E[5, 5] = E[8, 8] = e
    F = np.array([0.0, 10.0])
    d = np.zeros((3, 3))
    d[0, [0, 2]] = -C @ [sign * stuck[0], stuck[1]] - e * F
    return hl.Grasp(contacts, (*F, 0.0), flexibility=E, offset=d)


def test_a_hook_has_three_equilibria():
    """Stuck: r = (-1.3, 1), inside friction as 1.3 < 1.5. Open: v_N = 0.9 · 1.3 - 1 = 0.17 > 0, in 1e-3. Sliding
    against r_T = -1.5 r_N: v_N = 0 gives (1 - 0.9 · 1.5) r_N = 1 - 0.9 · 1.3, r_N = 17/35, and v_T = 0.109 > 0.
    """
    grasp = hook(1.5)
    found = grasp.equilibria()
    assert found.complete
    assert sorted(s.normal_force[0] for s in found) == pytest.approx([0.0, 17 / 35, 1.0], abs=1e-9)
    states = {round(s.normal_force[0], 6): s.contact_state[0] for s in found}
    assert states == {0.0: "separated", 0.485714: "sliding", 1.0: "sticking"}
    opened = min(found, key=lambda s: s.normal_force[0])
    assert opened.gap[0] == pytest.approx(0.17e-3)
    assert all(s.uniqueness.others is True for s in found)
    says(str(opened.uniqueness), "determined")
    says(opened.diagnosis, "finger 1")
    says(str(found).splitlines()[0], "3", "16")
    assert any(np.allclose(grasp.solve().forces, s.forces) for s in found)


@pytest.mark.parametrize(("mu", "stuck"), [(1.2, (-1.3, 1.0)), (1.5, (-1.0, 1.0)), (1.5, (1.3, 1.0))])
def test_less_friction_or_another_load_leaves_one(mu, stuck):
    """1.2 < 1.3 does not let it stick: open. 0.9 · 1.0 < 1, and a pull to the other side, do not let it open: stuck."""
    found = hook(mu, stuck=stuck).equilibria()
    assert (len(found), found.complete) == (1, True)
    (only,) = found
    assert only.uniqueness.others is False
    says(str(only.uniqueness), "equilibrium")
    says(str(found).split("\n  normal")[0].replace("\n  ", " "), "16")


def test_without_friction_a_solve_proves_it_unique():
    angles = np.deg2rad([90, 210, 330])
    contacts = [hl.Contact((np.cos(a), np.sin(a)), (-np.cos(a), -np.sin(a)), hl.Frictionless()) for a in angles]
    grasp = hl.Grasp(contacts, (0.5, -1, 0), flexibility=1e-3, preload=1e-2)
    s = grasp.solve()
    assert s.uniqueness.forces_determined
    assert s.uniqueness.others is False
    found = grasp.equilibria()
    assert (len(found), found.complete) == (1, True)
    says(found.why, "friction")


def test_with_friction_a_solve_claims_nothing():
    s = pinch().solve()
    assert s.uniqueness.others is None
    says(str(s.uniqueness), "grasp.equilibria()")
    assert str(s.uniqueness) in " ".join(str(s).split())
    says(s.diagnosis, "through left and right")


def test_a_family_of_forces_counts_once():
    """Rigid tangents: the pinch's vertical forces are equal by symmetry only in the least-norm member."""
    found = pinch(load=(0, 0, -1.0), flexibility=(0.0, 0.0, 1e-4)).equilibria()
    assert len(found) == 1
    (only,) = found
    if not only.uniqueness.forces_determined:
        assert not found.complete  # rigid fingers: no table of modes


# ---------------------------------------------------------------- spatial scenes
def case(g, faces):
    s = arrays(g)
    w = np.r_[s.force, s.moment]
    return Case("", s.positions, s.frames, s.mu, s.flexibility, s.offset, w, faces)


@pytest.mark.parametrize("faces", [4, 8, "cone"])
def test_rings_with_several_equilibria_pass_the_independent_checker(faces):
    most = 0
    for seed in range(6):
        contacts, data = ring(np.random.default_rng(seed), n=4 if faces == 8 else 3, mu=0.9)
        g = hl.Grasp(contacts, **data)
        found = g.equilibria(faces)
        assert found.complete == (faces != "cone")
        most = max(most, len(found))
        for k, s in enumerate(found):
            assert of_case(case(g, faces), s).worst < ENOUGH
            for other in found.found[:k]:
                assert abs(s.forces - other.forces).max() > 1e-6 * abs(s.forces).max()
        first = g.solve(faces, throw=False)
        if first.held:
            assert any(abs(first.forces - s.forces).max() < 1e-6 * abs(s.forces).max() for s in found)
        elif faces != "cone":
            assert not len(found)
    assert most > 1


@pytest.mark.parametrize("seed", range(8))
def test_none_is_missed(seed):
    """Where the list is complete, no other seed finds more; and where it is empty, no choice of modes has a point."""
    rng = np.random.default_rng(seed)
    contacts, data = ring(rng, n=2 if seed % 2 else 3, mu=0.5, preload=float(rng.choice([0.0, 1e-3, 0.01])))
    g = hl.Grasp(contacts, **data)
    m = 4 if seed % 2 else 3
    found = g.equilibria(m)
    assert found.complete
    assert bool(len(found)) == exists(g, m)
    for c in from_seeds(g, m, 6, seed=100):
        assert any(abs(c.forces - s.forces).max() < 1e-6 * abs(s.forces).max() for s in found)


def test_planar_scenes_with_strong_coupling_by_many_seeds():
    """Planar, μ = 1.5: several of these scenes have more than one; seeds find no other than the list."""
    rng, several = np.random.default_rng(0), 0
    for _ in range(40):
        a = rng.uniform(0, 2 * np.pi, 3)
        contacts = [hl.Contact(x, -x, hl.Coulomb(1.5)) for x in np.column_stack([np.cos(a), np.sin(a)])]
        B = rng.normal(size=(6, 6))
        g = hl.Grasp(contacts, rng.normal(size=3), flexibility=_planar(B @ B.T), preload=rng.uniform(0, 3e-3, 3))
        found = g.equilibria()
        several += len(found) > 1
        assert found.complete
        for c in from_seeds(g, 8, 3):
            assert any(abs(c.forces - s.forces).max() < 1e-6 * abs(s.forces).max() for s in found)
    assert several


def _planar(E):
    """(9, 9) with the six in-plane components."""
    out = np.zeros((9, 9))
    own = [0, 2, 3, 5, 6, 8]
    out[np.ix_(own, own)] = E * 1e-3
    return out


def test_too_many_choices_are_not_claimed():
    contacts, data = ring(np.random.default_rng(0), n=5)
    found = hl.Grasp(contacts, **data).equilibria(16, seconds=0.05)
    assert not found.complete
    says(without_numbers(found.why), "choices")
    if len(found) == 1:
        assert found.found[0].uniqueness.others is None


def test_a_bound_on_total_force_leaves_the_list_complete():
    found = hook(1.5).equilibria()
    g = hook(1.5)
    bounded = hl.Grasp(
        g.contacts, (0, 10.0, 0), flexibility=g.flexibility, offset=g.offset, effects=[hl.TotalForceBound(1e3)]
    ).equilibria()
    assert bounded.complete
    for a, b in zip(found, bounded, strict=True):
        np.testing.assert_allclose(a.forces, b.forces, atol=1e-9)


@pytest.mark.parametrize("faces", [4, 8, "cone"])
def test_where_no_force_is_needed_rounding_makes_no_equilibria(faces):
    """Fingertips only off to one side: the object follows or they slip, and nothing pushes."""
    angles = 2 * np.pi * np.arange(3) / 3
    contacts = [
        hl.Contact((0.03 * np.cos(a), 0.03 * np.sin(a), 0), (-np.cos(a), -np.sin(a), 0), hl.Coulomb(0.5))
        for a in angles
    ]
    g = hl.Grasp(contacts, flexibility=1e-4, offset=[[1e-3, 0, 0]] * 3)
    found = g.equilibria(faces)
    assert len(found) == 1
    (only,) = found
    assert abs(only.forces).max() < 1e-9
    assert only.uniqueness.others is not True
    assert "(0, 0, 0) N" in str(found)
    says(g.solve(faces).diagnosis, "4 directions")


def test_rounding_is_measured_against_the_scene_not_the_forces():
    """The same in a plane, in newtons, micronewtons and meganewtons."""
    for unit in (1.0, 1e-6, 1e6):
        a = np.deg2rad([90, 210, 330])
        contacts = [hl.Contact(x, -x, hl.Coulomb(1.5)) for x in np.column_stack([np.cos(a), np.sin(a)])]
        g = hl.Grasp(contacts, flexibility=1e-3 / unit, offset=[[1e-3, 0, 0]] * 3)
        assert len(g.equilibria()) == 1
        says(g.solve().diagnosis, "spin")
