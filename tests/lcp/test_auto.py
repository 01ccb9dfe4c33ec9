"""The default chain: it does what it says it would, in that order, with equal seeds the same bits."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.lcp import ContactProblem, proposals
from handlcp.lcp.solver import OtherStarts, scale_by_limits as in_units_of_limits
from tests.grasp.scenes import pinch, ring as make_ring
from tests.lcp.problems import random_p
from tests.support.grasp import contact_problem
from tests.support.lcp import certified, solves_contact
from tests.support.texts import says

AUTO = hl.Auto(restarts=2)


def ring(n, mu=0.6, seed=0, **more):
    """A grasp of n fingers."""
    contacts, rest = make_ring(np.random.default_rng(seed), n, mu)
    return hl.Grasp(contacts, **(rest | more))


def follows(trace, plan):
    """Whether the trace's names are those of the plan, in order."""
    i = 0
    for line in trace:
        name = line.split(": ")[0]
        if name not in plan[i:]:
            return False
        i = plan.index(name, i) + 1
    return True


def everything(chain):
    """(name, candidate) of all stages, as if the certifier refused them all."""
    return list(chain)


GRASPS = {
    "easy": ring(4),
    "frictionless": ring(3, mu=0.0),
    "slippery": ring(6, mu=0.05),
    "beyond friction": pinch(load=(0, 0, -20.0)),
    "no squeeze": ring(4, preload=0.0, seed=3),
}


@pytest.mark.parametrize("faces", [4, 8, 32, "cone"])
@pytest.mark.parametrize("name", GRASPS)
def test_a_grasp_is_solved_as_planned(name, faces):
    grasp = GRASPS[name]
    chain = hl.Auto(search_work=1e8, search_seconds=9.0)
    plan = grasp.plan(faces, chain)
    says(plan[0], "NSNGRK")
    assert plan[1:3] == ("holdability", "search, briefly")
    assert plan[-1] == "search, 100 million multiply-adds or 9 s at most"
    assert follows(grasp.solve(faces, chain, throw=False).trace, plan)


@pytest.mark.parametrize("seed", range(6))
def test_an_lcp_is_solved_as_planned(seed):
    rng = np.random.default_rng(seed)
    M = rng.normal(size=(6, 6))
    p = hl.LCP(M, rng.normal(size=6))
    assert follows(hl.solve_lcp(p, AUTO, throw=False).trace, AUTO.plan(p))


@pytest.mark.parametrize("faces", [4, 8, 32, "cone"])
def test_all_stages_run_in_the_order_of_the_plan(faces):
    p = ring(4).problem(faces)
    chain = AUTO.contact_stages(p) if isinstance(p, ContactProblem) else AUTO.stages(p)
    names = [name for name, _ in everything(chain)]
    proofs = ("holdability", "search, briefly", "search, longer")  # the grasp's own
    plan = tuple(name for name in AUTO.plan(p) if name not in proofs)
    assert tuple(names) == plan[: len(names)]
    last = ["search"] if isinstance(p, ContactProblem) else ["Farkas vector", "search"]
    assert [name.partition(",")[0] for name in plan[len(names) :]] == last


@pytest.mark.parametrize("faces", [4, 8, "cone"])
def test_every_stage_alone_solves_an_easy_grasp(faces):
    p = ring(5).problem(faces)
    if not isinstance(p, ContactProblem):
        p = p.contact
    missed = [name for name, s in everything(AUTO.contact_stages(p)) if not solves_contact(p, s.z)]
    assert not missed


def test_every_stage_alone_solves_an_easy_lcp():
    M, q = random_p(np.random.default_rng(0), 8)
    p = hl.LCP(M, q)
    for name, s in everything(AUTO.stages(p)):
        assert certified(p, s.z), name


@pytest.mark.parametrize("faces", [4, 8, "cone"])
def test_the_same_seed_gives_the_same_bits(faces):
    p = ring(6, mu=0.05).problem(faces)
    if not isinstance(p, ContactProblem):
        p = p.contact
    one, two = everything(AUTO.contact_stages(p)), everything(AUTO.contact_stages(p))
    for (name, a), (again, b) in zip(one, two, strict=True):
        assert name == again
        np.testing.assert_array_equal(a.z, b.z, err_msg=name)


# ---------------------------------------------------------------- the stages that are solvers of their own


def test_units_of_limits_are_a_change_of_variables():
    p = ring(4).problem("cone")
    q, s = in_units_of_limits(p)
    np.testing.assert_allclose(q.limits, 1.0)
    x = np.random.default_rng(0).normal(size=p.n)
    np.testing.assert_allclose(q.M @ (x / s) + q.q, s * (p.M @ x + p.q), atol=1e-12)
    z = hl.NSNGRK().propose_contact(q).z
    assert solves_contact(p, s * z)


def test_other_starts_find_what_one_start_does_not():
    """Some problems without structure that Newton's method misses from zero."""
    found = 0
    for i in range(20):
        rng = np.random.default_rng([77, i])
        M = rng.normal(size=(12, 12))
        z = np.where(rng.random(12) < 0.5, rng.uniform(0.5, 2, 12), 0.0)
        p = hl.LCP(M, np.where(z > 0, 0.0, rng.uniform(0.5, 2, 12)) - M @ z).scaled
        if hl.SemismoothNewton().propose(p).outcome != "converged":
            found += OtherStarts().propose(p).outcome.startswith("converged")
    assert found >= 5


def test_stalled_kaczmarz_steps_end_within_their_budget():
    """Steps that make no progress must not be asked for in batches that double until an integer overflows."""
    from tests.hard_cases.test_families import FAMILIES

    case = list(FAMILIES["flexibility: apart"][1](4, 30))[29]
    for name, proposal in proposals(contact_problem(case.grasp(), 4)):
        assert proposal.iterations < 10**7, name
