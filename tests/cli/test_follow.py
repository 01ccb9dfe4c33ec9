"""`handlcp follow` from the outside."""

from functools import partial

import numpy as np
import pytest

from handlcp import scene as scenes
from tests.support import command
from tests.support.command import CUBE, changed, strict
from tests.support.messages import without_compiling
from tests.support.show import events_in_short
from tests.support.texts import same

FEW = ("--steps", "8")
run = partial(command.run, "follow")


@pytest.fixture
def heavy(tmp_path):
    """A cube that is too heavy."""
    return changed(tmp_path, ("mass_kg = 0.2", "mass_kg = 1.5"))


def test_a_scene_that_is_held_prints_its_end_within_80_columns_and_exits_0():
    done = run(CUBE, *FEW, status=0)
    for part in ("Contacts at the end", "Joint torques at the end", "finger_2_tip", "sticking", "finger_1_distal"):
        assert part in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80
    said = " ".join(done.stdout[done.stdout.index("HELD:") :].partition("\n\n")[0].split())
    same("cli/test_follow: a cube that is held", said)
    assert without_compiling(done.stderr) == ""


def test_a_scene_that_is_lost_exits_1_and_says_where_and_why(heavy):
    done = run(heavy, *FEW, status=1)
    found = scenes.load(heavy).build().follow(steps=8)
    assert found.lost_stage == "load"
    said = " ".join(done.stdout[done.stdout.index("NOT HELD:") :].split())
    assert said.startswith(f"NOT HELD: {found.why}")
    assert "Contacts at the last step" in done.stdout


def test_what_happens_on_the_way_is_a_table(tmp_path):
    file = changed(tmp_path, ("[object]", "torque_limits_Nm = 0.1\n[object]"))
    grasp = scenes.load(file).build()
    told = events_in_short(grasp.follow(steps=8).events, grasp)
    done = run(file, *FEW, width="160")
    assert told
    lines = [" ".join(line.split()) for line in done.stdout.splitlines()]
    for line in told:
        place, sentence = line.split(": ", 1)
        assert f"{place.replace(',', '', 1)} {sentence}" in lines
    assert "On the way" not in run(CUBE, *FEW).stdout, "nothing happens"


def test_json_is_one_object_with_the_numbers_of_all_steps_and_no_nan():
    done = run(CUBE, *FEW, "--json", status=0)
    found, h = strict(done.stdout), scenes.load(CUBE).build().follow(steps=8)
    assert (found["word"], found["held"], found["reached"]) == ("HELD", True, True)
    assert found["lost_at"] is found["lost_stage"] is None
    assert (found["why"], found["stages"], found["geometry"]) == (h.why, list(h.stages), "followed")
    assert found["status_at_end"] == "SOLVED"
    np.testing.assert_allclose(found["contacts"]["forces_N"], h.steps.forces, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found["steps"]["displacement_m_rad"], h.steps.displacement, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(found["joints"]["torques_Nm"], h.steps.torques, rtol=1e-6, atol=1e-12)
    assert found["contacts"]["names"] == list(h.steps.names)
    assert found["contacts"]["friction_used"][0] == [None] * 3, "nothing is loaded at first"
    assert len(found["steps"]["share"]) == len(found["contacts"]["state"]) == len(h.steps)


def test_options_reach_the_loading():
    together = strict(run(CUBE, "--order", "together", *FEW, "--json").stdout)
    assert together["stages"] == ["together"]
    fixed = strict(run(CUBE, "--fixed", "--order", "together", "--steps", "1", "--json").stdout)
    assert fixed["geometry"] == "fixed"
    one = scenes.load(CUBE).build().solve("cone")
    np.testing.assert_allclose(fixed["contacts"]["forces_N"][-1], one.forces, rtol=1e-6, atol=1e-6)
    grasp = scenes.load(CUBE).build()
    six = strict(run(CUBE, "--faces", "6", *FEW, "--json").stdout)
    np.testing.assert_allclose(
        six["contacts"]["forces_N"][-1], grasp.follow(faces=6, steps=8).steps.forces[-1], rtol=1e-6, atol=1e-9
    )
