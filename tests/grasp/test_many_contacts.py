"""Many contacts: E as a factor gives what E as a matrix gives, whatever the order of the contacts and the units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError
from tests.support.grasp import at_centre, candidate, residuals
from tests.support.power import STRONG, WEAK, PowerGrasp, power_grasp

SEEDS = {10: 2, 17: 1, 30: 0}
EVERY = [(n, k, mu) for n, k in SEEDS.items() for mu in (WEAK, STRONG)]


def flexibility(g: PowerGrasp, pads=None) -> hl.Flexibility:
    own = g.pads[:, None, None] * np.eye(3) if pads is None else pads
    return hl.Flexibility(g.jacobian, np.diag(g.stiffness**-0.5), own)


def agree(a, b, order=slice(None), forces=1.0, motions=1.0):
    """Whether b is the same answer as a, in another order of contacts and other units."""
    assert a.held
    assert b.held
    size = abs(a.forces).max()
    assert abs(a.forces[order] - b.forces / forces).max() < 1e-9 * size
    far = max(abs(a.slip).max(), abs(a.gap).max())
    assert abs(a.gap[order] - b.gap / motions).max() < 1e-9 * far
    assert abs(a.slip[order] - b.slip / motions).max() < 1e-9 * far
    moved = abs(a.object_displacement - b.object_displacement / motions)
    assert moved.max() < 1e-9 * abs(a.object_displacement).max()
    assert tuple(np.array(a.contact_state)[order]) == b.contact_state
    free_a, free_b = a.uniqueness, b.uniqueness
    assert free_a.loose_motions == free_b.loose_motions
    assert free_a.forces_determined == free_b.forces_determined


@pytest.mark.parametrize(("n", "seed", "mu"), EVERY)
@pytest.mark.parametrize("faces", ["cone", 8])
def test_a_factor_gives_what_the_matrix_gives(n, seed, mu, faces):
    g = power_grasp(n, seed, mu, loaded=False)
    agree(g.as_matrix().solve(faces), g.factored().solve(faces))


@pytest.mark.parametrize(("n", "seed", "mu"), EVERY)
def test_the_certifier_agrees_with_the_matrix(n, seed, mu):
    """Forces found and certified by the factor pass the certifier that reads E as a matrix."""
    g = power_grasp(n, seed, mu, loaded=False)
    s = g.factored().solve()
    dense = g.dense()
    again = residuals(dense, "cone", candidate(s.forces, at_centre(dense, s.object_displacement)))
    assert again.passes
    assert abs(again.force_scale - s.residuals.force_scale) < 1e-9 * s.residuals.force_scale
    assert abs(again.motion_scale - s.residuals.motion_scale) < 1e-6 * s.residuals.motion_scale


def test_order_of_contacts():
    g = power_grasp(17, 1, STRONG)
    order = np.random.default_rng(0).permutation(17)
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    other = replace(g, contacts=tuple(g.contacts[i] for i in order), jacobian=g.jacobian[rows], pads=g.pads[order])
    agree(g.factored().solve(), other.factored().solve(), order)


@pytest.mark.parametrize(("forces", "softer"), [(1e3, 1.0), (1e-3, 1e2), (1.0, 1e-4)])
def test_units(forces, softer):
    """Loads and commands in other units: E as much softer, all motions by both."""
    g = power_grasp(17, 1, STRONG)
    other = replace(
        g, stiffness=g.stiffness / softer, pads=g.pads * softer, command=g.command * softer * forces,
        wrench=g.wrench * forces
    )  # fmt: skip
    agree(g.factored().solve(), other.factored().solve(), forces=forces, motions=softer * forces)


def test_a_start_leads_to_the_same_answer():
    g = power_grasp(17, 1, STRONG)
    near = replace(g, wrench=g.wrench * 0.98).factored().solve()
    begun = g.factored().solve(start=near)
    agree(g.factored().solve(), begun)
    assert begun.iterations == 0


@pytest.mark.parametrize("way", ["rigid pads", "one pad rigid along its normal", "no friction at some", "soft finger"])
def test_what_cannot_be_eliminated_goes_the_other_way(way):
    g = power_grasp(12, 2, STRONG, loaded=False)
    pads = g.pads[:, None, None] * np.eye(3)
    if way == "rigid pads":
        pads = np.zeros_like(pads)
    elif way == "one pad rigid along its normal":
        pads[3, 2] = 0.0
    else:
        law = hl.Frictionless() if way == "no friction at some" else hl.SoftFinger(0.6, 0.003)
        g = replace(g, contacts=tuple(c.with_friction(law) if i % 3 else c for i, c in enumerate(g.contacts)))
    E = flexibility(g, pads)
    a = hl.Grasp(g.contacts, g.wrench, flexibility=E.matrix, offset=g.offset).solve(throw=False)
    b = hl.Grasp(g.contacts, g.wrench, flexibility=E, offset=g.offset).solve(throw=False)
    assert a.status == b.status
    if a.held and way != "rigid pads":
        agree(a, b)


@pytest.mark.parametrize("effect", [hl.SoftWrist([1e-5] * 3 + [0.01] * 3), hl.TotalForceBound(1e4)])
def test_effects_beside_a_factor(effect):
    g = power_grasp(12, 2, STRONG, loaded=False)
    a = hl.Grasp(g.contacts, g.wrench, flexibility=g.flexibility, offset=g.offset, effects=[effect])
    b = hl.Grasp(g.contacts, g.wrench, flexibility=flexibility(g), offset=g.offset, effects=[effect])
    agree(a.solve(), b.solve())


def test_a_flexibility_of_other_contacts_is_refused():
    g, other = power_grasp(12, 2, STRONG), power_grasp(10, 2, STRONG)
    with pytest.raises(InputError, match="flexibility"):
        hl.Grasp(g.contacts, g.wrench, flexibility=flexibility(other), offset=g.offset)
