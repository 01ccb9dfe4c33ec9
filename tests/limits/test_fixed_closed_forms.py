"""Load limits in one posture that can be worked out by hand."""

import numpy as np
import pytest

import handlcp as hl

EXACT = 1e-9
SOFT, HALF = 1e-3, 0.05  # [m/N], [m]


def pinch(law, squeeze=5.0, **more):
    """Two fingers on the x axis that press with `squeeze` [N]."""
    contacts = [hl.Contact((-HALF, 0, 0), (1, 0, 0), law), hl.Contact((HALF, 0, 0), (-1, 0, 0), law)]
    return hl.Grasp(contacts, flexibility=SOFT, preload=squeeze * SOFT, **more)


@pytest.mark.parametrize(("faces", "share"), [("cone", 1.0), (8, np.cos(np.pi / 8))])
def test_a_pinch_slips_at_twice_the_friction(faces, share):
    limit = pinch(hl.Coulomb(0.5)).load_limit((0, 0, 1, 0, 0, 0), faces=faces)
    along = 1.0 if faces == "cone" else share  # the frame's x or y lies along z: there a face meets the load
    assert limit.factor == pytest.approx(2 * 0.5 * 5.0 * along, rel=EXACT)
    assert {(b.kind, b.who) for b in limit.binds} == {("slips", "finger 1"), ("slips", "finger 2")}
    assert limit.at_limit.held


def test_the_slip_load_does_not_depend_on_its_direction_on_the_cone():
    for angle in np.linspace(0.1, 3.0, 7):
        w = (0, np.cos(angle), np.sin(angle), 0, 0, 0)
        assert pinch(hl.Coulomb(0.4)).load_limit(w).factor == pytest.approx(2 * 0.4 * 5.0, rel=EXACT)


def test_a_pinch_of_soft_fingers_spins_at_twice_their_moment():
    limit = pinch(hl.SoftFinger(0.5, 0.01)).load_limit((0, 0, 0, 1, 0, 0))
    assert limit.factor == pytest.approx(2 * 0.01 * 5.0, rel=EXACT)
    assert {b.kind for b in limit.binds} == {"slips"}


def test_an_anisotropic_pinch_slips_at_the_coefficient_of_its_direction():
    law = hl.AnisotropicCoulomb(0.6, 0.3, along=(0, 0, 1))
    assert pinch(law).load_limit((0, 0, 1, 0, 0, 0)).factor == pytest.approx(2 * 0.6 * 5.0, rel=EXACT)
    assert pinch(law).load_limit((0, 1, 0, 0, 0, 0)).factor == pytest.approx(2 * 0.3 * 5.0, rel=EXACT)


def test_a_load_along_the_pinch_opens_a_finger_at_twice_the_squeeze():
    limit = pinch(hl.Coulomb(0.5)).load_limit((1, 0, 0, 0, 0, 0))
    assert limit.factor == np.inf or limit.events[0].kind in ("slips", "opens")
    opened = [e for e in limit.events if e.kind == "opens"]
    assert opened[0].who == "finger 1"
    assert opened[0].factor == pytest.approx(2 * 5.0, rel=EXACT)


def test_hard_fingers_do_not_resist_a_turn_about_their_line():
    limit = pinch(hl.Coulomb(0.5)).load_limit((0, 0, 0, 1, 0, 0))
    assert limit.factor == 0.0
    assert limit.binds[0].kind == "equilibrium"


@pytest.mark.parametrize("n", [3, 5])
def test_a_planar_ring_without_friction_holds_until_the_finger_behind_it_opens(n):
    angles = 2 * np.pi * np.arange(n) / n
    contacts = [hl.Contact((-HALF * np.cos(a), -HALF * np.sin(a)), (np.cos(a), np.sin(a)), hl.Frictionless())
                for a in angles]  # fmt: skip
    grasp = hl.Grasp(contacts, flexibility=SOFT, preload=2.0 * SOFT)
    limit = grasp.load_limit((1, 0, 0, 0, 0, 0))
    # each finger gives way as a spring: r_i = 2 - (2/n) F cos(a_i), so the one at 0 opens first
    first = next(e for e in limit.events if e.kind == "opens")
    assert first.factor == pytest.approx(2.0 * n / 2.0, rel=EXACT)


def test_pressing_on_a_table_has_no_limit():
    feet = [hl.Contact((x, y, 0), (0, 0, 1), hl.Coulomb(0.5)) for x in (-HALF, HALF) for y in (-HALF, HALF)]
    limit = hl.Grasp(feet, flexibility=SOFT).load_limit((0, 0, -1, 0, 0, 0))
    assert limit.factor == np.inf
    assert limit.binds == ()
    assert "nothing gives out" in limit.why


def test_pulling_off_a_table_has_none_either():
    feet = [hl.Contact((x, y, 0), (0, 0, 1), hl.Coulomb(0.5)) for x in (-HALF, HALF) for y in (-HALF, HALF)]
    assert hl.Grasp(feet, flexibility=SOFT).load_limit((0, 0, 1, 0, 0, 0)).factor == 0.0


def test_a_motion_that_is_allowed_ends_the_path_where_springs_say():
    limit = pinch(hl.Coulomb(0.5)).load_limit((0, 0, 1, 0, 0, 0), motion=1e-3)
    assert limit.factor == pytest.approx(1e-3 * 2 / SOFT, rel=EXACT)  # two springs side by side
    assert limit.binds[0].kind == "motion"


def test_a_total_bound_on_the_normal_forces_gives_way():
    bounded = pinch(hl.Coulomb(0.5), effects=[hl.TotalForceBound(6.0)])
    assert bounded.load_limit((0, 0, 1, 0, 0, 0)).factor == pytest.approx(0.5 * 6.0, rel=EXACT)


def test_the_bound_without_compliance_of_a_bounded_pinch_is_its_limit():
    limit = pinch(hl.Coulomb(0.5), effects=[hl.TotalForceBound(6.0)]).load_limit((0, 0, 1, 0, 0, 0))
    assert limit.bound == pytest.approx(limit.factor, rel=1e-6)
    assert limit.some_equilibrium == limit.factor


def test_a_grasp_without_a_load_is_asked_for_one():
    with pytest.raises(hl.InputError, match="wrench"):
        pinch(hl.Coulomb(0.5)).load_limit()


def test_the_factor_on_the_own_load_is_its_safety():
    grasp = pinch(hl.Coulomb(0.5)).replace(wrench=(0, 0, 2.0, 0, 0, 0))
    assert grasp.load_limit().factor == pytest.approx(2.5, rel=EXACT)
