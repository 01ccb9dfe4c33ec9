"""Friction that differs with the direction: an ellipse, met in coordinates in which it is a disc."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.grasp import arrays

RIBBED = hl.AnisotropicCoulomb(0.6, 0.2)


def pinch(law=RIBBED, wrench=(0, 0, -1, 0, 0, 0), tangent=(0, 0, 1), preload=1e-3):
    """Two fingers along x, x axes of the contacts along z, 10 N of squeeze."""
    contacts = [hl.Contact((-0.01 * x, 0, 0), (x, 0, 0), law, tangent) for x in (1, -1)]
    return hl.Grasp(contacts, wrench, flexibility=1e-4, preload=preload)


def ring(seed, law, squeeze=0.2e-3, tangent=None):
    rng = np.random.default_rng(seed)
    contacts = []
    for k in range(4):
        a = 2 * np.pi * (k + 0.2 * rng.random()) / 4
        n = np.array([-np.cos(a), -np.sin(a), 0.2 * rng.standard_normal()])
        contacts.append(hl.Contact(-0.03 * n, n / np.linalg.norm(n), friction=law, tangent=tangent))
    load = rng.standard_normal(6) * np.array([1, 1, 1, 0.01, 0.01, 0.01])
    return hl.Grasp(contacts, load, flexibility=1e-4, preload=squeeze)


@pytest.mark.parametrize("angle", np.linspace(0.0, 2 * np.pi, 7))
def test_a_pinch_holds_up_to_the_ellipse_and_no_further(angle):
    along, across = np.cos(angle), np.sin(angle)
    limit = 2 * 10.0 / np.hypot(along / 0.6, across / 0.2)
    load = np.array([0, -across, -along, 0, 0, 0])
    s = pinch(wrench=load * limit * (1 - 1e-6)).solve("cone")
    assert s.contact_state == ("sticking", "sticking")
    np.testing.assert_allclose(s.forces_world[:, 2], 0.5 * along * limit * (1 - 1e-6), rtol=1e-9, atol=1e-12)
    beyond = pinch(wrench=load * limit * (1 + 1e-6)).solve("cone", hl.Auto(search_seconds=0), throw=False)
    assert not beyond.held
    assert pinch(wrench=load * limit * 1.05).solve("cone", throw=False).status is hl.Status.NO_EQUILIBRIUM


def test_sliding_is_on_the_ellipse_and_against_its_normal():
    slides = 0
    for seed in range(20):
        s = ring(seed, RIBBED).solve("cone", throw=False)
        assert s.status is not hl.Status.UNDECIDED
        for i in range(len(s.forces) if s.held else 0):
            x, y, n = s.forces[i]
            assert (x / 0.6) ** 2 + (y / 0.2) ** 2 <= n**2 * (1 + 1e-9) + 1e-12
            if s.contact_state[i] == "sliding":
                slides += 1
                assert np.hypot(x / 0.6, y / 0.2) == pytest.approx(n, rel=1e-8)
                ways = [v / np.linalg.norm(v) for v in (s.slip[i], np.array([-x / 0.36, -y / 0.04]))]
                np.testing.assert_allclose(*ways, atol=1e-6)
    assert slides >= 10


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("faces", [4, 9, "cone"])
def test_gaps_slips_and_forces_obey_the_elastic_law_in_contact_axes(seed, faces):
    g = ring(seed, RIBBED, 0.6e-3)
    s = g.solve(faces)
    u = s.object_displacement
    for i, c in enumerate(g.contacts):
        v = c.rotation.T @ (u[:3] + np.cross(u[3:], c.position)) + 1e-4 * s.forces[i] + g.offset[i]
        np.testing.assert_allclose([*s.slip[i], s.gap[i]], v, atol=1e-12)
        np.testing.assert_allclose(s.forces_world[i], c.rotation @ s.forces[i], atol=1e-12)


def test_axes_exchanged_with_coefficients_make_the_same_scene():
    g, law = ring(2, RIBBED, tangent=(0, 0, 1)), hl.AnisotropicCoulomb(0.2, 0.6)
    turned = [hl.Contact(c.position, c.normal, law, c.rotation[:, 1]) for c in g.contacts]
    load = np.append(arrays(g).force, arrays(g).moment)
    other = hl.Grasp(turned, load, flexibility=1e-4, preload=0.2e-3).solve("cone")
    np.testing.assert_allclose(other.forces_world, g.solve("cone").forces_world, atol=1e-8)


def test_along_turns_the_contacts_axis_unless_a_tangent_is_given():
    law = hl.AnisotropicCoulomb(0.6, 0.2, along=(0.3, 0, 1))
    np.testing.assert_allclose(hl.Contact((0, 0, 0), (1, 0, 0), law).tangent, (0, 0, 1), atol=1e-12)
    np.testing.assert_allclose(hl.Contact((0, 0, 0), (1, 0, 0), law, (0, 1, 0)).tangent, (0, 1, 0), atol=1e-12)


def test_in_a_plane_it_is_the_coefficient_along_the_plane():
    def held(law, tangent):
        contacts = [hl.Contact((s * 0.01, 0, 0), (-s, 0, 0), law, tangent) for s in (-1.0, 1.0)]
        return hl.Grasp(contacts, (0, -1, 0, 0, 0, 0), flexibility=1e-4, preload=1e-3, plane=(0, 0, 1))

    between = 1 / np.hypot(np.sqrt(0.5) / 0.6, np.sqrt(0.5) / 0.2)
    for tangent, mu in (((0, 1, 0), 0.6), ((0, 0, 1), 0.2), ((0, 1, 1), between)):
        np.testing.assert_allclose(arrays(held(RIBBED, tangent)).mu, mu, rtol=1e-12)


def test_required_friction_keeps_the_ratio():
    least = pinch(wrench=(0, -2, 0, 0, 0, 0)).required_friction("cone").value
    assert least == pytest.approx(3 * 0.1, rel=2e-3)  # across, a third of it: 2 N on two fingers of 10 N


@pytest.mark.parametrize("bad", [(0.0, 0.5), (0.5, -1.0), (0.5, np.inf)])
def test_bad_numbers_are_refused_by_name(bad):
    with pytest.raises(hl.InputError, match=r"AnisotropicCoulomb\.mu_[xy]"):
        hl.AnisotropicCoulomb(*bad)
