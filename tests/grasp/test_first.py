"""The first stage in one compiled call equals its steps one by one, to the bit; warm starts end where cold ones do."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.grasp.model.status import contact_words
from tests.grasp.scenes import cube_example, pinch, ring
from tests.support.steps import ByHand, first_found, newton_steps

SECTIONS = (4, 8, hl.Pyramid(6, inscribed=False), "cone")


def planar():
    contacts = [hl.Contact((-0.01, 0), (1, 0)), hl.Contact((0.01, 0.001), (-1, 0)), hl.Contact((0, -0.01), (0, 1))]
    return hl.Grasp(contacts, (0.2, -1.0, 0.001), flexibility=1e-4, preload=2e-4)


def scenes():
    rng = np.random.default_rng(5)
    for n, mu, shared in ((2, 0.6, False), (3, 0.5, True), (4, 0.0, True), (5, 0.6, True), (5, 0.3, False)):
        contacts, more = ring(rng, n, mu, shared=shared)
        yield hl.Grasp(contacts, **more)
    contacts, more = ring(rng, 3)
    rough = [hl.Contact(c.position, c.normal, hl.Frictionless() if k else None) for k, c in enumerate(contacts)]
    yield hl.Grasp(rough, **more)
    yield from (planar(), pinch(), cube_example())
    yield hl.Grasp(pinch().contacts, (0, 0, -0.1, 0, 0, 0))  # rigid fingers


GRASPS = tuple(scenes())


@pytest.mark.parametrize("faces", SECTIONS, ids=str)
def test_one_compiled_call_gives_the_bits_of_its_steps(faces):
    several = 0
    for g in GRASPS:
        found, steps = first_found(g, faces), ByHand(g, faces)
        steps.assemble()
        p, candidate, verdict = steps.solve(seed=0), steps.decode(), steps.certify()
        if found.escape is not None:  # it stops as soon as that is proven
            assert not verdict.residuals.passes
            assert g.solve(faces, throw=False).status is hl.Status.NOT_HOLDABLE
            continue
        np.testing.assert_array_equal(found.proposal.z, p.z)
        assert (found.outcome, found.iterations) == (p.outcome, p.iterations)
        np.testing.assert_array_equal(found.forces, candidate.forces)
        np.testing.assert_array_equal(found.twist, candidate.twist)
        np.testing.assert_array_equal(found.motion, verdict.motion)
        assert found.residuals == verdict.residuals
        assert found.passes == verdict.residuals.passes
        if found.passes:
            slow = steps.conclude()
            free = slow.uniqueness
            if found.unique:
                assert contact_words(found.states) == slow.contact_state
                assert free.forces_determined
                assert not free.loose_motions
            several += found.unique
    assert several >= 3


def test_from_the_last_answer_a_little_further_on_it_takes_no_more_steps():
    """Loads that turn slowly: warm starts reach the answer of cold ones, in fewer Newton steps."""
    rng = np.random.default_rng(2)
    contacts, more = ring(rng, 5, mu=0.4)
    wrench = np.array(more.pop("wrench"))
    base = hl.Grasp(contacts, wrench, **more)
    warm_steps, cold_steps, last = 0, 0, base.solve("cone")
    for k in range(1, 15):
        c, s = np.cos(0.05 * k), np.sin(0.05 * k)
        turned = wrench * 1.0
        turned[:2] = c * wrench[0] - s * wrench[1], s * wrench[0] + c * wrench[1]
        g = base.replace(wrench=turned)
        warm, cold = g.solve("cone", start=last), g.solve("cone")
        np.testing.assert_allclose(warm.forces, cold.forces, rtol=1e-8, atol=1e-9 * abs(cold.forces).max())
        warm_steps += newton_steps(warm.trace[0])
        cold_steps += newton_steps(cold.trace[0])
        last = warm
    assert cold_steps > 0
    assert warm_steps < 0.8 * cold_steps


@pytest.mark.parametrize(
    "solver", [None, hl.NSNGRK(), hl.SemismoothNewton(), hl.Lemke()], ids=lambda s: type(s).__name__
)
def test_a_start_changes_no_answer_whatever_the_solver(solver):
    g = GRASPS[3]
    s = g.solve(8)
    again = g.solve(8, solver, start=s)
    np.testing.assert_allclose(again.forces, s.forces, rtol=1e-7, atol=1e-8 * abs(s.forces).max())


def test_a_start_works_with_effects_asked_for_by_name():
    contacts, more = ring(np.random.default_rng(3), 4)
    free = hl.Grasp(contacts, **more).solve()
    bounded = hl.Grasp(contacts, effects=[hl.TotalForceBound(0.9 * free.normal_force.sum())], **more)
    cold = bounded.solve()
    np.testing.assert_allclose(bounded.solve(start=free).forces, cold.forces, rtol=1e-8)
    np.testing.assert_allclose(bounded.solve(start=cold).forces, cold.forces, rtol=1e-8)


def test_a_start_has_as_many_contacts():
    with pytest.raises(hl.InputError) as caught:
        pinch().solve(start=cube_example().solve())
    assert caught.value.argument == "start"
    assert "2" in caught.value.expected
    assert "3" in caught.value.got
