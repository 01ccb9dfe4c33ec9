"""Soft fingers: a moment about the normal, within an ellipsoid or a polyhedron, and what turns under it."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.grasp import arrays, at_centre, judged, limit_surface
from tests.support.lcp import nearest_in_polyhedron
from tests.support.search import searched

SOFT = hl.SoftFinger(0.5, 0.005, 3.0)


def pinch(first=SOFT, second=SOFT, wrench=(0, 0, -1, 0.02, 0, 0), preload=1e-3, **more):
    """Two fingers 20 mm apart along x, 0.1 mm/N each: 10 N of squeeze per millimetre."""
    contacts = [
        hl.Contact((-0.01, 0, 0), (1, 0, 0), friction=first),
        hl.Contact((0.01, 0, 0), (-1, 0, 0), friction=second),
    ]
    return hl.Grasp(contacts, wrench, flexibility=1e-4, preload=preload, **more)


def ring(seed, laws, squeeze=0.4e-3):
    """Four fingers around an object, loaded at random."""
    rng = np.random.default_rng(seed)
    contacts = []
    for k, law in enumerate(laws):
        a = 2 * np.pi * (k + 0.2 * rng.random()) / len(laws)
        n = np.array([-np.cos(a), -np.sin(a), 0.3 * rng.standard_normal()])
        contacts.append(hl.Contact(-0.03 * n, n / np.linalg.norm(n), friction=law))
    load = rng.standard_normal(6) * np.array([1, 1, 1, 0.01, 0.01, 0.01])
    return hl.Grasp(contacts, load, flexibility=1e-4 * rng.uniform(0.5, 2, 3), preload=squeeze)


@pytest.mark.parametrize("faces", [4, 8, 13, "cone"])
def test_two_alike_share_a_moment_about_their_line_and_turn_by_their_pads(faces):
    s = pinch().solve(faces)
    assert s.contact_state == ("sticking", "sticking")
    np.testing.assert_allclose(s.torsion, (-0.01, 0.01), rtol=1e-9)
    np.testing.assert_allclose(s.object_displacement[3], 0.01 * 3.0, rtol=1e-9)
    np.testing.assert_allclose(s.forces[:, 2], 10.0, rtol=1e-9)
    assert abs(s.spin).max() < 1e-12


@pytest.mark.parametrize("faces", [4, 8, 16, "cone"])
def test_at_its_limit_one_turns_on_the_object_and_the_other_bears_the_rest(faces):
    weak = hl.SoftFinger(0.5, 0.0004, 3.0)
    s = pinch(weak, SOFT, wrench=(0, 0, 0, 0.02, 0, 0)).solve(faces)
    share = 1.0 if faces == "cone" else limit_surface(hl.Pyramid(faces)).share
    limit = share * 0.0004 * 10.0
    turned = 3.0 * (0.02 - limit)
    np.testing.assert_allclose(s.torsion, (-limit, 0.02 - limit), rtol=1e-9)
    np.testing.assert_allclose(s.object_displacement[3], turned, rtol=1e-9)
    np.testing.assert_allclose(s.spin[0], turned - 3.0 * limit, rtol=1e-9)
    assert s.contact_state == ("sliding", "sticking")
    assert s.uniqueness.loose_motions == 0


def test_a_point_lets_the_object_spin_and_a_patch_does_not():
    assert pinch(hl.Coulomb(0.5), hl.Coulomb(0.5), wrench=(0, 0, -1, 0, 0, 0)).solve().uniqueness.loose_motions == 1
    for faces in (8, "cone"):
        assert pinch(wrench=(0, 0, -1, 0, 0, 0)).solve(faces).uniqueness.loose_motions == 0


def test_rigid_pads_hold_the_object_still_and_share_a_moment_as_the_least_norm_says():
    rigid = hl.SoftFinger(0.5, 0.005)
    s = pinch(rigid, rigid).solve("cone")
    assert not s.uniqueness.forces_determined
    np.testing.assert_allclose(s.torsion, (-0.01, 0.01), rtol=1e-9)
    assert abs(s.object_displacement[3]) < 1e-12


@pytest.mark.parametrize("seed", [1, 2, 5, 7])
def test_sliding_on_the_ellipsoid_is_at_the_limit_and_against_its_normal(seed):
    laws = [hl.SoftFinger(0.5, 0.004, 5.0), hl.Coulomb(0.4), hl.SoftFinger(0.3, 0.002, 1.0), hl.SoftFinger(0.2, 0.001)]
    g = ring(seed, laws, 0.15e-3)
    s = g.solve("cone")
    soft = [i for i, law in enumerate(laws) if isinstance(law, hl.SoftFinger) and s.contact_state[i] == "sliding"]
    assert soft
    for i in soft:
        law, size = laws[i], max(abs(s.forces).max(), 1e-9)
        t = np.array([*s.forces[i, :2] / law.mu, s.torsion[i] / law.mu_torsion])
        assert np.linalg.norm(t) == pytest.approx(s.forces[i, 2], rel=1e-9, abs=1e-9 * size)
        slip = np.array([*s.slip[i] * law.mu, s.spin[i] * law.mu_torsion])
        np.testing.assert_allclose(slip / np.linalg.norm(slip), -t / np.linalg.norm(t), atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_forces_and_moments_balance_the_load(seed):
    g = ring(seed, [SOFT, SOFT, hl.Coulomb(0.4), SOFT], 0.8e-3)
    for faces in (4, 8, "cone"):
        s = g.solve(faces)
        total = np.zeros(6)
        for i, c in enumerate(g.contacts):
            f = s.forces_world[i]
            total += np.append(f, np.cross(c.position, f) + s.torsion[i] * c.normal)
        load = np.append(arrays(g).force, arrays(g).moment)
        np.testing.assert_allclose(total, -load, atol=1e-9 * abs(load).max())


def test_polyhedra_lead_to_the_ellipsoid_as_the_square_of_their_faces():
    g = ring(2, [hl.SoftFinger(0.3, 0.002, 2.0)] * 4, 0.15e-3)
    exact = g.solve("cone")
    assert "sliding" in exact.contact_state
    off = [abs(g.solve(m).forces - exact.forces).max() / abs(exact.forces).max() for m in (8, 16, 32, 64)]
    assert off[-1] < off[0] / 10
    assert off[-1] < 2e-3


@pytest.mark.parametrize("faces", [4, 8, "cone"])
def test_a_moment_beyond_what_any_force_bears_is_proven_unholdable(faces):
    """One finger presses 4 N down on the object against a push from below: it bears 4 N × 5 mm at most."""

    def lone(moment):
        return hl.Grasp(
            [hl.Contact((0, 0, 0.01), (0, 0, -1), friction=SOFT)], (0, 0, 4, 0, 0, moment), flexibility=1e-4
        )

    share = 1.0 if faces == "cone" else limit_surface(hl.Pyramid(faces)).share
    s = lone(0.99 * share * 0.02).solve(faces)
    np.testing.assert_allclose(abs(s.torsion), 0.99 * share * 0.02, rtol=1e-9)
    beyond = lone(1.01 * 0.02).solve(faces, throw=False)
    assert beyond.status is hl.Status.NOT_HOLDABLE
    assert beyond.certificate[5] > 0.0


def test_polyhedra_touch_the_ball_and_inscribed_ones_stay_within():
    for m in (3, 4, 5, 8, 12, 17):
        inner, outer = (limit_surface(hl.Pyramid(m, inscribed=i)) for i in (True, False))
        assert outer.share == 1.0
        assert (outer.normals.T @ outer.vertices).max() < 1.0 + 1e-12
        assert np.linalg.norm(inner.share * inner.vertices, axis=0).max() == pytest.approx(1.0, rel=1e-12)


def test_the_nearest_point_of_a_polyhedron_is_feasible_and_what_is_left_lies_in_the_normals():
    rng = np.random.default_rng(0)
    for m in (3, 4, 8, 16):
        normals = limit_surface(hl.Pyramid(m)).outward
        for _ in range(100):
            s, a = rng.standard_normal(3) * 3, rng.uniform(0.1, 2)
            p = nearest_in_polyhedron(s, a, normals)
            slack = a - normals @ p
            assert slack.min() > -1e-10
            active = normals[slack < 1e-9]
            weights = np.linalg.lstsq(active.T, s - p, rcond=None)[0] if len(active) else np.zeros(0)
            assert np.linalg.norm(active.T @ weights - (s - p)) < 1e-9
            # p = argmin over a convex set: no point of it lies further along s - p
            corner = limit_surface(hl.Pyramid(m)).vertices * a
            assert ((s - p) @ (corner - p[:, None])).max() < 1e-9


def test_on_the_ellipsoid_no_equilibrium_is_proven_with_the_squeeze_that_would_help():
    s = pinch(wrench=(0, 0, -5, 0.12, 0, 0)).solve("cone", throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    assert s.bounds is not None
    assert pinch(wrench=(0, 0, -5, 0.12, 0, 0), preload=1e-3 + 1.01 * s.required_preload).solve("cone").held


def constructed(seed):
    """Soft fingers in a known equilibrium on the ellipsoids: forces, moments and motions first, then the load and the
    offsets that make them one. Returns the grasp, forces (n, 3), torsion (n,) and
    the object's motion about the origin.
    """
    rng = np.random.default_rng(seed)
    n, lever = int(rng.integers(2, 5)), rng.uniform(0.003, 0.01)
    omega, forces, moments, contacts, v = rng.standard_normal(3) * 1e-2, [], [], [], []
    for _ in range(n):
        z = rng.standard_normal(3)
        z /= np.linalg.norm(z)
        turned, mu = float(z @ omega), rng.uniform(0.2, 0.8)
        state, N = rng.choice(["apart", "sticks", "slides"]), rng.uniform(0.5, 5.0)
        t = rng.standard_normal(3)
        t *= 1.0 / np.linalg.norm(t)
        t[2] = -np.sign(turned) * max(abs(t[2]), 0.2)  # the moment resists the turn
        t *= mu * N / np.linalg.norm(t) * (rng.uniform(0.2, 0.9) if state == "sticks" else 1.0)
        r, m, soft, slip, gap = np.append(t[:2], N), lever * t[2], 0.0, np.zeros(2), 0.0
        if state == "apart":
            r, m, gap, slip = np.zeros(3), 0.0, rng.uniform(1e-4, 1e-3), rng.standard_normal(2) * 1e-3
        elif state == "sticks":
            soft = -turned / m
        else:
            slip = lever**2 * turned / m * t[:2]
        contacts.append(hl.Contact(-0.03 * z, z, hl.SoftFinger(mu, mu * lever, soft)))
        forces.append(r), moments.append(m), v.append([*slip, gap])
    B = rng.standard_normal((3 * n, 3 * n)) * 3e-3
    E, r = B @ B.T, np.concatenate(forces)
    u = np.append(rng.standard_normal(3) * 1e-3, omega)
    moved = np.array([c.rotation.T @ (u[:3] + np.cross(omega, c.position)) for c in contacts])
    offset = np.array(v) - moved - (E @ r).reshape(-1, 3)
    world = [c.rotation @ f for c, f in zip(contacts, forces, strict=True)]
    load = -np.append(
        np.sum(world, axis=0),
        np.sum(
            [np.cross(c.position, f) + m * c.normal for c, f, m in zip(contacts, world, moments, strict=True)], axis=0
        ),
    )
    return hl.Grasp(contacts, load, flexibility=E, offset=offset), np.array(forces), np.array(moments), u


@pytest.mark.parametrize("seed", range(24))
def test_where_there_is_an_equilibrium_the_certifier_knows_it_and_nobody_says_none(seed):
    g, forces, moments, u = constructed(seed)
    levers = np.array([c.friction.lever for c in g.contacts])
    assert judged(g, "cone", forces, at_centre(g, u), torsion=moments / levers).worst < 1e-10
    s = g.solve("cone", hl.Auto(search_seconds=0.3), throw=False)
    assert s.status in (hl.Status.SOLVED, hl.Status.UNDECIDED)


def test_the_search_knows_that_an_open_soft_contact_slips_and_turns_freely():
    """Two fingers hold a load that lies across the third one, which a gap keeps off: an equilibrium in closed form, in
    which the object slips by f / (2 k) and turns by m / (2 k d²) before a fingertip that carries nothing.
    """
    d, softness, squeeze, law = 0.02, 1e-4, 2e-3, hl.SoftFinger(0.5, 0.004, 50.0)
    contacts = [hl.Contact((x, 0, 0), (-np.sign(x), 0, 0), law) for x in (-d, d)]
    contacts.append(hl.Contact((0, 0, d), (0, 0, -1), law))
    offset = [[0, 0, -squeeze], [0, 0, -squeeze], [0, 0, 1e-3]]
    g = hl.Grasp(contacts, (0, 8, -8, 0, 0, 0.02), flexibility=softness, offset=offset)
    found = searched(g, "cone")
    assert found.outcome == "solution"
    np.testing.assert_allclose(found.candidate.forces[:, 2], [squeeze / softness] * 2 + [0.0], atol=1e-9)
    s = g.solve("cone")
    assert s.contact_state == ("sticking", "sticking", "separated")
    np.testing.assert_allclose(np.linalg.norm(s.slip[2]), 8.0 * softness / 2, rtol=1e-9)
    np.testing.assert_allclose(abs(s.spin[2]), 0.02 * softness / (2 * d**2), rtol=1e-9)


@pytest.mark.parametrize(
    ("first", "second", "moment", "moves"),
    [
        *(
            (*(hl.SoftFinger(0.5, torsion, 3.0),) * 2, 0.02, 1e-10 * np.eye(6)[:3])
            for torsion in (0.005, 0.05, 0.5, 4.0)
        ),
        (*(hl.SoftFinger(1000.0, 0.005, 3.0),) * 2, 0.02, 1e-4 * np.eye(6)[3:4]),
        (hl.SoftFinger(0.5, 0.005, 1e12), SOFT, 0.0, 1e-6 * np.eye(6)[:1]),
    ],
)
def test_no_lever_and_no_pad_excuses_an_overlap_a_slip_or_a_turn(first, second, moment, moves):
    """In the law's coordinates a turn is as long as the lever; gaps and slips are not measured by that. What friction
    has to spare must hold a contact still: with a small lever a turn by a thousandth of its size shows.
    """
    g = pinch(first, second or first, wrench=(0, 0, -1, moment, 0, 0))
    s = g.solve("cone")
    torsion = s.torsion / first.lever  # in the law's coordinates
    assert judged(g, "cone", s.forces, at_centre(g, s), torsion=torsion).passes
    for moved in moves:
        assert not judged(g, "cone", s.forces, at_centre(g, s) + moved, torsion=torsion).passes


def test_torsion_without_end_is_refused_with_a_bound():
    with pytest.raises(hl.InputError, match="mu_torsion / mu up to 1000 times the size of the grasp, 10 m, got 2e"):
        pinch(hl.SoftFinger(0.5, 1e14))
    with pytest.raises(hl.InputError, match=r"SoftFinger\.mu: expected a number > 0 and ≤ 10000"):
        hl.SoftFinger(1e5, 0.01)
    assert pinch(hl.SoftFinger(1e5, 0.0)).solve().torsion[0] == 0.0
