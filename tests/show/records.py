"""An example of every record."""

from __future__ import annotations

from functools import cache

import numpy as np

import handlcp as hl
from handlcp.method.accuracy import accuracy_cost
from handlcp.method.convergence import convergence
from handlcp.study.gallery import Shelf
from tests.study.test_gallery import made

BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
PUSH = (1.0, 0, 0, 0, 0, 0)


@cache
def pinch(law=None, squeeze=1e-3):
    """Two points that press on an object along x, and have no hand."""
    law = hl.Coulomb(0.5) if law is None else law
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), law) for s in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=squeeze)


@cache
def hand():
    return hl.example_hand("three_finger", joint_stiffness=6.0)


@cache
def held(**more):
    """A cube in a hand."""
    return hand().at(hand().close_on(BOX)).grasp(BOX, hl.Coulomb(0.8), squeeze=5e-3, **more)


def studied():
    return accuracy_cost(pinch(), methods=["NSNGRK polished"], faces=[8], tolerances=[1e-9], left_out=True, repeats=1)


def path_rates(of):
    rates = of.sensitivity()
    rates.of(rates.quantities[0], "friction")
    return rates


EXAMPLES = {
    "GraspSolution": lambda: pinch().solve(accuracy=1e-6),
    "GraspSolution, soft": lambda: pinch(hl.SoftFinger(0.5, 0.01)).solve(),
    "GraspSolution, not held": lambda: pinch(squeeze=0.0).solve(throw=False),
    "HandGraspSolution": lambda: held().solve(),
    "Verdict": lambda: held().check(),
    "Loading": lambda: held().follow(steps=2),
    "Loading, of points": lambda: pinch().follow(steps=2),
    "Equilibria": lambda: pinch().equilibria(faces=4),
    "Explanation": lambda: held().explain(),
    "Suggestions": lambda: held().suggest(),
    "Required": lambda: pinch(squeeze=0.0).required_preload(tolerance=0.1),
    "LoadLimit": lambda: held().load_limit(PUSH, geometry="fixed"),
    "LoadLimit, of points": lambda: pinch().load_limit(PUSH),
    "Margins": lambda: held(wrench=PUSH).margins(),
    "RequiredStiffness": lambda: held().required_stiffness(2e-3),
    "BestChange": lambda: pinch().best_change(),
    "RequiredTorque": lambda: held().required_torque(),
    "Sensitivity": lambda: held().solve().sensitivity(),
    "PathSensitivity": lambda: path_rates(held().load_limit(PUSH, geometry="fixed")),
    "Solutions": lambda: hl.solve_many([pinch(), pinch(squeeze=0.0)]),
    "Audit": lambda: hand().audit(),
    "HandDescription": lambda: hand().describe(),
    "Found": lambda: hl.find_grasp(hand(), hl.Sphere(0.03, mass=0.1), friction=0.8, seed=0),
    "Reliability": lambda: hl.reliability(held(), {"friction": 0.2, "load": 0.1}, 64, workers=1),
    "Sample": lambda: hl.reliability(pinch(), {"friction": 0.2}, 64, workers=1).worst,
    "Envelope": lambda: hl.envelope(held(), directions=12, geometry="fixed"),
    "Envelope, in a plane": lambda: hl.envelope(pinch(), ("yz", 8)),
    "Envelope, gravity": lambda: hl.envelope(held(), directions=6, geometry="fixed", of="gravity"),
    "Envelope, wrenches": lambda: hl.envelope(pinch(), wrenches=np.eye(6)),
    "AccuracyCost": studied,
    "PathCost": lambda: hl.path_cost(pinch(), times=(0.5, 1), repeats=1),
    "Convergence": lambda: convergence(pinch(), seeds=[0], max_iterations=200),
    "Shelf": lambda: Shelf.from_dict(made()),
}  # fmt: skip
