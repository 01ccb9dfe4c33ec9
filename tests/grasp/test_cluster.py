"""A batch on a real Dask cluster, one of whose workers dies midway."""

import os
import signal

import pytest

import handlcp as hl
from tests.grasp.batches import QUICK, assert_same_bits, hand_grasp, mixture, sweep
from tests.support import patches

distributed = pytest.importorskip("distributed", reason="Dask is not installed here: pip install '.[test]' brings it")


@pytest.mark.long
def test_a_worker_killed_midway_changes_no_bit(monkeypatch, tmp_path):
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
