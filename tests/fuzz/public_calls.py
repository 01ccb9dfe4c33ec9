"""Every public function, constructor and method, with arguments that it takes, small enough to end at once.

`MADE` has an object of each public class that has methods; `GIVEN` what a call needs, by its name. What has no line
there needs nothing. `LEFT_OUT` says what is not called, and why; a test holds that nothing is missing.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np

import handlcp as hl
from tests.design import optima
from tests.support.table import HandTable, source

BALL = hl.Sphere(0.03, (0, 0, 0.08), mass=0.1)
PUSH = (1.0, 0, 0, 0, 0, 0)
TENDONS = {"a": {"finger_1_proximal": 0.01}, "b": {"finger_1_distal": 0.01}}

LAWS = ("AnisotropicCoulomb", "Coulomb", "Frictionless", "SoftFinger")
SHAPES = ("Box", "Cylinder", "Ellipsoid", "Mesh", "Sphere", "YCB")
URDF = """<robot name="bar"><link name="palm"/><link name="bar"/><joint name="turn" type="revolute">
<parent link="palm"/><child link="bar"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
MJCF = """<mujoco><worldbody><body name="palm"><body name="bar"><joint name="turn" axis="0 1 0"/>
<geom size=".01" pos="0 0 .05"/></body></body></worldbody></mujoco>"""


class Call(NamedTuple):
    """A public call. name : such as "Grasp.solve". function : what is called. given : arguments that it takes."""

    name: str
    function: Callable[..., Any]
    given: Callable[[], dict[str, Any]]

    @property
    def parameters(self) -> list[inspect.Parameter]:
        """All but the receiver."""
        return [p for p in inspect.signature(self.function).parameters.values() if p.name not in ("self", "cls")]

    def prepare(self) -> None:
        """Make the receiver of a method, which takes its own time."""
        if isinstance(self.function, _Bound):
            receiver(self.function.kind)


@cache
def hand() -> hl.Hand:
    return hl.example_hand("two_finger", joint_stiffness=6.0, torque_limits=3.0)


@cache
def state() -> hl.HandState:
    return hand().at(hand().close_on(BALL))


@cache
def held() -> hl.HandGrasp:
    """A ball in two fingers with soft pads of their own moment."""
    return state().grasp(BALL, hl.SoftFinger(0.8, 0.005), grip_force=5.0)


@cache
def three() -> hl.Hand:
    return hl.example_hand("three_finger", joint_stiffness=6.0)


@cache
def hard() -> hl.HandGrasp:
    """A ball in two fingers, at points."""
    return state().grasp(BALL, 0.8, grip_force=5.0)


@cache
def pinch() -> hl.Grasp:
    """Two points that press on an object, and have no hand."""
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(0.5)) for s in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)


@cache
def brief() -> hl.Brief:
    return hl.Brief(BALL, grip_force=5.0, tries=2)


@cache
def found() -> hl.Found:
    return hl.find_grasp(hand(), hl.Sphere(0.03, mass=0.1), friction=0.8, tries=8)


@cache
def evaluation() -> hl.Evaluation:
    return hl.evaluate(hand(), brief())


@cache
def study() -> hl.Study:
    return hl.sweep(optima.make, {"force": (0.5, 2.0)}, optima.brief, samples=2, executor="serial", progress=False)


@cache
def cost() -> hl.AccuracyCost:
    few = {"methods": ["NSNGRK polished"], "faces": [8], "tolerances": [1e-9], "left_out": False, "repeats": 1}
    return hl.accuracy_cost(pinch(), **few)


def lcp() -> hl.LCP:
    return hl.LCP([[2.0, 1.0], [1.0, 2.0]], [-1.0, 1.0])


def tendons() -> hl.Tendons:
    return hl.Tendons(TENDONS, 1e3, 1.0)


def table() -> HandTable:
    return HandTable([{"hand": "g1", "object": "?", "verdict": "FAILED"}], [source("g1")])


# The objects whose methods are called; each made when it is first asked for
MADE: dict[str, Callable[[], Any]] = {
    "Accuracy": lambda: pinch().solve(accuracy=1e-6).accuracy, "AccuracyCost": cost, "AnisotropicCoulomb": lambda: hl.AnisotropicCoulomb(0.5, 0.2), "Audit": lambda: hand().audit(),
    "Around": lambda: hl.Around("palm", ((0, 0, 0), (0, 0, 1)), 0.01), "Auto": hl.Auto,
    "Beside": lambda: hl.beside_hardware({}, tests=("payload",)), "Best": lambda: optima.run(budget=1),
    "BestChange": lambda: pinch().best_change(), "Box": lambda: hl.Box(0.05), "Brief": brief,
    "Candidate": lambda: found()[0],
    "Contact": lambda: pinch().contacts[0], "Coulomb": lambda: hl.Coulomb(0.5),
    "Cylinder": lambda: hl.Cylinder(0.03, 0.1), "Ellipsoid": lambda: hl.Ellipsoid((0.03, 0.02, 0.04)),
    "Envelope": lambda: hl.envelope(pinch(), 6, faces=8, adaptive=0), "Equilibria": lambda: pinch().equilibria(faces=4),
    "Evaluation": evaluation, "Explanation": lambda: pinch().explain(),
    "FingerStrength": lambda: hl.finger_strength(hand()), "ForceBounds": lambda: pinch().solve().force_bounds(),
    "Found": found, "Frictionless": hl.Frictionless, "Grasp": pinch, "GraspProblem": lambda: pinch().problem(4),
    "GraspSolution": lambda: pinch().solve(), "GraspStream": lambda: hl.GraspStream(pinch()),
    "GraspUpdate": lambda: hl.GraspStream(pinch()).update(wrench=PUSH), "Hand": hand, "HandDescription": hand().describe,
    "HandGrasp": hard, "HandGraspSolution": lambda: held().solve(), "HandState": state, "HandTable": table, "Kink": lambda: hl.Kink("force", "payload by force", 1.0, 2.0), "LCP": lcp,
    "LCPSolution": lambda: hl.solve_lcp(lcp()),
    "LoadLimit": lambda: pinch().load_limit(PUSH), "Loading": lambda: pinch().follow(steps=2),
    "Mesh": lambda: hl.Mesh(cube_file()), "Margins": lambda: pinch().margins(), "MeasuredStiffness": lambda: hl.stiffness_from([0.0, 0.1, 0.2], [0, 0.5, 1]),
    "Motor": lambda: hl.Motor(1.0, peak=2.0, thermal_time=10.0),
    "PathCost": lambda: hl.path_cost(pinch(), times=(0.5, 1), repeats=1),
    "PathSensitivity": lambda: pinch().follow(steps=2).sensitivity(),
    "Payload": lambda: pinch().payload(geometry="fixed", faces=8), "Pyramid": lambda: hl.Pyramid(8),
    "Reliability": lambda: hl.reliability(pinch(), {"friction": 0.2}, 64, workers=1),
    "Required": lambda: pinch().required_preload(tolerance=0.5),
    "RequiredStiffness": lambda: pinch().required_stiffness(2e-3, tolerance=0.5),
    "RequiredTorque": lambda: held().required_torque({"down": PUSH}, tolerance=0.5),
    "Route": lambda: hl.Route([hl.Site("palm", (0, 0, 0)), hl.Site("finger_1_distal", (0, 0, 0.01))]),
    "Sample": lambda: hl.reliability(pinch(), {"friction": 0.2}, 64, workers=1).sample(0),
    "Sensitivity": lambda: pinch().solve().sensitivity(), "Site": lambda: hl.Site("palm", (0, 0, 0)),
    "SlipResistance": lambda: hl.slip_resistance(pinch(), (0, 0, 1)),
    "Slopes": lambda: hl.slopes(held(), ["finger_1_tip.pad"]),
    "SoftFinger": lambda: hl.SoftFinger(0.5, 0.003), "Solutions": lambda: hl.solve_many([pinch()]),
    "Sphere": lambda: BALL, "SplitCylinder": lambda: hl.split_cylinder(three(), 0.05, grasps=["pinch"]),
    "Study": study, "Suggestions": lambda: pinch().suggest(),
    "Synergies": lambda: hl.Synergies({"a": {"finger_1_proximal": 1.0}}, 1.0),
    "Table": lambda: hl.Table((0, 0, 0.05)), "Tendons": tendons, "TorqueCheck": lambda: held().solve().torque_check,
    "TriedChange": lambda: pinch().best_change().tried[0], "Verdict": lambda: pinch().check(), "YCB": lambda: hl.YCB("018_plum"),
}  # fmt: skip

# What a call is given; what is not named here has its default
GIVEN: dict[str, Callable[[], dict[str, Any]]] = {
    "AccuracyCost.cheapest": lambda: {"error": 1.0}, "AccuracyCost.from_json": lambda: {"text": cost().to_json()},
    "AccuracyCost.front": lambda: {"method": "NSNGRK polished"}, "AccuracyCost.of": lambda: {"method": "NSNGRK polished"},
    "AccuracyCost.to_csv": lambda: {"path": "cost.csv"},
    "AnisotropicCoulomb": lambda: {"mu_x": 0.5, "mu_y": 0.2},
    **{f"{law}.with_mu": lambda: {"mu": 0.4} for law in LAWS},
    **{f"{shape}.moved_to": lambda: {"placement": (0, 0, 0.1)} for shape in SHAPES},
    **{f"{shape}.weighing": lambda: {"mass": 0.1} for shape in SHAPES},
    "Audit.about": lambda: {"joint": "finger_1_distal"},
    "Around": lambda: {"link": "palm", "placement": ((0, 0, 0), (0, 0, 1)), "radius": 0.01}, "Box": lambda: {"size": 0.05},
    "Brief": lambda: {"objects": BALL}, "Brief.from_toml": lambda: {"path": brief().to_toml("brief.toml")},
    "Contact": lambda: {"position": (0.02, 0, 0), "normal": (-1.0, 0, 0)}, "Contact.named": lambda: {"name": "thumb"},
    "Contact.with_friction": lambda: {"friction": hl.Coulomb(0.5)}, "ContactCompliance": lambda: {"flexibility": 1e-4},
    "Coulomb": lambda: {"mu": 0.5}, "Cylinder": lambda: {"radius": 0.03, "length": 0.1},
    "Ellipsoid": lambda: {"radii": (0.03, 0.02, 0.04)}, "Envelope.page": lambda: {"path": "envelope.html"},
    "Environment": lambda: {"contacts": pinch().contacts},
    "FingerForceBound": lambda: {"limits": 10.0},
    "Flexibility": lambda: {"jacobian": np.ones((6, 2)), "root": np.eye(2), "pads": np.tile(1e-4 * np.eye(3), (2, 1, 1))},
    "Grasp": lambda: {"contacts": pinch().contacts, "wrench": PUSH, "flexibility": 1e-4, "preload": 1e-3},
    "Grasp.follow": lambda: {"steps": 2}, "Grasp.equilibria": lambda: {"faces": 4, "seconds": 0.1},
    "Grasp.payload": lambda: {"geometry": "fixed", "faces": 8},
    "Grasp.required_friction": lambda: {"tolerance": 0.5}, "Grasp.required_preload": lambda: {"tolerance": 0.5},
    "Grasp.required_stiffness": lambda: {"motion": 2e-3, "tolerance": 0.5},
    "GraspSolution.page": lambda: {"path": "solution.html"}, "GraspStream": lambda: {"grasp": pinch()},
    "GraspStream.update": lambda: {"wrench": PUSH},
    "Hand.at": lambda: {"q": np.zeros(4)}, "Hand.close_on": lambda: {"obj": BALL},
    "Hand.finger_joints": lambda: {"fingertip": "finger_1_tip"},
    "Hand.from_mjcf": lambda: {"source": MJCF, "fingertips": {"tip": "bar"}, "joint_stiffness": 1.0},
    "Hand.from_model": lambda: {"model": hand().model, "fingertips": ["finger_1_tip"], "joint_stiffness": 1.0},
    "Hand.from_urdf": lambda: {"source": URDF, "fingertips": {"tip": ("bar", (0, 0, 0.05))}, "joint_stiffness": 1.0},
    "Hand.in_parts": lambda: {}, "Hand.limited": lambda: {"torques": hand().torques},
    "Hand.posed": lambda: {"q": np.zeros(4)}, "Hand.stiffer": lambda: {"factor": 2.0},
    "Hand.tip_kind": lambda: {"tip": 0}, "Hand.tip_links": lambda: {"tip": 0}, "Hand.tip_shapes": lambda: {"tip": 0},
    "Hand.tip_numbers": lambda: {"argument": "fingers", "fingers": ["finger_1_tip"]},
    "Hand.vary": lambda: {"changes": {"finger_1_tip.radius": 0.01}},
    "HandGrasp.follow": lambda: {"steps": 2}, "HandGrasp.equilibria": lambda: {"faces": 4, "seconds": 0.1},
    "HandGrasp.geometric_change": lambda: {"solution": hard().solve()},
    "HandGrasp.payload": lambda: {"geometry": "fixed", "faces": 8},
    "HandGrasp.load_limit": lambda: {"wrench": PUSH, "geometry": "fixed"},
    "HandGrasp.best_change": lambda: {"wrench": PUSH, "geometry": "fixed"},
    "HandGrasp.required_friction": lambda: {"tolerance": 0.5}, "HandGrasp.required_grip": lambda: {"tolerance": 0.5},
    "HandGrasp.required_preload": lambda: {"tolerance": 0.5}, "HandGrasp.required_squeeze": lambda: {"tolerance": 0.5},
    "HandGrasp.required_stiffness": lambda: {"motion": 2e-3, "tolerance": 0.5},
    "HandGrasp.required_torque": lambda: {"tolerance": 0.5},
    "HandGraspSolution.page": lambda: {"path": "solution.html"},
    "HandState.grasp": lambda: {"target": BALL},
    "HandState.jacobian_at": lambda: {"points": state().tip_positions, "tips": (0, 1)},
    "HandState.turning": lambda: {"tips": (0, 1)},
    "HandTable.drawn": lambda: {"hand": "g1"}, "HandTable.grasp": lambda: {"row": {"hand": "g1", "object": "?", "verdict": "FAILED", "held": None}},
    "HandTable.hand": lambda: {"name": "g1"}, "HandTable.object": lambda: {"name": "018_plum"},
    "HandTable.of": lambda: {"hand": "g1"}, "HandTable.page": lambda: {"path": "table.html"},
    "KnownForce": lambda: {"contact": 0, "force": (0, 0, 1.0)}, "LCP": lambda: {"M": np.eye(2), "q": [-1.0, 1.0]},
    "Loading.page": lambda: {"path": "loading.html"},
    "Mesh": lambda: {"path": cube_file()}, "Motor": lambda: {"continuous": 1.0}, "Motor.lasts": lambda: {"torque": 1.5},
    "Motor.share": lambda: {"torque": 1.5}, "PathCost.of": lambda: {"question": "the load limit"},
    "PathSensitivity.error": lambda: {"quantity": "forces", "parameter": "friction"},
    "PathSensitivity.of": lambda: {"quantity": "forces", "parameter": "friction"},
    "PathSensitivity.of_share": lambda: {"parameter": "friction", "share": 0.1},
    "PathSensitivity.sides": lambda: {"quantity": "forces", "parameter": "friction"},
    "PrescribedForce": lambda: {"contact": 0, "force": (0, 0, 1.0)}, "Pulley": lambda: {"divisor": 2.0},
    "Pyramid": lambda: {"faces": 8}, "Pyramid.limit": lambda: {"mu": np.array([0.5])},
    "Reliability.sample": lambda: {"k": 0}, "RequiredTorque.reductions": lambda: {"motor": hl.Motor(0.1)},
    "Route": lambda: {"places": [hl.Site("palm", (0, 0, 0)), hl.Site("finger_1_distal", (0, 0, 0.01))]},
    "Sensitivity.along": lambda: {"parameter": "friction", "direction": [1.0, 1.0]},
    "Sensitivity.of": lambda: {"quantity": "forces", "parameter": "friction"},
    "Sensitivity.to_frame": lambda: {"quantity": "forces", "parameter": "friction"},
    "Site": lambda: {"link": "palm", "point": (0, 0, 0)}, "SoftFinger": lambda: {"mu": 0.5, "mu_torsion": 0.003},
    "SoftWrist": lambda: {"flexibility": np.eye(6)}, "Sphere": lambda: {"radius": 0.03},
    "Stage": lambda: {"name": "push", "load": PUSH}, "Study.column_of": lambda: {"name": "force"},
    "Study.load": lambda: {"path": "no such file.parquet"}, "Study.page": lambda: {"path": "study.html"},
    "Study.some": lambda: {"at": [0]}, "Study.wanted": lambda: {}, "Study.pareto": lambda: {},
    "Synergies": lambda: {"S": {"a": {"finger_1_proximal": 1.0}}, "stiffness": 1.0},
    "Table": lambda: {"point": (0, 0, 0)}, "Table.under": lambda: {"obj": BALL},
    "Tendons": lambda: {"moment_arms": TENDONS, "stiffness": 1e3}, "Tendons.motored": lambda: {"motors": {}},
    "TotalForceBound": lambda: {"limit": 10.0}, "Verdict.about": lambda: {"code": "torque"}, "YCB": lambda: {"name": "018_plum"},
    "accuracy_cost": lambda: {
        "grasp": pinch(), "methods": ["NSNGRK polished"], "faces": [8], "tolerances": [1e-9], "left_out": False,
        "repeats": 1,
    },
    "audit_urdf": lambda: {"path": URDF}, "beside_hardware": lambda: {"hands": {}, "tests": ("payload",)},
    "describe_urdf": lambda: {"path": URDF},
    "envelope": lambda: {"grasp": pinch(), "directions": 6, "faces": 8, "adaptive": 0, "progress": False},
    "evaluate": lambda: {"hand": hand(), "brief": brief()}, "example_hand": lambda: {"name": "two_finger"},
    "find_grasp": lambda: {"hand": hand(), "obj": BALL, "tries": 2, "grip_force": 5.0},
    "finger_hand": dict, "finger_strength": lambda: {"hand": hand()},
    "lift_and_shake": lambda: {"hand": three(), "rated_payload": 0.1, "opening": 0.08, "tries": 1},
    "optimise": lambda: {
        "make": optima.make, "space": optima.SPACE, "brief": optima.brief, "budget": 1, "executor": "serial",
        "progress": False,
    },
    "path_cost": lambda: {"grasp": pinch(), "times": (0.5, 1), "repeats": 1},
    "read_postures": lambda: {"source": [{"q": [0.0] * 4, "placement": [0.0] * 6}]},
    "reliability": lambda: {"grasp": pinch(), "spread": {"friction": 0.2}, "samples": 64, "workers": 1, "progress": False},
    "report": lambda: {"hands": {"one": hand(), "other": hand().stiffer(2.0)}, "brief": brief(), "path": "report.html"},
    "slip_resistance": lambda: {"held": pinch(), "axis": (0, 0, 1)},
    "slopes": lambda: {"grasp": held(), "names": ["finger_1_tip.pad"]}, "solve_lcp": lambda: {"problem": lcp()},
    "solve_many": lambda: {"grasps": [pinch()], "progress": False},
    "split_cylinder": lambda: {"hand": three(), "diameter": 0.05, "grasps": ["pinch"]},
    "stiffness_from": lambda: {"angle": [0.0, 0.1, 0.2], "torque": [0.0, 0.5, 1.0]},
    "sweep": lambda: {
        "make": optima.make, "space": optima.SPACE, "brief": optima.brief, "samples": 1, "executor": "serial",
        "progress": False,
    },
    "table": lambda: {"hands": {"own": hand()}, "objects": {"ball": BALL}, "out": "table", "executor": "serial",
                      "kinds": ["pinch"], "seconds": 0.5, "simulated": False, "progress": False},
    "tendon_routes": lambda: {"source": MJCF}, "to_mujoco": lambda: {"grasp": held()},
    "vary_grasp": lambda: {"grasp": held(), "changes": {"finger_1_tip.pad": 1e-4}},
    "wrench_from_fingertip_forces": lambda: {"grasp": pinch(), "forces": np.zeros((2, 3))},
}  # fmt: skip

_BY_THE_PACKAGE = "called by the package with what it made itself: see docs/extend.md for what it passes"
_RESULT = "made by the package alone: users receive it"
HOOKS = {
    "Auto": ["contact_stages", "first", "others", "plan", "search_end", "stages"],
    "Lemke": ["propose"], "NSNGRK": ["propose", "propose_contact"], "SemismoothNewton": ["propose", "propose_contact"],
    **{law: ["from_file", "to_file", "toward"] for law in ("AnisotropicCoulomb", "Coulomb", "Frictionless", "SoftFinger")},
    **{tip: ["bound", "moved"] for tip in ("Around", "Route", "Site")}, "Contact": ["moved", "placed"],
    **{shape: ["closest", "closest_all", "beyond"] for shape in ("Box", "Cylinder", "Ellipsoid", "Mesh", "Sphere", "YCB")},
    "Flexibility": ["of", "any"], "Residuals": ["of"], "Tendons": ["for_joints"], "Synergies": ["for_joints"],
    "Hand": ["with_parts"], "SoftWrist": ["carried"], "TorqueSaturation": ["limited"], "LiftAndShake": ["to_dict", "to_json", "to_row"], "Payload": ["cause", "moving"], "TorqueCheck": ["remark"],
    "GraspSolution": ["deferred"], "HandGraspSolution": ["deferred"],
    "GraspProblem": ["back", "candidate", "complete", "lift", "natural"],
}  # fmt: skip
MADE_BY_USERS = {
    "AnisotropicCoulomb", "Around", "Auto", "Box", "Brief", "Contact", "ContactCompliance", "Coulomb", "Cylinder",
    "Ellipsoid", "Environment", "FingerForceBound", "Flexibility", "Frictionless", "GeometricStiffness", "Grasp",
    "GraspStream", "HandGrasp", "KnownForce", "LCP", "Lemke", "Mesh", "Motor", "NSNGRK", "PrescribedForce", "Pulley",
    "Pyramid", "Route", "SemismoothNewton", "Site", "SoftFinger", "SoftWrist", "Sphere", "Stage", "Synergies", "Table",
    "Tendons", "TorqueSaturation", "TotalForceBound", "YCB",
}  # fmt: skip


def cube_file() -> str:
    """A mesh file in the working folder."""
    import trimesh

    trimesh.creation.box((0.05, 0.05, 0.05)).export("cube.stl")
    return "cube.stl"


def calls() -> Iterator[Call]:
    """All of them, in order of their names."""
    for name in sorted(hl.__all__):
        value = getattr(hl, name)
        if not inspect.isclass(value):
            yield Call(name, value, GIVEN.get(name, dict))
        elif not issubclass(value, (Exception, hl.Status)):
            yield from _of_class(name, value)


def _of_class(name: str, kind: type) -> Iterator[Call]:
    if name in MADE_BY_USERS:
        yield Call(name, kind, GIVEN.get(name, dict))
    hooks = (*HOOKS.get(name, ()), *(_EFFECT if issubclass(kind, hl.grasp.Effect) else ()))
    for method, found in inspect.getmembers(kind, callable):
        theirs = not method.startswith("_") and inspect.unwrap(getattr(found, "__func__", found)).__module__
        if theirs and theirs.startswith("handlcp") and method not in hooks:
            yield Call(f"{name}.{method}", _Bound(name, method), GIVEN.get(f"{name}.{method}", dict))


_EFFECT = tuple(name for name in dir(hl.grasp.Effect) if not name.startswith("_"))


class _Bound:
    """A method of the object that `MADE` has, made when it is called."""

    def __init__(self, kind: str, method: str) -> None:
        self.kind, self.method = kind, method

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(getattr(getattr(hl, self.kind), self.method))

    def __call__(self, *args: Any, **given: Any) -> Any:
        return getattr(receiver(self.kind), self.method)(*args, **given)


@cache
def receiver(kind: str) -> Any:
    """The object of a class whose methods are called; the class itself, where its methods make one."""
    return MADE[kind]() if kind in MADE else getattr(hl, kind)
