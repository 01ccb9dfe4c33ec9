"""The example hand with three fingers, and one with the same motors that holds half as much again.

Run it: `python examples/optimise_hand.py` (a minute or two on two cores)
"""

from __future__ import annotations

from math import cos, pi, sin

import handlcp as hl

HAND = hl.example_hand("three_finger", joint_stiffness=4.0)  # motors of 0.8 and 0.4 N·m
GRIP = 6.5  # N: the grip with which the hand as it is holds most
SPACE = {  # m, N·m/rad, N
    "proximal": (0.035, 0.055), "distal": (0.025, 0.045), "radius": (0.03, 0.05), "stiffness": (3.0, 10.0, "log"),
    "grip": (5.0, 12.0),
}  # fmt: skip


def make(proximal: float, distal: float, radius: float, stiffness: float) -> hl.Hand:
    """The hand with links of these lengths, its fingers so far from the palm's axis [m]."""
    changes: dict[str, object] = {"joint_stiffness": stiffness}
    for k in range(3):
        at = 2 * pi * k / 3
        changes[f"finger_{k + 1}_proximal.length"] = proximal
        changes[f"finger_{k + 1}_distal.length"] = distal
        changes[f"finger_{k + 1}_proximal.position"] = (radius * cos(at), radius * sin(at), 0.0)
    return HAND.vary(changes)


def brief(grip: float) -> hl.Brief:
    """A ball, gripped with so many newtons a finger."""
    return hl.Brief({"ball": hl.Sphere(0.03, mass=0.2)}, friction=0.6, grip_force=grip, tries=64)


def main(budget: int = 120, mujoco: bool = False) -> tuple[hl.Evaluation, hl.Best]:
    """The hand as it is, and the best that was found."""
    before = hl.evaluate(HAND, brief(GRIP))
    best = hl.optimise(make, SPACE, brief, "payload", budget=budget, mujoco=mujoco)
    print(f"{before.payload:.3f} kg as it is: {before.gives_out}", best, sep="\n\n")
    assert best.evaluation().payload > 1.3 * before.payload
    assert (best.hand().torque_limits == HAND.torque_limits).all()
    return before, best


if __name__ == "__main__":
    main()
