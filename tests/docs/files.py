"""The files of a reader: a hand, a mug, readings of sensors. Pages name them, tests write them."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Callable

__all__ = ["write_all"]

ROOT = pathlib.Path(__file__).parents[2]
FINGERS = {"finger_1": "thumb", "finger_2": "index", "finger_3": "middle"}


def hand(file: pathlib.Path) -> None:
    """Three fingers of two joints, under names of a reader."""
    text = (ROOT / "urdf" / "three_finger.urdf").read_text(encoding="utf-8")
    for ours, theirs in FINGERS.items():
        text = text.replace(ours, theirs)
    file.write_text(text, encoding="utf-8")


def mjcf(file: pathlib.Path) -> None:
    """The same hand for MuJoCo, with a site at the end of each finger."""
    fingers = []
    for name, angle in zip(FINGERS.values(), (0, 120, 240), strict=True):
        hinge = 'type="hinge" axis="0 -1 0" damping="0.1"'
        fingers.append(
            f'<body name="{name}_base" euler="0 0 {angle}"><geom type="sphere" size="0.001" pos="0.045 0 0"/>'
            f'<body name="{name}_1" pos="0.045 0 0"><joint name="{name}_proximal" {hinge} range="-28 92"/>'
            f'<geom type="capsule" size="0.007" fromto="0 0 0 0 0 0.05"/><body name="{name}_2" pos="0 0 0.05">'
            f'<joint name="{name}_distal" {hinge} range="0 109"/><site name="{name}_tip" pos="0 0 0.04"/>'
            '<geom type="capsule" size="0.006" fromto="0 0 0 0 0 0.04"/></body></body></body>'
        )
    file.write_text(f"<mujoco><worldbody>{''.join(fingers)}</worldbody></mujoco>", encoding="utf-8")


def mug(file: pathlib.Path) -> None:
    """A can in millimetres, as CAD programs write it: 50 mm wide, 90 mm high."""
    import trimesh

    file.write_bytes(trimesh.creation.cylinder(radius=25.0, height=90.0, sections=64).export(file_type="stl"))


def planner(file: pathlib.Path) -> None:
    """A posture around the mug as a planner writes it, by joint name; it stops 0.3 mm before it touches."""
    import handlcp as hl

    wider = hl.Cylinder(0.0253, 0.09, placement=(0, 0, 0.08))
    q = hl.example_hand("three_finger").close_on(wider)
    names = [f"{finger}_{joint}" for finger in FINGERS.values() for joint in ("proximal", "distal")]
    file.write_text(json.dumps(dict(zip(names, map(float, q), strict=True))), encoding="utf-8")


WRITERS: dict[str, Callable[[pathlib.Path], None]] = {
    "my_hand.urdf": hand, "my_hand.xml": mjcf, "mug.stl": mug, "planner.json": planner,
}  # fmt: skip


def write_all(folder: pathlib.Path) -> None:
    """All of them, and the repository's examples and hands, which commands of the pages name."""
    for name, write in WRITERS.items():
        write(folder / name)
    for name in ("examples", "urdf"):
        os.symlink(ROOT / name, folder / name)
