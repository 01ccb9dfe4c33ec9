"""From a hand to forces, slips and torques in ten lines: a ball, held from above by a hand with five fingers.

Run it: `python examples/quickstart.py`
"""

from __future__ import annotations

import handlcp as hl

MASS, G = 0.3, 9.81  # kg, m/s²


def main() -> hl.HandGraspSolution:
    """Pose, build, solve, read off."""
    hand = hl.example_hand("five_finger", joint_stiffness=6.0)  # N·m/rad
    ball = hl.Sphere(radius=0.035, placement=(0, 0, 0.07), mass=MASS)
    q = hand.close_on(ball)  # each finger flexes until it touches
    grasp = hand.at(q).grasp(
        ball, friction=hl.Coulomb(0.6), gravity=(0, 0, G), squeeze=0.003
    )  # the hand hangs: +z is down; the joints are commanded to take each tip 3 mm deeper
    solution = grasp.solve()

    print(grasp.explain(), end="\n\n")
    print(solution)

    # The fingers carry the weight, all the same, and each by a fifth.
    lift = -solution.forces_world[:, 2]
    assert abs(lift.sum() - MASS * G) < 1e-8 * MASS * G
    assert abs(lift - MASS * G / 5).max() < 1e-3 * MASS * G
    assert solution.torque_check.ok
    return solution


if __name__ == "__main__":
    main()
