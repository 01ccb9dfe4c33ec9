"""Per-finger force bounds against closed forms; nothing to pay without one; certificates; what cannot be held."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError
from tests.grasp.scenes import pinch, ring
from tests.support import patches
from tests.support.grasp import arrays, at_centre, judged
from tests.support.search import is_overload, overload
from tests.support.texts import says

C, SQUEEZE = 1e-4, 1e-3  # m/N and m of the pinch: 10 N a finger where nothing is bounded
SECTIONS = [4, 8, "cone"]
EXACT = {"rtol": 1e-9, "atol": 1e-15}


def work_balances(g, s, bounds):
    """Where no contact slides: the load's work on the object = Σ r·(E r + d) + Σ r̄ z̄ (virtual work on the answer)."""
    r = s.forces.ravel()
    put_in = arrays(g).wrench @ at_centre(g, s)
    taken = r @ arrays(g).flexibility @ r + r @ g.offset.ravel() + bounds @ s.extra["z̄_i"]
    size = abs(r @ g.offset.ravel())
    assert abs(put_in - taken) < 1e-9 * size


# ---------------------------------------------------------------- closed forms
@pytest.mark.parametrize("faces", SECTIONS)
def test_both_fingers_give_way_at_their_bound(faces):
    """Both push with r̄, and each gives way by δ - C r̄. Where the object stops between them is not determined."""
    g = pinch(effects=[hl.FingerForceBound(6.0)])
    s = g.solve(faces)
    np.testing.assert_allclose(s.normal_force, [6, 6], **EXACT)
    np.testing.assert_allclose(s.extra["z̄_i"], [SQUEEZE - 6 * C] * 2, **EXACT)
    np.testing.assert_allclose(s.forces[:, 0], 0.5, **EXACT)  # tangents point up: half the load each
    np.testing.assert_allclose(s.object_displacement, [0, 0, -0.5 * C, 0, 0, 0], atol=1e-15)
    assert s.uniqueness.loose_motions == 2  # along the fingers' line, and about it
    assert s.uniqueness.forces_determined
    assert s.contact_state == ("sticking", "sticking")
    work_balances(g, s, np.array([6.0, 6.0]))


@pytest.mark.parametrize("faces", SECTIONS)
def test_one_finger_gives_way_and_the_other_pushes_the_object_after_it(faces):
    """Both push with r̄; v_2 = -u + C r̄ - δ = 0 gives u, and v_1 = u + C r̄ - δ + z̄ = 0 gives z̄ = 2 (δ - C r̄)."""
    g = pinch(effects=[hl.FingerForceBound([6.0, np.inf])])
    s = g.solve(faces)
    np.testing.assert_allclose(s.normal_force, [6, 6], **EXACT)
    np.testing.assert_allclose(s.extra["z̄_i"], [2 * (SQUEEZE - 6 * C)], **EXACT)
    np.testing.assert_allclose(s.object_displacement[:3], [6 * C - SQUEEZE, 0, -0.5 * C], atol=1e-13)
    assert s.uniqueness.loose_motions == 1
    work_balances(g, s, np.array([6.0]))


@pytest.mark.parametrize("faces", SECTIONS)
def test_the_weaker_bound_decides(faces):
    s = pinch(effects=[hl.FingerForceBound([7.0, 4.0])]).solve(faces)
    np.testing.assert_allclose(s.normal_force, [4, 4], **EXACT)
    np.testing.assert_allclose(s.extra["z̄_i"], [0, 2 * (SQUEEZE - 4 * C)], **EXACT)


def test_in_a_plane_the_other_fingers_take_over():
    """Three fingers 120° apart, no friction, flexibility C, squeezed by δ, and a push P towards finger 1: finger i has
    r_i = δ/C - (2/3) P cos(its angle to finger 1)… until its bound; then r_1 = r̄ and r_2 = r_3 = r̄ - P by balance.
    """
    t = np.deg2rad([90, 210, 330])
    contacts = [hl.Contact((np.cos(a), np.sin(a)), (-np.cos(a), -np.sin(a)), hl.Frictionless()) for a in t]
    data = {"wrench": (0, 3.0, 0), "flexibility": C, "preload": SQUEEZE}
    free = hl.Grasp(contacts, **data).solve()
    np.testing.assert_allclose(free.normal_force, [12, 9, 9], rtol=1e-9)
    s = hl.Grasp(contacts, **data, effects=[hl.FingerForceBound(11.0)]).solve()
    np.testing.assert_allclose(s.normal_force, [11, 8, 8], rtol=1e-9)
    # Fingers 2 and 3: u_y sin 30° … v = u_y / 2 + C 8 - δ = 0; finger 1: v = -u_y + C 11 - δ + z̄ = 0
    u = 2 * (SQUEEZE - 8 * C)
    np.testing.assert_allclose(s.object_displacement[1], u, rtol=1e-9)
    np.testing.assert_allclose(s.extra["z̄_i"], [u - 11 * C + SQUEEZE, 0, 0], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("faces", SECTIONS)
@pytest.mark.parametrize("seed", range(3))
def test_in_a_ring_every_bound_is_kept_and_the_answer_solves_the_free_grasp_with_the_opened_gaps(faces, seed):
    """What gives way is an offset of its finger: with it in the data, the grasp without bounds answers the same."""
    contacts, data = ring(np.random.default_rng(seed), n=5)
    free = hl.Grasp(contacts, **data).solve(faces)
    bound = 0.8 * free.normal_force.max()
    g = hl.Grasp(contacts, **data, effects=[hl.FingerForceBound(bound)])
    s = g.solve(faces)
    assert s.normal_force.max() == pytest.approx(bound, rel=1e-9)
    z = s.extra["z̄_i"]
    assert (z >= 0).all()
    assert z.max() > 1e-5
    assert (z[s.normal_force < 0.999 * bound] < 1e-12).all()
    offset = np.zeros((5, 3))
    offset[:, 2] = z
    again = hl.Grasp(contacts, **data, offset=offset).solve(faces, start=s)
    np.testing.assert_allclose(again.forces, s.forces, atol=1e-8 * bound)


@pytest.mark.parametrize(
    ("effects", "more", "force"),
    [
        ([hl.FingerForceBound(6.0), hl.TotalForceBound(20.0)], {}, 6.0),
        ([hl.FingerForceBound(6.0), hl.TotalForceBound(8.0)], {}, 4.0),
        ([hl.FingerForceBound(6.0)], {"flexibility": 0.0}, 6.0),
    ],
)
def test_the_tighter_of_two_bounds_holds_and_rigid_fingers_are_bounded_too(effects, more, force):
    """Stiff fingers squeezed by anything push with their bounds: what a rigid grasp alone cannot say."""
    np.testing.assert_allclose(pinch(effects=effects, **more).solve().normal_force, force, rtol=1e-9)


# ---------------------------------------------------------------- certificates
@pytest.mark.parametrize("faces", [8, "cone"])
def test_the_certifier_rejects_what_it_should(faces):
    contacts, data = ring(np.random.default_rng(0))
    free = hl.Grasp(contacts, **data).solve(faces)
    bound = 0.8 * free.normal_force.max()
    g = hl.Grasp(contacts, **data, effects=[hl.FingerForceBound(bound)])
    s = g.solve(faces)
    z, twist = s.extra["z̄_i"], at_centre(g, s)
    assert judged(g, faces, s.forces, twist, {"z̄_i": z}).passes
    for i in range(len(z)):
        for change in (1e-4, -1e-4, np.nan, np.inf):
            bad = z.copy()
            bad[i] += change * max(z)
            assert not judged(g, faces, s.forces, twist, {"z̄_i": bad}).passes
    # the free grasp's answer keeps every law but the bound
    over = judged(g, faces, free.forces, at_centre(g, free), {"z̄_i": 0 * z})
    assert max(over.balance, over.normal, over.cone, over.slip) < 1e-8
    assert over.effects > 1e-2


@pytest.mark.parametrize("faces", SECTIONS)
def test_bounds_too_low_for_the_load_are_proven_so(faces):
    """0.5 on each side carries 2 · 0.5 · 0.9 < 1 N; pyramids less. The proof is recomputed by its signs."""
    g = pinch(effects=[hl.FingerForceBound(0.9)])
    s = g.solve(faces, throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    assert s.required_preload is None
    says(s.diagnosis, hl.FingerForceBound.title)
    proof = overload(g, faces)
    assert is_overload(g, faces, proof)
    assert not is_overload(g, faces, -proof)
    assert not is_overload(g, faces, np.full(8, np.nan))
    enough = pinch(effects=[hl.FingerForceBound(1.0 / np.cos(np.pi / 4) + 1e-3)])
    assert overload(enough, faces) is None
    assert not is_overload(enough, faces, proof)
    assert enough.solve(faces).held


def test_no_squeeze_beats_a_bound_and_more_friction_does(monkeypatch):
    patches.ticks_of_equilibria(monkeypatch)
    g = pinch(effects=[hl.FingerForceBound(0.9)])
    r = g.required_preload()
    assert (r.value, r.proven) == (None, True)
    mu = g.required_friction("cone", tolerance=1e-6)
    np.testing.assert_allclose(mu.value, 1.0 / 1.8, rtol=2e-3)  # proven on a polygon around the cone
    found = g.equilibria()
    assert (len(found), found.complete) == (0, True)


# ---------------------------------------------------------------- input and company
def test_as_many_bounds_as_contacts():
    with pytest.raises(InputError) as e:
        pinch(effects=[hl.FingerForceBound([1.0, 2.0, 3.0])])
    assert e.value.argument == "effects[0].limits"
    assert "2" in e.value.expected
    says(str(e.value), "effects[0].limits: ", "3")
    with pytest.raises(InputError) as e:
        pinch(effects=[hl.FingerForceBound(1.0), hl.FingerForceBound(2.0)])
    assert e.value.argument == "effects[1]"
    says(str(e.value), "FingerForceBound")
