"""Grasps whose pictures are hard to draw: many contacts, long names, moments, hands without geometry."""

from __future__ import annotations

import pathlib
import xml.etree.ElementTree as ET
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin

import handlcp as hl
from handlcp.scene import load

__all__ = ["CASES", "EXAMPLES", "bare_hand", "case", "on_table", "ring"]

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


def ring(count, friction=None, load=(0, 0, -1.0, 0, 0, 0), names=None, squeeze=3e-3, **extra):
    """Contacts evenly around a circle in the xy plane, pushing inwards."""
    laws = friction if isinstance(friction, list) else [friction or hl.Coulomb(0.5)] * count
    turns = 2 * np.pi * np.arange(count) / count
    names = [None] * count if names is None else names
    contacts = [
        hl.Contact(0.03 * np.array([np.cos(a), np.sin(a), 0]), (-np.cos(a), -np.sin(a), 0), law, name=name)
        for a, law, name in zip(turns, laws, names, strict=True)
    ]
    return hl.Grasp(contacts, load, flexibility=1e-3, preload=squeeze, **extra)


def on_table(feet):
    """Two fingers and a table below, with its contacts on a circle."""
    turns = 2 * np.pi * (np.arange(feet) + 0.5) / feet
    ends = [hl.Contact((0.03 * np.cos(a), 0.03 * np.sin(a), 0), (0, 0, 1), hl.Coulomb(0.4)) for a in turns]
    named = [hl.Contact(c.position, c.normal, c.friction, name=f"table {k}") for k, c in enumerate(ends, 1)]
    pair = [hl.Contact((s * 0.03, 0, 0.04), (-s, 0, 0), hl.Coulomb(0.5), name=f"tip {s:+d}") for s in (-1, 1)]
    return hl.Grasp(
        pair, (0.4, 0, -3.0, 0, 0, 0), flexibility=1e-3, preload=1e-3, environment=hl.Environment(named, 1e-4)
    )


def bare_hand(keep: Callable[[str], bool] = lambda link: False, name: str = "three_finger") -> hl.Hand:
    """An example hand whose links have no geometry, except those that are kept. Its tips are balls of 8 mm."""
    from handlcp.hand.library import urdf

    root = ET.parse(urdf(name)).getroot()
    for link in root.findall("link"):
        if not keep(link.get("name", "")):
            for element in [e for e in link if e.tag in ("visual", "collision")]:
                link.remove(element)
    return _from_text(ET.tostring(root, encoding="unicode"))


def _from_text(text: str) -> hl.Hand:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "hand.urdf"
        file.write_text(text, encoding="utf-8")
        return hl.Hand.from_urdf(file, joint_stiffness=6.0, pad_flexibility=1e-4, tip_radius=0.008)


def _example(name: str) -> Any:
    file = load(EXAMPLES / f"{name}.toml")
    return file.build(), file.shape(), file.title


def _bare(keep: Callable[[str], bool] = lambda link: False) -> Any:
    given = load(EXAMPLES / "cube_three_fingers.toml").build()
    state = bare_hand(keep).at(given.state.q)
    grasp = state.grasp(given.target, friction=hl.Coulomb(0.8), squeeze=0.005)
    return grasp, None, "A hand without geometry"


def _inside() -> Any:
    """A cube as high as the fingers: their links are in it."""
    given = load(EXAMPLES / "cube_three_fingers.toml").build()
    tall = hl.Box((0.05, 0.05, 0.16), pin.SE3(np.eye(3), given.target.placement.translation - (0, 0, 0.02)), mass=0.2)
    return given.state.grasp(tall, friction=hl.Coulomb(0.8), squeeze=0.005), None, "Links inside a tall box"


def _soft() -> Any:
    soft = hl.SoftFinger(0.6, 0.02)
    pair = [hl.Contact((0, s * 0.03, 0), (0, -s, 0), soft, name=f"pad {k}") for k, s in enumerate((-1, 1), 1)]
    return hl.Grasp(pair, (0, 0, -2.0, 0, 0.03, 0), flexibility=1e-4, preload=1e-3), None, "Soft pads, a load aside"


LONG = [f"right_hand_{finger}_finger_distal_phalanx_fingertip_pad_frame" for finger in ("index", "middle", "thumb")]

SLIPPERY = (0.002, 0.11, 0.8, 0.8, 0.8)

CASES: dict[str, Callable[[], Any]] = {
    **{f.stem: (lambda f=f: _example(f.stem)) for f in sorted(EXAMPLES.glob("*.toml"))},
    **{f"paper/{f.stem}": (lambda f=f: _example(f"paper/{f.stem}")) for f in sorted(EXAMPLES.glob("paper/*.toml"))},
    "eight_on_table": lambda: (on_table(8), None, "Eight contacts on a table"),
    "forty_on_table": lambda: (on_table(40), None, "Forty contacts on a table"),
    "twelve_fingers": lambda: (ring(12), None, "Twelve fingers"),
    "thirty_fingers": lambda: (ring(30, load=(0, 0, -3.0, 0, 0, 0)), None, "Thirty fingers"),
    "long_names": lambda: (ring(3, names=LONG), None, "A title that is so long that it would run off the page " * 3),
    "frictionless": lambda: (ring(3, hl.Frictionless()), None, "Frictionless fingers under a weight"),
    "turned_off": lambda: (ring(3, hl.Frictionless(), load=(0, 0, 0, 0, 0, 0.1)), None, "A torque that nothing bears"),
    "pure_torque": lambda: (ring(3, load=(0, 0, 0, 0, 0, 0.02)), None, "A torque alone"),
    "force_and_torque": lambda: (ring(4, load=(0.3, 0, -0.5, 0.004, 0, 0.01)), None, "A force and a torque"),
    "unequal_slips": lambda: (ring(5, [hl.Coulomb(m) for m in SLIPPERY]), None, "Slips of unequal size"),
    "soft_pads": _soft,
    "bare_hand": _bare,
    "half_bare_hand": lambda: _bare(lambda link: not link.startswith("finger_2")),
    "links_inside": _inside,
}  # fmt: skip


@cache
def case(name: str) -> Any:
    """(grasp, solution, object or None, title)."""
    grasp, obj, title = CASES[name]()
    return grasp, grasp.solve("cone" if name == "soft_pads" else 8, throw=False), obj, title
