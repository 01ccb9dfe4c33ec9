"""Families of hard grasps: seeded scenes of each kind, with an answer that is known before it is solved.

Every family is solved at every number of faces: the built-in answer, or another that obeys every law; what nothing
holds is refused with a motion whose signs prove it. `FAMILIES` has, by name, how many scenes are solved by default and
a generator of so many scenes with so many faces.
"""

import numpy as np
import pytest

from tests.hard_cases import scenes as made
from tests.hard_cases.scenes import FACES, Case, around, backwards, ball, count, examine, fingers, springs, turn
from tests.support.friction_sets import corners, reach

FAMILIES = {}
PADS = np.array([2e-4, 2e-4, 1e-4])
ANY = ["stick", "slide", "corner", "limit", "touch", "open"]


def family(name, default, seed, make):
    """A family of scenes make(rng, i, faces), each with a generator of random numbers of its own."""
    tag = np.atleast_1d(seed).tolist()

    def generate(faces, k):
        return (make(np.random.default_rng([*tag, i]), i, faces) for i in range(k))

    FAMILIES[name] = default, generate


def some(rng, least=3, most=7):
    return int(rng.integers(least, most))


# ---------------------------------------------------------------- one finger to forty
def many(place, states):
    def make(rng, i, faces):
        n = (1, 2, 3, 6, 10, 16, 25, 40)[i % 8]
        p, R = place(rng, n)
        E = fingers(rng, n, shared=i % 2 == 0)
        return backwards(f"{i}: {n} fingers", rng, p, R, 0.5, E, faces, rng.choice(states, n))

    return make


family("number: stick or open", 8, 90, many(around, ["stick", "open"]))
family("number: any state", 8, 91, many(ball, ANY))


# ---------------------------------------------------------------- friction from none to ten, alike or mixed
def rough(mu):
    def make(rng, i, faces):
        n = some(rng)
        p, R = (around, ball)[i % 2](rng, n)
        return backwards(f"{i}", rng, p, R, mu(rng, n), fingers(rng, n), faces)

    return make


family("friction: 1e-6", 4, 50, rough(lambda rng, n: 1e-6))
family("friction: 0.02", 4, 51, rough(lambda rng, n: 0.02))
family("friction: 1", 4, 52, rough(lambda rng, n: 1.0))
family("friction: 10", 4, 53, rough(lambda rng, n: 10.0))
family("friction: 0 to 10", 4, 54, rough(lambda rng, n: rng.choice([0.0, 1e-6, 0.02, 0.5, 10.0], n)))


# ---------------------------------------------------------------- no friction: with pads the forces are unique
def smooth(states, least=7, most=10, pads=True):
    def make(rng, i, faces):
        n = some(rng, least, most)
        p, R = ball(rng, n)
        R = made.frames(R[:, :, 2] + 0.6 * rng.normal(size=(n, 3)), rng=rng)
        E = fingers(rng, n, pad=tuple(PADS) if pads else (0, 0, 0))
        return backwards(f"{i}", rng, p, R, 0.0, E, faces, rng.choice(states, n), unique=pads)

    return make


family("frictionless: all push", 4, 40, smooth(["slide"]))
family("frictionless: some open", 4, 41, smooth(["slide", "open"]))
family("frictionless: some at rest", 4, 42, smooth(["slide", "touch", "graze", "open"]))
family("frictionless: few fingers", 4, 43, smooth(["slide"], 1, 6))
family("frictionless: no pads", 4, 44, smooth(["slide", "touch", "open"], pads=False))


# ---------------------------------------------------------------- fingers from 1e-12 to 1 m/N, 1e8 apart in one hand
def alike(rng, i, faces):
    """Between steel and rubber band; forces of some newtons."""
    n, scale = some(rng), 10.0 ** np.linspace(-8, 4, 7)[i % 7]
    p, R = around(rng, n)
    return backwards(f"{i}: {1e-4 * scale:.0e} m/N", rng, p, R, 0.5, fingers(rng, n) * scale, faces)


def apart(travel, what=None):
    def make(rng, i, faces):
        n = some(rng)
        size = np.repeat(10.0 ** (rng.permutation(np.linspace(-4, 4, n)) / 2), 3)
        p, R = around(rng, n)
        E = fingers(rng, n) * np.outer(size, size)
        return backwards(f"{i}", rng, p, R, 0.6, E, faces, None if what is None else [what] * n, travel=travel)

    return make


family("flexibility: uniform", 4, 1, alike)
family("flexibility: apart", 4, 2, apart(1e-5))
family("flexibility: stuck apart", 4, 3, apart(1e-8, "stick"))  # moves by what the stiffest allows


# ---------------------------------------------------------------- no pads: some directions are rigid, or all
def padless(rank):
    def make(rng, i, faces):
        n = some(rng)
        p, R = around(rng, n)
        E = np.zeros((3 * n, 3 * n))
        for j, r in enumerate(rank(rng, n)):
            b = slice(3 * j, 3 * j + 3)
            E[b, b] = fingers(rng, 1, int(r), pad=(0, 0, 0)) if r else 0.0
        return backwards(f"{i}", rng, p, R, 0.5, E, faces)

    return make


family("no pads: two joints", 4, 10, padless(lambda rng, n: np.full(n, 2)))
family("no pads: straight fingers", 4, 11, padless(lambda rng, n: np.full(n, 1)))
family("no pads: rigid", 4, 12, padless(lambda rng, n: np.zeros(n)))
family("no pads: a mixture", 4, 13, padless(lambda rng, n: rng.integers(0, 4, n)))


# ---------------------------------------------------------------- elastic fingers beside something rigid that sticks
def supported(least, most, rolls, supports):
    """Fingers in any state beside `least` to `most` rigid supports in one of the states `supports`."""

    def make(rng, i, faces):
        n, m = some(rng, 2, 6), some(rng, least, most + 1)
        p, R = around(rng, n)
        floor = turn(rng)
        rectangle = np.array([[1.0, 1, -1], [-1, 1, -1], [-1, -1, -1], [1, -1, -1]])[:m]
        below = np.array([[0.0, 0.0, -1.0]]) if m == 1 else rectangle * [*rng.uniform(0.5, 1, 2), 1]
        p = np.concatenate([p, p.mean(0) + 0.03 * below @ floor.T])
        R = np.concatenate([R, np.tile(floor, (m, 1, 1))])
        E = np.zeros((3 * (n + m), 3 * (n + m)))
        E[: 3 * n, : 3 * n] = fingers(rng, n, pad=tuple(PADS) if i % 3 else (0.0,) * 3) * 10.0 ** rng.uniform(-3, 1)
        states = [*rng.choice(made.STATES, n), *rng.choice(supports, m)]
        travel = float(np.trace(E)) / (3 * n)
        twist = travel * np.r_[np.zeros(3), rng.normal(size=3) / 0.03] if rolls else np.zeros(6)
        if rolls:  # about the one support
            twist[:3] = -np.cross(twist[3:], p[-1] - p.mean(0))
        mu = rng.uniform(0.1, 1, n + m)
        return backwards(f"{i}", rng, p, R, mu, E, faces, states, travel=travel, twist=twist)

    return make


family("rigid: a ball rolls", 6, 201, supported(1, 1, True, ["stick"]))
family("rigid: a box stands", 6, 202, supported(2, 4, False, ["stick"]))
family("rigid: any state", 6, 203, supported(1, 4, False, ["stick", "limit", "touch"]))


# ---------------------------------------------------------------- contacts at one point, twice, on a line, in a plane
def placed(place):
    def make(rng, i, faces):
        p, R = place(rng)
        return backwards(f"{i}", rng, p, R, 0.5, fingers(rng, len(p)), faces)

    return make


def coincident(rng):
    n = some(rng, 2, 6)
    p, R = ball(rng, n)
    return np.tile(p[:1], (n, 1)), R


def duplicated(rng):
    p, R = around(rng, some(rng, 2, 4))
    return np.repeat(p, 2, axis=0), np.repeat(R, 2, axis=0)


def collinear(rng):
    n = some(rng, 2, 6)
    along = turn(rng)[0]
    p = rng.uniform(-0.03, 0.03, (n, 1)) * along + rng.uniform(-0.1, 0.1, 3)
    return p, made.frames(rng.normal(size=(n, 3)), rng=rng)


def coplanar(hair):
    def place(rng):
        n, Q = some(rng), turn(rng)
        level = np.column_stack([rng.uniform(-0.03, 0.03, (n, 2)), hair * rng.normal(size=n)])
        z = np.column_stack([hair * 30 * rng.normal(size=(n, 2)), np.ones(n) * rng.choice([-1, 1], n)])
        return level @ Q.T + rng.uniform(-0.1, 0.1, 3), made.frames(z @ Q.T, rng=rng)

    return place


family("places: coincident", 4, 20, placed(coincident))
family("places: duplicated", 4, 21, placed(duplicated))
family("places: collinear", 4, 22, placed(collinear))
family("places: coplanar", 4, 23, placed(coplanar(0.0)))
family("places: coplanar but 1e-12 m", 4, 24, placed(coplanar(1e-12)))
family("places: coplanar but 1e-8 m", 4, 25, placed(coplanar(1e-8)))
family("places: waist without slopes", 4, 26, placed(lambda rng: around(rng, some(rng), rough=0.0)))


# ---------------------------------------------------------------- on the friction limit, at gaps of zero, and both
def limiting(*states):
    def make(rng, i, faces):
        n = some(rng)
        p, R = around(rng, n)
        here = [states[j % len(states)] for j in range(n)]
        return backwards(f"{i}", rng, p, R, rng.uniform(0.3, 1, n), fingers(rng, n, shared=True), faces, here)

    return make


family("limits: all on the limit", 6, 60, limiting("limit"))
family("limits: some at rest", 6, 61, limiting("stick", "touch"))
family("limits: all at rest", 6, 62, limiting("touch"))
family("limits: limit, rest, stick", 6, 63, limiting("limit", "touch", "stick"))
family("limits: limit, graze, corner", 6, 64, limiting("limit", "graze", "corner"))
family("limits: all slide", 6, 65, limiting("slide", "corner"))
family("limits: all at corners", 6, 66, limiting("corner"))


# ---------------------------------------------------------------- no preload, gaps, and a million times the load
def preloaded(offset, twist=1e-3, rough=1.0):
    def make(rng, i, faces):
        n = some(rng)
        p, R = around(rng, n, rough=rough)
        d = np.zeros((n, 3))
        d[:, 2] = offset(rng, n)
        soft = np.tile([2e-4, 1e-4], (n, 1)) * 10.0 ** rng.uniform(-0.5, 0.5, (n if rough else 1, 1))
        u = twist * np.r_[rng.normal(size=3), rng.normal(size=3) / 0.03]
        return springs(f"{i}", p, R, rng.uniform(0.3, 1), soft, faces, d, u)

    return make


family("preload: none", 5, 70, preloaded(lambda rng, n: 0.0))
family("preload: gaps", 5, 71, preloaded(lambda rng, n: rng.uniform(0, 1e-3, n)))
family("preload: some", 5, 72, preloaded(lambda rng, n: -rng.uniform(0, 2e-3, n)))
# Equal squeeze of equal springs, evenly around: the load is what a motion of a millionth of the squeeze calls for
family("preload: a million times the load", 5, 73, preloaded(lambda rng, n: -1e-2, twist=1e-8, rough=0.0))
family("preload: 1e9 times the load", 5, 74, preloaded(lambda rng, n: -1e-2, twist=1e-11, rough=0.0))


# ---------------------------------------------------------------- loads of none, of 1e-9 and of 1e9 newtons
def loaded(force):
    def make(rng, i, faces):
        n = some(rng)
        p, R = (around, ball)[i % 2](rng, n)
        return backwards(f"{i}", rng, p, R, 0.5, fingers(rng, n), faces, force=force)

    return make


def tiny_load_on_a_firm_grasp(rng, i, faces):
    """Preload of some newtons that balances by itself; then 1e-9 N more: it must not become an error."""
    n = some(rng)
    p, R = around(rng, n, rough=0.0)
    f = rng.normal(size=3) * 1e-9
    w, d = np.r_[f, np.cross(p.mean(0), f)], np.tile([0.0, 0.0, -1e-3], (n, 1))
    return Case(f"{i}", p, R, np.full(n, 0.5), np.diag(np.tile(PADS, n)), d, w, faces)


def unloaded(rng, i, faces):
    """An even squeeze: each finger pushes by its own, nothing moves. Without squeeze nothing at all."""
    n, squeeze = some(rng, 2), [1e-3, 0.0, -1e-3][i % 3]
    p, R = around(rng, n, rough=0.0)
    d, f = np.tile([0.0, 0.0, -squeeze], (n, 1)), np.tile([0.0, 0.0, max(squeeze, 0.0) / 1e-4], (n, 1))
    known = f if squeeze != 0 else None
    return Case(f"{i}", p, R, np.full(n, 0.5), np.diag(np.tile(PADS, n)), d, np.zeros(6), faces, forces=known)


family("wrench: 1e-9 N", 4, 80, loaded(1e-9))
family("wrench: 1e9 N", 4, 81, loaded(1e9))
family("wrench: 1e-9 N on a firm grasp", 4, 83, tiny_load_on_a_firm_grasp)
family("wrench: zero", 4, 84, unloaded)


# ---------------------------------------------------------------- planar scenes: in xy, upside down, on edge and askew
def flat(rng, i):
    """N contacts in a plane, and its axes as columns."""
    fixed = [np.eye(3), np.eye(3)[:, [1, 0, 2]] * [1, 1, -1], np.eye(3)[:, [1, 2, 0]]]
    n = some(rng, 2)
    Q = fixed[i] if i < 3 else turn(rng)
    t = 2 * np.pi * (np.arange(n) + 0.2 * rng.uniform(-1, 1, n)) / n
    out = np.outer(np.cos(t), Q[:, 0]) + np.outer(np.sin(t), Q[:, 1])
    z = -out + 0.3 * rng.normal(size=(n, 1)) * np.cross(Q[:, 2], out)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    p = 0.03 * out + rng.uniform(-0.1, 0.1, 3)
    return n, Q, p, made.frames(z, np.cross(Q[:, 2], z))


def planar(rng, i, faces):
    """Backwards, all states; joints that bend in the plane and pads."""
    n, Q, p, R = flat(rng, i)
    E = np.diag(np.tile(PADS, n))
    for j in range(n):
        J = np.zeros((3, 2))
        J[[0, 2]] = 0.05 * rng.normal(size=(2, 2))
        E[3 * j : 3 * j + 3, 3 * j : 3 * j + 3] += J @ J.T
    return backwards(f"{i}", rng, p, R, rng.uniform(0, 1, n), E, faces, plane=Q[:, 2])


def planar_springs(rng, i, faces):
    """By formula, without and with squeeze."""
    n, Q, p, R = flat(rng, i)
    d = np.zeros((n, 3))
    d[:, 2] = -rng.choice([0.0, 1e-3])
    u = 1e-3 * np.r_[Q[:, :2] @ rng.normal(size=2), Q[:, 2] * rng.normal() / 0.03]
    return springs(f"{i}", p, R, 0.5, (2e-4, 1e-4), faces, d, u, plane=Q[:, 2])


family("planar: built", 6, 110, planar)
family("planar: springs", 6, 111, planar_springs)

# ---------------------------------------------------------------- two opposing hard fingers, whose forces are by hand
SQUEEZE = 1e-3  # m of each finger
PUSH = SQUEEZE / PADS[2]


def pinch(name, rng, faces, mu, side, push=0.0, spin=0.0, answer="solvable"):
    """A load `side` (2,) N in the tangent plane, the same axes for both fingers, `push` N along their line, `spin` N·m
    about it. Equal springs share the load: half the side force each, the push moves half of itself across.
    """
    Q, c = turn(rng), rng.uniform(-0.1, 0.1, 3)
    z = np.array([Q[:, 0], -Q[:, 0]])
    R = made.frames(z, np.tile(Q[:, 1], (2, 1)))
    force = R[0] @ np.r_[side, push]
    w = np.r_[force, np.cross(c, force) + spin * Q[:, 0]]
    half = -(R[0][:, :2] @ np.asarray(side, float)) / 2
    f = np.array([R[0].T @ half + [0, 0, PUSH - push / 2], R[1].T @ half + [0, 0, PUSH + push / 2]])
    d, E = np.tile([0.0, 0.0, -SQUEEZE], (2, 1)), np.diag(np.tile(PADS, 2))
    known = f if answer == "solvable" else None
    return Case(name, c - 0.03 * z, R, np.full(2, mu), E, d, w, faces, None, answer, known)


def towards(rng, faces, corner):
    """A unit direction: at a corner of the polygon (the same for both fingers' mirrored axes), or a side's middle."""
    if faces == "cone":
        a = rng.uniform(0, 2 * np.pi)
        return np.array([np.cos(a), np.sin(a)])
    k = int(rng.integers(faces))
    return corners(faces)[k] if corner else np.array([np.cos(2 * np.pi * k / faces), np.sin(2 * np.pi * k / faces)])


def pulled_aside(share, **more):
    def make(rng, i, faces):
        mu = float(rng.choice([0.02, 0.3, 0.8]))
        side = share * 2 * PUSH * reach(mu, faces) * towards(rng, faces, i % 2)
        return pinch(f"{i}", rng, faces, mu, side, **more)

    return make


def pushed_along(rng, i, faces):
    """A push along the line on top, as far as the weaker finger still sticks."""
    mu = float(rng.uniform(0.1, 1))
    push = rng.uniform(-1, 1) * PUSH
    limit = 2 * (PUSH - abs(push) / 2) * reach(mu, faces)
    return pinch(f"{i}", rng, faces, mu, 0.9 * limit * towards(rng, faces, i % 2), push)


family("two: well inside", 4, 30, pulled_aside(0.5))
family("two: on the limit", 4, 31, pulled_aside(1.0))
family("two: 1e-9 inside the limit", 4, 32, pulled_aside(1 - 1e-9))
family("two: beyond the limit", 4, 33, pulled_aside(1.001, answer="no equilibrium"))
family("two: far beyond", 4, 34, pulled_aside(20.0, answer="no equilibrium"))
family("two: spun", 4, 36, pulled_aside(0.5, spin=1e-2, answer="not holdable"))
family("two: pushed", 4, 35, pushed_along)


# ---------------------------------------------------------------- loads outside all cones, and just inside
def one_sided(rng, i, faces):
    """Every force has a part along an axis, and so has the load."""
    n, mu, axis = some(rng, 1), rng.uniform(0, 0.8), turn(rng)[0]
    side = np.cross(axis, rng.normal(size=(n, 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    tilt = rng.uniform(0, 0.95, (n, 1)) * (np.pi / 2 - np.arctan(mu))
    z = np.cos(tilt) * axis + np.sin(tilt) * side
    p = -0.03 * z + rng.uniform(-0.1, 0.1, 3)
    w = np.r_[rng.normal(size=3), 0.01 * rng.normal(size=3)]
    w[:3] += (abs(w[:3] @ axis) + 1) * axis
    E, d = fingers(rng, n), np.tile([0, 0, -1e-3], (n, 1))
    return Case(f"{i}", p, made.frames(z, rng=rng), np.full(n, mu), E, d, w, faces, answer="not holdable")


def on_props(share, answer):
    """Props under a plate, all alike, pushed sideways through their plane with `share` of what friction allows."""

    def make(rng, i, faces):
        n, mu, weight = some(rng), float(rng.choice([1e-3, 0.3, 2.0])), 10.0
        Q, c = turn(rng), rng.uniform(-0.1, 0.1, 3)
        t = 2 * np.pi * np.arange(n) / n
        p = 0.03 * np.column_stack([np.cos(t), np.sin(t), 0 * t]) @ Q.T + c
        R = made.frames(np.tile(Q[:, 2], (n, 1)), np.tile(Q[:, 0], (n, 1)))
        if faces == "cone":
            a = rng.uniform(0, 2 * np.pi)
            way = np.array([np.cos(a), np.sin(a)])
        else:
            j, C = int(rng.integers(faces)), corners(faces)
            way = C[j] if i % 2 else (C[j] + C[j - 1]) / 2
        force = R[0] @ np.r_[share * reach(mu, faces) * weight * way, -weight]
        w = np.r_[force, np.cross(c, force)]
        E = np.diag(np.tile(PADS, n))
        return Case(f"{i}", p, R, np.full(n, mu), E, np.zeros((n, 3)), w, faces, answer=answer)

    return make


def out_of_plane(rng, i, faces):
    """Nothing without friction resists a load in the tangent plane of all contacts."""
    n, Q = some(rng, 2, 8), turn(rng)
    t = 2 * np.pi * np.arange(n) / n
    out = np.column_stack([np.cos(t), np.sin(t), 0 * t]) @ Q.T
    w = np.r_[rng.uniform(0.1, 1) * Q[:, 2] + 0.1 * Q[:, 0], np.zeros(3)]
    d, R = np.tile([0, 0, -1e-3], (n, 1)), made.frames(-out, rng=rng)
    return Case(f"{i}", 0.03 * out, R, np.zeros(n), fingers(rng, n), d, w, faces, answer="not holdable")


def pulled_off(rng, i, faces):
    """One finger, and the load away from it."""
    z = turn(rng)[:1]
    c = rng.uniform(-0.1, 0.1, (1, 3))
    f = 10.0 ** rng.uniform(-6, 6) * z[0]
    R, w = made.frames(z, rng=rng), np.r_[f, np.cross(c[0], f)]
    return Case(f"{i}", c, R, np.array([0.5]), fingers(rng, 1), np.zeros((1, 3)), w, faces, answer="not holdable")


family("unholdable: one-sided", 4, 100, one_sided)
family("unholdable: props, 1.01 of the limit", 4, 101, on_props(1.01, "not holdable"))
family("unholdable: props, 20 of the limit", 4, 102, on_props(20.0, "not holdable"))
family("holdable: props, 0.99 of the limit", 4, 103, on_props(0.99, "solvable"))
family("holdable: props, on the limit", 4, 104, on_props(1.0, "solvable"))
family("unholdable: frictionless", 4, 105, out_of_plane)
family("unholdable: pulled", 4, 106, pulled_off)


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("name", FAMILIES)
def test_an_answer_is_found_and_what_has_none_is_refused_with_proof(name, faces):
    default, generate = FAMILIES[name]
    examine(generate(faces, count(default))).demand()


@pytest.mark.parametrize("m", [3, 5, 6, 7, 12, 24, 32, 64, 128])
def test_a_pyramid_of_any_number_of_faces_is_solved(m):
    """Of that very polygon, sides and corners included."""

    def built(i):
        rng = np.random.default_rng([120, m, i])
        n = some(rng)
        p, R = around(rng, n)
        return backwards(f"{m} faces, {i}", rng, p, R, 0.5, fingers(rng, n), m)

    examine(built(i) for i in range(count(3))).demand()
