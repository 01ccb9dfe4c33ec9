"""Two springs that pinch an object, whose limits have closed forms."""

import numpy as np

import handlcp as hl
from tests.loading.poles import sliders

K, C = 500.0, 1e-4  # of each joint [N/m], of each pad [m/N]


def pinch(tmp_path, friction=0.6, normal=2.0, left=None, **more):
    """(grasp, normal force): in the plane y = 0, fingers slide along x. left : how far the left one is from the end of
    its range, once it pinches [m]; None: far.
    """
    arm = 0.02
    at = 0.0 if left is None else 1.0 - left  # ranges end at 1 m
    fingers = {"left": ((-arm - at, 0, 0), (1, 0, 0)), "right": ((arm + at, 0, 0), (-1, 0, 0))}
    hand = sliders(tmp_path, fingers, K, pad_flexibility=C, **more)
    law = hl.Coulomb(friction)
    contacts = {
        "left_tip": hl.Contact((-arm, 0, 0), (1, 0, 0), law),
        "right_tip": hl.Contact((arm, 0, 0), (-1, 0, 0), law),
    }
    squeeze = normal * (1.0 / K + C)
    grasp = hand.at(np.full(2, at)).grasp(
        contacts, reference=(0, 0, 0), plane=(0.0, 1.0, 0.0), joint_offset=np.full(2, squeeze)
    )  # fmt: skip
    return grasp, normal
