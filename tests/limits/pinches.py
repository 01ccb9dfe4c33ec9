"""Two springs, or two bare contacts, that pinch an object, whose limits have closed forms."""

import numpy as np

import handlcp as hl
from tests.loading.hands import sliders

K, C = 500.0, 1e-4  # of each joint [N/m], of each pad [m/N]


def bare_pinch(law=0.4, squeeze=1e-3, along=(1, 0, 0), tangent=None, **more):
    """Two contacts, 60 mm apart, that give way by C and press with squeeze / C each."""
    d = np.asarray(along, dtype=float)
    ends = [hl.Contact(tuple(-0.03 * way), tuple(way), law, tangent) for way in (d, -d)]
    return hl.Grasp(ends, flexibility=C, preload=squeeze, **more)


def pinch(tmp_path, friction=0.6, normal=2.0, left=None, **more):
    """(grasp, normal force): in the plane y = 0, fingers slide along x. left : how far the left one is from the end of
    its range, once it pinches [m]; None: far.
    """
    arm = 0.02
    at = 0.0 if left is None else 1.0 - left  # ranges end at 1 m
    fingers = {"left": ((-arm - at, 0, 0), (1, 0, 0)), "right": ((arm + at, 0, 0), (-1, 0, 0))}
    hand = sliders(tmp_path, fingers, K, pad_flexibility=C, **more)
    law = hl.Coulomb(friction)
    sides = {"left_tip": 1, "right_tip": -1}
    contacts = {tip: hl.Contact((-way * arm, 0, 0), (way, 0, 0), law) for tip, way in sides.items()}
    command = np.full(2, normal * (1.0 / K + C))
    state = hand.at(np.full(2, at))
    return state.grasp(contacts, reference=(0, 0, 0), plane=(0.0, 1.0, 0.0), joint_offset=command), normal


def polygon(faces, angle):
    """How far an inscribed regular polygon of friction reaches at an angle from a face's normal; the cone has 1."""
    if faces == "cone":
        return 1.0
    turns = angle - 2 * np.pi * np.arange(faces) / faces
    return np.cos(np.pi / faces) / np.cos(turns).max()
