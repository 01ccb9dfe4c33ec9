"""Every public function, constructor and method, with arguments that it takes, small enough to end at once.

`GIVEN` is what a call needs, by its name; what has no line there needs nothing. `HOOKS` are methods that are not
called. A test holds that no class is missing.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

import handlcp as hl
from tests.design import optima
from tests.fuzz import public_objects as made


class Call(NamedTuple):
    """A public call. name : such as "Grasp.solve". function : what is called. given : arguments that it takes."""

    name: str
    function: Callable[..., Any]
    given: Callable[[], dict[str, Any]]

    @property
    def parameters(self):
        """All but the receiver."""
        return [p for p in inspect.signature(self.function).parameters.values() if p.name not in ("self", "cls")]

    def prepare(self):
        """Make the receiver of a method, which takes its own time."""
        if isinstance(self.function, _Bound):
            made.receiver(self.function.kind)


_SPREAD = {"spread": {"friction": 0.2}, "samples": 64, "workers": 1}
_STUDY = {"make": optima.make, "space": optima.SPACE, "brief": optima.brief, "executor": "serial", "progress": False}
_OF_GRASPS = {
    "follow": lambda: {"steps": 2},
    "equilibria": lambda: {"faces": 4, "seconds": 0.1},
    "payload": lambda: {"geometry": "fixed", "faces": 8},
    "required_friction": lambda: {"tolerance": 0.5},
    "required_preload": lambda: {"tolerance": 0.5},
    "required_stiffness": lambda: {"motion": 2e-3, "tolerance": 0.5},
}
# What a call is given; what is not named here has its default
GIVEN: dict[str, Callable[[], dict[str, Any]]] = {
    "AccuracyCost.cheapest": lambda: {"error": 1.0},
    "AccuracyCost.from_json": lambda: {"text": made.cost().to_json()},
    "AccuracyCost.front": lambda: {"method": "NSNGRK polished"},
    "AccuracyCost.of": lambda: {"method": "NSNGRK polished"},
    "AccuracyCost.to_csv": lambda: {"path": "cost.csv"},
    "AnisotropicCoulomb": lambda: {"mu_x": 0.5, "mu_y": 0.2},
    **{f"{law}.with_mu": lambda: {"mu": 0.4} for law in made.LAWS},
    **{f"{shape}.moved_to": lambda: {"placement": (0, 0, 0.1)} for shape in made.SHAPES},
    **{f"{shape}.weighing": lambda: {"mass": 0.1} for shape in made.SHAPES},
    "Audit.about": lambda: {"joint": "finger_1_distal"},
    "Around": lambda: {"link": "palm", "placement": ((0, 0, 0), (0, 0, 1)), "radius": 0.01},
    "Box": lambda: {"size": 0.05},
    "Brief": lambda: {"objects": made.BALL},
    "Brief.from_toml": lambda: {"path": made.brief().to_toml("brief.toml")},
    "Contact": lambda: {"position": (0.02, 0, 0), "normal": (-1.0, 0, 0)},
    "Contact.with_name": lambda: {"name": "thumb"},
    "Contact.with_friction": lambda: {"friction": hl.Coulomb(0.5)},
    "ContactCompliance": lambda: {"flexibility": 1e-4},
    "Coulomb": lambda: {"mu": 0.5},
    "Cylinder": lambda: {"radius": 0.03, "length": 0.1},
    "Ellipsoid": lambda: {"radii": (0.03, 0.02, 0.04)},
    **{f"{kind}.page": lambda: {"path": "page.html"} for kind in made.PAGES},
    "Environment": lambda: {"contacts": made.pinch().contacts},
    "FingerForceBound": lambda: {"limits": 10.0},
    "Flexibility": lambda: {"jacobian": np.ones((6, 2)), "root": np.eye(2), "pads": np.full((2, 3, 3), 1e-4)},
    "Grasp": lambda: {"contacts": made.pinch().contacts, "wrench": made.PUSH, "flexibility": 1e-4, "preload": 1e-3},
    **{f"{kind}.{method}": given for kind in ("Grasp", "HandGrasp") for method, given in _OF_GRASPS.items()},
    "GraspStream": lambda: {"grasp": made.pinch()},
    "GraspStream.update": lambda: {"wrench": made.PUSH},
    "Hand.at": lambda: {"q": np.zeros(4)},
    "Hand.close_on": lambda: {"obj": made.BALL},
    "Hand.finger_joints": lambda: {"fingertip": "finger_1_tip"},
    "Hand.from_mjcf": lambda: {"source": made.MJCF, "fingertips": {"tip": "bar"}, "joint_stiffness": 1.0},
    "Hand.from_model": lambda: {"model": made.hand().model, "fingertips": ["finger_1_tip"], "joint_stiffness": 1.0},
    "Hand.from_urdf": lambda: {"source": made.URDF, "fingertips": made.TIP, "joint_stiffness": 1.0},
    "Hand.limited": lambda: {"torques": made.hand().torques},
    "Hand.posed": lambda: {"q": np.zeros(4)},
    "Hand.scale_stiffness": lambda: {"factor": 2.0},
    "Hand.tip_kind": lambda: {"tip": 0},
    "Hand.tip_links": lambda: {"tip": 0},
    "Hand.tip_shapes": lambda: {"tip": 0},
    "Hand.tip_numbers": lambda: {"argument": "fingers", "fingers": ["finger_1_tip"]},
    "Hand.vary": lambda: {"changes": {"finger_1_tip.radius": 0.01}},
    "HandGrasp.geometric_change": lambda: {"solution": made.hard().solve()},
    "HandGrasp.load_limit": lambda: {"wrench": made.PUSH, "geometry": "fixed"},
    "HandGrasp.best_change": lambda: {"wrench": made.PUSH, "geometry": "fixed"},
    "HandGrasp.required_grip": lambda: {"tolerance": 0.5},
    "HandGrasp.required_squeeze": lambda: {"tolerance": 0.5},
    "HandGrasp.required_torque": lambda: {"tolerance": 0.5},
    "HandState.grasp": lambda: {"target": made.BALL},
    "HandState.jacobian_at": lambda: {"points": made.state().tip_positions, "tips": (0, 1)},
    "HandState.angular_jacobian": lambda: {"tips": (0, 1)},
    "KnownForce": lambda: {"contact": 0, "force": (0, 0, 1.0)},
    "LCP": lambda: {"M": np.eye(2), "q": [-1.0, 1.0]},
    "Mesh": lambda: {"path": made.cube_file()},
    "Motor": lambda: {"continuous": 1.0},
    "Motor.lasts": lambda: {"torque": 1.5},
    "Motor.share": lambda: {"torque": 1.5},
    "PathCost.of": lambda: {"question": "the load limit"},
    "PathSensitivity.error": lambda: {"quantity": "forces", "parameter": "friction"},
    "PathSensitivity.of": lambda: {"quantity": "forces", "parameter": "friction"},
    "PathSensitivity.of_share": lambda: {"parameter": "friction", "share": 0.1},
    "PathSensitivity.sides": lambda: {"quantity": "forces", "parameter": "friction"},
    "PrescribedForce": lambda: {"contact": 0, "force": (0, 0, 1.0)},
    "Pulley": lambda: {"divisor": 2.0},
    "Pyramid": lambda: {"faces": 8},
    "Pyramid.limit": lambda: {"mu": np.array([0.5])},
    "Reliability.sample": lambda: {"k": 0},
    "RequiredTorque.reductions": lambda: {"motor": hl.Motor(0.1)},
    "Route": lambda: {"places": [hl.Site("palm", (0, 0, 0)), hl.Site("finger_1_distal", (0, 0, 0.01))]},
    "Sensitivity.along": lambda: {"parameter": "friction", "direction": [1.0, 1.0]},
    "Sensitivity.of": lambda: {"quantity": "forces", "parameter": "friction"},
    "Sensitivity.to_frame": lambda: {"quantity": "forces", "parameter": "friction"},
    "Site": lambda: {"link": "palm", "point": (0, 0, 0)},
    "SoftFinger": lambda: {"mu": 0.5, "mu_torsion": 0.003},
    "SoftWrist": lambda: {"flexibility": np.eye(6)},
    "Sphere": lambda: {"radius": 0.03},
    "Stage": lambda: {"name": "push", "load": made.PUSH},
    "Study.column_of": lambda: {"name": "force"},
    "Study.load": lambda: {"path": "no such file.parquet"},
    "Study.some": lambda: {"at": [0]},
    "Synergies": lambda: {"S": {"a": {"finger_1_proximal": 1.0}}, "stiffness": 1.0},
    "Table": lambda: {"point": (0, 0, 0)},
    "Table.under": lambda: {"obj": made.BALL},
    "Tendons": lambda: {"moment_arms": made.TENDONS, "stiffness": 1e3},
    "Tendons.motored": lambda: {"motors": {}},
    "TotalForceBound": lambda: {"limit": 10.0},
    "Verdict.about": lambda: {"code": "torque"},
    "YCB": lambda: {"name": "018_plum"},
    "accuracy_cost": lambda: {"grasp": made.pinch(), **made.ONE_METHOD},
    "audit_urdf": lambda: {"path": made.URDF},
    "describe_urdf": lambda: {"path": made.URDF},
    "envelope": lambda: {"grasp": made.pinch(), "directions": 6, "faces": 8, "adaptive": 0, "progress": False},
    "evaluate": lambda: {"hand": made.hand(), "brief": made.brief()},
    "example_hand": lambda: {"name": "two_finger"},
    "find_grasp": lambda: {"hand": made.hand(), "obj": made.BALL, "tries": 2, "grip_force": 5.0},
    "finger_strength": lambda: {"hand": made.hand()},
    "lift_and_shake": lambda: {"hand": made.three(), "rated_payload": 0.1, "opening": 0.08, "tries": 1},
    "optimise": lambda: {**_STUDY, "budget": 1},
    "path_cost": lambda: {"grasp": made.pinch(), "accuracies": (1e-1, 1e-2), "repeats": 1},
    "read_postures": lambda: {"source": [{"q": [0.0] * 4, "placement": [0.0] * 6}]},
    "reliability": lambda: {"grasp": made.pinch(), **_SPREAD, "progress": False},
    "report": lambda: {"hands": made.hands(), "brief": made.brief(), "path": "report.html"},
    "slip_resistance": lambda: {"held": made.pinch(), "axis": (0, 0, 1)},
    "slopes": lambda: {"grasp": made.held(), "names": ["finger_1_tip.pad"]},
    "solve_lcp": lambda: {"problem": made.lcp()},
    "solve_many": lambda: {"grasps": [made.pinch()], "progress": False},
    "split_cylinder": lambda: {"hand": made.three(), "diameter": 0.05, "grasps": ["pinch"]},
    "stiffness_from": lambda: {"angle": [0.0, 0.1, 0.2], "torque": [0.0, 0.5, 1.0]},
    "sweep": lambda: {**_STUDY, "samples": 1},
    "tendon_routes": lambda: {"source": made.MJCF},
    "to_mujoco": lambda: {"grasp": made.held()},
    "vary_grasp": lambda: {"grasp": made.held(), "changes": {"finger_1_tip.pad": 1e-4}},
    "wrench_from_fingertip_forces": lambda: {"grasp": made.pinch(), "forces": np.zeros((2, 3))},
}

# Methods that are not called: the package calls them with what it made itself, as docs/extend.md says; and those of an
# answer that takes seconds, which are every record's
HOOKS = {
    "Auto": ["contact_stages", "first", "others", "plan", "search_end", "stages"],
    "Lemke": ["propose"],
    "NSNGRK": ["propose", "propose_contact"],
    "SemismoothNewton": ["propose", "propose_contact"],
    **{law: ["from_file", "to_file", "toward"] for law in made.LAWS},
    **{tip: ["bound", "moved"] for tip in ("Around", "Route", "Site")},
    "Contact": ["with_pose", "from_arrays"],
    **{shape: ["closest", "closest_all", "beyond"] for shape in made.SHAPES},
    "Flexibility": ["from_factor", "any"],
    "Residuals": ["from_law_residuals"],
    "Tendons": ["for_joints"],
    "Synergies": ["for_joints"],
    "Hand": ["with_parts"],
    "SoftWrist": ["carried"],
    "TorqueSaturation": ["limited"],
    "LiftAndShake": ["to_dict", "to_json", "to_row"],
    "Payload": ["cause", "moving"],
    "TorqueCheck": ["remark"],
    "GraspSolution": ["with_deferred_fields"],
    "HandGraspSolution": ["deferred"],
    "GraspProblem": ["back", "candidate", "complete", "lift", "natural"],
}
_MADE_BY_USERS = """
    AnisotropicCoulomb Around Auto Box Brief Contact ContactCompliance Coulomb Cylinder Ellipsoid Environment
    FingerForceBound Flexibility Frictionless GeometricStiffness Grasp GraspStream HandGrasp KnownForce LCP Lemke
    Mesh Motor NSNGRK PrescribedForce Pulley Pyramid Route SemismoothNewton Site SoftFinger SoftWrist Sphere Stage
    Synergies Table Tendons TorqueSaturation TotalForceBound YCB
"""
MADE_BY_USERS = set(_MADE_BY_USERS.split())


def calls():
    """All of them, in order of their names."""
    for name in sorted(hl.__all__):
        value = getattr(hl, name)
        if not inspect.isclass(value):
            yield Call(name, value, GIVEN.get(name, dict))
        elif not issubclass(value, (Exception, hl.Status)):
            yield from _of_class(name, value)


def _of_class(name, kind):
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

    def __init__(self, kind, method):
        self.kind, self.method = kind, method

    @property
    def __signature__(self):
        return inspect.signature(getattr(getattr(hl, self.kind), self.method))

    def __call__(self, *args, **given):
        return getattr(made.receiver(self.kind), self.method)(*args, **given)
