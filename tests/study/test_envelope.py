"""Envelopes: closed forms of a pinch, mirror images, single limits, linear programs, the force polytope of a finger."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

import handlcp as hl
from tests.support.squeezed import MU, G, N, cube, flat_pinch, pinch
from tests.support.study import without_limits
from tests.support.texts import says


def fixed(directions, **more):
    """The envelope of the cube in one posture, without more directions than these."""
    return hl.envelope(cube(), directions, **({"geometry": "fixed", "faces": 8, "adaptive": 0} | more))


@cache
def of_cube(count, adaptive=0):
    return fixed(count, adaptive=adaptive)


def kinds(binds):
    return {b.kind for b in binds}


# ---------------------------------------------------------------- closed forms
def test_a_pinch_holds_2_mu_n_in_every_tangential_direction():
    env = hl.envelope(pinch(), ("yz", 24))
    np.testing.assert_allclose(env.factors, 2 * MU * N, rtol=1e-9)
    assert [kinds(binds) for binds in env.binds] == [{"slips"}] * 24
    assert [{b.who for b in binds} for binds in env.binds] == [{"left", "right"}] * 24
    np.testing.assert_allclose(env.directions[:, 0], 0.0, atol=1e-15)


def test_a_pinch_across_is_weakest_where_its_load_also_relieves_a_finger():
    """A force F along (dx, dt) takes F |dx| / 2 from one normal force, and the two frictions stay equal, since nothing
    else balances their moment: F |dt| / 2 = μ (N - F |dx| / 2).
    """
    env = hl.envelope(pinch(), 362)
    d = env.directions
    along, across = abs(d[:, 0]), np.hypot(d[:, 1], d[:, 2])
    free = across < 1e-12  # pressed on one finger alone: nothing gives out
    assert np.isinf(env.factors[free]).all()
    assert free.sum() == 2
    np.testing.assert_allclose(env.factors[~free], (2 * MU * N / (across + MU * along))[~free], rtol=1e-7)
    steepest = hl.envelope(pinch(), [(MU, 1, 0), (-MU, 0, 1), (0, 1, 0)])
    assert steepest.weakest.factor == pytest.approx(2 * MU * N / np.sqrt(1 + MU**2), rel=1e-9)
    assert env.weakest.factor == pytest.approx(steepest.weakest.factor, rel=2e-2)
    assert env.weakest.factor >= steepest.weakest.factor * (1 - 1e-9)


def test_what_nothing_ever_limits_is_infinite_everywhere_it_is_told():
    env = hl.envelope(pinch(), [(1, 0, 0), (0, 1, 0)])
    assert env.binds[0] == ()
    assert "nothing gives out" in str(env)
    assert "any load along +x" in str(env)
    assert env.to_dict()["force_N"] == [None, pytest.approx(2 * MU * N)]


def test_no_direction_holds_any_load_where_torque_limits_alone_end_it(monkeypatch, tmp_path):
    """A path that finds no limit is wrong there, and is not believed."""
    without_limits(monkeypatch)
    env = fixed(12)
    assert np.isnan(env.factors).all()
    assert {b.kind for binds in env.binds for b in binds} == {"undecided"}
    assert "any load" not in str(env)
    assert "undecided" in str(env)
    assert np.isnan(env.compliance.median)
    assert env.plot(tmp_path / "undecided.png").stat().st_size > 10_000
    free = hl.envelope(pinch(), [(1, 0, 0)])
    assert np.isinf(free.factors).all()  # pressed on a finger, nothing ever ends it


def test_a_force_beside_the_centre_is_a_wrench():
    at, way = np.array([0.0, 0.0, 0.01]), np.array([(0.6, 0.8, 0), (0, 0.6, -0.8)])
    beside = hl.envelope(pinch(), way, at=at)
    wrenches = np.concatenate([way, np.cross(at, way)], axis=1)
    assert beside.factors.tolist() == hl.envelope(pinch(), wrenches).factors.tolist()
    np.testing.assert_allclose(beside.wrenches, wrenches, atol=1e-15)


# ---------------------------------------------------------------- one direction after the other
def test_every_direction_is_the_limit_of_its_own_load():
    env = of_cube(12)
    for k in range(0, len(env.factors), 5):
        one = cube().load_limit(env.wrenches[k], geometry="fixed", faces=8)
        assert env.factors[k] == pytest.approx(one.factor, rel=1e-9)
        assert env.binds[k] == one.binds


def test_a_hand_that_is_its_own_mirror_image_holds_as_much_on_both_sides():
    env = of_cube(42)
    mirrored = fixed(env.directions * (1, -1, 1))
    np.testing.assert_allclose(mirrored.factors, env.factors, rtol=1e-6)


def test_a_torque_turns_about_its_direction():
    env = fixed([(0, 0, 2.0)], of="torque")
    one = cube().load_limit((0, 0, 0, 0, 0, 1.0), geometry="fixed", faces=8)
    assert env.factors[0] == pytest.approx(one.factor, rel=1e-9)
    assert env.unit == "N·m"


def test_few_directions_of_round_fingertips_are_followed_unless_asked_otherwise_and_it_is_said():
    env = hl.envelope(cube(), [(1, 0, 0), (0, 0, -1)])
    assert env.geometry == env.to_dict()["geometry"] == "followed"
    assert "fingers and object move under the load" in str(env)
    for k in range(2):
        assert env.factors[k] == cube().load_limit(env.wrenches[k]).factor
    assert (env.accuracy <= 1e-3).all()
    many = hl.envelope(cube(), np.tile(env.directions, (60, 1)), faces=8)
    assert many.geometry == "fixed"
    assert 'geometry="followed"' in str(many)


def test_an_accuracy_is_reached_or_it_is_said_where_it_is_not():
    ways, asked = [(0, 0, 1)], 5e-3
    env = hl.envelope(cube(), ways, accuracy=asked)
    finer = [cube().load_limit((*d, 0, 0, 0), accuracy=asked / 4).factor for d in ways]
    np.testing.assert_allclose(env.factors, finer, rtol=2 * asked)
    assert (env.accuracy <= asked).all()
    assert "estimated to be within 0.5 % in all 1 directions" in str(env)
    fixed = hl.envelope(pinch(), [(0, 1, 0)], accuracy=1e-3)
    assert fixed.factors[0] == pytest.approx(2 * MU * N, rel=fixed.accuracy[0])
    assert (fixed.accuracy == 0.0).all(), "nothing slides on a round cone before it is lost: forces are exact"
    missed = dataclasses.replace(env, accuracy=np.array([2.0 * asked]))
    assert "in 0 of 1 directions; off by" in str(missed)
    with pytest.raises(hl.InputError, match="accuracy"):
        hl.envelope(pinch(), [(0, 1, 0)], accuracy=0.0)


# ---------------------------------------------------------------- gravity
def test_the_mass_that_is_held_is_that_of_a_limit_and_of_following_a_heavier_object():
    ways = [(0, 0, -1), (0, 0.6, 0.8)]
    env = fixed(ways, of="gravity")
    followed = 0
    for k, d in enumerate(env.directions):
        bare = cube().replace(mass=0.0)
        assert env.factors[k] == pytest.approx(bare.load_limit(env.wrenches[k], geometry="fixed", faces=8).factor)
        np.testing.assert_allclose(env.wrenches[k, :3], G * d)
        if "torque" in kinds(env.binds[k]) or "range" in kinds(env.binds[k]):
            continue  # following goes on beyond these
        for share, holds in ((0.98, True), (1.02, False)):
            heavy = cube().replace(mass=float(share * env.factors[k]), gravity=G * d)
            assert heavy.follow(geometry="fixed", faces=8).held is holds
            followed += 1
    assert followed
    assert env.question.load.mass == 0.2
    assert "times the object" in str(env)


def test_the_fingers_weight_turns_with_gravity():
    heavy = cube(finger_weight=True)
    env = hl.envelope(heavy, geometry="fixed", directions=[(0, 0, -1), (1, 0, 0)], of="gravity", faces=8)
    for k, d in enumerate(env.directions):
        turned = heavy.replace(mass=0.0, gravity=G * d)
        assert env.factors[k] == pytest.approx(turned.load_limit(env.wrenches[k], geometry="fixed", faces=8).factor)


# ---------------------------------------------------------------- where directions are added
def test_directions_are_added_in_the_middle_between_two_that_differ_and_nowhere_else():
    first, env = of_cube(42), of_cube(42, 1)
    m = len(first.factors)
    np.testing.assert_array_equal(env.directions[:m], first.directions)
    t = first.triangles
    edges = {tuple(sorted(pair)) for a, b, c in t.tolist() for pair in ((a, b), (b, c), (c, a))}
    between = [(a, b) for a, b in edges if set(first.binds[a]) != set(first.binds[b])]
    middles = np.array([first.directions[a] + first.directions[b] for a, b in between])
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    added = env.directions[m:]
    assert 0 < len(added) == len(middles) < len(edges)
    assert np.linalg.norm(added[:, None] - middles[None], axis=2).min(axis=1).max() < 1e-12


def test_the_border_between_two_causes_becomes_sharp():
    env = fixed(("xz", 24), adaptive=4)
    order = np.argsort(np.arctan2(env.directions[:, 2], env.directions[:, 0]))
    apart = []
    for a, b in zip(order, np.roll(order, -1), strict=True):
        if set(env.binds[a]) != set(env.binds[b]):
            apart.append(np.degrees(np.arccos(np.clip(env.directions[a] @ env.directions[b], -1, 1))))
    assert len(apart) >= 3
    np.testing.assert_allclose(apart, 15.0 / 2**4, rtol=1e-6)


def test_shares_are_those_of_the_solid_angle():
    env = of_cube(42, 1)
    assert env.shares.sum() == pytest.approx(1.0)
    assert sum(c.share for c in env.causes) == pytest.approx(1.0)
    assert (env.shares * env.directions[:, 2] ** 2).sum() == pytest.approx(1 / 3, rel=0.02)
    around = hl.envelope(pinch(), ("xy", 8))
    assert around.shares.sum() == pytest.approx(1.0)
    first = np.flatnonzero(env.cause == 0)
    assert env.causes[0].share == pytest.approx(env.shares[first].sum())
    assert env.causes[0].least == env.factors[first].min()


# ---------------------------------------------------------------- without compliance
def program(grasp, wrench, faces, torque=True):
    """The largest factor that any forces in these pyramids and torque limits balance, from public names alone."""
    n, J = len(grasp.contacts), grasp.jacobian
    P = np.array([c.position for c in grasp.contacts]) - grasp.reference
    each = [np.concatenate([R, np.cross(p, R.T).T]) for p, R in zip(P, grasp.frames, strict=True)]
    wrench_of = np.concatenate(each, axis=1)
    a = 2 * np.pi * np.arange(faces) / faces
    rows = np.zeros((n * faces, 3 * n))
    for i, c in enumerate(grasp.contacts):
        block = np.stack([np.cos(a), np.sin(a), np.full(faces, -c.mu * np.cos(np.pi / faces))], axis=1)
        rows[i * faces : (i + 1) * faces, 3 * i : 3 * i + 3] = block
    limit = grasp.state.hand.torque_limits
    A, b = [rows], [np.zeros(len(rows))]
    if torque:
        A, b = [rows, J.T, -J.T], [np.zeros(len(rows)), limit, limit]
    A, b = np.concatenate(A), np.concatenate(b)
    weight = np.append(grasp.target.mass * grasp.given_gravity, np.zeros(3))
    found = linprog(
        np.append(np.zeros(3 * n), -1.0), np.column_stack([A, np.zeros(len(A))]), b,
        np.column_stack([wrench_of, wrench]), -weight, bounds=[(None, None)] * (3 * n) + [(0, None)],
    )  # fmt: skip
    return found.x[-1]


def test_the_bound_on_pyramids_is_that_of_a_linear_program():
    env = fixed(12)
    known = np.array([program(cube(), w, 8) for w in env.wrenches])
    np.testing.assert_allclose(env.bound, known, rtol=1e-6)


def test_the_bound_on_the_cone_lies_between_a_fine_program_and_a_little_more():
    env = fixed([(1, 0, 0), (-0.6, 0.8, 0), (0, 0, 1), (0.3, -0.4, -0.5)], of="torque", faces="cone")
    fine = np.array([program(cube(), w, 96) for w in env.wrenches])
    assert (env.bound >= fine * (1 - 1e-6)).all()
    assert (env.bound <= fine / np.cos(np.pi / 96) ** 2 * (1 + 1e-6)).all()


def test_no_direction_holds_more_than_its_bound():
    env = of_cube(42, 1)
    assert (env.factors <= env.bound * (1 + 1e-6)).all()
    c = env.compliance
    said = next(line for line in str(env).replace("\n  ", " ").splitlines() if "alone" in line)
    says(said, f"{c.least:.0%}".replace("%", " %"))
    kept = env.factors / env.bound
    assert c.least == kept.min() == kept[c.number]
    assert c.least < c.median < 1.0


def test_wrenches_out_of_the_plane_of_a_planar_scene_are_refused():
    grasp = flat_pinch()
    assert hl.envelope(grasp, [(0, 1.0, 0, 0, 0, 0)]).factors[0] == pytest.approx(2 * MU * N, rel=1e-6)
    with pytest.raises(hl.InputError, match=r"directions\[1\]: expected forces in the plane"):
        hl.envelope(grasp, [(0, 1.0, 0, 0, 0, 0), (0, 0, 1.0, 0, 0, 0)])


def test_the_bound_of_torques_alone_is_the_force_polytope_of_the_finger():
    """One finger that pushes a point, with friction that never matters: what is left is |Jᵀ f| ≤ τ_max."""
    polytope = pytest.importorskip("pycapacity.robot")
    hand = hl.example_hand("allegro", joint_stiffness=5.0, torque_limits=0.7)
    state = hand.at({name: 0.4 for name in hand.joint_names})
    tip = hand.fingertips[1]
    p = state.tip_positions[1]
    grasp = state.grasp({tip: hl.Contact(p, (1, 0, 0), hl.Coulomb(1e4))}, reference=p)
    J = state.jacobian[3:6]
    own = np.flatnonzero(abs(J).max(axis=0) > 1e-9)
    found = polytope.force_polytope(J[:, own], 0.7 * np.ones(len(own)), -0.7 * np.ones(len(own)))
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(40, 3))
    ways = ways[ways[:, 0] < -0.2 * np.linalg.norm(ways, axis=1)]  # what the finger pushes against
    env = hl.envelope(grasp, geometry="fixed", directions=ways)
    faces = ConvexHull(found.vertices.T).equations
    H, d = faces[:, :3], -faces[:, 3]  # H f ≤ d
    slope = -env.directions @ H.T
    radius = np.where(slope > 1e-12, d / np.where(slope > 1e-12, slope, 1.0), np.inf).min(axis=1)
    np.testing.assert_allclose(env.bound, radius, rtol=1e-6)


# ---------------------------------------------------------------- planar scenes, bad input
def test_in_a_plane_directions_go_around_it():
    env = hl.envelope(flat_pinch(), 36)
    assert (env.directions[:, 2] == 0).all()
    up = int(np.argmax(env.directions[:, 1]))
    assert env.factors[up] == pytest.approx(2 * MU * N, rel=1e-9)
    about = hl.envelope(flat_pinch(), 36, of="torque")
    np.testing.assert_allclose(about.directions, [(0, 0, 1), (0, 0, -1)])


@pytest.mark.parametrize(
    ("asked", "argument"),
    [
        ({"directions": 0}, "directions"), ({"directions": "zx"}, "directions"),
        ({"directions": [(0, 0, 0)]}, "directions"), ({"directions": [(1, 0)]}, "directions"),
        ({"directions": ("xy", 2)}, "directions"), ({"directions": (0, 0, 0)}, "directions"),
        ({"directions": np.zeros((0, 3))}, "directions"), ({"of": "weight"}, "of"), ({"of": "wrench"}, "of"),
        ({"of": "torque", "directions": [(1, 0, 0, 0, 0, 0)]}, "of"), ({"of": "torque", "at": (0, 0, 0)}, "at"),
        ({"at": (0, 0)}, "at"), ({"geometry": "loose"}, "geometry"), ({"adaptive": -1}, "adaptive"),
        ({"motion": 0.0}, "motion"), ({"turn": -1.0}, "turn"), ({"faces": 2}, "faces"), ({"progress": 3}, "progress"),
    ],
)  # fmt: skip
def test_bad_input_is_named(asked, argument):
    with pytest.raises(hl.InputError, match=f"^{argument}"):
        hl.envelope(pinch(), **({"directions": 12} | asked))
