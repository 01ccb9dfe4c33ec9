"""The bound without compliance against closed forms and linear programs, and the margins of one grasp together."""

import numpy as np
import pytest
from scipy.optimize import linprog

import handlcp as hl
import handlcp.scene
from tests.support.margins import bounds

MU, N = 0.5, 3.0
BOUNDED = (hl.FingerForceBound(N),)


def pinch(friction=None, effects=BOUNDED):
    friction = hl.Coulomb(MU) if friction is None else friction
    contacts = [hl.Contact((-0.02, 0, 0), (1, 0, 0), friction), hl.Contact((0.02, 0, 0), (-1, 0, 0), friction)]
    return hl.Grasp(contacts, flexibility=1e-4, effects=effects)


def ring(n, rng, friction=None):
    """Contacts around a ball of 30 mm, pointing inwards but for some slant."""
    contacts = []
    for i in range(n):
        out = rng.normal(size=3)
        out /= np.linalg.norm(out)
        normal = -out + 0.3 * rng.normal(size=3)
        law = hl.Coulomb(rng.uniform(0.2, 1.0)) if friction is None else friction[i % len(friction)]
        contacts.append(hl.Contact(0.03 * out, normal / np.linalg.norm(normal), law))
    return contacts


def limited(wrench, forces_of, room, wrenches, base):
    """Max λ of A_f x = b, by HiGHS: columns `forces_of` (c, g) of edges, rows (k, c) and room (k,) on the forces."""
    edges, rows = forces_of
    columns = wrench @ edges
    best = []
    for w in wrenches:
        lp = linprog(
            np.append(np.zeros(edges.shape[1]), -1.0), A_ub=np.column_stack([rows @ edges, np.zeros(len(rows))]),
            b_ub=room, A_eq=np.column_stack([columns, w]), b_eq=-np.asarray(base), method="highs"
        )  # fmt: skip
        best.append(np.inf if lp.status == 3 else lp.x[-1])
    return np.array(best)


def edges(grasp, faces, circumscribed=False):
    """(3n, g) forces along the edges of friction pyramids with so many edges, each with a normal force of one."""
    n, columns = len(grasp.contacts), []
    angle = 2 * np.pi * (np.arange(faces) + 0.5) / faces
    for i, c in enumerate(grasp.contacts):
        mu = c.friction.mu / (np.cos(np.pi / faces) if circumscribed else 1.0)
        for a in angle if mu > 0 else angle[:1]:
            column = np.zeros(3 * n)
            column[3 * i : 3 * i + 3] = mu * np.cos(a), mu * np.sin(a), 1.0
            columns.append(column)
    return np.array(columns).T


def grasp_matrix(grasp):
    """(6, 3n) wrench about the reference of the forces in contact axes."""
    blocks = []
    for p, R in zip([c.position for c in grasp.contacts], grasp.frames, strict=True):
        blocks.append(np.vstack([R, np.cross(p - grasp.reference, R, axisb=0, axisc=0)]))
    return np.hstack(blocks)


# ---------------------------------------------------------------- closed forms
SPIN, MIXED, TORSION = (0, 0, 0, 1, 0, 0), (0, 0, 1.0, 0.003, 0, 0), 0.004
WEDGE = [hl.Contact((-0.02, 0), (1, 0), hl.Coulomb(MU)), hl.Contact((0.02, 0), (-1, 0), hl.Coulomb(MU))]
ELLIPSE = 1.0 / np.hypot(0.6 / 0.6, 0.8 / 0.2)
CLOSED_FORMS = {
    "a pinch, 2 μ N across and N along": (
        pinch(), [(0, 0, -1, 0, 0, 0), (0, 0.6, 0.8, 0, 0, 0), (1, 0, 0, 0, 0, 0)], [2 * MU * N, 2 * MU * N, N], 1e-9),
    "points under a spin, nothing": (pinch(), [SPIN], [0.0], 0.0),
    "soft fingers under a spin": (pinch(hl.SoftFinger(MU, TORSION)), [SPIN], [2 * TORSION * N], 1e-9),
    "soft fingers share force and moment on their ellipsoid: (Fz / 2 μ N)² + (Mx / 2 μ_τ N)² = 1": (
        pinch(hl.SoftFinger(MU, TORSION)), [MIXED],
        [1.0 / np.hypot(MIXED[2] / (2 * MU * N), MIXED[3] / (2 * TORSION * N))], 1e-8),
    "anisotropic friction, as its ellipse says": (
        pinch(hl.AnisotropicCoulomb(0.6, 0.2, (0, 1, 0))),
        [(0, 1, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0), (0, 0.6, 0.8, 0, 0, 0)],
        [2 * 0.6 * N, 2 * 0.2 * N, 2 * N * ELLIPSE], 1e-8),
    "a planar wedge, as its interval says": (
        hl.Grasp(WEDGE, flexibility=1e-4, effects=BOUNDED),
        [(0, 1, 0, 0, 0, 0), (1, 0, 0, 0, 0, 0), (0, 0, 0, 0, 0, 1)],
        [2 * MU * N, N, 2 * MU * N * 0.02], 1e-9),
}  # fmt: skip


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_it_bears_as_much_as_the_closed_form_says(name):
    grasp, wrenches, factors, exact = CLOSED_FORMS[name]
    found = bounds(grasp, wrenches)
    assert found.factors == pytest.approx(factors, rel=exact, abs=0.0)
    assert found.gaps.max() < 1e-8


def test_on_a_pyramid_a_pinch_bears_what_its_faces_do():
    share = np.cos(np.pi / 8)  # along the normal of a face
    assert bounds(pinch(), [(0, 0, 1, 0, 0, 0)], 8).factors == pytest.approx([2 * MU * N * share], rel=1e-9)


def test_a_box_on_a_table_is_pressed_without_end_and_slides_at_mu_times_its_weight():
    corners = [hl.Contact((x, y, 0), (0, 0, 1), hl.Coulomb(0.4)) for x in (-0.05, 0.05) for y in (-0.05, 0.05)]
    grasp = hl.Grasp([hl.Contact((0, 0, 0.1), (0, 0, -1), hl.Frictionless())], flexibility=1e-4,
                     environment=hl.Environment(corners), effects=[hl.FingerForceBound(2.0)])  # fmt: skip
    found = bounds(grasp, [(0, 0, -1, 0, 0, 0), (1, 0, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0)], base=(0, 0, -5.0, 0, 0, 0))
    assert found.factors == pytest.approx([np.inf, 0.4 * 7.0, 7.0], rel=1e-9)


# ---------------------------------------------------------------- linear programs
@pytest.mark.parametrize("seed", range(4))
def test_on_pyramids_it_is_the_linear_program(seed):
    rng = np.random.default_rng(seed)
    n, base = int(rng.integers(2, 6)), np.append(rng.normal(size=3), np.zeros(3)) * (seed % 2)
    bound = rng.uniform(1.0, 20.0, size=n)
    grasp = hl.Grasp(ring(n, rng), flexibility=1e-4, effects=[hl.FingerForceBound(tuple(bound))])
    wrenches = rng.normal(size=(20, 6)) * ([1.0] * 3 + [0.03] * 3)
    found = bounds(grasp, wrenches, 8, base)
    if not found.balanced:
        assert (found.factors == 0.0).all()
        return
    normals = np.zeros((n, 3 * n))
    normals[range(n), range(2, 3 * n, 3)] = 1.0
    expected = limited(grasp_matrix(grasp), (edges(grasp, 8), normals), bound, wrenches, base)
    assert found.factors == pytest.approx(expected, rel=1e-8, abs=1e-7)


@pytest.mark.parametrize("seed", range(2))
def test_the_cone_lies_between_the_fine_pyramids_in_it_and_around_it(seed):
    rng = np.random.default_rng(seed)
    n, fine = 4, 180
    grasp = hl.Grasp(ring(n, rng, [hl.Coulomb(0.9)]), flexibility=1e-4, effects=[hl.FingerForceBound(5.0)])
    wrenches = rng.normal(size=(10, 6)) * ([1.0] * 3 + [0.03] * 3)
    normals = np.zeros((n, 3 * n))
    normals[range(n), range(2, 3 * n, 3)] = 1.0
    low, high = (
        limited(grasp_matrix(grasp), (edges(grasp, fine, out), normals), np.full(n, 5.0), wrenches, np.zeros(6))
        for out in (False, True)
    )
    found = bounds(grasp, wrenches)
    assert (found.factors >= low * (1 - 1e-8) - 1e-7).all()
    assert (found.factors <= high * (1 + 1e-8) + 1e-7).all()
    assert (high - low <= 1e-2 * high + 1e-7).all()
    assert found.gaps.max() < 1e-8


@pytest.mark.parametrize("base", [None, (0.0,) * 6])
def test_joints_with_torque_limits_are_the_same_linear_program(base):
    grasp = handlcp.scene.load("examples/cube_three_fingers.toml").build()
    n, J, limits = len(grasp.contacts), grasp.spec.mechanism.jacobian, grasp.spec.mechanism.limits
    assert np.isfinite(limits).all()
    rng = np.random.default_rng(0)
    wrenches = rng.normal(size=(12, 6)) * ([1.0] * 3 + [0.03] * 3)
    there = np.zeros(6) if base is not None else np.array([0, 0, -0.2 * 9.81, 0, 0, 0])
    rows, room = np.vstack([J.T, -J.T]), np.append(limits, limits)
    assert len(J) == 3 * n
    expected = limited(grasp_matrix(grasp), (edges(grasp, 8), rows), room, wrenches, there)
    found = bounds(grasp, wrenches, 8, base)
    assert found.factors == pytest.approx(expected, rel=1e-8)
    assert found.torque.any(axis=1).all()  # without motors at their limit a grasp that squeezes holds more
    assert {kind for kind, _ in found.binds(0)} <= {"slips", "opens", "torque"}


# ---------------------------------------------------------------- its proofs
@pytest.mark.parametrize("law", [hl.Coulomb(0.6), hl.SoftFinger(0.6, 0.004), hl.AnisotropicCoulomb(0.7, 0.3)])
def test_the_forces_at_the_bound_balance_it_within_friction_and_bounds(law):
    rng = np.random.default_rng(3)
    grasp = hl.Grasp(ring(4, rng, [law]), flexibility=1e-4, effects=[hl.FingerForceBound(4.0)])
    wrenches = rng.normal(size=(10, 6)) * ([1.0] * 3 + [0.03] * 3)
    found = bounds(grasp, wrenches)
    held = (found.factors > 0) & np.isfinite(found.factors)
    assert held.any()
    assert (found.forces[held][:, :, 2] <= 4.0 + 1e-7).all()
    if isinstance(law, hl.SoftFinger):
        return  # the moments of soft fingers balance the rest
    out = found.forces[held].reshape(held.sum(), -1) @ grasp_matrix(grasp).T
    assert out + found.factors[held, None] * wrenches[held] == pytest.approx(np.zeros((held.sum(), 6)), abs=1e-7)


def test_what_binds_is_named():
    found = bounds(pinch(), [(0, 0, -1, 0, 0, 0), (1, 0, 0, 0, 0, 0)])
    across, along = found.binds(0), found.binds(1)
    assert ("slips", "finger 1") in across
    assert ("slips", "finger 2") in across
    assert ("force", "per-finger force bound") in along
    assert ("slips", "finger 2") not in along


def test_where_the_weight_alone_is_not_balanced_the_bound_is_nothing_and_says_so():
    found = bounds(pinch(), [(0, 1, 0, 0, 0, 0)], base=(0, 0, -10.0, 0, 0, 0))
    assert not found.balanced
    assert found.factors.tolist() == [0.0]


def test_forces_that_are_known_or_prescribed_are_part_of_it():
    """The second finger presses with 1 N, whatever the first does, so that along x only 1 N - λ is left."""
    known = bounds(pinch(effects=[hl.KnownForce(1, (None, None, 1.0))]), [(1, 0, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0)])
    assert known.factors == pytest.approx([1.0, 2 * MU], rel=1e-8)
    given = pinch(effects=[hl.PrescribedForce(1, (0, 0, 1.0)), hl.FingerForceBound((2.5, np.inf))])
    assert bounds(given, [(1, 0, 0, 0, 0, 0), (-1, 0, 0, 0, 0, 0)]).factors == pytest.approx([1.0, 1.5], rel=1e-8)


def test_units_change_no_bound():
    rng = np.random.default_rng(5)
    contacts = ring(4, rng)
    wrenches = rng.normal(size=(6, 6)) * ([1.0] * 3 + [0.03] * 3)
    one = bounds(hl.Grasp(contacts, flexibility=1e-4, effects=[hl.FingerForceBound(4.0)]), wrenches).factors
    far = [hl.Contact(1e3 * c.position, c.normal, c.friction) for c in contacts]  # mm and mN
    other = hl.Grasp(far, flexibility=1e-4, effects=[hl.FingerForceBound(4.0e3)])
    scaled = wrenches * ([1e3] * 3 + [1e6] * 3)
    assert bounds(other, scaled).factors == pytest.approx(one, rel=1e-8, abs=1e-9)


# ---------------------------------------------------------------- the margins of one grasp together: the nearest
SLIPS_AT, PUSH, PULL, E = 0.5, 4.0, 1.2, 1e-3


def loaded_pinch(pull=PULL, mu=(SLIPS_AT, SLIPS_AT), push=PUSH):
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(m)) for s, m in zip((-1.0, 1.0), mu, strict=True)]
    return hl.Grasp(contacts, (0, 0, -pull, 0, 0, 0), flexibility=E, preload=push * E)


@pytest.fixture(scope="module")
def cube():
    return handlcp.scene.load("examples/cube_three_fingers.toml").build()


def test_the_friction_margin_is_that_of_the_finger_that_uses_most():
    m = loaded_pinch(mu=(0.9, SLIPS_AT)).margins()
    assert m.friction.who == "finger 2"
    assert m.friction.amount == pytest.approx(SLIPS_AT * PUSH - PULL / 2, rel=1e-9)
    assert m.friction.share == pytest.approx(1 - PULL / 2 / (SLIPS_AT * PUSH), rel=1e-9)


def test_the_safety_factor_of_a_pinch_is_2_mu_n_over_the_load():
    m = loaded_pinch().margins()
    assert m.safety == pytest.approx(2 * SLIPS_AT * PUSH / PULL, rel=1e-9)
    assert {b.who for b in m.load.binds} == {"finger 1", "finger 2"}


def test_the_torque_margin_is_that_of_the_joint_nearest_its_limit(cube):
    m, s = cube.margins(), cube.solve()
    check = s.torque_check
    assert m.torque.who == check.binding
    k = check.utilisation.argmax()
    assert m.torque.amount == pytest.approx(check.limit[k] - abs(check.torque[k]), rel=1e-6)
    assert m.torque.share == pytest.approx(1 - check.utilisation.max(), rel=1e-6)
    assert m.safety is None  # nothing loads it but its weight
    assert m.force_closure.closed
    assert m.form_closure.closed is False


def test_without_an_answer_the_contacts_still_have_their_measures():
    m = loaded_pinch(pull=20.0).margins()
    assert not m.solution.held
    assert m.friction is m.torque is None
    assert m.epsilon >= 0.0
    assert "no equilibrium was found" in str(m)


def test_a_contact_that_slides_says_so_and_no_margin_is_minus_zero():
    """Of two pairs, the smoother one bears all it can, and the other the rest."""
    ways = [(np.array(d, dtype=float), m) for d, m in (((1, 0, 0), 0.2), ((0, 1, 0), 0.9))]
    contacts = [hl.Contact(0.02 * s * d, -s * d, hl.Coulomb(m)) for d, m in ways for s in (-1.0, 1.0)]
    m = hl.Grasp(contacts, (0, 0, -6.0, 0, 0, 0), flexibility=E, preload=PUSH * E).margins()
    assert m.friction.amount == pytest.approx(0.0, abs=1e-6)
    text = str(m)
    row = next(line for line in text.splitlines() if line.startswith("friction"))
    assert "slides already" in row
    assert "-0" not in row


def test_without_friction_there_is_no_friction_margin():
    axes = np.vstack([np.eye(3), -np.eye(3)])
    contacts = [hl.Contact(0.02 * a, -a, hl.Frictionless()) for a in axes]
    m = hl.Grasp(contacts, flexibility=E, preload=1e-3).margins()
    assert m.friction is None
    assert m.force_closure.closed is m.form_closure.closed is False  # a ball turns


@pytest.mark.parametrize("seed", range(2))
def test_loading_never_holds_more_than_friction_alone_could(seed):
    rng = np.random.default_rng(seed)
    out = rng.normal(size=(4, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    contacts = [hl.Contact(0.03 * p, -p, hl.Coulomb(0.6)) for p in out]
    bound = hl.FingerForceBound(6.0)
    g = hl.Grasp(contacts, flexibility=E, preload=2e-3, effects=[bound])
    w = np.append(rng.normal(size=3), np.zeros(3))
    reached = g.load_limit(w, faces=8).factor
    assert reached <= bounds(g, [w], 8).factors[0] * (1 + 1e-8) + 1e-9


def test_it_is_a_table(cube):
    m = cube.margins()
    frame = m.to_frame()
    assert frame.loc["epsilon", "value"] == pytest.approx(m.epsilon)
    assert frame.loc["friction", "who"] == m.friction.who


@pytest.mark.parametrize(("given", "name"), [({"length": "long"}, "length"), ({"solution": 3}, "solution")])
def test_what_makes_no_sense_is_refused(given, name):
    with pytest.raises(hl.InputError) as caught:
        loaded_pinch().margins(**given)
    assert caught.value.argument == name
