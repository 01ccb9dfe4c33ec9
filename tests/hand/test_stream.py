"""A stream's answers are those of a grasp made anew, and it keeps no more memory than one of them."""

import copy
import gc
import pickle
import tracemalloc

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand import example_hand
from tests.support.grasp import arrays

BALL = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
PINCH = [hl.Contact((-0.01, 0, 0), (1, 0, 0)), hl.Contact((0.01, 0, 0), (-1, 0, 0))]


@pytest.fixture(scope="module")
def five():
    """The five-finger hand with springs that let it hold the ball."""
    return example_hand("five_finger", joint_stiffness=5.0)


QUICK = hl.Auto(search_seconds=0)


def followed(hand, **more):
    """A grasp by given contacts: those that a ball has."""
    q = hand.close_on(BALL, squeeze=3e-3)
    seen = hand.at(q).grasp(BALL, hl.Coulomb(0.6))
    load = np.array([*arrays(seen).force, 0, 0, 0])
    fixed = {"offset": seen.offset, "reference": seen.reference} | more
    return q, load, lambda q, w: hand.at(q).grasp(seen.contacts, wrench=w, **fixed)


def walk(q, load, steps, seed=0, size=3e-3, pull=1.0):
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        q = q + rng.normal(size=len(q)) * size
        yield q, load + pull * rng.normal(size=6) * (0.2, 0.2, 0.2, 4e-3, 4e-3, 4e-3)


def same(update, solution):
    assert update.held == solution.held
    if not update.held:
        return
    size = abs(solution.forces).max()
    for name, scale in (("forces", size), ("forces_world", size), ("torques", abs(solution.torques).max())):
        np.testing.assert_allclose(getattr(update, name), getattr(solution, name), atol=1e-8 * scale)
    travel = max(abs(solution.object_displacement).max(), abs(solution.slip).max())
    for name in ("gap", "slip", "object_displacement"):
        np.testing.assert_allclose(getattr(update, name), getattr(solution, name), atol=1e-7 * travel)
    assert update.contact_state == solution.contact_state
    assert update.torque_check.binding == solution.torque_check.binding


@pytest.mark.parametrize("faces", [8, "cone"])
def test_a_stream_follows_posture_and_load(five, faces):
    q, load, grasp = followed(five)
    stream, states, last, fallen = hl.GraspStream(grasp(q, load), faces), set(), None, 0
    for posture, wrench in walk(q, load, 40, pull=3.0):
        # Where friction allows several equilibria, the start says which one comes out
        solution = grasp(posture, wrench).solve(faces, QUICK, throw=False, start=last)
        update = stream.update(posture, wrench=wrench)
        if len(solution.trace) > 1 and not update.held:  # the first stage, which is all that a stream has, fails
            last, fallen = None, fallen + 1
            continue
        same(update, solution)
        states |= set(update.contact_state)
        last = solution
    assert {"sticking", "sliding"} <= states
    assert fallen < 14


A = np.random.default_rng(0).normal(size=(10, 10))
CURL = np.kron(np.eye(5), [[1.0], [0.6]])
FOOT = hl.Environment([hl.Contact((0, 0, 0.055), (0, 0, 1), hl.Coulomb(0.3))], 1e-3, -1e-4)
KINDS = {
    "weight, full springs": (4 * np.eye(10) + 0.1 * (A @ A.T), 1e-4, {"finger_weight": True}),
    "weight, anisotropic pads": (5.0, (3e-4, 2e-4, 1e-4), {"finger_weight": True}),
    "a command, tendons": (hl.Tendons(0.01 * A[:4], 3e4, 4.0), 1e-4, {"joint_offset": np.full(10, 0.005)}),
    "a support, synergies": (hl.Synergies(CURL, 5.0, 20.0), 1e-4, {"environment": FOOT}),
}


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_and_answers_of_a_stream_are_those_of_a_grasp_made_anew(kind):
    springs, pads, more = KINDS[kind]
    hand = example_hand("five_finger", joint_stiffness=springs, pad_flexibility=pads)
    q, load, grasp = followed(hand, **more)
    stream = hl.GraspStream(grasp(q, load))
    for posture, wrench in walk(q, load, 4):
        update = stream.update(posture, wrench=wrench)
        now, made = stream.grasp, grasp(posture, wrench)
        for name in ("flexibility", "force", "moment", "offset", "positions"):
            wanted = getattr(arrays(made), name)
            np.testing.assert_allclose(getattr(arrays(now), name), wanted, atol=1e-12 * abs(wanted).max())
        np.testing.assert_allclose(now.jacobian, made.jacobian, atol=1e-15)
        np.testing.assert_allclose(now.gravity_torque, made.gravity_torque, atol=1e-15)
        if update.held:
            same(update, made.solve(throw=False, start=now.solve(start=update)))
    assert update.held


def test_contacts_that_roll(five):
    q, load, grasp = followed(five)
    g = grasp(q, load)
    stream = hl.GraspStream(g)
    turn = hl.Contact((0, 0, 0), (np.sin(0.02), 0, np.cos(0.02))).rotation
    positions, frames = arrays(g).positions @ turn.T, turn @ g.frames
    update = stream.update(positions=positions, frames=frames)
    every = zip(positions, frames, g.contacts, strict=True)
    contacts = [hl.Contact(p, R[:, 2], c.friction, R[:, 0], c.name) for p, R, c in every]
    made = five.at(q).grasp(contacts, wrench=load, offset=g.offset, reference=g.reference)
    same(update, made.solve(throw=False))
    same(update, stream.grasp.solve(throw=False))
    assert [c.position.tolist() for c in stream.grasp.contacts] == positions.tolist()


def test_what_cannot_be_held_is_undecided_and_then_held_again(five):
    q, load, grasp = followed(five)
    stream = hl.GraspStream(grasp(q, load))
    first = stream.update()
    lost = stream.update(wrench=load + np.array([0, 0, -500.0, 0, 0, 0]))
    assert not lost.held
    assert lost.status is hl.Status.UNDECIDED
    assert np.isnan(lost.torques).all()
    assert set(lost.contact_state) == {"unknown"}
    np.testing.assert_allclose(stream.update(wrench=load).forces, first.forces, rtol=1e-9)


def test_a_grasp_without_a_hand_is_followed_under_its_load():
    g = hl.Grasp(PINCH, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    stream = hl.GraspStream(g)
    for pull in np.linspace(-2, 2, 9):
        update = stream.update(wrench=(0, 0, pull, 0, 0, 0))
        np.testing.assert_allclose(update.forces_world[:, 2], -pull / 2, atol=1e-12)
    with pytest.raises(AttributeError):
        update.torques  # noqa: B018
    with pytest.raises(hl.InputError, match="q"):
        stream.update([0.0])


def test_readings_of_the_fingertips_lead_to_the_load_online(five):
    """The paper's online use: the world pulls, sensors read, the model follows."""
    q, load, grasp = followed(five)
    stream = hl.GraspStream(grasp(q, load))
    for _, pulled in walk(q, load, 5, seed=4):
        world = grasp(q, pulled).solve()
        wrench = hl.wrench_from_fingertip_forces(stream.grasp, world.forces)
        np.testing.assert_allclose(stream.update(wrench=wrench).torques, world.torques, atol=1e-8)


@pytest.mark.parametrize(
    ("argument", "bad"),
    [("q", [0.0, 1.0]), ("offset", np.zeros(15)), ("positions", np.zeros((4, 3))), ("frames", np.zeros((5, 3, 3)))],
    ids=["q", "offset", "positions", "frames"],
)
def test_a_refused_change_changes_nothing(five, argument, bad):
    q, load, grasp = followed(five)
    stream = hl.GraspStream(grasp(q, load))
    before = stream.update().forces
    good = {"q": q + 0.01, "wrench": load * 1.1, "offset": np.zeros((5, 3))}
    with pytest.raises(hl.InputError, match=argument):
        stream.update(**(good | {argument: bad}))
    np.testing.assert_array_equal(stream.update().forces, before)


@pytest.mark.parametrize("twin", [copy.copy, lambda s: pickle.loads(pickle.dumps(s))])
def test_copies_share_nothing_and_go_on_from_where_it_is(five, twin):
    q, load, grasp = followed(five)
    stream = hl.GraspStream(grasp(q, load), "cone")
    stream.update(q + 0.01, wrench=load * 1.2)
    other = twin(stream)
    np.testing.assert_allclose(other.update().torques, stream.update().torques, rtol=1e-9)
    moved = other.update(q - 0.01, wrench=load * 0.5)
    same(moved, grasp(q - 0.01, load * 0.5).solve("cone"))
    same(stream.update(), grasp(q + 0.01, load * 1.2).solve("cone"))


def test_effects_asked_for_by_name_are_refused():
    g = hl.Grasp(PINCH, flexibility=1e-4, effects=[hl.TotalForceBound(3.0)])
    with pytest.raises(hl.InputError, match="TotalForceBound"):
        hl.GraspStream(g)
    with pytest.raises(hl.InputError, match="a Grasp"):
        hl.GraspStream(PINCH)


def test_updates_keep_no_memory(five):
    q, load, grasp = followed(five)
    stream = hl.GraspStream(grasp(q, load))
    moves = list(walk(q, load, 20, size=1e-3))

    def run(times):
        for _ in range(times):
            for posture, wrench in moves:
                stream.update(posture, wrench=wrench).torques  # noqa: B018
        gc.collect()

    run(20)
    tracemalloc.start()
    run(20)
    before, _ = tracemalloc.get_traced_memory()
    run(80)
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert after - before < 1600 * 8, "numpy keeps some small blocks for reuse; one number kept an update would be more"
