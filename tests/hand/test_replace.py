"""`grasp.replace(x=…)` of a hand is the grasp made afresh with that argument, to the last bit."""

import copy
import pickle

import numpy as np
import pytest

import handlcp as hl
from tests.support.grasp import arrays
from tests.support.refusals import refused
from tests.support.texts import says

G = 9.81
BOX = hl.Box(0.05, (0, 0, 0.08), 0.2)
TIPS = ("finger_1_tip", "finger_2_tip", "finger_3_tip")
TABLE = hl.Table((0, 0, 0.055), friction=0.3, flexibility=1e-3)
ASKED = {
    "friction": {"finger_1_tip": hl.SoftFinger(0.8, 0.004), "finger_2_tip": 0.7, "finger_3_tip": 0.9},
    "wrench": (0.1, 0, -0.2, 0, 0.001, 0), "gravity": (0, 0, -G), "preload": 1e-4, "squeeze": 4e-3,
    "finger_weight": True, "environment": TABLE, "effects": [hl.FingerForceBound([50.0] * 3)],
}  # fmt: skip
OTHER = {
    "friction": [0.5, hl.Coulomb(0.6), hl.SoftFinger(0.5, 0.003), {t: 0.4 for t in TIPS}],
    "gravity": [(0, 0, -1.62), (G, 0, 0), (0, 0, 0)],
    "preload": [0.0, 2e-3, (1e-3, 2e-3, 3e-3)],
    "offset": [np.full((3, 3), -1e-4), np.full((7, 3), 1e-5)],
    "squeeze": [0.0, 1e-3, {"finger_2_tip": 2e-3}],
    "grip_force": [3.0, (1.0, 2.0, 3.0)],
    "joint_offset": [[0.01] * 6, {"finger_1_distal": 0.02}],
    "finger_weight": [False, "torques"],
    "environment": [hl.Table((0, 0, 0.055), friction=hl.Frictionless()), TABLE.under(BOX)],
    "effects": [[], hl.TotalForceBound(80.0), [hl.SoftWrist([1e-4] * 3 + [0.1] * 3)]],
    "max_gap": [1e-6, 5e-3],
}  # fmt: skip
CASES = [(name, k) for name, values in OTHER.items() for k in range(len(values))]
WRENCHES = {"squeeze", "grip_force", "joint_offset"}


@pytest.fixture(scope="module")
def state():
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4)
    return hand.at(hand.close_on(BOX))


@pytest.fixture(scope="module")
def grasp(state):
    return state.grasp(BOX, **ASKED)


def afresh(state, target=BOX, **changes):
    """The grasp with these arguments; a command takes the place of another."""
    kept = {name: x for name, x in ASKED.items() if not (name in WRENCHES and WRENCHES & set(changes))}
    return state.grasp(target, **(kept | changes))


def assert_same(a, b, solve=False):
    """The same bits: what was asked, what was built, what the joints do, and the answer."""
    for part in ("positions", "frames", "wrench", "reference", "flexibility", "offset"):
        np.testing.assert_array_equal(getattr(a.spec, part), getattr(b.spec, part), err_msg=part)
    assert [type(e) for e in a.spec.effects] == [type(e) for e in b.spec.effects]
    assert [c.friction for c in a.contacts] == [c.friction for c in b.contacts]
    assert a.names == b.names
    for part in ("flexibility", "offset", "force", "moment", "mu"):
        np.testing.assert_array_equal(getattr(arrays(a), part), getattr(arrays(b), part), err_msg=part)
    for part in ("jacobian", "gravity_torque", "joint_offset", "given_gravity"):
        np.testing.assert_array_equal(getattr(a, part), getattr(b, part), err_msg=part)
    assert (a.target is None) == (b.target is None)
    assert [str(r) for r in a.out_of_reach] == [str(r) for r in b.out_of_reach]
    if solve:
        quick = hl.Auto(search_seconds=0.0)
        one, other = (g.solve(solver=quick, throw=False, proof=False) for g in (a, b))
        np.testing.assert_array_equal(one.forces, other.forces)
        np.testing.assert_array_equal(one.torques, other.torques)


@pytest.mark.parametrize(("name", "k"), CASES, ids=[f"{name} {k}" for name, k in CASES])
def test_it_is_the_grasp_made_with_that_argument(state, grasp, name, k):
    assert_same(grasp.replace(**{name: OTHER[name][k]}), afresh(state, **{name: OTHER[name][k]}), solve=k == 0)


@pytest.mark.parametrize("name", OTHER)
def test_after_other_changes_copies_and_pickles_too(state, grasp, name):
    between = pickle.loads(pickle.dumps(copy.copy(grasp.replace(mass=0.3, preload=3e-4))))
    heavier = hl.Box(0.05, (0, 0, 0.08), 0.3)
    expected = {"preload": 3e-4} | {name: OTHER[name][0]}
    assert_same(between.replace(**{name: OTHER[name][0]}), afresh(state, heavier, **expected))


def test_of_nothing_and_of_the_value_that_it_has_it_is_the_same_grasp(grasp):
    assert_same(grasp.replace(), grasp, solve=True)
    for name, value in (ASKED | {"wrench": grasp.spec.wrench, "mass": 0.2, "object": BOX}).items():
        assert_same(grasp.replace(**{name: value}), grasp)


def test_fingers_leave_and_come_back(state):
    grasp = state.grasp(BOX, friction=0.7, squeeze=4e-3, environment=TABLE)
    two = grasp.replace(fingers=TIPS[:2])
    assert_same(two, state.grasp(BOX, friction=0.7, squeeze=4e-3, environment=TABLE, fingers=TIPS[:2]))
    assert_same(two.replace(fingers=TIPS), grasp)


def test_a_mapping_of_frictions_leaves_the_others_theirs(state, grasp):
    changed = grasp.replace(friction={"finger_2_tip": 0.2})
    assert_same(changed, afresh(state, friction=ASKED["friction"] | {"finger_2_tip": 0.2}))
    fewer = changed.replace(fingers=TIPS[1:], effects=())
    assert [c.friction for c in fewer.contacts[:2]] == [hl.Coulomb(0.2), hl.Coulomb(0.9)]
    with pytest.raises(hl.UnknownName):
        grasp.replace(friction={"thumb": 0.2})


def test_mass_and_gravity_change_the_weight_beside_what_was_given(state, grasp):
    """Newton's law: the load is what was given and m g at the centre of mass."""
    given = np.array(ASKED["wrench"])
    np.testing.assert_array_equal(grasp.replace(mass=1.5).spec.wrench, given + np.array([0, 0, -1.5 * G, 0, 0, 0]))
    np.testing.assert_array_equal(grasp.replace(gravity=(1, 0, 0)).spec.wrench, given + np.array([0.2, 0, 0, 0, 0, 0]))
    np.testing.assert_array_equal(grasp.replace(mass=0).spec.wrench, given)
    assert_same(grasp.replace(mass=1.5), afresh(state, hl.Box(0.05, (0, 0, 0.08), 1.5)), solve=True)


def test_a_wrench_is_the_whole_load_and_a_weight_changes_beside_it(grasp):
    whole = np.array([0.3, 0, -5.0, 0, 0, 0.01])
    lifted = grasp.replace(wrench=whole)
    np.testing.assert_array_equal(lifted.spec.wrench, whole)
    np.testing.assert_array_equal(lifted.replace(squeeze=1e-3).spec.wrench, whole)
    np.testing.assert_allclose(lifted.replace(mass=1.2).spec.wrench, whole - [0, 0, G, 0, 0, 0], rtol=1e-14)
    for weighing in ({"mass": 1.0}, {"gravity": (0, 0, -1)}, {"object": BOX}):
        error = refused("wrench", grasp.replace, wrench=whole, **weighing)
    says(str(error), "included")


def test_a_wrench_that_leaves_the_weight_out_says_so_where_the_grasp_is_judged(grasp):
    """The weight is 0.2 × 9.81 N; a wrench that includes it needs no word."""
    push, weight = np.array([0, 0.1, 0, 0, 0, 0]), np.array([0, 0, -0.2 * G, 0, 0, 0])
    alone, both = grasp.replace(wrench=push), grasp.replace(wrench=push + weight)
    (note,) = alone.solve().verdict.about("weight_left_out")
    says(note.sentence, "1.96 N", "load=")
    assert note.severity == "note"
    assert alone.check().about("weight_left_out") == (note,)
    assert note.sentence in " ".join(str(alone.explain()).split())
    for other in (both, grasp.replace(load=push), alone.replace(load=push)):
        assert not other.solve().verdict.about("weight_left_out")
        assert "left out" not in str(other.explain())


def test_a_load_is_besides_the_weight_as_the_wrench_of_a_fresh_grasp(state, grasp):
    load = (0.3, 0, -5.0, 0, 0, 0.01)
    assert_same(grasp.replace(load=load), afresh(state, wrench=load), solve=True)
    heavy, moon = hl.Box(0.05, (0, 0, 0.08), 0.4), (0, 0, -1.62)
    changed = grasp.replace(load=load, mass=0.4, gravity=moon, squeeze=3e-3)
    assert_same(changed, afresh(state, heavy, wrench=load, gravity=moon, squeeze=3e-3))
    assert_same(grasp.replace(load=load, object=heavy), afresh(state, heavy, wrench=load))
    assert_same(changed.replace(load=(0, 0, 0, 0, 0, 0)).replace(load=load), changed)
    off = state.grasp(BOX, reference=(0.01, 0, 0.05), squeeze=4e-3)
    assert_same(off.replace(load=load), state.grasp(BOX, reference=(0.01, 0, 0.05), squeeze=4e-3, wrench=load))


def test_another_object_is_looked_for_and_so_is_the_table_under_it(state, grasp):
    wider = hl.Box(0.0502, (0, 0, 0.0801), 0.4)
    assert_same(grasp.replace(object=wider, max_gap=2e-3), afresh(state, wider, max_gap=2e-3), solve=True)
    with pytest.raises(hl.NotReached):
        grasp.replace(object=hl.Box(0.03, (0, 0, 0.08), 0.4))
    heavy = grasp.replace(object=wider, mass=2.0)
    assert heavy.target.mass == 2.0
    assert wider.mass == 0.4


def test_given_contacts_become_an_object_and_have_no_mass(state):
    contacts = state.grasp(BOX, friction=0.5).contacts
    given = state.grasp(contacts, preload=1e-3, gravity=(0, 0, -G))
    rough = [c.with_friction(hl.Coulomb(0.8)) for c in contacts]
    assert_same(given.replace(friction=0.8), state.grasp(rough, preload=1e-3))
    one = given.replace(friction={"finger_3_tip": hl.Frictionless()})
    assert [c.friction for c in one.contacts] == [hl.Coulomb(0.5), hl.Coulomb(0.5), hl.Frictionless()]
    assert_same(given.replace(object=BOX), state.grasp(BOX, preload=1e-3))
    outer = dict(zip(TIPS[::2], contacts[::2], strict=True))
    assert_same(given.replace(fingers=TIPS[::2]), state.grasp(outer, preload=1e-3))
    error = refused("mass", given.replace, mass=1.0)
    says(str(error), "weight")
    back = state.grasp(BOX, friction=0.9).replace(object=contacts)
    assert_same(back, state.grasp(contacts))


def test_a_flexibility_stays_whatever_else_changes(state, grasp):
    hard = grasp.replace(friction=0.8, flexibility=1e-4)
    for other in (hard, hard.replace(mass=1.0), hard.replace(squeeze=1e-3), hard.replace(fingers=TIPS[:2], effects=())):
        k = 3 * len(other.fingertips)
        np.testing.assert_array_equal(other.flexibility[:k, :k], 1e-4 * np.eye(k))
        np.testing.assert_array_equal(other.flexibility[k:, k:], np.eye(12) * 1e-3)


def test_effects_environment_and_weights_are_taken_away(state, grasp):
    nothing = {"effects": (), "environment": (), "finger_weight": False, "joint_offset": {}, "preload": 0, "mass": 0}
    bare, light = grasp.replace(gravity=(0, 0, 0), **nothing), hl.Box(0.05, (0, 0, 0.08))
    assert_same(bare, state.grasp(light, ASKED["friction"], ASKED["wrench"], gravity=(0, 0, 0)))
    assert bare.effects == ()
    assert len(bare.contacts) == 3


def test_what_was_passed_may_change_afterwards(state):
    load, friction = np.array([0, 0, -1.0, 0, 0, 0]), {"finger_1_tip": 0.4}
    grasp = state.grasp(BOX, friction, load, effects=(e for e in [hl.TotalForceBound(60.0)]))
    load[:], friction["finger_2_tip"] = 7.0, 0.1
    again = grasp.replace(squeeze=1e-3)
    np.testing.assert_array_equal(again.spec.wrench, grasp.spec.wrench)
    assert [c.friction.mu for c in again.contacts] == [0.4, 0.6, 0.6]
    assert len(again.effects) == 1


def test_where_a_stream_is_its_grasp_can_be_changed(state):
    """Of which a specification alone is known: the contacts stay where they are."""
    settings = {"friction": 0.7, "preload": 2e-3, "environment": TABLE}
    grasp = state.grasp(BOX, **settings)
    now = hl.GraspStream(grasp).grasp
    for change in ({"friction": 0.5}, {"squeeze": 2e-3}, {"mass": 1.0}, {"finger_weight": True}, {"environment": ()}):
        mine, made = now.replace(**change), grasp.replace(**change)
        for part in ("positions", "frames", "flexibility", "offset", "force", "moment", "mu"):
            expected = getattr(arrays(made), part)
            np.testing.assert_allclose(getattr(arrays(mine), part), expected, atol=1e-15 + 1e-12 * abs(expected).max())
    assert_same(now.replace(object=BOX, offset=np.zeros((3, 3)), preload=2e-3), grasp)


def test_a_mesh_is_not_read_again(state, tmp_path):
    path = tmp_path / "cube.stl"
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box((0.05, 0.05, 0.05)).export(path)
    mesh = hl.Mesh(path, placement=(0, 0, 0.08), mass=0.2)
    grasp = state.grasp(mesh)
    path.unlink()
    heavier = grasp.replace(mass=1.0)
    assert heavier.target.mass == 1.0
    moved = heavier.target.moved_to((0, 0, 1))
    np.testing.assert_allclose(moved.center_of_mass, [0, 0, 1], atol=1e-9)
    np.testing.assert_allclose(mesh.center_of_mass, [0, 0, 0.08], atol=1e-9)
