"""Compliances asked for by name: closed forms, one E for everything downstream, and nothing where they are absent."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch, ring
from tests.support import patches
from tests.support.effects import softened
from tests.support.grasp import arrays, changed

RNG = np.random.default_rng(11)
ROOT = RNG.normal(size=(6, 6)) * np.array([1e-2] * 3 + [1e-1] * 3)[:, None]
WRIST = hl.SoftWrist(ROOT @ ROOT.T, (0.01, -0.02, -0.1))
BLOCKS = np.array([a @ a.T for a in RNG.normal(size=(4, 3, 3)) * 1e-2])


def hand_built(g, wrist=WRIST, blocks=BLOCKS):
    """The sum by the textbook: a column for each unit force."""
    s, n = arrays(g), len(g.contacts)
    E = g.flexibility.copy()
    for j in range(3 * n):
        force = s.frames[j // 3][:, j % 3]
        arm = s.positions[j // 3] - wrist.at
        palm = wrist.flexibility @ -np.r_[force, np.cross(arm, force)]  # the palm feels the reaction
        for i in range(n):
            tip = palm[:3] + np.cross(palm[3:], s.positions[i] - wrist.at)
            E[3 * i : 3 * i + 3, j] -= s.frames[i].T @ tip  # object minus fingertip
    for i, block in enumerate(blocks):
        E[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] += block
    return E


BOTH = (WRIST, hl.ContactCompliance(BLOCKS))


def soft_ring(seed=3, effects=BOTH):
    contacts, data = ring(np.random.default_rng(seed))
    return hl.Grasp(contacts, **data, effects=effects)


def test_two_fingers_in_series_with_a_contact_compliance_share_the_squeeze():
    """Each side is finger and surface in series: N = squeeze / (a + b), and the load moves the object down by
    w / 2 · (a_T + b_T).
    """
    a, b, squeeze, w = 1e-4, np.array([3e-4, 5e-4, 2e-4]), 1e-3, 0.5
    s = pinch(load=(0, 0, -w), squeeze=squeeze, flexibility=a, effects=[hl.ContactCompliance(b)]).solve()
    np.testing.assert_allclose(s.forces[:, 2], squeeze / (a + b[2]), rtol=1e-9)
    np.testing.assert_allclose(s.forces[:, 0], w / 2, rtol=1e-9)
    np.testing.assert_allclose(s.object_displacement[2], -w / 2 * (a + b[0]), rtol=1e-9)


def test_a_soft_wrist_sinks_under_the_whole_load_and_the_squeeze_does_not_see_it():
    """The pinch's squeeze is an inner force: no wrench on the palm. The load w moves palm and object by C w on top of
    the fingers' own retreat, and turns them by the moment arm.
    """
    a, squeeze, w, arm = 1e-4, 1e-3, 0.5, 0.03
    down, tilt = 4e-3, 0.7
    wrist = hl.SoftWrist((0, 0, down, 0, tilt, 0), at=(-arm, 0, 0))
    s = pinch(load=(0, 0, -w), squeeze=squeeze, flexibility=a, effects=[wrist]).solve()
    np.testing.assert_allclose(s.forces[:, 2], squeeze / a, rtol=1e-9)
    turned = tilt * w * arm  # about +y: what lies at +x goes down
    np.testing.assert_allclose(s.object_displacement[2], -w * (a / 2 + down) - turned * arm, rtol=1e-9)
    np.testing.assert_allclose(s.object_displacement[4], turned, rtol=1e-9)


def test_a_force_on_one_finger_moves_all_tips():
    """A palm that only translates, by c a newton: E_ij = c Rᵢᵀ Rⱼ; one that turns about `at`: (p - at) × crossed."""
    contacts, data = ring(np.random.default_rng(5), n=3)
    c = 2e-3
    g = hl.Grasp(contacts, data["wrench"], effects=[hl.SoftWrist((c, c, c, 0, 0, 0), (9.0, 9.0, 9.0))])
    R = g.frames
    expected = np.block([[c * R[i].T @ R[j] for j in range(3)] for i in range(3)])
    np.testing.assert_allclose(arrays(g).flexibility, expected, atol=1e-9 * c)
    at, spin = np.array([0.1, 0.2, 0.3]), 0.5
    g = hl.Grasp(contacts, data["wrench"], effects=[hl.SoftWrist((0, 0, 0, spin, spin, spin), at)])
    W = np.hstack([np.cross(p - at, r.T).T for p, r in zip(arrays(g).positions, R, strict=True)])
    np.testing.assert_allclose(arrays(g).flexibility, spin * W.T @ W, rtol=1e-9, atol=1e-12)


def test_both_equal_an_e_built_by_hand_and_give_the_same_answer(monkeypatch):
    patches.ticks_of_equilibria(monkeypatch)
    g = soft_ring()
    E = hand_built(g)
    np.testing.assert_allclose(arrays(g).flexibility, E, rtol=1e-9, atol=1e-9 * abs(E).max())
    np.testing.assert_array_equal(arrays(g).flexibility, arrays(g).flexibility.T)
    assert np.linalg.eigvalsh(arrays(g).flexibility - g.flexibility).min() > -1e-15
    plain = changed(g, effects=(), flexibility=arrays(g).flexibility)
    for faces in (8, "cone"):
        a, b = g.solve(faces), plain.solve(faces)
        np.testing.assert_array_equal(a.forces, b.forces)
        np.testing.assert_array_equal(a.object_displacement, b.object_displacement)
        assert a.trace == b.trace, "one compiled call, as without effects"
        assert a.uniqueness == b.uniqueness
    assert g.required_preload().value == plain.required_preload().value
    assert len(g.equilibria()) == len(plain.equilibria())


def test_the_balance_of_energy_counts_the_compliance():
    """The load's work from where nothing is squeezed is what the springs hold: w·u = rᵀ E r while all stick."""
    contacts, data = ring(np.random.default_rng(3), mu=50.0)
    g = hl.Grasp(contacts, **data, effects=[WRIST, hl.ContactCompliance(1e-3)])
    s, free = g.solve("cone"), g.replace(wrench=np.zeros(6)).solve("cone")
    assert set(s.contact_state) == set(free.contact_state) == {"sticking"}
    r = (s.forces - free.forces).ravel()
    work = np.r_[data["wrench"]] @ (s.object_displacement - free.object_displacement)
    assert work > 0
    np.testing.assert_allclose(r @ arrays(g).flexibility @ r, work, rtol=1e-9)


def test_a_planar_scene_feels_only_what_lies_in_its_plane():
    """A wrist off the plane that tilts moves the tips in it; y parts and what they couple with drop out."""
    contacts = [hl.Contact((-0.01, 0), (1, 0)), hl.Contact((0.01, 0), (-1, 0)), hl.Contact((0, -0.01), (0, 1))]
    blocks = BLOCKS[:3]
    g = hl.Grasp(
        contacts, (0.2, -1.0, 0.001), flexibility=1e-4, preload=2e-4, effects=[WRIST, hl.ContactCompliance(blocks)]
    )
    cut = hand_built(g, blocks=blocks) - g.flexibility
    cut[1::3] = 0
    cut[:, 1::3] = 0
    assert abs(cut).max() > 0
    np.testing.assert_allclose(arrays(g).flexibility - g.flexibility, cut, atol=1e-9 * abs(cut).max())
    s = g.solve()
    np.testing.assert_array_equal(s.forces, changed(g, effects=(), flexibility=arrays(g).flexibility).solve().forces)
    height, tilt, w = 0.05, 0.3, 1.0  # a wrist below the plane, turning about x: a pull along y tilts it
    lone = pinch_in_plane(hl.SoftWrist((0, 0, 0, tilt, 0, 0), at=(0, 0, -height)), w)
    still = pinch_in_plane(hl.SoftWrist((0, 0, 0, 0, 0, 0)), w)
    sink = lone.object_displacement[1] - still.object_displacement[1]
    np.testing.assert_allclose(sink, -tilt * height**2 * w, rtol=1e-9)


def pinch_in_plane(wrist, w):
    contacts = [hl.Contact((-0.01, 0), (1, 0)), hl.Contact((0.01, 0), (-1, 0))]
    return hl.Grasp(contacts, (0, -w, 0), flexibility=1e-4, preload=1e-3, effects=[wrist]).solve()


def test_many_at_once_and_a_stream_see_them():
    grasps = [soft_ring(k) for k in range(3, 8)]
    for g, s in zip(grasps, hl.solve_many(grasps), strict=True):
        np.testing.assert_array_equal(s.forces, g.solve(throw=False).forces)
    g = soft_ring()
    stream = hl.GraspStream(g)
    np.testing.assert_allclose(stream.update().forces, g.solve().forces, rtol=1e-9)
    moved = arrays(g).positions + 1e-3
    update = stream.update(positions=moved)
    E = softened(g, g.flexibility, moved)
    assert abs(E - arrays(g).flexibility).max() > 1e-6, "the wrist's arm changed"
    now = stream.grasp
    np.testing.assert_array_equal(arrays(now).flexibility, E)
    np.testing.assert_array_equal(now.flexibility, g.flexibility)
    np.testing.assert_allclose(update.forces, now.solve(start=g.solve()).forces, rtol=1e-9, atol=1e-12)


def test_a_hand_on_a_soft_wrist_in_a_grasp_and_along_a_stream():
    hand = hl.example_hand("five_finger", joint_stiffness=5.0)
    ball = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
    q = hand.close_on(ball, squeeze=3e-3)
    effects = [hl.SoftWrist((1e-4, 1e-4, 1e-4, 0.2, 0.2, 0.2)), hl.ContactCompliance((1e-4, 1e-4, 5e-4))]
    plain, g = hand.at(q).grasp(ball), hand.at(q).grasp(ball, effects=effects)
    np.testing.assert_array_equal(g.flexibility, arrays(plain).flexibility)
    expected = softened(g, arrays(plain).flexibility)
    np.testing.assert_array_equal(arrays(g).flexibility, expected)
    stream = hl.GraspStream(g)
    stream.update(q + 0.01)
    there = hand.at(q + 0.01)
    contacts = [hl.Contact(c.position, c.normal, c.friction) for c in g.contacts]
    for name in ("scene", "own"):
        one, two = stream.grasp, there.grasp(contacts, effects=effects)
        a, b = (arrays(one), arrays(two)) if name == "scene" else (one, two)
        np.testing.assert_allclose(a.flexibility, b.flexibility, atol=1e-12 * abs(b.flexibility).max())


@pytest.mark.parametrize(
    ("make", "argument"),
    [
        (lambda: hl.ContactCompliance(-1e-4), "ContactCompliance.flexibility"),
        (lambda: hl.ContactCompliance((1, 2)), "ContactCompliance.flexibility"),
        (lambda: hl.ContactCompliance((1, -2, 0)), "ContactCompliance.flexibility"),
        (lambda: hl.ContactCompliance([np.eye(3), -np.eye(3)]), "ContactCompliance.flexibility[1]"),
        (lambda: hl.ContactCompliance("soft"), "ContactCompliance.flexibility"),
        (lambda: pinch(effects=[hl.ContactCompliance(BLOCKS)]), "effects[0].flexibility"),
        (lambda: pinch(effects=[WRIST, WRIST]), "effects[1]"),
        (lambda: hl.SoftWrist(1e-4), "SoftWrist.flexibility"),
        (lambda: hl.SoftWrist(np.eye(3)), "SoftWrist.flexibility"),
        (lambda: hl.SoftWrist(-np.eye(6)), "SoftWrist.flexibility"),
        (lambda: hl.SoftWrist(np.triu(np.ones((6, 6)))), "SoftWrist.flexibility"),
        (lambda: hl.SoftWrist(np.eye(6) + 2 * np.eye(6)[::-1]), "SoftWrist.flexibility"),
        (lambda: hl.SoftWrist(np.eye(6), (0, 0)), "SoftWrist.at"),
    ],
)
def test_bad_compliances_name_the_argument(make, argument):
    with pytest.raises(hl.InputError) as caught:
        make()
    assert caught.value.argument == argument
