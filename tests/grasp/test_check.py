"""`grasp.check()` of grasps without a hand: the order of loading, and equilibria besides the one that is reached."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import ring
from tests.support.texts import same, says

MU, N, C = 0.5, 10.0, 1e-4


def pinch(load=(0.0, 0.0, -1.0), mu=MU, squeeze=N * C, effects=()):
    """Two fingers that squeeze with 10 N."""
    contacts = [hl.Contact((side, 0, 0), (-side / 0.03, 0, 0), hl.Coulomb(mu)) for side in (-0.03, 0.03)]
    return hl.Grasp(contacts, (*load, 0, 0, 0), flexibility=C, preload=squeeze, effects=effects)


@pytest.mark.parametrize("share", [0.99, 1.01, 2.0])
def test_a_pinch_is_lost_where_friction_gives_out(share):
    v = pinch(load=(0, 0, -share * 2 * MU * N)).check()
    assert v.word == ("HELD" if share < 1 else "NOT HELD")
    if share > 1:
        assert v.about("lost")[0].values["share"] == pytest.approx(1 / share, rel=2e-3)


def test_loaded_before_it_is_squeezed_the_object_is_lost_at_once():
    grasp = pinch()
    assert grasp.check().ok
    v = grasp.check(order=("load", "squeeze"))
    (lost,) = v.about("lost")
    assert (v.word, lost.values["stage"], lost.values["share"]) == ("NOT HELD", "load", 0.0)


def test_a_bare_grasp_knows_no_geometry_and_is_told_of_large_motions():
    """With all its fingers soft along the load, 0.1 m/N, the object sinks by 25 mm on a grasp of 30 mm."""
    v = pinch(load=(0, 0, -0.5)).replace(flexibility=(0.1, 0.1, C)).check()
    (found,) = v.about("large_motion")
    assert found.values["move_m"] == pytest.approx(0.025, rel=1e-6)
    assert found.values["force_error"] == pytest.approx(0.025 / 0.03, rel=1e-6)


def test_what_is_advised_is_enough_and_no_more_than_was_asked_about():
    pull = 1.3 * 2 * MU * N
    v = pinch(load=(0, 0, -pull)).check()
    advice = {r.values["change"]: r.values["value"] for r in v.about("advice")}
    assert advice["friction"] == 0.8, "0.65 is needed, and the next that is tried is 0.8"
    assert pinch(load=(0, 0, -pull), squeeze=N * C + advice["squeeze"]).check().ok
    assert advice["squeeze"] <= 0.2 * 0.03
    same("grasp/test_check: advice", "; ".join(r.sentence for r in v.about("advice")))


def test_nothing_but_friction_helps_where_nothing_balances_the_load():
    contacts = [hl.Contact((side, 0, 0), (-side / 0.03, 0, 0), hl.Frictionless()) for side in (-0.03, 0.03)]
    v = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=C, preload=1e-3).check()
    assert v.reasons[0].code == "not_holdable"
    assert not v.about("advice"), "no squeeze is advised to fingers that are smooth"


@pytest.mark.parametrize(("seed", "several"), [(29, True), (78, True), (1, False), (3, False), (5, False)])
def test_other_equilibria_are_mentioned_where_they_are_found(seed, several):
    """Of random rings of three fingers; `equilibria` solves all choices of contact modes one by one."""
    rng = np.random.default_rng(seed)
    contacts, data = ring(rng, n=3, mu=0.5, preload=float(rng.choice([0.0, 1e-3, 0.01])))
    g = hl.Grasp(contacts, **data)
    s = g.solve(4, throw=False)
    said, every = g.check(faces=4, solution=s, max_slip=np.inf).about("others"), g.equilibria(4)
    assert bool(said) is (len(every) > 1) is several
    if several:
        apart = max(np.linalg.norm(e.forces - s.forces, axis=1).max() for e in every)
        assert said[0].values["forces_differ"] * np.linalg.norm(s.forces, axis=1).max() == pytest.approx(
            apart, rel=1e-6
        )
        says(said[0].sentence, "equilibria()")
