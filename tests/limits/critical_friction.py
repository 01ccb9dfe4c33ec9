"""A pinched object at a share of the least friction that holds it: the test by which simulators are compared.

    python -m tests.limits.critical_friction    prints the table of the documentation

Two, three or five fingers press on a cylinder from around, each with N, and its weight W pulls along its axis. By
symmetry each bears W / n across, so that the least friction is W / (n N), however soft fingers and pads are. "hard" is
Coulomb's law on pads of 1 µm/N, "soft" a soft finger on pads of 1 mm/N.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import handlcp as hl
from tests.loading.hands import sliders

SHARES = (0.90, 0.99, 0.999, 1.001, 1.01, 1.10)
FINGERS = (2, 3, 5)
KINDS = {"hard": 1e-6, "soft": 1e-3}  # of the pads [m/N]
CRITICAL, N = 0.5, 10.0  # [-], of each finger [N]
RADIUS, TIP, K, TORSION, G = 0.03, 0.005, 2000.0, 0.004, 9.81  # [m], [m], [N/m], [m], [m/s²]


def weight_of(fingers: int) -> float:
    """[N] whose least friction is `CRITICAL`."""
    return CRITICAL * fingers * N


def law_of(kind: str, mu: float) -> hl.Coulomb | hl.SoftFinger:
    """The friction law with this coefficient."""
    return hl.Coulomb(mu) if kind == "hard" else hl.SoftFinger(mu, TORSION)


def ways_around(fingers: int) -> np.ndarray:
    """(n, 3) directions in which the fingers press."""
    turns = 2 * np.pi * np.arange(fingers) / fingers
    return -np.column_stack([np.cos(turns), np.sin(turns), np.zeros(fingers)])


def bare_contacts(fingers: int, kind: str, share: float) -> hl.Grasp:
    """Contacts alone, under the weight."""
    pads, law = KINDS[kind], law_of(kind, share * CRITICAL)
    contacts = [hl.Contact(tuple(-RADIUS * way), tuple(way), law) for way in ways_around(fingers)]
    return hl.Grasp(contacts, (0, 0, -weight_of(fingers), 0, 0, 0), flexibility=pads, preload=N * pads)


def hand_of_sliders(folder: Path, fingers: int, kind: str, share: float) -> hl.HandGrasp:
    """A hand of prismatic fingers: its normal forces do not hang on how far the cylinder sinks."""
    pads, ways = KINDS[kind], ways_around(fingers)
    tips = {f"f{k}": (tuple(-(RADIUS + TIP) * way), tuple(way)) for k, way in enumerate(ways)}
    hand = sliders(folder, tips, K, pad_flexibility=pads, torque_limits=np.inf, tip_radius=TIP)
    can = hl.Cylinder(RADIUS, 0.1, mass=weight_of(fingers) / G)
    command = np.full(fingers, N * (1.0 / K + pads))
    return hand.at(hand.neutral).grasp(can, law_of(kind, share * CRITICAL), joint_offset=command)


def example_hand(fingers: int, law: hl.Coulomb | hl.SoftFinger) -> hl.HandGrasp:
    """A shipped hand around a ball, whose weight pulls it out of the hand."""
    name = {2: "two_finger", 3: "three_finger", 5: "five_finger"}[fingers]
    hand = hl.example_hand(name, joint_stiffness=6.0, torque_limits=np.inf)
    ball = hl.Sphere(0.03, (0, 0, 0.085), mass=0.3)
    return hand.at(hand.close_on(ball)).grasp(ball, law, gravity=(0, 0, G), squeeze=0.003)


def least_friction(grasp: hl.HandGrasp) -> float:
    """Of a grasp that sticks: the largest share of friction that a finger needs on the way."""
    forces = np.asarray(grasp.follow().steps.forces)
    pressed = forces[:, :, 2] > 0.0
    needed = np.hypot(forces[:, :, 0], forces[:, :, 1]) / np.where(pressed, forces[:, :, 2], np.inf)
    return float(needed.max())


def words_of(fingers: int, kind: str, folder: Path | None = None) -> list[str]:
    """The verdicts at all shares; of bare contacts without a folder."""
    made = (
        bare_contacts(fingers, kind, share) if folder is None else hand_of_sliders(folder, fingers, kind, share)
        for share in SHARES
    )  # fmt: skip
    return [grasp.check().word for grasp in made]


def main() -> int:
    """Print the table; 1 where a word does not flip between the two shares next to 1."""
    expected, wrong = ["HELD" if share > 1.0 else "NOT HELD" for share in SHARES], 0
    print("| μ / μ_crit | " + " | ".join(f"{share:g}" for share in SHARES) + " |")
    print("| --- |" + " --- |" * len(SHARES))
    with tempfile.TemporaryDirectory() as folder:
        for where, kept in (("bare contacts", None), ("a hand", Path(folder))):
            for fingers in FINGERS:
                for kind in KINDS:
                    words = words_of(fingers, kind, kept)
                    wrong += words != expected
                    print(f"| {fingers} fingers, {kind}, {where} | " + " | ".join(words) + " |", flush=True)
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main())
