"""Loading in steps beside closed forms: friction that slips, hysteresis, and an object that buckles."""

import numpy as np
import pytest

import handlcp as hl
from tests.loading.hands import sliders

C, P = 1e-3, 2e-3  # flexibility of each contact [m/N], squeeze of each normal [m]
N = P / C  # normal force of opposite contacts [N]


def pair(mu, axis):
    """Two opposite contacts on this axis."""
    way = np.eye(3)[axis]
    return [hl.Contact(0.03 * way, -way, hl.Coulomb(mu)), hl.Contact(-0.03 * way, way, hl.Coulomb(mu))]


def held(*contacts):
    return hl.Grasp([c for part in contacts for c in part], flexibility=C, preload=P)


@pytest.mark.parametrize("faces", ["cone", 8])
def test_two_fingers_lose_the_object_where_friction_is_used_up(faces):
    share = 1.0 if faces == "cone" else np.cos(np.pi / 8)  # the pyramid is inscribed, and z is no corner of it
    most = 2 * 0.4 * N
    h = held(pair(0.4, 0)).follow((0, 0, -2 * most, 0, 0, 0), faces=faces)
    assert not h.reached
    assert h.lost_stage == "load"
    assert most * share * 0.999 <= 2 * most * h.lost_at <= most * 1.001
    assert h.events[-1].kind == "lost"


def test_the_first_slip_is_found_at_its_load():
    weak, strong = 0.2, 0.8
    h = held(pair(weak, 0), pair(strong, 1)).follow((0, 0, -1.5 * N, 0, 0, 0))
    slips = [e for e in h.events if e.kind == "slips"]
    assert [e.who for e in slips] == ["finger 1", "finger 2"]
    assert 1.5 * slips[0].share == pytest.approx(4 * weak, abs=1.5 / 40 / 32)  # four springs share the load till then
    assert h.reached
    after = (1.5 * N - 2 * weak * N) / 2  # the other two carry the rest
    np.testing.assert_allclose(abs(h.steps.forces_world[-1][2:, 2]), after, rtol=1e-9)
    assert h.displacement[2] == pytest.approx(-C * after, rel=1e-9)


def test_a_cycle_takes_the_energy_of_elastic_perfectly_plastic_springs():
    weak, most = 0.2, 1.5 * N
    path = [(0, 0, s * most, 0, 0, 0) for s in (-1, 1, -1)]
    h = held(pair(weak, 0), pair(0.8, 1)).follow(path)
    assert h.reached
    begun, ended = (int(np.flatnonzero(h.steps.stage == k)[-1]) for k in (1, 3))
    limit, amplitude = weak * N, C * (most - 2 * weak * N) / 2
    loop = 2 * 4 * limit * (amplitude - C * limit)  # of the two that slip
    assert h.steps.dissipated[ended] - h.steps.dissipated[begun] == pytest.approx(loop, rel=1e-9)
    np.testing.assert_allclose(h.steps.forces[ended], h.steps.forces[begun], atol=1e-9 * N)
    np.testing.assert_allclose(h.steps.displacement[ended], h.steps.displacement[begun], atol=1e-9 * P)


def test_friction_never_gives_energy_back():
    rng = np.random.default_rng(3)
    path = np.column_stack([rng.uniform(-1.2 * N, 1.2 * N, (8, 3)), np.zeros((8, 3))])
    h = held(pair(0.2, 0), pair(0.9, 1), pair(0.9, 2)).follow(path)
    assert np.diff(h.steps.dissipated).min() >= -1e-15 * N * P
    assert h.steps.dissipated[-1] > 0.0


def pole(tmp_path, height, arm, k, squeeze, load_height):
    """A plate on a point at the origin, held at a height by two frictionless springs, loaded further up."""
    fingers = {"left": ((-arm, 0, height), (1, 0, 0)), "right": ((arm, 0, height), (-1, 0, 0))}
    hand = sliders(tmp_path, fingers, k)
    sides = {"left_tip": 1, "right_tip": -1}
    contacts = {tip: hl.Contact((-way * arm, 0, height), (way, 0, 0), hl.Frictionless()) for tip, way in sides.items()}
    foot = hl.Environment([hl.Contact((0, 0, 0), (0, 0, 1), hl.Coulomb(1.0))])
    return hand.at(hand.neutral).grasp(
        contacts, reference=(0, 0, load_height), environment=foot, plane=(0.0, 1.0, 0.0),
        joint_offset=np.full(2, squeeze),
    )  # fmt: skip


def test_a_pole_between_two_springs_is_lost_at_its_buckling_load(tmp_path):
    height, arm, k, squeeze, up = 0.1, 0.02, 500.0, 2e-3, 0.15
    g = pole(tmp_path, height, arm, k, squeeze, up)
    # Turned by θ, the springs push back with 2 k H² θ, their turned forces with 2 a k s θ; the load tips it with W h θ
    most = (2 * k * height**2 + 2 * arm * k * squeeze) / up
    h = g.follow((0, 0, -2 * most, 0, 0, 0))
    assert not h.reached
    assert 2 * most * h.lost_at == pytest.approx(most, rel=0.002)
    assert not h.held
    # Of two ways that are alike, always this one
    assert "in balance, but a small push along +x drives it away" in h.why
    limit = g.load_limit((0, 0, -1, 0, 0, 0))
    assert limit.factor == pytest.approx(most, rel=1e-3)
    assert "leaves, as a small push along +x makes it where it is in balance" in limit.why
    assert 2 * most * h.jump.share == pytest.approx(most, rel=1e-3)
    assert g.replace(wrench=(0, 0, -1.9 * most, 0, 0, 0)).solve().held  # one posture knows nothing of it
    assert g.follow((0, 0, -0.95 * most, 0, 0, 0)).reached


def test_a_loading_whose_forces_are_open_tells_the_same_forces_everywhere_and_does_not_call_them_the_smallest():
    """A bar on three rigid supports: whatever these share of the load, statics is content."""
    supports = [hl.Contact((x, 0, 0), (0, 0, 1), 0.0) for x in (-0.1, 0.0, 0.1)]
    bar = hl.Grasp(supports, flexibility=0.0, wrench=(0, 0, -10.0, 0, 0, 0))
    loading, verdict = bar.follow(), bar.check()
    np.testing.assert_allclose(loading.solution.forces, loading.steps.forces[-1], atol=1e-9)
    assert f"{loading.solution.normal_force.max():.3g} N" in " ".join(str(loading).split())
    for said in (verdict, loading.solution.verdict):
        (open_,) = said.about("forces_open")
        assert open_.sentence == "other forces satisfy the same conditions; those that the loading led to are given"
    assert "those of the loading are given" in loading.solution.diagnosis
    assert not verdict.about("followed_forces"), "forces that are open are not off"
    np.testing.assert_allclose(bar.solve().normal_force, 10.0 / 3, rtol=1e-9)
    assert bar.solve().verdict.about("forces_open")[0].sentence.endswith("the smallest are given")
