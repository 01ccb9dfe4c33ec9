"""The arrays of a batch are what its solutions say, bit for bit."""

import gc
import pickle
import weakref

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.batches import QUICK, assert_same_bits, four, hand_grasp, mixture, soft_and_anisotropic, sweep
from tests.grasp.scenes import pinch


def assert_arrays_agree(many):
    for k, s in enumerate(many):
        assert many.forces[k].tobytes() == s.forces.tobytes()
        assert many.displacement[k].tobytes() == s.object_displacement.tobytes()
        assert many.status[k] == s.status.name
        assert np.isnan(many.forces[k]).all() == (not many.held[k])


@pytest.mark.parametrize("faces", [8, "cone"])
def test_forces_and_motions_are_the_solutions_own(faces):
    grasps = soft_and_anisotropic() + sweep(soft_and_anisotropic()[0], 4, 20.0)
    many = hl.solve_many(grasps, faces, QUICK, workers=1)
    assert 3 < many.held.sum() < len(many)
    assert many.forces.shape == (len(many), 4, 3)
    assert_arrays_agree(many)


def test_torques_are_the_solutions_own():
    grasp = hand_grasp(finger_weight=True)
    soft = hand_grasp(friction=hl.SoftFinger(0.6, 0.003))
    grasps = [*sweep(hand_grasp(), 6, 2.0), *sweep(grasp, 3), *sweep(soft, 3)]
    grasps.append(hand_grasp(effects=[hl.TorqueSaturation()]))
    many = hl.solve_many(grasps, 8, QUICK, workers=1)
    assert 3 < many.held.sum() < len(many)
    for k, s in enumerate(many):
        assert many.torques[k].tobytes() == s.torques.tobytes() or not s.held
        assert np.isnan(many.torques[k]).all() == (not s.held)
        np.testing.assert_array_equal(many.utilisation[k], s.torque_check.utilisation)
    assert_arrays_agree(many)


def test_grasps_without_a_hand_have_no_torques():
    with pytest.raises(hl.Unsupported, match="torques: not all grasps are of a hand"):
        hl.solve_many([pinch()]).torques  # noqa: B018
    with pytest.raises(hl.Unsupported, match="utilisation: not all grasps are of a hand"):
        hl.solve_many([hand_grasp(), pinch()]).utilisation  # noqa: B018
    three = hl.example_hand("three_finger")
    ball = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
    other = three.at(three.close_on(ball)).grasp(ball)
    with pytest.raises(hl.Unsupported, match="hands with different joints"):
        hl.solve_many([hand_grasp(), other], solver=QUICK).torques  # noqa: B018


def test_no_grasps_make_empty_arrays():
    none = hl.solve_many([])
    assert none.forces.shape == (0, 0, 3)
    assert none.torques.shape == none.utilisation.shape == (0, 0)
    assert none.displacement.shape == (0, 6)
    assert none.held.shape == none.status.shape == (0,)
    assert set(none.to_dict()) >= {"status", "held", "object.x"}


# ---------------------------------------------------------------- columns for a data frame
def test_columns_are_named_by_fingers_and_joints():
    grasps = [hand_grasp(), *sweep(hand_grasp(), 8, 3.0), pinch()]
    many = hl.solve_many(grasps, solver=QUICK, workers=1)
    columns = many.to_dict()
    assert {len(c) for c in columns.values()} == {len(grasps)}
    assert list(columns)[:3] == ["status", "held", f"{many[0].names[0]}.force_x"]
    for k, s in enumerate(many):
        for i, name in enumerate(s.names):
            own = [columns[f"{name}.force_{axis}"][k] for axis in "xyz"]
            np.testing.assert_array_equal(own, s.forces[i])
        np.testing.assert_array_equal(columns["object.rz"][k], s.object_displacement[5])
        if k + 1 < len(grasps):
            table = s.torque_check
            for row in table:
                np.testing.assert_array_equal(columns[f"{row.joint}.torque"][k], row.torque)
                np.testing.assert_array_equal(columns[f"{row.joint}.utilisation"][k], row.utilisation)
            np.testing.assert_array_equal(columns["utilisation"][k], table.utilisation.max())
            assert columns["binding"][k] == (table.binding if s.held else None)
    assert columns["binding"][-1] is None
    assert np.isnan(columns[f"{grasps[0].names[0]}.force_x"][-1])
    assert "left.force_z" in columns


# ---------------------------------------------------------------- what is kept
def test_solutions_that_nobody_holds_are_not_kept():
    many = hl.solve_many(sweep(four(), 5, 0.01), workers=1)
    held = many[0]
    assert many[0] is held
    gone = weakref.ref(many[1])
    gc.collect()
    assert gone() is None
    assert many[1].held


def test_a_pickle_has_the_same_answers():
    many = hl.solve_many([*mixture(), hand_grasp()], 8, QUICK, workers=1)
    copy = pickle.loads(pickle.dumps(many))
    assert_same_bits(copy, many)
    np.testing.assert_array_equal(copy.displacement, many.displacement)
    assert copy.statuses == many.statuses
