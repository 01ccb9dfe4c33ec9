"""The search over contact modes with effects that limit the forces: closed forms, an independent search of the plain
LCP, equilibria that were put together by hand, and statuses on pyramids, in a plane and on the exact cone.
"""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch, ring
from tests.grasp.test_uniqueness import hook
from tests.support import patches
from tests.support.grasp import arrays, candidate, residuals
from tests.support.search import active_sets, choices_of_modes, members_of_modes, overload, saturation, searched
from tests.support.texts import says, without_numbers

C = 1e-4  # m/N
SECTIONS = [4, 8, "cone"]
KEY = "grasp/test_within_limits"
NO_SEARCH = hl.Auto(search_seconds=0.0)
PATIENT = hl.Auto(search_seconds=60.0)  # what is proven must not depend on who else uses the machine


@pytest.fixture(autouse=True)
def _the_same_time_for_all(monkeypatch):
    """What a search for all equilibria comes to does not depend on how busy the machine is."""
    patches.ticks_of_equilibria(monkeypatch)


def two_pairs(load, effects, squeeze=(2e-4, 1e-3), mu=(0.5, 0.5)):
    """A pair of fingers along x and one along y, an object that slides down between them."""
    contacts = [
        hl.Contact(0.01 * p, -p, hl.Coulomb(m), tangent=(0, 0, 1))
        for p, m in zip(np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]]), np.repeat(mu, 2), strict=True)
    ]
    data = {"flexibility": C, "preload": np.repeat(squeeze, 2)}
    return hl.Grasp(contacts, (0, 0, -load, 0, 0, 0), **data, effects=effects)


def towards_a_face(faces):
    return 1.0 if faces == "cone" else np.cos(np.pi / faces)


# ---------------------------------------------------------------- closed forms
@pytest.mark.parametrize("faces", SECTIONS)
def test_a_bounded_pair_holds_as_much_as_its_bound_and_the_squeeze_of_the_other_allow(faces):
    """N = 2 N where nothing is bounded, 4 N at the bound: μ (2 + 2 + 4 + 4) in all. More squeeze of the first pair
    would hold twice of that, within all bounds.
    """
    bounds, limit = [hl.FingerForceBound([np.inf, np.inf, 4.0, 4.0])], 6.0 * towards_a_face(faces)
    found = searched(two_pairs(0.99 * limit, bounds), faces)
    assert found.outcome == "solution"
    np.testing.assert_allclose(found.candidate.extra["z̄_i"].sum(), 2 * (1e-3 - 4 * C), rtol=1e-9)
    beyond = two_pairs(1.01 * limit, bounds)
    assert overload(beyond, faces) is None
    assert searched(beyond, faces).outcome == "none"
    s = beyond.solve(faces, PATIENT, throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    assert s.bounds[0] >= 1000
    # Forces within the bound would do, so it is not to blame
    says(without_numbers(s.diagnosis), "squeeze is too small")
    assert hl.FingerForceBound.title not in s.diagnosis
    assert beyond.replace(preload=np.repeat([3e-4, 1e-3], 2)).solve(faces).held


@pytest.mark.parametrize("faces", SECTIONS)
def test_a_total_bound_opens_the_fingers_that_hold_as_far_as_the_others(faces):
    """z̄ is common to all: r̄ / 4 each, of which only the pair with friction holds anything."""
    bound, limit = [hl.TotalForceBound(8.0)], 2.0 * towards_a_face(faces)

    def g(load):
        return two_pairs(load, bound, squeeze=(1e-3, 1e-3), mu=(0.5, 0.0))

    found = searched(g(0.99 * limit), faces)
    assert found.outcome == "solution"
    np.testing.assert_allclose(found.candidate.extra["z̄"], 1e-3 - 2 * C, rtol=1e-9)
    beyond = g(1.5 * limit)
    assert overload(beyond, faces) is None
    assert beyond.solve(faces, throw=False).status is hl.Status.NO_EQUILIBRIUM


def test_in_a_plane_too():
    """Two fingers squeezed to 10 N and bounded to 6 N, a bound that three newtons of load sideways do not reach."""
    contacts = [hl.Contact((x, 0), (-x, 0), hl.Coulomb(0.5)) for x in (-1, 1)]

    def g(load, *effects):
        return hl.Grasp(contacts, (0, -load, 0), flexibility=C, preload=1e-3, effects=effects)

    for effect in (hl.FingerForceBound(6.0), hl.TotalForceBound(12.0)):
        assert searched(g(5.9, effect), 8).outcome == "solution"
        assert searched(g(6.1, effect), 8).outcome == "none"
        all_of_them = g(5.9, effect).equilibria()
        assert all_of_them.complete
        np.testing.assert_allclose(all_of_them.found[0].normal_force, 6.0, rtol=1e-9)
    loose = hl.Grasp(contacts, (0, -6.1, 0), flexibility=C, preload=6e-4, effects=[hl.FingerForceBound(20.0)])
    assert loose.solve(throw=False).status is hl.Status.NO_EQUILIBRIUM


@pytest.mark.parametrize("faces", SECTIONS)
def test_a_bound_that_nothing_reaches_stands_in_nobodys_way(faces):
    for effect in (hl.TotalForceBound(1e12), hl.FingerForceBound(1e12), hl.FingerForceBound([1e12, np.inf])):
        r = searched(pinch(effects=[effect]), faces)
        assert r.outcome == "solution"
        np.testing.assert_allclose(r.candidate.forces[:, 2], 10.0, rtol=1e-9)


# ---------------------------------------------------------------- an independent search
def bounded_ring(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 5))
    contacts, data = ring(rng, n=n, mu=float(rng.choice([0.3, 0.6])), preload=float(rng.choice([1e-3, 0.01, 0.02])))
    normal = hl.Grasp(contacts, **data).solve(4, NO_SEARCH, throw=False).normal_force
    normal, a = normal if np.isfinite(normal).all() else np.full(n, 5.0), rng.uniform(0.4, 1.1)
    each = hl.FingerForceBound(max(normal.max(), 1e-3) * rng.uniform(0.4, 1.1, n))
    total = hl.TotalForceBound(a * normal.sum())
    asked = [[total], [each], [total, hl.FingerForceBound(0.9 * a * normal.max())]][seed % 3]
    return hl.Grasp(contacts, **data, effects=asked)


# Chosen from a first run so that some have answers, and some none although forces within all limits would do
@pytest.mark.parametrize("seed", [102, 106, 132, 144, 150])
@pytest.mark.parametrize("faces", [3, 4])
def test_it_agrees_with_the_search_over_active_sets_and_with_all_modes_one_by_one(seed, faces):
    g = bounded_ring(seed)
    oracle = active_sets(g, faces, work=1e10)
    assert oracle != "unknown"
    assert searched(g, faces).outcome == oracle
    every = g.equilibria(faces)
    assert (len(every) > 0) == (oracle == "solution")
    assert every.complete or "degenerate" in every.why


# ---------------------------------------------------------------- put together by hand
def yielding(rng, kind, forces):
    """An effect of this kind, and for each of its groups (name, rows A, s), so that `forces` (n, 3) obey it: limits
    reached that give way, limits reached that rest, and limits with room left.
    """
    n = len(forces)
    if kind is hl.TotalForceBound:
        rows = np.tile([0.0, 0.0, 1.0], n)[None]
        return hl.TotalForceBound(forces[:, 2].sum()), [("z̄", rows, rng.uniform(0, 2e-3, 1))]
    if kind is hl.FingerForceBound:
        state = rng.integers(0, 3, n)
        rows, s = np.kron(np.eye(n), [0.0, 0.0, 1.0]), np.where(state == 0, rng.uniform(0, 2e-3, n), 0.0)
        s[forces[:, 2] == 0] = 0.0
        bounds = np.where((state < 2) & (forces[:, 2] > 0), forces[:, 2], forces[:, 2] + rng.uniform(0.1, 9, n))
        return hl.FingerForceBound(bounds), [("z̄_i", rows, s)]
    J = rng.normal(size=(3 * n, 4)) * 0.05
    torque, state = forces.ravel() @ J, rng.integers(0, 3, 4)
    limits = abs(torque) + np.where(state < 2, 0.0, rng.uniform(0.01, 0.3, 4))
    s = np.where(state == 0, rng.uniform(0, 0.03, 4), 0.0)
    effect = saturation(n, J, limits)
    return effect, [("s⁺", J.T, np.where(torque > 0, s, 0.0)), ("s⁻", -J.T, np.where(torque < 0, s, 0.0))]


def put_together(seed, kind, faces):
    """(grasp without the effect, effect): contacts that are open, stick or slide, from which load and offset follow."""
    rng = np.random.default_rng(seed)
    n, mu, planar = 3, 0.6, faces == 2
    contacts, data = ring(rng, n=n, mu=mu)
    E, u = data["flexibility"], np.r_[rng.normal(size=3) * 1e-3, rng.normal(size=3) * 0.03]
    if planar:
        t = rng.uniform(-0.4, 0.4, n) + 2 * np.pi * np.arange(n) / n
        contacts = [
            hl.Contact((0.03 * np.cos(a), 0.03 * np.sin(a)), (-np.cos(a), -np.sin(a)), hl.Coulomb(mu)) for a in t
        ]
        E, u = E * np.outer(*[np.tile([1.0, 0.0, 1.0], n)] * 2), u * [1, 1, 0, 0, 0, 1]
    forces, v = np.zeros((n, 3)), np.zeros((n, 3))
    for i, state in enumerate(rng.permutation([0, 1, 2]) if seed % 2 else rng.integers(1, 3, n)):
        forces[i, 2] = rng.uniform(1, 9)
        a = rng.choice([0.0, np.pi]) if planar else rng.uniform(0, 2 * np.pi)
        if faces not in (2, "cone"):
            a = 2 * np.pi * rng.integers(faces) / faces  # towards the middle of a face
        most = mu * (1.0 if faces in (2, "cone") else np.cos(np.pi / faces))
        out = np.array([np.cos(a), np.sin(a), 0.0]) * [1, not planar, 0]
        if state == 0:
            forces[i, 2], v[i] = 0.0, [*rng.normal(size=2) * [1, not planar] * 1e-3, rng.uniform(0, 2e-3)]
        elif state == 1:
            forces[i] += rng.uniform(0, 0.9) * most * forces[i, 2] * out
        else:
            forces[i] += most * forces[i, 2] * out
            v[i] = -rng.uniform(0, 2e-3) * out
    plain = arrays(hl.Grasp(contacts, flexibility=E))
    to_centre = plain.units.centre
    twist = np.r_[u[:3] + np.cross(u[3:], to_centre), u[3:]]
    effect, groups = yielding(rng, kind, forces)
    opening = sum(A.T @ s for _, A, s in groups) * np.tile([1, not planar, 1], n)
    offset = v.ravel() - plain.grasp_matrix.T @ twist - E @ forces.ravel() - opening
    w = -plain.grasp_matrix @ forces.ravel()
    wrench = np.r_[w[:3], w[3:] + np.cross(to_centre, w[:3])]
    data = {"flexibility": E, "offset": offset.reshape(n, 3)}
    g = hl.Grasp(contacts, wrench[[0, 1, 5]] if planar else wrench, **data)
    answer = candidate(forces, twist, {name: s for name, _, s in groups})
    return g, effect, answer


@pytest.mark.parametrize("kind", [hl.TotalForceBound, hl.FingerForceBound, hl.TorqueSaturation])
@pytest.mark.parametrize("faces", [2, 4, "cone"])
@pytest.mark.parametrize("seed", range(3))
def test_where_there_is_an_equilibrium_it_never_says_none(seed, faces, kind):
    g, effect, answer = put_together(seed, kind, faces)
    asked = 4 if faces == 2 else faces
    assert residuals(g, asked, answer, effect).passes
    assert searched(g, asked, effect).outcome == "solution"
    if faces != "cone":  # nor does the list of all
        found = members_of_modes(g, asked, effect)
        assert any(residuals(g, asked, c, effect).passes for c in found)


# ---------------------------------------------------------------- all of them
def test_a_hook_whose_stuck_finger_is_bounded_still_has_three_equilibria():
    """Of `hook`'s, the open one and the sliding one keep the bound of 0.7 N. Instead of r_N = 1 the stuck finger has
    0.7, with r_T = -1.3 + 0.9 · 0.3, inside friction as 1.03 < 1.05, and gives way by 0.3 - 0.9 · 0.27, in 1e-3.
    """
    g = hook(1.5)
    bounded = hl.Grasp(
        g.contacts,
        (0, 10.0, 0),
        flexibility=g.flexibility,
        offset=g.offset,
        effects=[hl.FingerForceBound([0.7, np.inf, np.inf])],
    )
    found = bounded.equilibria()
    assert found.complete
    says(found.why, "32")
    by_force = sorted(found, key=lambda s: s.normal_force[0])
    assert [s.normal_force[0] for s in by_force] == pytest.approx([0.0, 17 / 35, 0.7], abs=1e-9)
    assert [s.extra["z̄_i"][0] for s in by_force] == pytest.approx([0.0, 0.0, 0.057e-3], abs=1e-12)


@pytest.mark.parametrize("room", [5.0, 1e12])
def test_limits_both_ways_hide_no_equilibrium_within_reach_or_out_of_it(room):
    free, J = hook(1.5), np.random.default_rng(0).normal(size=(9, 2)) * 0.05
    effect = saturation(3, J, np.full(2, room))
    assert choices_of_modes(free, 8, effect) == 2**4 * choices_of_modes(free, 8)
    every = [c for c in members_of_modes(free, 8, effect) if residuals(free, 8, c, effect).passes]
    assert sorted(c.forces[0, 2] for c in every) == pytest.approx([0.0, 17 / 35, 1.0], abs=1e-9)
    assert all((c.extra[name] == 0.0).all() for c in every for name in ("s⁺", "s⁻"))


# ---------------------------------------------------------------- words
@pytest.mark.parametrize("faces", [8, "cone"])
def test_only_limits_that_stand_in_the_way_are_named(faces):
    def diagnosed(*effects):
        s = pinch(effects=effects).solve(faces, throw=False)
        assert s.status is hl.Status.NO_EQUILIBRIUM
        return s.diagnosis

    each = diagnosed(hl.TotalForceBound(1e3), hl.FingerForceBound(0.9))
    says(each, hl.FingerForceBound.title)
    total = diagnosed(hl.TotalForceBound(1.0), hl.FingerForceBound(9.0))
    says(without_numbers(total), "total normal force")
    assert " 1 N" in total
    weak = pinch(squeeze=0.0, effects=[hl.TotalForceBound(1e3)]).solve(faces, throw=False)
    assert weak.required_preload is not None
    assert hl.TotalForceBound.title not in weak.diagnosis
    says(without_numbers(weak.diagnosis), "no finger squeezes")
    rigid = {"flexibility": 0.0, "load": (0, 0, -3.0)}
    unbounded = pinch(**rigid, effects=[hl.FingerForceBound(np.inf)]).solve(faces, throw=False)
    says(unbounded.diagnosis, "rigid fingers")
    assert pinch(**rigid, effects=[hl.FingerForceBound(7.0)]).solve(faces).held


def test_two_limits_that_are_too_low_only_together_are_named_together():
    """The finger below could carry all 4 N but is bounded to one; the pair would need 6 N in all for the rest."""
    contacts = [hl.Contact((x, 0), (-np.sign(x), 0), hl.Coulomb(0.5)) for x in (-1.0, 1.0)]
    up = hl.Contact((0, -1), (0, 1), hl.Frictionless())
    effects = [hl.TotalForceBound(4.0), hl.FingerForceBound([np.inf, np.inf, 1.0])]

    def g(*chosen):
        return hl.Grasp([*contacts, up], (0, -4.0, 0), flexibility=C, preload=1e-3, effects=chosen)

    assert all(overload(g(e), 8) is None for e in effects)
    s = g(*effects).solve(throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    says(s.diagnosis, hl.TotalForceBound.title, hl.FingerForceBound.title)
