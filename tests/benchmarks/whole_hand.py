"""What many contacts cost: power grasps of 5 to 60 contacts of a hand with 16 joints, beside those of five fingers.

    python -m tests.benchmarks.whole_hand                      times, and what becomes of 200 random grasps
    python -m tests.benchmarks.whole_hand --times --rounds 20
    python -m tests.benchmarks.whole_hand --statuses --count 100

Four fingers with four joints each close around a cylinder, a ball or a box; contacts lie on all phalanges and on the
palm, which no joint moves. Times are the best of some rounds, in turns, and ratios are of medians over the grasps.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np
from rich.console import Console

import handlcp as hl
from handlcp.check import Array
from tests.benchmarks.clock import best_times
from tests.benchmarks.report import conditions, opened, plain_table

__all__ = ["PowerGrasp", "power_grasp"]

COUNTS = (5, 10, 20, 40, 60)
FINGERS, JOINTS = 4, 4
_FLEXION = np.deg2rad((-60.0, 5.0, 60.0, 110.0))  # where around the object phalanges begin, and the last one ends
_WEAK, _STRONG = 0.15, 0.6


@dataclass(frozen=True)
class PowerGrasp:
    """Arrays of a grasp with n contacts, SI: jacobian (3n, 16) in contact axes, stiffness (16,), pads (n,) [m/N],
    command (16,) of the joints beyond their posture, wrench (6,) about the world's origin.
    """

    contacts: tuple[hl.Contact, ...]
    jacobian: Array
    stiffness: Array
    pads: Array
    command: Array
    wrench: Array

    @property
    def offset(self) -> Array:
        """(n, 3) of the object relative to the hand: the closing command."""
        return -(self.jacobian @ self.command).reshape(-1, 3)

    @property
    def flexibility(self) -> Array:
        """(3n, 3n) E as one matrix."""
        return (self.jacobian / self.stiffness) @ self.jacobian.T + np.diag(np.repeat(self.pads, 3))

    def dense(self) -> hl.Grasp:
        """The grasp, with E as one matrix."""
        return hl.Grasp(self.contacts, self.wrench, flexibility=self.flexibility, offset=self.offset)

    def factored(self) -> hl.Grasp:
        """The same grasp, with E as a factor."""
        pads = self.pads[:, None, None] * np.eye(3)
        E = hl.Flexibility(self.jacobian, np.diag(1.0 / np.sqrt(self.stiffness)), pads)
        return hl.Grasp(self.contacts, self.wrench, flexibility=E, offset=self.offset)


def power_grasp(n: int, seed: int, friction: float | None = None, loaded: bool = True) -> PowerGrasp:
    """A random one with n contacts; friction None: 0.15 or 0.6. loaded : by more than its weight."""
    rng = np.random.default_rng((n, seed))
    shape, size = rng.integers(3), rng.uniform(0.028, 0.045)
    mu = float(rng.choice((_WEAK, _STRONG))) if friction is None else friction
    palm = max(1, int(rng.binomial(n - FINGERS, 0.15)))
    fingers = (*np.arange(FINGERS), *rng.integers(0, FINGERS, n - palm - FINGERS), *[-1] * palm)
    contacts, rows = [], []
    places = np.array([-0.026, 0.0, 0.026, -0.01])  # of the fingers along the object; the last is the thumb
    for finger in fingers:
        side = -1.0 if finger == FINGERS - 1 else 1.0
        if finger < 0:
            phalanx, angle, along = -1, rng.uniform(-2.2, -0.95), rng.uniform(-0.03, 0.03)
        else:
            # One contact a finger of a grasp with few is on its last phalanx
            phalanx = 2 if n <= 2 * FINGERS else int(rng.integers(3))
            angle = rng.uniform(_FLEXION[phalanx] + 0.15, _FLEXION[phalanx + 1] - 0.1)
            along = places[finger] + rng.uniform(-0.006, 0.006)
        point, inward = _surface(int(shape), size, angle, along)
        if side < 0.0:
            point, inward = point * (-1, 1, 1), inward * (-1, 1, 1)
        contact = hl.Contact(tuple(point), tuple(inward), mu)
        contacts.append(contact)
        rows.append(contact.rotation.T @ _velocity(int(finger), phalanx, point, size, side, places))
    torque = np.zeros((FINGERS, JOINTS))
    torque[:, 1:] = rng.uniform(0.15, 0.5, (FINGERS, 1)) * np.array((1.0, 0.7, 0.4)) * rng.uniform(0.8, 1.2, (4, 3))
    torque[-1] *= 1.5
    stiffness = 2.0 * np.exp(0.3 * rng.normal(size=FINGERS * JOINTS))
    down = rng.normal(size=3)
    weight = 9.81 * rng.uniform(0.1, 0.6) * down / np.linalg.norm(down)
    load = rng.normal(size=6) * (1.0, 1.0, 1.0, 0.03, 0.03, 0.03)
    load *= 10.0 ** rng.uniform(-0.5, 1.3) if loaded else 0.0
    return PowerGrasp(
        tuple(contacts), np.concatenate(rows), stiffness, 10.0 ** rng.uniform(-5.0, -4.0, n),
        torque.ravel() / stiffness, np.append(weight, np.zeros(3)) + load,
    )  # fmt: skip


def _surface(shape: int, size: float, angle: float, along: float) -> tuple[Array, Array]:
    """(point, normal into the object) at an angle about its axis y: of a cylinder, a ball or a box."""
    x, z = np.cos(angle), np.sin(angle)
    if shape == 0:
        return np.array((size * x, along, size * z)), np.array((-x, 0.0, -z))
    if shape == 1:
        ball = 1.25 * size
        point = np.array((x * np.sqrt(ball**2 - along**2), along, z * np.sqrt(ball**2 - along**2)))
        return point, -point / ball
    far = size / max(abs(x), abs(z))
    normal = (-np.sign(x), 0.0, 0.0) if abs(x) > abs(z) else (0.0, 0.0, -np.sign(z))
    return np.array((far * x, along, far * z)), np.array(normal)


def _velocity(finger: int, phalanx: int, point: Array, size: float, side: float, places: Array) -> Array:
    """(3, 16) of a point on a phalanx, world axes: joint 0 swings the finger sideways, 1 to 3 bend it."""
    J = np.zeros((3, FINGERS * JOINTS))
    for k in range(1 + phalanx + 1 if finger >= 0 else 0):
        angle = _FLEXION[max(k - 1, 0)]
        radius = 1.2 * size + 0.01
        joint = np.array((side * radius * np.cos(angle), places[finger], radius * np.sin(angle)))
        axis = np.array((0.0, 0.0, 1.0)) if k == 0 else np.array((0.0, -side, 0.0))
        J[:, JOINTS * finger + k] = np.cross(axis, point - joint)
    return J


# ----------------------------------------------------------------

Make = Callable[[PowerGrasp], hl.Grasp]
WAYS: dict[str, Make] = {"dense E": PowerGrasp.dense, "factored E": PowerGrasp.factored}


def times(console: Console, rounds: int, count: int) -> None:
    """Time of a held solve, by contacts, beside five."""
    rows: dict[tuple[str, int], list[float]] = {}
    for n in COUNTS:
        held = [
            g
            for k in range(20 * count)
            if (g := power_grasp(n, k, _STRONG, loaded=False)).dense().solve(throw=False).held
        ]
        for g in held[:count]:
            tasks = {way: _solving(make, g) for way, make in WAYS.items()}
            for way, seconds in best_times(tasks, rounds).items():
                rows.setdefault((way, n), []).append(seconds)
    table = plain_table(
        "A held grasp, friction 0.6", "contacts", *[w for way in WAYS for w in (f"{way} [µs]", "ratio")]
    )
    for n in COUNTS:
        cells = []
        for way in WAYS:
            now, five = median(rows[way, n]), median(rows[way, COUNTS[0]])
            cells += [f"{1e6 * now:.0f}", f"{now / five:.1f}"]
        table.add_row(str(n), *cells)
    console.print(table)


def _solving(make: Make, g: PowerGrasp) -> Callable[[], Callable[[], Any]]:
    def task() -> Callable[[], Any]:
        grasp = make(g)
        return lambda: grasp.solve(throw=False).forces

    return task


def statuses(console: Console, count: int) -> None:
    """What becomes of random grasps of 10 to 60 contacts, half of them with weak friction."""
    rng = np.random.default_rng(0)
    found: dict[float, Counter[str]] = {_WEAK: Counter(), _STRONG: Counter()}
    for k in range(count):
        mu = (_WEAK, _STRONG)[k % 2]
        g = power_grasp(int(rng.integers(10, 61)), 1000 + k, mu)
        s = g.dense().solve(throw=False)
        found[mu][s.status.name] += 1
        if s.status.name == "UNDECIDED":
            console.print(f"  UNDECIDED: power_grasp({len(g.contacts)}, {1000 + k}, {mu})")
    names = sorted({name for c in found.values() for name in c})
    table = plain_table(f"{count} random power grasps of 10 to 60 contacts", "friction", *names)
    for mu, c in found.items():
        table.add_row(f"{mu:g}", *[str(c[name]) for name in names])
    console.print(table)
    share = sum(c["UNDECIDED"] for c in found.values()) / count
    console.print(f"UNDECIDED: {share:.1%}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", action="store_true", help="only the times")
    parser.add_argument("--statuses", action="store_true", help="only what becomes of random grasps")
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--grasps", type=int, default=5, help="timed grasps of each number of contacts")
    parser.add_argument("--count", type=int, default=200, help="random grasps")
    o = parser.parse_args()
    console = opened(120)
    console.print(conditions(), highlight=False)
    if o.times or not o.statuses:
        times(console, o.rounds, o.grasps)
    if o.statuses or not o.times:
        statuses(console, o.count)


if __name__ == "__main__":
    main()
