"""What one solve costs: its parts beside bare Pinocchio, verdicts, effects, rigid contacts, cones beside QuantEcon.

    python -m tests.benchmarks.solve [--rounds 400] [--scenes 60]

Posture to torques of a ball in the five-finger hand, in turns with the kinematics that it needs. Then random rings of
five fingers: what a "no" costs beside a "yes", and `solve_lcp` beside Lemke's method where QuantEcon is installed
(`pip install '.[bench]'`).
"""

from __future__ import annotations

import functools
import itertools
from collections import defaultdict
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

import numpy as np
import pinocchio as pin

import handlcp as hl
from tests.benchmarks.measure import best_times, median_times, options, print_ratios, print_table
from tests.grasp.scenes import ring

__all__ = ["main"]

FACES = 8
SECTIONS: tuple[Any, ...] = (8, 16, 32, "cone")
BALL = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
MOTOR = hl.Motor(0.005, 0.02, holding=3.0, friction=0.05, reduction=100.0, efficiency=0.7, thermal_time=20.0)
Make = Callable[[], hl.Grasp]


def split(rounds: int) -> dict[str, float]:
    """Print and return the parts of posture → torques as multiples of bare Pinocchio."""
    hand = hl.example_hand("five_finger", joint_stiffness=5.0)
    q = hand.close_on(BALL, squeeze=3e-3)
    seen = hand.at(q).grasp(BALL, hl.Coulomb(0.6))
    load = np.array([0, 0, -0.2 * 9.81, 0, 0, 0])
    data, tips = hand.model.createData(), [hand.model.getFrameId(name) for name in hand.fingertips]

    def bare() -> None:
        pin.framesForwardKinematics(hand.model, data, q)
        pin.computeJointJacobians(hand.model, data, q)
        for tip in tips:
            pin.getFrameJacobian(hand.model, data, tip, pin.LOCAL_WORLD_ALIGNED)

    def grasp(state: hl.HandState) -> hl.HandGrasp:
        return state.grasp(seen.contacts, wrench=load, offset=seen.offset, reference=seen.reference)

    state, stream = hand.at(q), hl.GraspStream(grasp(hand.at(q)), FACES)
    times = median_times({
        "bare Pinocchio: FK, joint Jacobians, 5 frame Jacobians": bare,
        "hand.at(q)": lambda: hand.at(q),
        "state.grasp(contacts)": lambda: grasp(state),
        "posture → torques": lambda: grasp(hand.at(q)).solve(FACES).torques,
        "posture → torques, contacts detected": lambda: hand.at(q).grasp(BALL, hl.Coulomb(0.6)).solve(FACES).torques,
        "posture → torques as an update of a stream": lambda: stream.update(q, wrench=load).torques,
    }, rounds)  # fmt: skip
    return print_ratios(f"One grasp, five fingers, {FACES} faces", times)


def rings(count: int, preload: float = 0.02) -> list[Make]:
    """Random rings of five fingers; in half of them a joint couples all fingers."""
    rng = np.random.default_rng(0)
    made = [ring(rng, 5, rng.uniform(0.3, 1.0), preload * rng.uniform(0.1, 1.5), k % 2 == 0) for k in range(count)]
    return [functools.partial(hl.Grasp, contacts, **more) for contacts, more in made]


def solve_of(make: Make, faces: Any) -> Callable[[], Callable[[], Any]]:
    """A solve of a grasp that is new every time."""

    def task() -> Callable[[], Any]:
        grasp = make()
        return lambda: grasp.solve(faces, throw=False)

    return task


def verdicts(scenes: int, rounds: int) -> dict[str, float]:
    """Print and return what each status costs, as a multiple of a grasp that is held; squeezed and not squeezed."""
    found: dict[tuple[Any, str], list[float]] = defaultdict(list)
    for faces, make in itertools.product((FACES, "cone"), [*rings(scenes), *rings(scenes // 2, 0.0)]):
        status = make().solve(faces, throw=False).status.name
        found[faces, status].append(best_times({"solve": solve_of(make, faces)}, rounds, 1)["solve"])
    ratios, rows = {}, []
    for (faces, status), times in sorted(found.items(), key=str):
        ratio = median(times) / median(found[faces, "SOLVED"])
        ratios[f"{status}, {faces}"] = ratio
        rows.append((status, str(faces), str(len(times)), f"{1e6 * median(times):.0f}", f"{ratio:.1f}"))
    print_table("Verdicts, medians over random rings", ("status", "faces", "grasps", "µs", "× held"), rows)
    return ratios


def effects(rounds: int) -> dict[str, float]:
    """Print and return what a solve takes with an effect, as a multiple of the one without."""
    stiff: dict[str, Any] = {"joint_stiffness": 6.0, "pad_flexibility": 2e-4}
    ball: dict[str, Any] = {"friction": 0.6, "squeeze": 3e-3}

    def made(hand: dict[str, Any], more: dict[str, Any]) -> hl.HandGrasp:
        own = hl.example_hand("five_finger", **stiff | hand)
        return own.at(own.close_on(BALL)).grasp(BALL, **ball | more)

    most = 0.9 * float(made({}, {}).solve(FACES).normal_force.max())
    asked: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
        "no effect": ({}, {}),
        "the same, once more: the noise": ({}, {}),
        "geared motors": ({"motors": MOTOR}, {}),
        "soft fingers": ({}, {"friction": hl.SoftFinger(0.6, 0.006)}),
        "soft wrist": ({}, {"effects": [hl.SoftWrist(np.full(6, 1e-4))]}),
        "contact compliance": ({}, {"effects": [hl.ContactCompliance(1e-4)]}),
        "bounds of finger forces": ({}, {"effects": [hl.FingerForceBound(most)]}),
        "geometric stiffness": ({}, {"effects": [hl.GeometricStiffness()]}),
    }
    pulls = np.random.default_rng(0).uniform(-0.5, 0.5, (64, 6)) * [1, 1, 1, 0.02, 0.02, 0.02]

    def task(grasp: hl.HandGrasp) -> Callable[[], Callable[[], Any]]:
        numbers = itertools.count()

        def ready() -> Callable[[], Any]:
            loaded = grasp.replace(load=pulls[next(numbers) % len(pulls)])
            return lambda: loaded.solve(FACES, throw=False)

        return ready

    tasks = {name: task(made(*more)) for name, more in asked.items()}
    return print_ratios("Effects, five fingers", best_times(tasks, max(2, rounds // 20), 10))


def rigid(rounds: int) -> dict[str, float]:
    """Print and return what a plate on n rigid legs costs, as multiples of the same on flexible ones; then what is open
    read, and the answer printed.
    """

    def legs(n: int, flexibility: float) -> hl.Grasp:
        angles = 2 * np.pi * np.arange(n) / n
        contacts = [hl.Contact((np.cos(a), np.sin(a), 0), (0, 0, 1), 0.5) for a in angles]
        return hl.Grasp(contacts, wrench=(0, 0, -10, 0, 0, 0), flexibility=flexibility)

    def read(n: int) -> Callable[[], Callable[[], Any]]:
        return lambda: (lambda solution: lambda: str(solution))(legs(n, 0.0).solve())

    ratios, rows = {}, []
    for n in (50, 100, 200):
        tasks = {"flexible": functools.partial(legs, n, 1e-4), "rigid": functools.partial(legs, n, 0.0)}
        times = best_times(
            {name: solve_of(make, "cone") for name, make in tasks.items()} | {"read": read(n)}, rounds, 1
        )
        ratios[str(n)] = times["rigid"] / times["flexible"]
        rows.append((str(n), *(f"{1e3 * t:.1f}" for t in times.values()), f"{ratios[str(n)]:.1f}"))
    print_table("Rigid legs under a plate", ("legs", "flexible ms", "rigid ms", "printed ms", "× flexible"), rows)
    return ratios


def lemke(make: Make, faces: int) -> Callable[[], Callable[[], Any]] | None:
    """QuantEcon's call on the same standard problem; None where it has no answer."""
    from quantecon.optimize import lcp_lemke

    problem = make().problem(faces)
    if not problem.eliminated:
        return None
    M, q = np.array(problem.scaled.M), np.array(problem.scaled.q)
    z = lcp_lemke(M, q, max_iter=10000).z
    if not (abs(np.minimum(z, M @ z + q)).max() < 1e-6):
        return None
    return lambda: lambda: lcp_lemke(M, q, max_iter=10000)


def sections(scenes: int, rounds: int) -> dict[str, float]:
    """Print and return medians of `solve_lcp` as multiples of 8 faces; beside Lemke as well (the cone: 8 faces)."""
    ours: dict[Any, list[float]] = defaultdict(list)
    beside: dict[Any, list[float]] = defaultdict(list)
    try:
        import quantecon  # noqa: F401
    except ImportError:
        print("quantecon is not installed: handlcp[bench] brings it")
        peer = False
    else:
        peer = True
    for make, faces in itertools.product(rings(scenes), SECTIONS):
        if hl.solve_lcp(make().problem(faces), throw=False).status is not hl.Status.SOLVED:
            continue

        def task(make: Make = make, faces: Any = faces) -> Callable[[], Any]:
            problem = make().problem(faces)
            return lambda: hl.solve_lcp(problem, throw=False)

        theirs = lemke(make, FACES if faces == "cone" else faces) if peer else None
        times = best_times({"ours": task} | ({"theirs": theirs} if theirs else {}), rounds)
        ours[faces].append(times["ours"])
        if theirs:
            beside[faces].append(times["ours"] / times["theirs"])
    ratios, rows = {}, []
    for faces, times in ours.items():
        ratios[f"{faces}"] = median(times) / median(ours[FACES])
        other = f"{median(beside[faces]):.2f}" if beside[faces] else "–"
        cells = str(len(times)), f"{1e6 * median(times):.1f}", f"{ratios[str(faces)]:.2f}", other
        rows.append((str(faces), *cells))
    print_table("solve_lcp on rings of five fingers", ("faces", "grasps", "µs", "× 8 faces", "× QuantEcon"), rows)
    return ratios


def main(arguments: Sequence[str] | None = None) -> dict[str, dict[str, float]]:
    """Measure, print, and return the ratios of each table."""
    parser = options(__doc__)
    parser.add_argument("--rounds", type=int, default=400, help="calls of each part")
    parser.add_argument("--scenes", type=int, default=60, help="random rings")
    asked = parser.parse_args(arguments)
    few = max(1, asked.rounds // 50)
    return {
        "split": split(asked.rounds), "verdicts": verdicts(asked.scenes, few),
        "effects": effects(asked.rounds), "rigid": rigid(few), "sections": sections(asked.scenes, few),
    }  # fmt: skip


if __name__ == "__main__":
    main()
