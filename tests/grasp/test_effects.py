"""A scene gets the effects it calls for, and no others: sizes, bits, and the catalogue's own account."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import cube_example, pinch, ring
from tests.support.effects import ENVIRONMENT, KINDS, kinds_in_the_catalogue, limits_kept, limits_of, page_of
from tests.support.grasp import arrays


def sizes(g, faces=8):
    return {u.name: (u.count, u.free) for u in g.problem(faces).groups}


def test_unknowns_follow_the_table_of_the_model():
    contacts, data = ring(np.random.default_rng(0), n=5)
    assert sizes(hl.Grasp(contacts, **data), 8) == {
        "r_N": (5, False), "λ": (40, False), "r_T": (10, True), "u": (6, True)
    }  # fmt: skip


def test_a_frictionless_contact_has_no_tangential_unknowns():
    contacts, data = ring(np.random.default_rng(0), n=5)
    contacts[1] = hl.Contact(contacts[1].position, contacts[1].normal, hl.Frictionless())
    contacts[3] = hl.Contact(contacts[3].position, contacts[3].normal, hl.Coulomb(0))
    assert sizes(hl.Grasp(contacts, **data), 6) == {
        "r_N": (5, False),
        "λ": (18, False),
        "r_T": (6, True),
        "u": (6, True),
    }


def test_a_planar_scene_has_three_object_unknowns_and_one_tangent_a_contact():
    contacts = [hl.Contact((np.cos(t), np.sin(t)), (-np.cos(t), -np.sin(t)), hl.Coulomb(0.4)) for t in (0, 2, 4)]
    g = hl.Grasp(contacts, (1, 0, 0), flexibility=1e-3)
    assert sizes(g, 64) == {"r_N": (3, False), "λ": (6, False), "r_T": (3, True), "u": (3, True)}


def test_a_prescribed_contact_has_no_unknowns():
    g = pinch(effects=[hl.PrescribedForce(0, (0, 0, 1.0))])
    assert sizes(g) == {"r_N": (1, False), "λ": (8, False), "r_T": (2, True), "u": (6, True)}


def test_a_bound_costs_one_unknown():
    assert sizes(pinch(effects=[hl.TotalForceBound(50)]))["z̄"] == (1, False)


def test_an_absent_bound_changes_no_bit():
    """The problem without it, and the same rows and columns of the problem with it."""
    plain, bounded = pinch(), pinch(effects=[hl.TotalForceBound(50)])
    a, b = plain.problem().scaled, bounded.problem().scaled
    keep = [k for k, name in enumerate(bounded.problem().labels) if not name.startswith("z̄")]
    np.testing.assert_array_equal(a.M, b.M[np.ix_(keep, keep)])
    np.testing.assert_array_equal(a.q, b.q[keep])


def test_zero_flexibility_stamps_nothing_and_no_friction_leaves_no_trace():
    contacts = [hl.Contact(p, (0, 0, 1), hl.Coulomb(0)) for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0))]
    zero = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0)).problem().scaled
    none = hl.Grasp([hl.Contact(c.position, c.normal, hl.Frictionless()) for c in contacts], (0, 0, -1, 0, 0, 0))
    np.testing.assert_array_equal(zero.M, none.problem().scaled.M)
    titles = [e.title for e in none.problem().effects]
    assert titles == ["object balance", "unilateral contact"]


def test_flexibility_at_zero_force_entries_is_not_read():
    """E of the tangents of a frictionless contact cannot matter."""
    contacts, data = ring(np.random.default_rng(0), n=4, mu=0)
    E = data["flexibility"].copy()
    tangents = [k for k in range(12) if k % 3 != 2]
    E[tangents] = 0
    E[:, tangents] = 0
    a = hl.Grasp(contacts, **data).problem()
    b = hl.Grasp(contacts, **(data | {"flexibility": E})).problem()
    np.testing.assert_array_equal(a.scaled.M != 0, b.scaled.M != 0)


def test_explain_accounts_for_every_unknown():
    g = cube_example()
    e = g.explain(8)
    assert e.unknowns == sum(line.cost for line in e.effects) == 39
    assert e.size == g.problem(8).n == 27
    on = {line.title for line in e.effects if line.on}
    off = {line.title for line in e.effects if not line.on}
    assert on == {"object balance", "unilateral contact", "Coulomb friction", "finger flexibility"}
    assert on | off == {*KINDS, ENVIRONMENT}
    assert "27" in str(e)


@pytest.mark.parametrize("effect", kinds_in_the_catalogue())
def test_every_effect_states_its_equation_on_top_of_its_file_and_all_that_the_catalogue_wants(effect):
    formulas = [line for line in page_of(effect).splitlines() if line.startswith("    ")]
    assert any(set(line) & set("=≤⟂") for line in formulas)
    assert all((effect.title, effect.equation, effect.when, effect.brings, effect.source))


def test_elimination_is_decided_by_condition_not_by_trying():
    assert cube_example().problem().eliminated
    two = pinch().problem()  # two hard fingers: nothing resists the spin, the free block is singular
    assert not two.eliminated
    assert two.rcond < 1e-7
    assert two.mixed
    smooth = hl.Grasp([hl.Contact((0, 0, 0), (0, 0, 1), hl.Frictionless())], flexibility=1e-3).problem()
    assert not smooth.eliminated


def test_the_problem_in_si_is_the_problem_in_natural_units():
    p = cube_example().problem()
    q = hl.LCP(p.M, p.q, p.free, units=p.scaled.units)
    np.testing.assert_allclose(q.scaled.M, p.scaled.M, rtol=1e-14)
    s = hl.solve_lcp(p)
    assert p.labels[:3] == ("r_N[0]", "r_N[1]", "r_N[2]")
    np.testing.assert_allclose(s.z[:3], [0.934263, 0.934263, 3.96422], rtol=2e-6)  # N


# ---------------------------------------------------------------- limits are made once a scene
@dataclass(frozen=True, eq=False)
class Counted(hl.TotalForceBound):
    """Counts how often its limits are made."""

    asked: list = field(default_factory=list)

    def limits(self, scene):
        self.asked.append(scene)
        return super().limits(scene)


@pytest.mark.parametrize("faces", [8, "cone"])
def test_a_solve_makes_limits_once_and_another_scene_its_own(faces):
    effect = Counted(12.0)
    g = pinch(effects=[effect])
    g.solve(faces)
    g.problem(faces)
    g.explain(faces)
    assert effect.asked == [arrays(g)]
    heavier = g.replace(wrench=(0, 0, -2.0, 0, 0, 0))
    heavier.solve(faces)
    assert effect.asked[1:] == [arrays(heavier)]


def test_equal_effects_on_one_scene_keep_their_own_limits_and_many_do_not_pile_up():
    g = pinch()
    for k in range(1, 100):
        for effect in (hl.TotalForceBound(float(k)), hl.TotalForceBound(float(k))):
            assert limits_of(effect, g)[0].room[0] == k
            assert limits_of(effect, g) is limits_of(effect, g)
    assert len(limits_kept(g)) <= 20


def test_limits_travel_with_their_scene_and_cannot_be_written_to():
    g = pinch(effects=[hl.FingerForceBound(6.0)])
    s = g.solve()
    again = pickle.loads(pickle.dumps(g))
    np.testing.assert_array_equal(again.solve().forces, s.forces)
    assert limits_kept(again)[0][0] is again.effects[0]
    (limit,) = limits_of(g.effects[0], g)
    with pytest.raises(ValueError, match="read-only"):
        limit.room[0] = 1.0
    with ThreadPoolExecutor(4) as pool:
        h = g.replace(preload=1e-3)
        answers = list(pool.map(lambda _: h.solve().forces, range(16)))
    for forces in answers:
        np.testing.assert_array_equal(forces, s.forces)
