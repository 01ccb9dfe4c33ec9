"""The wrench on the object from force sensors in the fingertips, as the paper's introduction proposes to use them.

The paper gives no numbers for it: this is its Example 5, a cube on three hard and two frictionless fingers, with a push
from the side besides its weight. First the readings are those of a known wrench, which comes back; then they are noisy,
and the wrench read from their mean gives what no fingertip feels: slips, and how the object moves.

Run it: `python examples/paper/wrench_from_fingertips.py`
"""

from __future__ import annotations

import numpy as np

import handlcp as hl

CENTRE = (0.5, 0.5, 0.5)  # m, of a cube with 1 m edges: wrench and motion refer to it
WRENCH = np.array([0.1, 0.2, -5.0, 0.0, 0.0, 0.0])  # N, N·m: the weight of 5 N, and a push
NOISE = 0.02  # N, standard deviation of a reading, each axis for itself
READINGS = 100


def example_5() -> hl.Grasp:
    """Example 5 with Example 2's flexibility, in m/N, as it gives none of its own."""
    hard, smooth = hl.Coulomb(0.6), hl.Frictionless()
    contacts = [
        hl.Contact((0, 0.75, 0.75), (1, 0, 0), hard),
        hl.Contact((0.75, 0, 0.75), (0, 1, 0), hard),
        hl.Contact((0.75, 0.75, 0), (0, 0, 1), hard),
        hl.Contact((1, 0.25, 0.25), (-1, 0, 0), smooth),
        hl.Contact((0.25, 1, 0.25), (0, -1, 0), smooth),
    ]
    return hl.Grasp(contacts, WRENCH, flexibility=(6e-6, 6e-6, 1.5e-6), reference=CENTRE)


def main() -> hl.GraspSolution:
    """There and back, then with noise."""
    grasp = example_5()
    truth = grasp.solve()
    back = hl.wrench_from_fingertip_forces(grasp, truth.forces)
    print(f"put on the object  {numbers(WRENCH)} N, N·m")
    print(f"read back          {numbers(back)} from {grasp.scene.n} fingertips")
    assert abs(back - WRENCH).max() < 1e-9 * abs(WRENCH).max()

    rng = np.random.default_rng(1)
    readings = truth.forces + NOISE * rng.standard_normal((READINGS, *truth.forces.shape))
    one = hl.wrench_from_fingertip_forces(grasp, readings[0])
    mean = hl.wrench_from_fingertip_forces(grasp, readings.mean(axis=0))
    spread = NOISE * np.sqrt(grasp.scene.n)  # N: the fingers' errors add up as their squares do
    print(f"one noisy reading  {numbers(one)} ± {1e3 * spread:.1f} mN")
    print(f"mean of {READINGS}        {numbers(mean)} ± {1e3 * spread / np.sqrt(READINGS):.1f} mN")
    assert abs(one - WRENCH)[:3].max() < 4 * spread
    assert abs(mean - WRENCH)[:3].max() < 4 * spread / np.sqrt(READINGS)

    solution = grasp.replace(wrench=mean).solve()
    print("\nUnder that wrench:")
    for name, state, slip in zip(solution.names, solution.contact_state, solution.slip, strict=True):
        print(f"  {name} {state}, slip {1e6 * np.hypot(*slip):.1f} µm")
    moved, truly = (1e6 * np.linalg.norm(s.object_displacement[:3]) for s in (solution, truth))
    print(f"  the cube's centre moves {moved:.1f} µm; {truly:.1f} µm under the true one")
    assert abs(moved - truly) < 0.05 * truly
    return solution


def numbers(wrench: np.ndarray) -> str:
    """In N and N·m, to a millinewton."""
    return "(" + ", ".join(f"{x + 0.0:6.3f}" for x in np.round(wrench, 3)) + ")"


if __name__ == "__main__":
    main()
