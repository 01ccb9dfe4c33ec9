"""Whatever a user passes to the classes and functions of the top level: a typed error, or a certified answer.

Warnings are errors in this suite, so a stray one fails; so does any other exception, and NaN in an answer.
"""

import os

import numpy as np
from hypothesis import HealthCheck, given, settings, strategies as st

import handlcp as hl
from tests.fuzz.wrong_values import Odd

HARD = os.environ.get("HANDLCP_HARD") == "1"
many = settings(
    derandomize=True,
    deadline=10_000 if HARD else None,  # ms: longer is a hang, but on a busy machine
    database=None,
    max_examples=3000 if HARD else 100,
    suppress_health_check=list(HealthCheck),
)
some = settings(many, max_examples=1000 if HARD else 40)


SIZES = [0.0, -0.0, 1.0, -1.0, 0.5, 1e-300, 1e300, -1e300, 1e-30, 1e30, 1e-9, 1e9, 5e-324, 1.7e308, 1e150, 1e-150]
numbers = st.sampled_from([*SIZES, np.nan, np.inf, -np.inf])
OBJECTS = [None, True, False, "", "one", b"x", Odd(), {}, set(), [], (), [[]], {"a": 1}, 1j, 10**400, -(10**400)]
ARRAYS = [np.float32(1), np.int8(3), np.array("x"), np.array(None), np.array([1, "a"], object), np.array(1.0)]
NEARLY = [np.nan, np.inf, "nan", "inf", "1.0", 3, -1, 2**63, range(3), lambda: 1, type, [None] * 3, ["1", "2", "3"]]
SHAPES = [[1, [2, 3]], np.ma.masked, np.zeros((0, 3)), np.zeros((3, 0)), np.datetime64("2026-01-01"), float, ...]
rubbish = st.sampled_from([*OBJECTS, *ARRAYS, *NEARLY, *SHAPES])
vectors = st.integers(0, 7).flatmap(lambda n: st.lists(numbers, min_size=n, max_size=n))
units = st.sampled_from([(0, 0, 1), (1, 0, 0), (0, 0.6, 0.8), (0, -1, 0), (0, 1), (-1, 0)])
anything = numbers | rubbish | vectors | units | st.integers(-3, 3)


def attempt(make, *args, **kwargs):
    """What comes out, or None after a typed error."""
    try:
        return make(*args, **kwargs)
    except hl.HandLCPError:
        return None


def sound(s):
    """A grasp's answer that may be believed: no NaN in SOLVED, a proof with NOT_HOLDABLE."""
    assert isinstance(s.status, hl.Status)
    assert str(s)
    if s.held:
        assert s.residuals.worst <= 1e-8
        for a in (s.forces, s.forces_world, s.gap, s.slip, s.object_displacement):
            assert np.isfinite(a).all()
    if s.status is hl.Status.NOT_HOLDABLE:
        assert np.isfinite(s.certificate).all()
        assert abs(s.certificate).max() > 0


@many
@given(anything, anything, anything, anything, anything)
def test_contact(position, normal, friction, tangent, name):
    attempt(hl.Contact, position, normal, friction, tangent, name)


@many
@given(anything)
def test_coulomb(mu):
    law = attempt(hl.Coulomb, mu)
    assert law is None or (law.mu >= 0 and np.isfinite(law.mu))


@many
@given(anything, anything)
def test_effects(a, b):
    attempt(hl.TotalForceBound, a)
    attempt(hl.PrescribedForce, a, b)
    attempt(hl.Pyramid, a, b)


@many
@given(anything, anything, anything, anything)
def test_solver_settings(a, b, c, d):
    problem = hl.LCP(np.eye(2), [-1.0, 1.0])
    for make, names in (
        (hl.NSNGRK, ("tol", "max_iterations", "seed", "stride", "polish")),
        (hl.Lemke, ("max_iterations", "coverings", "seed", "pivot_tolerance")),
        (hl.SemismoothNewton, ("tol", "max_iterations")),
        (hl.Auto, ("seed", "restarts", "search_work", "search_seconds")),
    ):
        values = dict(zip(names, (a, b, c, d, True), strict=False))
        for settings_ in (values, *({k: v} for k, v in values.items())):
            solver = attempt(make, **settings_)
            budget = [getattr(solver, k, 0) or 0 for k in ("max_iterations", "coverings", "restarts")]
            if solver is not None and max(budget) < 10**5:
                attempt(hl.solve_lcp, problem, solver, throw=False)


PLACES = [(0.03, 0, 0), (-0.03, 0, 0), (0, 0.03, 0), (0, 0, 0.03), (0, 0, 0)]


@many
@given(
    st.lists(st.sampled_from(range(5)), min_size=0, max_size=5),
    st.dictionaries(
        st.sampled_from(["wrench", "flexibility", "preload", "offset", "reference", "effects", "plane"]), anything
    ),
    anything | st.sampled_from([3, 4, 8, "cone"]),
)
def test_grasp_arguments(places, arguments, faces):
    contacts = [hl.Contact(PLACES[k], (-np.sign(PLACES[k][0]) or 1.0, 0, 0)) for k in places]
    defaults = {"flexibility": 1e-4, "preload": 1e-3, "wrench": (0, 0, -1, 0, 0, 0)}
    g = attempt(hl.Grasp, contacts, **(defaults | arguments))
    if g is not None and not (isinstance(faces, int) and faces > 10**4):
        s = attempt(g.solve, faces, throw=False)
        if s is not None:
            sound(s)


sizes = st.sampled_from([0.0, 1e-300, 1e-150, 1e-30, 1e-9, 1e-4, 1.0, 1e4, 1e9, 1e30, 1e150, 1e300])


@many
@given(st.integers(0, 2**32 - 1), sizes, sizes, sizes, sizes, sizes, st.sampled_from([3, 8, "cone"]))
def test_grasps_of_every_size(seed, length, force, soft, squeeze, mu, faces):
    """A sound grasp whose lengths, loads, springs, squeeze and friction have absurd sizes."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))

    def build():
        z = rng.normal(size=(n, 3))
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        contacts = [hl.Contact(-length * a, a, hl.Coulomb(mu)) for a in z]
        with np.errstate(over="ignore"):
            w = force * rng.normal(size=6) * np.r_[1, 1, 1, length, length, length]
        return hl.Grasp(contacts, w, flexibility=soft, preload=squeeze)

    g = attempt(build)
    s = None if g is None else attempt(g.solve, faces, throw=False)
    if s is not None:
        sound(s)


@many
@given(anything, anything, anything, anything)
def test_lcp_arguments(M, q, free, start):
    p = attempt(hl.LCP, M, q, free)
    if p is not None:
        attempt(hl.solve_lcp, p, throw=False, start=start)
    attempt(hl.solve_lcp, M)
    attempt(hl.solve_lcp, hl.LCP(np.eye(2), [1.0, -1.0]), q, throw=False)
    attempt(hl.solve_lcp, hl.LCP(np.eye(2), [1.0, -1.0]), start=start, throw=False)


@many
@given(st.integers(0, 2**32 - 1), st.integers(1, 7), st.lists(numbers, min_size=1, max_size=4), st.booleans())
def test_lcps_of_every_size(seed, n, palette, mixed):
    """Matrices whose entries are drawn from a few absurd numbers and from ordinary ones."""
    rng = np.random.default_rng(seed)
    entries = np.array([*palette, 0.0, 1.0, -1.0, 0.3])
    M, q = rng.choice(entries, (n, n)), rng.choice(entries, n)
    if seed % 3 == 0 and abs(np.nan_to_num(palette)).max() < 1e300:
        M = rng.normal(size=(n, n)) * (rng.choice(palette) if np.isfinite(palette).all() else 1.0)
    p = attempt(hl.LCP, M, q, rng.random(n) < 0.3 if mixed else None)
    assert np.isfinite(M).all() & np.isfinite(q).all() or p is None
    if p is None:
        return
    s = attempt(hl.solve_lcp, p, throw=False)
    if s is not None and s.status is hl.Status.SOLVED:
        assert np.isfinite(s.z).all()
        assert np.isfinite(s.w).all()
        assert s.residual <= 1e-8
    if s is not None and s.status is hl.Status.INFEASIBLE:
        assert np.isfinite(s.certificate).all()


OF_HANDS = ["fingertips", "joint_stiffness", "pad_flexibility", "torque_limits", "base", "tip_radius", "package_dirs"]
named = st.sampled_from([{"finger_1_distal": 1.0}, ["finger_1_tip"], {"finger_1_tip": np.nan}, "palm"])


@some
@given(st.dictionaries(st.sampled_from(OF_HANDS), anything | named))
def test_from_urdf_arguments(arguments):
    hand = attempt(hl.example_hand, "two_finger", **arguments)
    if hand is not None:
        assert str(hand.audit())
        state = hand.at(hand.neutral)
        assert np.isfinite(state.jacobian).all()


@some
@given(anything, anything, anything)
def test_postures_and_objects(q, a, b):
    hand = hl.example_hand("two_finger")
    state = attempt(hand.at, q)
    attempt(hand.close_on, hl.Sphere(0.02, (0, 0, 0.08)), q)
    if state is not None:
        attempt(state.grasp, a)
    for make in (hl.Sphere, hl.Box, hl.Ellipsoid, hl.Mesh):
        attempt(make, a, b)
    attempt(hl.Cylinder, a, b)
    attempt(hl.Hand.from_urdf, a, joint_stiffness=1.0)
    attempt(hl.example_hand, a)
    attempt(hl.audit_urdf, a)
