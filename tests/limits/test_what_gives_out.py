"""What gives out at a load limit, by name, on hands, tables, and grasps that hold nothing."""

import numpy as np
import pytest

import handlcp as hl
from tests.limits.pinches import bare_pinch as pinch
from tests.support.limits import limits_of_grasp

DIRECTIONS = np.hstack([np.vstack([np.eye(3), -np.eye(3)]), np.zeros((6, 3))])


def held_cube(friction=0.8, **more):
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, **more)
    cube = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    return hand.at(hand.close_on(cube)), cube, hl.Coulomb(friction)


# ---------------------------------------------------------------- names
def test_a_limit_of_a_hand_names_the_fingers_that_slip():
    state, cube, law = held_cube()
    grasp = state.grasp(cube, law, squeeze=0.005)
    limits = limits_of_grasp(grasp, DIRECTIONS, 8)
    assert set(limits.kinds) <= {"slips", "slides", "opens", "torque", "range"}
    for who in limits.who:
        assert who
        assert set(who) <= {*grasp.names, *grasp.spec.mechanism.names}
    for load, binds in zip(DIRECTIONS, limits.binds, strict=True):
        assert grasp.load_limit(load, geometry="fixed", faces=8).binds == binds


def test_the_fingers_that_are_named_are_at_their_friction_and_the_others_are_not():
    state, cube, law = held_cube()
    limit = state.grasp(cube, law, squeeze=0.005).load_limit((0, 1, 0, 0, 0, 0), geometry="fixed", max_slip=np.inf)
    forces = limit.path.forces[-1]
    used = np.linalg.norm(forces[:, :2], axis=1) / (0.8 * forces[:, 2])
    named = [name in {b.who for b in limit.binds} for name in limit.at_limit.names]
    assert {b.kind for b in limit.binds} == {"slips"}
    assert used[named] == pytest.approx(1.0, abs=1e-6)
    assert (used[np.logical_not(named)] < 1.0 - 1e-6).all()
    assert "and nothing else balances more load" in limit.why


def test_a_turn_that_no_contact_resists_is_balance_itself():
    limit = pinch().load_limit((0, 0, 0, 1, 0, 0))
    assert [(b.kind, b.who) for b in limit.binds] == [("equilibrium", "the object")]
    assert limit.why == "it holds nothing of this load: no forces balance it"


def test_joints_that_yield_are_events_by_their_names():
    state, cube, law = held_cube(50.0, torque_limits=0.13)
    grasp = state.grasp(cube, law, joint_offset=[0.02, 0.01] * 3, effects=[hl.TorqueSaturation()])
    limit = grasp.load_limit((1, 0, 0, 0, 0, 0), geometry="fixed")
    strict = grasp.replace(effects=()).load_limit((1, 0, 0, 0, 0, 0), geometry="fixed")
    first = limit.events[0]
    assert (first.kind, first.who) == ("yields", strict.binds[0].who)
    assert first.factor == pytest.approx(strict.factor, rel=1e-9)
    assert limit.factor > strict.factor
    assert abs(limit.path.torques).max() <= 0.13 * (1.0 + 1e-6)


# ---------------------------------------------------------------- a pinch pushed along its own line
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_push_along_a_pinch_has_no_limit_whatever_the_faces(seed, way):
    # N1 = N - X/2 falls to zero at X = 2 N; from there the other contact bears X, along its normal
    along = np.random.default_rng(seed).normal(size=3)
    along /= np.linalg.norm(along)
    grasp = pinch(along=along)
    for faces in ("cone", 8):
        limit = grasp.load_limit((*(way * along), 0, 0, 0), faces=faces)
        assert limit.factor == np.inf
        assert [e.kind for e in limit.events] == ["opens"]
        assert limit.events[0].factor == pytest.approx(20.0, rel=1e-9)
    assert grasp.follow((*(way * 30.0 * along), 0, 0, 0)).reached


# ---------------------------------------------------------------- what is asked
def test_a_planar_grasp_takes_the_loads_that_it_is_made_with():
    turns = 2 * np.pi * np.arange(3) / 3
    at = [0.03 * np.array([np.cos(t), np.sin(t)]) for t in turns]
    ring = hl.Grasp([hl.Contact(p, -p / 0.03, hl.Coulomb(0.5)) for p in at], flexibility=1e-4, preload=1e-3)
    flat, whole = ring.load_limit((1.0, 2.0, 0.01)), ring.load_limit((1.0, 2.0, 0, 0, 0, 0.01))
    assert flat.factor == whole.factor
    np.testing.assert_array_equal(flat.wrench, whole.wrench)
    with pytest.raises(hl.InputError, match="plane"):
        ring.load_limit((0, 0, 1.0, 0, 0, 0))


# ---------------------------------------------------------------- nothing squeezes
@pytest.mark.parametrize("gaps", [(1e-3, 0.0), (1e-3, 1e-3)])
def test_fingers_that_are_apart_and_do_not_squeeze_hold_nothing(gaps):
    limit = pinch(squeeze=0.0, offset=[[0, 0, gap] for gap in gaps]).load_limit((0, 0, 1, 0, 0, 0))
    assert limit.factor == 0.0
    assert "nothing of this load" in limit.why


def test_a_squeeze_closes_a_gap_before_the_load_comes():
    # 3 mm against 1 mm: 2 mm are left for two contacts, so that each presses with 10 N
    limit = pinch(squeeze=0.0, offset=[[0, 0, 1e-3], [0, 0, -3e-3]]).load_limit((0, 0, 1, 0, 0, 0))
    assert limit.factor == pytest.approx(2 * 0.4 * 10.0, rel=1e-9)


# ---------------------------------------------------------------- a table
def test_a_box_on_a_table_beside_two_fingers_has_limits_all_around():
    from handlcp import scene

    grasp = scene.load("examples/box_on_table.toml").build()
    own = grasp.load_limit(geometry="fixed", faces=8)
    assert own.factor > 1.0, "check() says that it holds its load"
    limits = limits_of_grasp(grasp, DIRECTIONS, 8)
    assert (limits.factors > 1.0).all()
    assert limits.binds[2][0].kind == "slides", "+z presses it onto the table, into which it sinks past the fingers"
    assert grasp.load_limit(DIRECTIONS[2], geometry="fixed", faces=8, max_slip=np.inf).factor == np.inf
    for share, held in ((0.98, True), (1.02, False)):
        assert grasp.follow(share * limits.factors[2] * DIRECTIONS[2], geometry="fixed", faces=8).held == held
    # Both ways along and across the fingers are alike
    assert limits.factors[0] == pytest.approx(limits.factors[3], rel=1e-6)
    assert limits.factors[1] == pytest.approx(limits.factors[4], rel=1e-6)
