"""A hand of three fingers whose tendons run along routes, and the same hand with the arms of one posture."""

import numpy as np

import handlcp as hl
from handlcp.hand import example_hand

KT, LOAD = 3e4, [2.0, 1.0, 0.0, 0.0, 0.02, 0.0]  # N/m; N, N·m


def threes(extensors, pretension, routed=True, friction=0.0):
    """A box in three fingers with a flexor each, and an extensor. routed : or with the arms that routes have in the
    posture in which the hand has closed. friction : μ.
    """
    ways, routes, ends = {"flexor": -1.0} | ({"extensor": 1.0} if extensors else {}), dict[str, hl.Route](), {}
    for k, a in ((1, 0.0), (2, 2 * np.pi / 3), (3, -2 * np.pi / 3)):
        near, far = f"finger_{k}_proximal_link", f"finger_{k}_distal_link"
        for way, s in ways.items():
            r = 0.045 + s * 0.012
            routes[f"{way} {k}"] = hl.Route([
                hl.Site("palm", (r * np.cos(a), r * np.sin(a), -0.005)), hl.Site(near, (s * 0.009, 0, 0.02)),
                hl.Around(near, ((0, 0, 0.05), (0.0, 1.0, 0.0)), 0.006, side=(s * 0.02, 0, 0.05)),
                hl.Site(far, (s * 0.004, 0, 0.015)),
            ])  # fmt: skip
            ends[f"{way} {k}"] = f"finger_{k}_distal"
    tendons = hl.Tendons(routes, KT, 1.0, pretension=pretension, friction=friction)
    hand = example_hand("three_finger", joint_stiffness=tendons, pad_flexibility=1e-4)
    box = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
    closed = hand.at(hand.close_on(box))
    if not routed:
        there = closed.hand.stiffness
        rows = zip(routes, there.arms, strict=True)
        arms = {name: dict(zip(hand.joint_names, row.tolist(), strict=True)) for name, row in rows}
        posts = zip(ends.items(), there.cables.wrap_friction, strict=True) if friction else ()
        grips = {name: {joint: grip} for (name, joint), grip in posts}
        fixed = hl.Tendons(arms, KT, 1.0, pretension=pretension, friction=grips)
        closed = hand.replace(joint_stiffness=fixed).at(closed.q)
    return closed.grasp(box, friction=0.8, squeeze=0.004, wrench=LOAD)
