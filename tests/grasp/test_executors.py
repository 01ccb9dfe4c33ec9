"""A batch on any executor has the answers of one process, and says what failed."""

import os
import signal
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.batches import QUICK, Later, assert_same_bits, four, hand_grasp, mixture, sweep
from tests.support import patches


@pytest.mark.parametrize("size", [1, 3, 1000])
@pytest.mark.parametrize("faces", [8, "cone"])
def test_the_answers_are_those_of_one_process_whatever_the_shards(size, faces, monkeypatch):
    grasps = [*mixture(), *sweep(hand_grasp(), 5, 3.0)]
    alone = hl.solve_many(grasps, faces, QUICK, workers=1)
    patches.shards_of(monkeypatch, size)
    with ThreadPoolExecutor(2) as pool:
        for executor in (pool, Later()):
            many = hl.solve_many(grasps, faces, QUICK, executor=executor)
            assert_same_bits(many, alone)
            np.testing.assert_array_equal(many.displacement, alone.displacement)
            for s, g in zip(many, grasps, strict=True):
                assert s.scene is g.scene


def test_loads_of_one_grasp_travel_as_their_own_numbers_alone():
    there = Later()
    grasps = sweep(hand_grasp(), 300, 0.1)
    assert hl.solve_many(grasps, executor=there).held.all()
    assert len(there.sent) == 2  # of 256 and 44
    assert sum(there.sent) < 300 * 60 + 2 * 8000


def test_a_pool_that_loses_a_process_says_so(monkeypatch):
    patches.shards_of(monkeypatch, 1)
    grasps = sweep(four(), 20, 0.1)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        os.kill(pool.submit(os.getpid).result(), signal.SIGKILL)
        with pytest.raises(BrokenProcessPool, match=r"terminated abruptly|not usable anymore"):
            hl.solve_many(grasps, executor=pool)


def test_what_a_progress_raises_stops_the_batch(monkeypatch):
    patches.shards_of(monkeypatch, 1)

    def stop(done, total):
        raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt):
        hl.solve_many(sweep(four(), 20, 0.1), executor=pool, progress=stop)


@pytest.mark.long
def test_a_cluster_whose_worker_is_killed_midway_changes_no_bit(monkeypatch, tmp_path):
    missing = "Dask is not installed here: pip install '.[test]' brings it"
    distributed = pytest.importorskip("distributed", reason=missing)
    patches.shards_of(monkeypatch, 8)
    grasps = [*sweep(hand_grasp(), 100, 0.3), *mixture()[18:], *sweep(hand_grasp(), 4, 3.0)]
    alone = hl.solve_many(grasps, 8, QUICK, workers=1)
    assert 100 < alone.held.sum() < len(grasps)
    killed = []
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=tmp_path
    )
    with cluster, distributed.Client(cluster) as client:
        workers = list(client.run(os.getpid).values())
        assert len(workers) == 2

        def kill(done, total):
            if not killed:
                assert done < total
                killed.append(workers[0])
                os.kill(workers[0], signal.SIGKILL)

        many = hl.solve_many(grasps, 8, QUICK, executor=client.get_executor(), progress=kill)
        assert killed[0] not in client.run(os.getpid).values()
        assert_same_bits(many, alone)
