"""Many grasps at once are what each of them is alone, whatever the workers."""

import tracemalloc

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.batches import (
    QUICK,
    Later,
    assert_same_bits,
    four,
    hand_grasp,
    mixture,
    soft_and_anisotropic,
    sweep,
)
from tests.grasp.scenes import pinch
from tests.support import patches
from tests.support.grasp import arrays, packed
from tests.support.power import STRONG, WEAK, power_grasp


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize("faces", [8, "cone"])
def test_each_solution_is_the_grasps_own(workers, faces, monkeypatch):
    patches.chunks_of(monkeypatch, 7)
    grasps = mixture()
    many = hl.solve_many(grasps, faces, QUICK, workers=workers)
    assert len(many) == len(grasps)
    for g, s, held, status in zip(grasps, many, many.held, many.statuses, strict=True):
        alone = g.solve(faces, QUICK, throw=False)
        assert (s.status, s.trace, s.contact_state) == (alone.status, alone.trace, alone.contact_state)
        assert (held, status) == (alone.held, alone.status)
        np.testing.assert_array_equal(s.forces, alone.forces)
        np.testing.assert_array_equal(s.object_displacement, alone.object_displacement)
    assert 5 < many.held.sum() < len(grasps)


def test_a_hands_grasps_come_back_with_torques():
    g = hand_grasp()
    grasps = [g, g.replace(wrench=(0.1, 0, -1.5, 0, 0, 0))]
    for g, s in zip(grasps, hl.solve_many(grasps), strict=True):
        np.testing.assert_array_equal(s.torques, g.solve().torques)


@pytest.mark.long
def test_what_takes_long_goes_through_processes_and_comes_back_the_same(monkeypatch):
    patches.everything_to_processes(monkeypatch)
    grasps = [g for g in mixture() if not g.solve(8, QUICK, throw=False).held or g.effects]
    assert len(grasps) > 4
    hand = hl.example_hand("five_finger")
    ball = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
    grasps.append(hand.at(hand.close_on(ball)).grasp(ball))
    for g, s in zip(grasps, hl.solve_many(grasps, 8, QUICK, workers=2), strict=True):
        alone = g.solve(8, QUICK, throw=False)
        assert type(s) is type(alone)
        assert (s.status, s.trace, s.diagnosis) == (alone.status, alone.trace, alone.diagnosis)
        np.testing.assert_array_equal(s.forces, alone.forces)
        assert not s.forces.flags.writeable
        assert arrays(s) is arrays(g)


def test_progress_counts_up_to_all(monkeypatch):
    patches.chunks_of(monkeypatch, 2)
    seen = []
    hl.solve_many([pinch()] * 7, workers=2, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (7, 7)
    assert [d for d, _ in seen] == sorted(d for d, _ in seen)


@pytest.mark.parametrize("workers", [1, 2])
def test_without_a_proof_nothing_is_searched(workers, monkeypatch):
    patches.everything_to_processes(monkeypatch)
    grasps = [g for g in mixture() if not g.solve(8, QUICK, throw=False).held]
    many = hl.solve_many([*grasps, pinch()], workers=workers, proof=False)
    assert_same_bits(many, [g.solve(throw=False, proof=False) for g in [*grasps, pinch()]])
    assert set(many.status[:-1]) == {"UNDECIDED", "NOT_HOLDABLE"}
    assert many.held[-1]
    assert not any("search" in line for s in many for line in s.trace)


def test_grasps_of_many_contacts_are_solved_with_their_factor_in_a_batch_too():
    """Given as a factor, found in a matrix, or neither: forces, states and steps of the solver are those of `solve`."""
    grasps = [
        power_grasp(12, 2, STRONG).factored(),
        power_grasp(30, 0, WEAK).dense(),
        power_grasp(12, 2, STRONG).dense(),
    ]
    grasps += [power_grasp(12, 3, STRONG).factored(), pinch()]
    for executor in (None, Later()):
        many = hl.solve_many(grasps, proof=False, executor=executor)
        assert_same_bits(many, [g.solve(throw=False, proof=False) for g in grasps])
    assert many.held.all()


def test_many_scenes_are_packed_as_each_of_them_is():
    power = [power_grasp(12, seed, STRONG).factored() for seed in (2, 3)]
    matrix = [power_grasp(30, 0, WEAK).dense()]
    for group in (mixture()[:1] * 3, [hand_grasp()], [mixture()[24]], soft_and_anisotropic()[:4], power, matrix):
        one, all_ = packed(group, 8)
        np.testing.assert_array_equal(one, all_)


def test_a_batch_keeps_arrays_alone():
    grasps = sweep(four(), 600, 0.1)
    hl.solve_many(grasps[:300], workers=1)
    tracemalloc.start()
    try:
        many = hl.solve_many(grasps, workers=1)
        kept, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert many.held.all()
    assert kept / len(grasps) < 1000  # bytes
    assert most < kept + 256 * 10_000  # the scenes of one shard


def test_a_batch_hangs_nothing_on_its_grasps():
    grasps = [*[pinch(load=(0, 0, -100.0)) for _ in range(3)], *sweep(four(), 3, 0.1)]
    before = [set(vars(g.scene)) for g in grasps]
    many = hl.solve_many(grasps, solver=QUICK, workers=1)
    assert 3 <= many.held.sum() < len(grasps)
    for k in (1, 2, 4, 5):  # the first of a kind may keep what the kind was read off
        assert set(vars(grasps[k].scene)) == before[k]


def test_bad_input_is_named():
    with pytest.raises(hl.InputError, match="progress: expected True"):
        hl.solve_many([pinch()], progress=3)
    with pytest.raises(hl.InputError, match="proof: expected True or False"):
        hl.solve_many([pinch()], proof="no")
    with pytest.raises(hl.InputError, match=r"grasps\[1\]"):
        hl.solve_many([pinch(), 3])
    with pytest.raises(hl.InputError, match="grasps"):
        hl.solve_many(pinch())
    with pytest.raises(hl.InputError, match="workers"):
        hl.solve_many([pinch()], workers=0)
    with pytest.raises(hl.InputError, match="faces"):
        hl.solve_many([pinch()], faces=2)
