"""A little of everything that calls kernels: what `handlcp warm` runs, so that nobody waits for a compiler later.

Kernels are compiled for types of arguments, and which types occur is known best by those who call them. So this calls
what users call, on scenes as small as they may be.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from handlcp.actuation import Route, Site, Tendons
from handlcp.geometry import Sphere
from handlcp.grasp import Contact, Coulomb, Grasp, SoftFinger, solve_many
from handlcp.hand import GraspStream, HandGrasp, example_hand
from handlcp.lcp import LCP, NSNGRK, Auto, Lemke, SemismoothNewton, solve_lcp
from handlcp.lcp.compiler.compile_policy import MANY_CALLS
from handlcp.studies.accuracy.as_printed import AsPrinted, in_units
from handlcp.studies.effect_catalogue import effect_scenes, entries
from handlcp.studies.envelope import envelope

_NO_SEARCH = Auto(search_seconds=0)


@cache
def _reference_grasp() -> HandGrasp:
    """The reference scene of the catalogue, a ball in five fingers."""
    trial = effect_scenes(entries()[0])[1]
    return trial.grasp(trial.state(), trial.ball())


def _pinch(load: float, fingers: int = 2) -> Grasp:
    """Fingers around the z axis with a load along x that pulls the object out from between them."""
    angles = 2 * np.pi * np.arange(fingers) / fingers
    out = [(np.cos(a), np.sin(a), 0.0) for a in angles]
    contacts = [Contact((x / 100, y / 100, z), (-x, -y, z), Coulomb(0.25)) for x, y, z in out]
    return Grasp(contacts, (0, 0, -load, 0, 0, 0), flexibility=1e-4, preload=1e-3)


def _one_solve() -> None:
    for faces in ("cone", 8):
        _reference_grasp().solve(faces, start=_reference_grasp().solve(faces))


def _every_effect() -> None:
    for entry in entries():
        for trial in effect_scenes(entry):
            grasp = trial.grasp(trial.state(), trial.ball())
            solution = grasp.solve(trial.faces, _NO_SEARCH, throw=False)
            grasp.solve(trial.faces, _NO_SEARCH, throw=False, start=solution)
            grasp.explain(trial.faces)


def _every_solver() -> None:
    rows = np.array([[2.0, 1.0, 0.5], [1.0, 2.0, 1.0], [0.5, 1.0, 3.0]])
    for solver in (Lemke(), NSNGRK(), NSNGRK(polish=False), SemismoothNewton(), Auto()):
        for free in (None, np.array([False, False, True])):
            solve_lcp(LCP(rows, [-1.0, 1.0, -2.0], free), solver, throw=False)
        _pinch(1.0).solve(8, solver, throw=False, start=_pinch(1.0).solve(8))
    for contact_solver in (NSNGRK(), NSNGRK(polish=False), SemismoothNewton()):
        _reference_grasp().solve("cone", contact_solver, throw=False)


def _searches() -> None:
    for faces in (4, "cone"):
        for load in (1.0, 6.0, 1e3):  # held, no equilibrium, not holdable
            _pinch(load, fingers=3).solve(faces, throw=False)
        _pinch(1.0).equilibria(faces)
    _pinch(6.0).required_preload()
    _pinch(1.0).required_friction()
    _reference_grasp().suggest(_reference_grasp().solve("cone"), "cone")


def _streams() -> None:
    for grasp in (_reference_grasp(), _pinch(1.0)):
        GraspStream(grasp, "cone").update(wrench=(0, 0, -0.5, 0, 0, 0))
    q = _reference_grasp().state.q
    GraspStream(_reference_grasp(), start=_reference_grasp().solve()).update(q=q)


def _loading() -> None:
    for faces in ("cone", 8):
        _reference_grasp().follow(faces=faces, steps=2)
    _reference_grasp().follow(geometry="fixed", steps=2)
    _pinch(1.0).follow(steps=2)
    trial = effect_scenes(entries()[0])[1]
    state, ball = trial.state(), trial.ball()
    state.grasp(ball, friction=SoftFinger(0.6, 0.003), squeeze=1e-3).follow(steps=2)


def _routes() -> None:
    cable = Route([Site("palm", (0.0, 0.0, -0.02)), Site("finger_1_distal_link", (0.0, 0.0, 0.01))])
    hand = example_hand("three_finger", joint_stiffness=Tendons({"cable": cable}, 1e4, 6.0, pretension=1.0))
    cable.bound(hand.kinematics).slope(hand.neutral)


def _whole_hands() -> None:
    hand, ball = example_hand("five_finger"), Sphere(0.03, placement=(0.0, 0.0, 0.07), mass=0.05)
    whole = hand.at(hand.neutral).grasp(ball, links="all", closing_torque=0.2, hold_object=True)  # 15 contacts
    whole.solve(throw=False)
    whole.follow(steps=2)


def _limits() -> None:
    down, law = (0, 0, -1, 0, 0, 0), SoftFinger(0.6, 0.003)
    tips = [Contact((-0.02 * x, 0, 0), (x, 0, 0), law) for x in (-1, 1)]
    soft = Grasp(tips, flexibility=1e-4, preload=1e-3)
    for faces in ("cone", 8):
        for grasp in (_reference_grasp(), _pinch(1.0), soft):
            grasp.load_limit(down, geometry="fixed", faces=faces)
            envelope(grasp, np.eye(3), faces=faces, adaptive=0)
    _reference_grasp().load_limit(down)


def _derivatives() -> None:
    for faces in ("cone", 8):
        for grasp in (_reference_grasp(), _pinch(1.0)):
            str(grasp.solve(faces).sensitivity())


def _batches() -> None:
    solve_many([_pinch(1.0)] * MANY_CALLS, workers=1)


def _studies() -> None:
    for problem in (LCP(np.diag([1.0, 2.0]), [-1.0, 1.0]), _pinch(1.0).problem(8)):
        for units in ("natural", "given"):
            for method in (AsPrinted(max_iterations=3), NSNGRK(max_iterations=3, polish=False, stride=1)):
                method.propose(in_units(problem, units)[0])


JOBS: tuple[tuple[str, Callable[[], None]], ...] = (
    ("one solve", _one_solve),
    ("every effect", _every_effect),
    ("every solver", _every_solver),
    ("searches", _searches),
    ("streams", _streams),
    ("loading", _loading),
    ("tendons along routes", _routes),
    ("whole hands", _whole_hands),
    ("load limits", _limits),
    ("derivatives", _derivatives),
    ("batches", _batches),
    ("studies", _studies),
)
