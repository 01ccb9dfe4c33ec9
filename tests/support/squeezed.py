"""A pinch and a cube that are squeezed: what envelopes, payloads and load limits are asked of."""

from functools import cache

import handlcp as hl

MU, N, R, K = 0.5, 2.0, 0.02, 1e-3  # of the pinch: friction, grip [N], half width [m], flexibility [m/N]
G = 9.81


@cache
def pinch():
    """Two points that press on an object along x with N each; nothing else is there."""
    left = hl.Contact((-R, 0, 0), (1, 0, 0), MU, name="left")
    right = hl.Contact((R, 0, 0), (-1, 0, 0), MU, name="right")
    return hl.Grasp([left, right], flexibility=K, preload=K * N)


@cache
def flat_pinch():
    """The same in a plane."""
    sides = [hl.Contact((-R, 0), (1, 0), MU), hl.Contact((R, 0), (-1, 0), MU)]
    return hl.Grasp(sides, flexibility=K, preload=K * N)


@cache
def cube(**more):
    """A cube of 0.2 kg in three fingertips, squeezed by 5 mm."""
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    box = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    return hand.at(hand.close_on(box)).grasp(box, friction=0.8, squeeze=0.005, **more)
