"""Postures that something else has found: read, put into the hand, and refused where a key is missing."""

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl

HALF = np.sqrt(0.5)


def test_arrays_of_one_and_of_many():
    (one,) = hl.read_postures((np.array([0.1, 0.2]), np.eye(4)))
    assert one.q.tolist() == [0.1, 0.2]
    assert one.placement == pin.SE3.Identity()
    many = hl.read_postures({"q": np.zeros((3, 2)), "placement": [(0, 0, z) for z in range(3)]}, joints=["a", "b"])
    assert [p.placement.translation[2] for p in many] == [0, 1, 2]
    assert many[2].q == {"a": 0.0, "b": 0.0}


def test_a_pose_of_seven_numbers_turns_as_its_quaternion_says():
    """A quarter turn about z carries x to y."""
    ((_, placement, _),) = hl.read_postures((np.zeros(2), [1.0, 2.0, 3.0, HALF, 0, 0, HALF]))
    np.testing.assert_allclose(placement.rotation @ [1, 0, 0], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(placement.translation, [1, 2, 3])


def test_dexgraspbench_says_hand_and_object_in_the_world(tmp_path):
    """A hand turned by a quarter about z and 1 m along x: what is at y = 2 m in the world is at x = 2, y = 1 in it."""
    held = {"grasp_qpos": np.array([[1.0, 0, 0, HALF, 0, 0, HALF, 0.1, 0.2]]), "squeeze_qpos": np.zeros((1, 9))}
    held |= {"obj_pose": np.array([0.0, 2.0, 0, 1, 0, 0, 0]), "obj_path": np.array("mug")}
    np.savez(tmp_path / "grasp.npz", **held)
    np.savez_compressed(tmp_path / "packed.npz", **held)
    for source in (held, tmp_path / "grasp.npz", tmp_path / "packed.npz"):
        (one,) = hl.read_postures(source, joints=("thumb", "index"))
        assert one.q == {"thumb": 0.1, "index": 0.2}
        np.testing.assert_allclose(one.placement.translation, [2.0, 1.0, 0.0], atol=1e-12)


def test_the_message_about_its_own_files_says_what_reads_them(tmp_path):
    file = tmp_path / "grasp.npy"
    held = {"grasp_qpos": np.array([0.0, 0, 0, 1, 0, 0, 0, 0.1]), "obj_pose": np.array([0.0, 0, 0, 1, 0, 0, 0])}
    np.save(file, held, allow_pickle=True)
    with pytest.raises(hl.InputError, match=r"np\.load\(file, allow_pickle=True\)"):
        hl.read_postures(file)
    (one,) = hl.read_postures(np.load(file, allow_pickle=True).item())
    assert one.q.tolist() == [0.1]


def test_graspgen_says_the_gripper_in_the_object(tmp_path):
    """A gripper 0.1 m above the object, turned upside down about x: the object is 0.1 m along its z."""
    pytest.importorskip("yaml")
    file = tmp_path / "grasps.yaml"
    file.write_text(
        "format: isaac_grasp\ngrasps:\n  grasp_0:\n    confidence: 0.9\n    position: [0.0, 0.0, 0.1]\n"
        "    orientation: {w: 0.0, xyz: [1.0, 0.0, 0.0]}\n    cspace_position: {index: 0.3}\n",
        encoding="utf-8",
    )
    (one,) = hl.read_postures(str(file))
    assert (one.name, one.q) == ("grasp_0", {"index": 0.3})
    np.testing.assert_allclose(one.placement.translation, [0.0, 0.0, 0.1], atol=1e-12)
    with pytest.raises(hl.InputError, match="pregrasp_cspace_position"):
        hl.read_postures(str(file), which="pregrasp")
    with pytest.raises(hl.InputError, match="grasps: expected at least one"):
        hl.read_postures({"grasps": {}})


@pytest.mark.parametrize(
    ("source", "options", "said"),
    [
        ("grasps.txt", {}, ".npz or .yaml"),
        ("no_such_file.yaml", {}, "does not exist"),
        ({"q": [0.0]}, {}, "placement missing"),
        ({"grasp_qpos": np.zeros(9)}, {}, "obj_pose missing"),
        ({"grasp_qpos": np.zeros(5), "obj_pose": np.zeros(7)}, {}, "7 \\+ nv"),
        ({"grasps": {"a": {"position": [0, 0, 0]}}}, {}, "orientation, cspace_position missing"),
        (([0.0], None), {"joints": ["a", "b"]}, "joints"),
        ((np.zeros((2, 1)), [None]), {}, "one for each posture"),
    ],
)
def test_bad_input_is_refused(source, options, said):
    with pytest.raises(hl.InputError, match=said):
        hl.read_postures(source, **options)
