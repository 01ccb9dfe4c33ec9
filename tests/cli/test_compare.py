"""`handlcp compare`: what both say, in print and as JSON, and what MuJoCo cannot have."""

from __future__ import annotations

import json
import pathlib
import re

import pytest

from tests.support.command import run

pytest.importorskip("mujoco")

CUBE = """
title = "A cube"
[hand]
name = "three_finger"
joint_stiffness_Nm_per_rad = 6.0
[object]
shape = "box"
size_m = 0.05
position_m = [0.0, 0.0, 0.08]
mass_kg = 0.05
[grasp]
friction = 0.8
joint_offset_rad = { %s }
"""
JOINTS = [f"finger_{i}_{part}" for i in (1, 2, 3) for part in ("proximal", "distal")]


def compared(folder, offset, *words):
    file = folder / "cube.toml"
    file.write_text(CUBE % ", ".join(f"{joint} = {offset}" for joint in JOINTS), encoding="utf-8")
    return run("compare", file, "--seconds", "0.5", *words, width=None)


def test_it_prints_both_and_how_far_they_are_apart(tmp_path: pathlib.Path):
    ran = compared(tmp_path, 0.02)
    assert ran.exit_code == 0
    said = " ".join(ran.stdout.split())
    for words in ("A cube", "finger_1_tip", "finger_3_distal", "handlcp: HELD", "MuJoCo: HELD"):
        assert words in said
    forces = re.search(r"Difference: forces ([\d.e-]+) % of the largest force", said)
    assert forces is not None
    assert float(forces[1]) < 0.3
    assert re.search(r"Time: handlcp \S+ s, MuJoCo \S+ s", said)


def test_json_has_the_same_numbers(tmp_path: pathlib.Path):
    ran = compared(tmp_path, 0.02, "--json", "--together")
    found = json.loads(ran.stdout)
    assert found["both_hold"]
    assert found["agree"]
    assert found["force_error"] < 3e-3
    assert len(found["mujoco"]["forces_N"]) == len(found["handlcp"]["forces_N"]) == len(found["contacts"]) == 3
    assert found["handlcp"]["lost_at"] is None


def test_a_cube_that_drops_is_exit_status_1(tmp_path: pathlib.Path):
    ran = compared(tmp_path, 0.0)
    assert ran.exit_code == 1
    assert "handlcp: NOT HELD" in ran.stdout
    assert "MuJoCo: NOT HELD" in ran.stdout
