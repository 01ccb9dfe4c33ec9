"""A loading says first whether it holds, in the words of a verdict, here and in another process."""

import copy
import json
import pickle
from functools import cache

import joblib
import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from handlcp.errors import NoSolutionFound
from handlcp.viz.loading.figure import draw_end_picture as loading_picture, draw_loading as loading_figure
from tests.loading.hands import cube

CUBE = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
SCENE = """
[hand]
name = "three_finger"
joint_stiffness_Nm_per_rad = 6.0
{limits}
[object]
shape = "box"
size_m = 0.05
position_m = [0.0, 0.0, 0.08]
mass_kg = 0.2
[grasp]
friction = {friction}
squeeze_m = 0.005
"""


@cache
def loading(friction=0.8, limits=None):
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, **({} if limits is None else {"torque_limits": limits}))
    grasp = hand.at(hand.close_on(CUBE)).grasp(CUBE, friction=friction, squeeze=0.005)
    return grasp, grasp.follow(steps=8)


SLIDES = {"friction": 0.3}  # all slides from 71 % of the load on, and the object comes to rest farther down
WORDS = {"HELD": {}, "NOT HELD": SLIDES, "OVER LIMIT": {"limits": 0.2}}


@pytest.mark.parametrize("word", WORDS)
def test_the_word_of_a_loading_is_that_of_the_check(word):
    grasp, path = loading(**WORDS[word])
    assert path.word == word == grasp.check().word
    assert str(path).startswith(f"{word}: ")
    assert repr(path).startswith(f"{word}: ")
    assert path.to_dict()["word"] == word
    assert path.to_dict()["held"] is path.held is (word == "HELD")


def test_what_throws_throws_where_the_object_slid_away():
    grasp = loading(**SLIDES)[0]
    with pytest.raises(NoSolutionFound, match="has slid 1 mm"):
        grasp.follow(steps=8, throw=True)
    held, path = loading()
    assert held.follow(steps=8, throw=True).word == path.word


@pytest.mark.parametrize(
    ("friction", "limits", "word"),
    [(0.8, "", "HELD"), (0.3, "", "NOT HELD"), (0.8, "torque_limits_Nm = 0.2", "OVER LIMIT")],
)
def test_the_command_says_the_same_and_exits_0_for_held_alone(friction, limits, word, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE.format(friction=friction, limits=limits), encoding="utf-8")
    arguments = ["follow", str(file), "--steps", "8"]
    done = CliRunner().invoke(app, arguments, env={"COLUMNS": "80", "NO_COLOR": "1"})
    assert f"\n{word}: " in f"\n{done.stdout}"
    assert done.exit_code == (0 if word == "HELD" else 1)
    told = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert (told["word"], told["held"]) == (word, word == "HELD")


def test_figure_picture_and_page_begin_with_the_same_word(tmp_path):
    word, path = "OVER LIMIT", loading(**WORDS["OVER LIMIT"])[1]
    for figure in (loading_figure(path), loading_picture(path)):
        assert f"{word}:" in [t.get_text() for t in figure.texts]
    page = path.page(tmp_path / "a.html").read_text(encoding="utf-8")
    assert f">{word}</p>" in page


# ---------------------------------------------------------------- what a check and a loading answer can be sent to
def on_a_mesh(tmp_path):
    file = tmp_path / "box.stl"
    file.write_bytes(trimesh.creation.box((0.05, 0.05, 0.05)).export(file_type="stl"))
    hand, mesh = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Mesh(file, placement=(0, 0, 0.08), mass=0.2)
    return hand.at(hand.close_on(mesh)).grasp(mesh, friction=0.8, squeeze=0.005)


def at_points():
    detected = cube(squeeze=0.005)
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
    made = {"balls on a box": lambda: cube(squeeze=0.005), "balls on a mesh": lambda: on_a_mesh(tmp_path)}
    grasp = (made | {"points": at_points})[kind]()
    here = grasp.spec.mechanism.moving_geometry(grasp.spec)
    there = way(here, tmp_path)
    moved = type(here.start)(*here.start[:3], (np.eye(3), np.array([1e-4, -2e-4, 3e-4])))
    a, b = here.iterate(moved, None), there.iterate(moved, None)
    for name in ("positions", "frames", "gap"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), strict=True)


@pytest.mark.parametrize("way", WAYS)
def test_a_verdict_with_its_loading_says_the_same_in_another_process(way, tmp_path):
    verdict = cube(squeeze=0.005).check()
    there = way(verdict, tmp_path)
    assert (there.word, str(there), str(there.loading)) == (verdict.word, str(verdict), str(verdict.loading))
    np.testing.assert_array_equal(there.loading.steps.forces, verdict.loading.steps.forces)
    np.testing.assert_array_equal(there.loading.solution.forces, verdict.loading.solution.forces)
