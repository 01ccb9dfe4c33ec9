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


WRITERS: dict[str, Callable[[pathlib.Path], None]] = {"my_hand.urdf": hand, "mug.stl": mug, "planner.json": planner}


def write_all(folder: pathlib.Path) -> None:
    """All of them, and the repository's examples and hands, which commands of the pages name."""
    for name, write in WRITERS.items():
        write(folder / name)
    for name in ("examples", "urdf"):
        os.symlink(ROOT / name, folder / name)
