"""The search over contact modes against an independent enumeration of all modes, closed forms, and the paper."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog

import handlcp as hl
from handlcp.grasp import Effect
from handlcp.grasp.model.equation_system import Unknown
from handlcp.studies.paper import PRELOAD, example
from tests.grasp.scenes import pinch, ring
from tests.support.grasp import arrays
from tests.support.search import applicable, searched
from tests.support.texts import says

C = 1e-4


def exists(g, m):
    """Whether some choice of modes has a point, by one linear program a choice; nothing of the search is used."""
    s, a = arrays(g), 2 * np.pi * np.arange(m) / m
    scale = np.trace(s.flexibility) / len(s.flexibility)
    f0 = max(np.abs(s.force).max(), 1e-9)
    G, E, d = s.grasp_matrix, s.flexibility / scale, s.offset.ravel() / (scale * f0)
    G = np.vstack([G[:3], G[3:] / s.units.length_unit])
    w = np.r_[s.wrench[:3], s.wrench[3:] / s.units.length_unit] / f0
    corner = lambda j: np.array([np.cos(a[j] + np.pi / m), np.sin(a[j] + np.pi / m)])  # noqa: E731
    face = lambda j: np.array([np.cos(a[j % m]), np.sin(a[j % m])])  # noqa: E731
    modes = [([], [(0, 0, 1)] + [(*t, 0) for t in ((1, 0), (-1, 0), (0, 1), (0, -1))])]
    modes += [([(*corner(j), 1) for j in range(m)], [])]
    modes += [([(*corner(j - 1), 1), (*corner(j), 1)], [(*-face(j), 0)]) for j in range(m)]
    modes += [([(*corner(j), 1)], [(*-face(j), 0), (*-face(j + 1), 0)]) for j in range(m)]
    for choice in itertools.product(modes, repeat=s.n):
        F, V = [], []
        for i, (force, motion) in enumerate(choice):
            for column in force:
                F.append(np.zeros(3 * s.n))
                F[-1][3 * i : 3 * i + 3] = np.array(column) * [s.mu[i], s.mu[i], 1]
            for column in motion:
                V.append(np.zeros(3 * s.n))
                V[-1][3 * i : 3 * i + 3] = column
        F, V = np.array(F).reshape(-1, 3 * s.n).T, np.array(V).reshape(-1, 3 * s.n).T
        A = np.block([[V, -E @ F, -G.T], [np.zeros((6, V.shape[1])), G @ F, np.zeros((6, 6))]])
        k = V.shape[1] + F.shape[1]
        if linprog(np.zeros(k + 6), A_eq=A, b_eq=np.r_[d, -w], bounds=[(0, None)] * k + [(None, None)] * 6).status == 0:
            return True
    return False


@pytest.mark.parametrize("seed", range(8))
def test_the_search_agrees_with_all_modes_one_by_one(seed):
    rng = np.random.default_rng(seed)
    contacts, data = ring(rng, n=2 if seed % 2 else 3, mu=0.5, preload=float(rng.choice([0.0, 1e-3, 0.01])))
    g = hl.Grasp(contacts, **data)
    m = 4 if seed % 2 else 3
    assert searched(g, m).outcome == ("solution" if exists(g, m) else "none")


@pytest.mark.parametrize("faces", [4, 6, 8, "cone"])
def test_example_4_has_no_equilibrium_and_one_with_preload(faces):
    r = searched(example(4).grasp, faces)
    assert r.outcome == "none"
    assert r.force_bound >= 1000
    assert searched(example(4, preload=5e-6).grasp, faces).outcome == "solution"
    # squeezed by fingers 1 and 2 alone, the pyramids of 4 and 6 faces are too narrow
    assert searched(example(4, preload=PRELOAD).grasp, faces).outcome == ("none" if faces in (4, 6) else "solution")


@pytest.mark.parametrize("faces", [4, 8, 16, "cone"])
def test_a_pinch_holds_up_to_its_friction_limit(faces):
    limit = 2 * 10.0 * 0.5 * (1.0 if faces == "cone" else np.cos(np.pi / faces))  # 10 N of squeeze, towards a face
    assert searched(pinch(load=(0, 0, -0.999 * limit)), faces).outcome == "solution"
    assert searched(pinch(load=(0, 0, -1.001 * limit)), faces).outcome == "none"


def test_planar_scenes_and_prescribed_forces():
    contacts = [hl.Contact((-1, 0), (1, 0), hl.Coulomb(0.5)), hl.Contact((1, 0), (-1, 0), hl.Coulomb(0.5))]
    held = hl.Grasp(contacts, (0, -9.0, 0), flexibility=C, preload=1e-3)
    assert searched(held, 8).outcome == "solution"
    assert searched(hl.Grasp(contacts, (0, -11.0, 0), flexibility=C, preload=1e-3), 8).outcome == "none"
    # finger 1 is told to push 10 N; finger 2 cannot but answer, with or without preload
    pushed = hl.Grasp(contacts, (0, -9.0, 0), flexibility=C, effects=[hl.PrescribedForce(0, (4.5, 0, 10.0))])
    up = hl.Grasp(contacts, (0, -9.0, 0), flexibility=C, effects=[hl.PrescribedForce(0, (-4.5, 0, 10.0))])
    assert {searched(pushed, 8).outcome, searched(up, 8).outcome} == {"solution", "none"}


# Methods of effects that are no limit alone: they move the contacts, bring an unknown, stamp a block, have a law
OWN = {
    "opening": lambda self, scene, extra: np.zeros(3 * scene.n),
    "unknowns": lambda self, scene: (Unknown("own", 1, False, "motion"),),
    "stamp": lambda self, scene, system: system.add_between_forces(np.eye(scene.kind.index.size)),
    "residual": lambda self, scene, forces, extra, force_size, motion_size: 0.0,
}


def effect_with(method):
    return type("Own", (Effect,), {method: OWN[method]})()


def test_an_effect_that_moves_contacts_by_more_than_its_limits_is_not_for_this_search():
    assert applicable((hl.TotalForceBound(5.0), hl.FingerForceBound(5.0), hl.TorqueSaturation()))
    assert not applicable((effect_with("opening"),))
    with pytest.raises(ValueError) as caught:  # noqa: PT011  its text is compared below
        searched(pinch(), 4, effect_with("opening"))
    says(str(caught.value), "impossible")


def test_no_work_is_no_claim():
    contacts, data = ring(np.random.default_rng(0), n=5)
    assert searched(hl.Grasp(contacts, **data), 16, work=1.0).outcome == "unknown"


@pytest.mark.parametrize("method", OWN)
def test_an_effect_with_anything_of_its_own_is_no_limit_alone(method):
    effect = effect_with(method)
    assert effect.stamps
    assert not effect.only_limits
    assert not applicable((hl.TotalForceBound(5.0), effect))


def test_laws_of_balance_contact_and_friction_are_known_to_every_search():
    problem = pinch().problem("cone")
    assert len(problem.effects) > 2
    assert all(effect.only_limits for effect in problem.effects)


@pytest.mark.parametrize("measure", ["force", "twist"])
def test_levers_belong_to_motions_alone(measure):
    with pytest.raises(hl.InputError, match="levers"):
        Unknown("own", 1, False, measure, (0.1,))
    with pytest.raises(hl.InputError, match="levers"):
        Unknown("own", 2, False, "motion", (0.1,))
    assert Unknown("own", 1, False, "motion", (0.1,)).levers == (0.1,)
