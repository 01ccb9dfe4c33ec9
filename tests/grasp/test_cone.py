"""The exact cone, and pyramids solved on the cone's few unknowns instead of one multiplier a face."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.admm import equilibrium
from tests.grasp.scenes import cube_example, pinch, ring
from tests.support.lcp import contact_rows, projection
from tests.support.texts import says


def scenes(count=8):
    for seed in range(count):
        contacts, data = ring(np.random.default_rng(seed))
        yield hl.Grasp(contacts, **data)


def test_a_pinch_holds_up_to_the_circular_limit_in_every_direction():
    for angle in np.linspace(0, 2 * np.pi, 13):
        direction = np.array([0, np.cos(angle), np.sin(angle)])
        held = pinch(mu=0.25, load=5.0 * (1 - 1e-9) * direction).solve("cone")  # 2 · 10 N · 0.25
        np.testing.assert_allclose(np.linalg.norm(held.tangential_force, axis=1), 2.5, rtol=1e-8)
        assert not pinch(mu=0.25, load=5.0 * (1 + 1e-6) * direction).solve("cone", throw=False).held


def test_sliding_forces_are_on_the_cone_and_against_the_slip():
    slides = 0
    for g in scenes():
        s = g.solve("cone", throw=False)
        if not s.held:
            continue
        for state, f, v in zip(s.contact_state, s.forces, s.slip, strict=True):
            if state == "sliding":
                slides += 1
                size = np.linalg.norm(f[:2])
                assert size == pytest.approx(0.6 * f[2], rel=1e-7)
                np.testing.assert_allclose(f[:2] / size, -v / np.linalg.norm(v), atol=1e-6)
    assert slides > 3


def test_pyramids_converge_to_the_cone_as_one_over_faces_squared():
    g = cube_example()
    cone = g.solve("cone").forces
    errors = np.array([abs(g.solve(m).forces - cone).max() for m in (16, 64, 256)])
    assert errors[0] < 0.02 * abs(cone).max()
    assert errors[2] < errors[0] / 50  # 256 at best: where the force lies between two vertices matters, too


@pytest.mark.parametrize("faces", [3, 4, 5, 8, 32])
def test_pyramids_through_the_cone_solve_the_same_lcp(faces):
    """The chain's answer, lifted to one multiplier a face, is a certified solution of the plain LCP."""
    compared = 0
    for g in scenes(5):
        p = g.problem(faces)
        if g.solve(faces, throw=False).held:
            s = hl.solve_lcp(p)
            says(s.trace[0].partition(":")[0], "friction")
            assert s.residual < 1e-9
            candidate = p.candidate(s.z / p.scaled.units.z)
            reference = g.solve(faces)
            if reference.uniqueness.loose_motions == 0 and len(s.trace) == len(reference.trace) == 1:
                np.testing.assert_allclose(candidate.forces, reference.forces, atol=1e-7 * abs(reference.forces).max())
                compared += 1
    assert compared


@pytest.mark.parametrize("faces", [0, 2, 3, 4, 7, 16])
def test_the_derivative_of_the_projection_is_its_difference_quotient(faces):
    rng = np.random.default_rng(faces)
    h, mu = 1e-7, 0.8
    for _ in range(100):
        x, y, n = rng.normal(), 0.0 if faces == 2 else rng.normal(), rng.uniform(0.1, 2)
        P, D = projection(x, y, mu * n, mu, faces)
        for k, (dx, dy, dn) in enumerate(np.eye(3) * h):
            if faces == 2 and k == 1:
                continue
            A, _ = projection(x + dx, y + dy, mu * (n + dn), mu, faces)
            B, _ = projection(x - dx, y - dy, mu * (n - dn), mu, faces)
            quotient = (A - B) / (2 * h)
            if abs(quotient - D[:, k]).max() > 1e-5:  # a corner between the two points: a one-sided value will do
                sides = [(A - P) / h, (P - B) / h]
                assert min(abs(q - D[:, k]).max() for q in sides) < 1e-5


def test_subgradients_of_contact_rows_are_their_difference_quotients():
    p = cube_example().problem("cone")
    rng, n, h = np.random.default_rng(0), p.n, 1e-6
    for _ in range(20):
        x = rng.normal(size=n)
        _, J = contact_rows(p, x)
        ends = [(contact_rows(p, x + h * e)[0], contact_rows(p, x - h * e)[0]) for e in np.eye(n)]
        quotient = np.column_stack([(ahead - behind) / (2 * h) for ahead, behind in ends])
        np.testing.assert_allclose(J, quotient, atol=1e-5)


# ---------------------------------------------------------------- The exact cone against Pinocchio's ADMM in a proxim


def natural(contacts, wrench, E, d):
    """(G, E, w, d) of order one about the contacts' centre, from SI; and the unit of force."""
    p = np.array([c.position for c in contacts])
    R = [c.rotation for c in contacts]
    centre = p.mean(0)
    length = np.sqrt(((p - centre) ** 2).sum(1).mean())
    G = np.hstack([np.vstack([F, np.cross(a, F.T).T]) for F, a in zip(R, (p - centre) / length, strict=True)])
    w = np.r_[wrench[:3], (wrench[3:] - np.cross(centre, wrench[:3])) / length]
    force, soft = np.linalg.norm(w), np.trace(E) / len(E)
    return G, E / soft, w / force, d / (soft * force), force


@pytest.mark.parametrize(
    ("seed", "n", "mu", "frictionless"), [(0, 4, 0.6, ()), (1, 5, 0.4, ()), (8, 4, 0.6, ()), (0, 5, 0.6, (2,))]
)
def test_forces_agree_with_admm(seed, n, mu, frictionless):
    contacts, rest = ring(np.random.default_rng(seed), n, mu)
    contacts = [
        hl.Contact(c.position, c.normal, hl.Frictionless()) if i in frictionless else c for i, c in enumerate(contacts)
    ]
    solution = hl.Grasp(contacts, **rest).solve("cone")
    assert "sliding" in solution.contact_state  # where all fingers stick, friction plays no part
    assert solution.uniqueness.forces_determined
    d = np.zeros((n, 3))
    d[:, 2] = -rest["preload"]
    G, E, w, d, force = natural(contacts, rest["wrench"], rest["flexibility"], d.ravel())
    found = equilibrium(G, E, w, d, np.array([c.mu for c in contacts]))
    assert found.converged
    expected = found.forces.reshape(n, 3) * force
    assert abs(solution.forces - expected).max() <= 1e-8 * abs(expected).max()
