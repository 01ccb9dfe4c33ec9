"""What a check and a loading answer can be sent to another process, and be copied: it says and finds the same there."""

import copy
import pickle

import joblib
import numpy as np
import pytest
import trimesh

import handlcp as hl

BELOW = (0, 0, 0.08)


def on_a_box():
    hand, box = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Box(0.05, BELOW, mass=0.2)
    return hand.at(hand.close_on(box)).grasp(box, friction=0.8, squeeze=0.005)


def on_a_mesh(tmp_path):
    file = tmp_path / "box.stl"
    file.write_bytes(trimesh.creation.box((0.05, 0.05, 0.05)).export(file_type="stl"))
    hand, mesh = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Mesh(file, placement=BELOW, mass=0.2)
    return hand.at(hand.close_on(mesh)).grasp(mesh, friction=0.8, squeeze=0.005)


def at_points():
    detected = on_a_box()
    return detected.state.grasp(detected.contacts, wrench=(0, 0, -2, 0, 0, 0), squeeze=0.005)


def through_pickle(x, tmp_path):
    return pickle.loads(pickle.dumps(x))


def through_a_deep_copy(x, tmp_path):
    return copy.deepcopy(x)


def through_joblib(x, tmp_path):
    joblib.dump(x, tmp_path / "kept.joblib")
    return joblib.load(tmp_path / "kept.joblib")


def through_dask(x, tmp_path):
    protocol = pytest.importorskip(
        "distributed.protocol", reason="Dask is not installed here: pip install '.[test]' brings it"
    )
    return protocol.deserialize(*protocol.serialize(x, serializers=("pickle",)))


WAYS = [through_pickle, through_a_deep_copy, through_joblib, through_dask]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", ["balls on a box", "balls on a mesh", "points"])
def test_a_hand_that_is_followed_finds_the_same_contacts_in_another_process(kind, way, tmp_path):
    made = {"balls on a box": on_a_box, "balls on a mesh": lambda: on_a_mesh(tmp_path), "points": at_points}
    grasp = made[kind]()
    here = grasp.spec.mechanism.moving_geometry(grasp.spec)
    there = way(here, tmp_path)
    moved = type(here.start)(*here.start[:3], (np.eye(3), np.array([1e-4, -2e-4, 3e-4])))
    a, b = here.iterate(moved, None), there.iterate(moved, None)
    for name in ("positions", "frames", "gap"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), strict=True)


@pytest.mark.parametrize("way", WAYS)
def test_a_verdict_with_its_loading_says_the_same_in_another_process(way, tmp_path):
    verdict = on_a_box().check()
    there = way(verdict, tmp_path)
    assert (there.word, str(there), str(there.loading)) == (verdict.word, str(verdict), str(verdict.loading))
    np.testing.assert_array_equal(there.loading.steps.forces, verdict.loading.steps.forces)
    np.testing.assert_array_equal(there.loading.solution.forces, verdict.loading.solution.forces)
