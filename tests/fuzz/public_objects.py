"""An object of each public class that has methods, for calls of them, each small enough to be made at once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import handlcp as hl
from tests.design import optima

BALL = hl.Sphere(0.03, (0, 0, 0.08), mass=0.1)
PUSH = (1.0, 0, 0, 0, 0, 0)
TENDONS = {"a": {"finger_1_proximal": 0.01}, "b": {"finger_1_distal": 0.01}}

LAWS = ("AnisotropicCoulomb", "Coulomb", "Frictionless", "SoftFinger")
PAGES = ("Envelope", "GraspSolution", "HandGraspSolution", "Loading", "Study")
ONE_METHOD = {"methods": ["NSNGRK polished"], "faces": [8], "tolerances": [1e-9], "left_out": False, "repeats": 1}
SHAPES = ("Box", "Cylinder", "Ellipsoid", "Mesh", "Sphere", "YCB")
URDF = """<robot name="bar"><link name="palm"/><link name="bar"/><joint name="turn" type="revolute">
<parent link="palm"/><child link="bar"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
TIP = {"tip": ("bar", (0, 0, 0.05))}
MJCF = """<mujoco><worldbody><body name="palm"><body name="bar"><joint name="turn" axis="0 1 0"/>
<geom size=".01" pos="0 0 .05"/></body></body></worldbody></mujoco>"""


def cube_file():
    """A mesh file in the working folder."""
    import trimesh

    trimesh.creation.box((0.05, 0.05, 0.05)).export("cube.stl")
    return "cube.stl"


@cache
def hand():
    return hl.example_hand("two_finger", joint_stiffness=6.0, torque_limits=3.0)


def hands():
    return {"one": hand(), "other": hand().scale_stiffness(2.0)}


@cache
def state():
    return hand().at(hand().close_on(BALL))


@cache
def held():
    """A ball in two fingers with soft pads of their own moment."""
    return state().grasp(BALL, hl.SoftFinger(0.8, 0.005), grip_force=5.0)


@cache
def three():
    return hl.example_hand("three_finger", joint_stiffness=6.0)


@cache
def hard():
    """A ball in two fingers, at points."""
    return state().grasp(BALL, 0.8, grip_force=5.0)


@cache
def pinch():
    """Two points that press on an object, and have no hand."""
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(0.5)) for s in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)


@cache
def brief():
    return hl.Brief(BALL, grip_force=5.0, tries=2)


@cache
def found():
    return hl.find_grasp(hand(), hl.Sphere(0.03, mass=0.1), friction=0.8, tries=8)


@cache
def evaluation():
    return hl.evaluate(hand(), brief())


@cache
def study():
    return hl.sweep(optima.make, {"force": (0.5, 2.0)}, optima.brief, samples=2, executor="serial", progress=False)


@cache
def cost():
    return hl.accuracy_cost(pinch(), **ONE_METHOD)


def lcp():
    return hl.LCP([[2.0, 1.0], [1.0, 2.0]], [-1.0, 1.0])


def tendons():
    return hl.Tendons(TENDONS, 1e3, 1.0)


# The objects whose methods are called; each made when it is first asked for
MADE: dict[str, Callable[[], Any]] = {
    "Accuracy": lambda: pinch().solve(accuracy=1e-6).accuracy,
    "AccuracyCost": cost,
    "AnisotropicCoulomb": lambda: hl.AnisotropicCoulomb(0.5, 0.2),
    "Audit": lambda: hand().audit(),
    "Around": lambda: hl.Around("palm", ((0, 0, 0), (0, 0, 1)), 0.01),
    "Auto": hl.Auto,
    "Best": lambda: optima.run(budget=1),
    "BestChange": lambda: pinch().best_change(),
    "Box": lambda: hl.Box(0.05),
    "Brief": brief,
    "Candidate": lambda: found()[0],
    "Contact": lambda: pinch().contacts[0],
    "Coulomb": lambda: hl.Coulomb(0.5),
    "Cylinder": lambda: hl.Cylinder(0.03, 0.1),
    "Ellipsoid": lambda: hl.Ellipsoid((0.03, 0.02, 0.04)),
    "Envelope": lambda: hl.envelope(pinch(), 6, faces=8, adaptive=0),
    "Equilibria": lambda: pinch().equilibria(faces=4),
    "Evaluation": evaluation,
    "Explanation": lambda: pinch().explain(),
    "FingerStrength": lambda: hl.finger_strength(hand()),
    "ForceBounds": lambda: pinch().solve().force_bounds(),
    "Found": found,
    "Frictionless": hl.Frictionless,
    "Grasp": pinch,
    "GraspProblem": lambda: pinch().problem(4),
    "GraspSolution": lambda: pinch().solve(),
    "GraspStream": lambda: hl.GraspStream(pinch()),
    "GraspUpdate": lambda: hl.GraspStream(pinch()).update(wrench=PUSH),
    "Hand": hand,
    "HandDescription": hand().describe,
    "HandGrasp": hard,
    "HandGraspSolution": lambda: held().solve(),
    "HandState": state,
    "Kink": lambda: hl.Kink("force", "payload by force", 1.0, 2.0),
    "LCP": lcp,
    "LCPSolution": lambda: hl.solve_lcp(lcp()),
    "LoadLimit": lambda: pinch().load_limit(PUSH),
    "Loading": lambda: pinch().follow(steps=2),
    "Mesh": lambda: hl.Mesh(cube_file()),
    "Margins": lambda: pinch().margins(),
    "MeasuredStiffness": lambda: hl.stiffness_from([0.0, 0.1, 0.2], [0, 0.5, 1]),
    "Motor": lambda: hl.Motor(1.0, peak=2.0, thermal_time=10.0),
    "PathCost": lambda: hl.path_cost(pinch(), accuracies=(1e-1, 1e-2), repeats=1),
    "PathSensitivity": lambda: pinch().follow(steps=2).sensitivity(),
    "Payload": lambda: pinch().payload(geometry="fixed", faces=8),
    "Pyramid": lambda: hl.Pyramid(8),
    "Reliability": lambda: hl.reliability(pinch(), {"friction": 0.2}, 64, workers=1),
    "Required": lambda: pinch().required_preload(tolerance=0.5),
    "RequiredStiffness": lambda: pinch().required_stiffness(2e-3, tolerance=0.5),
    "RequiredTorque": lambda: held().required_torque({"down": PUSH}, tolerance=0.5),
    "Route": lambda: hl.Route([hl.Site("palm", (0, 0, 0)), hl.Site("finger_1_distal", (0, 0, 0.01))]),
    "Sample": lambda: hl.reliability(pinch(), {"friction": 0.2}, 64, workers=1).sample(0),
    "Sensitivity": lambda: pinch().solve().sensitivity(),
    "Site": lambda: hl.Site("palm", (0, 0, 0)),
    "SlipResistance": lambda: hl.slip_resistance(pinch(), (0, 0, 1)),
    "Slopes": lambda: hl.slopes(held(), ["finger_1_tip.pad"]),
    "SoftFinger": lambda: hl.SoftFinger(0.5, 0.003),
    "Solutions": lambda: hl.solve_many([pinch()]),
    "Sphere": lambda: BALL,
    "SplitCylinder": lambda: hl.split_cylinder(three(), 0.05, grasps=["pinch"]),
    "Study": study,
    "Suggestions": lambda: pinch().suggest(),
    "Synergies": lambda: hl.Synergies({"a": {"finger_1_proximal": 1.0}}, 1.0),
    "Table": lambda: hl.Table((0, 0, 0.05)),
    "Tendons": tendons,
    "TorqueCheck": lambda: held().solve().torque_check,
    "TriedChange": lambda: pinch().best_change().tried[0],
    "Verdict": lambda: pinch().check(),
    "YCB": lambda: hl.YCB("018_plum"),
}


@cache
def receiver(kind):
    """The object of a class whose methods are called; the class itself, where its methods make one."""
    return MADE[kind]() if kind in MADE else getattr(hl, kind)
