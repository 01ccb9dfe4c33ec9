"""A scene gets the effects it calls for, and no others: sizes, bits, and the catalogue's own account."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import cube_example, pinch
from tests.support.effects import ENVIRONMENT, KINDS, limits_kept, limits_of
from tests.support.grasp import arrays


def sizes(g, faces=8):
    return {u.name: (u.count, u.free) for u in g.problem(faces).groups}


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
