"""The benchmarks run, with small sizes, and their ratios are what the documentation claims, within wide limits."""

import numpy as np
import pytest

from tests.benchmarks import batch, cold_start, path, questions, search, solve

pytestmark = pytest.mark.bench


def test_one_solve():
    found = solve.main(["--rounds", "50", "--scenes", "6"])
    assert found["split"]["posture → torques as an update of a stream"] < 40.0
    assert found["verdicts"]["SOLVED, 8"] == 1.0
    assert 0.5 < found["effects"]["geared motors"] < 1.5
    assert found["sections"]["32"] < 3.0
    assert max(found["rigid"].values()) < 500.0


def test_a_loading():
    found = path.main(["--rounds", "2", "--no-mujoco"])
    assert all(ratios["follow"] < 60.0 for ratios in found["stages"].values())
    assert max(found["steps"].values()) < 4.0


def test_questions_of_a_load():
    found = questions.main(["--directions", "4", "--rounds", "1"])
    assert found["questions"]["solve"] == 1.0
    assert all(np.isfinite(ratio) for table in found.values() for ratio in table.values())


def test_a_search_and_a_sweep():
    found = search.main(["three_finger", "--kinds", "pinch", "--objects", "3", "--designs", "4"])
    assert found["searches"]
    assert found["designs"]["alone holds more [kg]"] < 0.1


def test_many_grasps():
    found = batch.main(["--grasps", "300", "--directions", "50", "--updates", "20000", "--rounds", "1"])
    assert found["many"]["all hold, one core"] < 1.0
    assert max(found["directions"].values()) < 2.0
    assert found["growth"] < 50.0


def test_a_first_start():
    found = cold_start.main(["--ways", "interpreted", "--blocks", "1"])
    assert np.isfinite(found["interpreted"]).all()
