"""Grasp forces, slips, object motion and joint torques of robot hands, by linear complementarity.

import handlcp as hl

g = hl.Grasp([hl.Contact(...), ...], wrench, flexibility=1e-4)
s = g.solve()
print(s)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from handlcp.version import VERSION

if TYPE_CHECKING:
    from handlcp.errors import (
        HandLCPError,
        InputError,
        NoGraspFound,
        NoSolutionFound,
        NotReached,
        SceneFileError,
        UnknownName,
        Unsupported,
        URDFError,
    )
    from handlcp.grasp import (
        Accuracy,
        AnisotropicCoulomb,
        BestChange,
        Contact,
        ContactCompliance,
        Coulomb,
        Environment,
        Equilibria,
        Explanation,
        FingerForceBound,
        Frictionless,
        GeometricStiffness,
        Grasp,
        GraspProblem,
        GraspSolution,
        KnownForce,
        Loading,
        LoadLimit,
        Margins,
        PathSensitivity,
        PrescribedForce,
        Pyramid,
        Reason,
        Required,
        RequiredStiffness,
        Residuals,
        Sensitivity,
        SoftFinger,
        SoftWrist,
        Solutions,
        Stage,
        Suggestions,
        TorqueSaturation,
        TotalForceBound,
        TriedChange,
        Uniqueness,
        Verdict,
        solve_many,
        wrench_from_fingertip_forces,
    )
    from handlcp.hand import (
        Audit,
        Box,
        Candidate,
        Cylinder,
        Doubt,
        Ellipsoid,
        Found,
        GraspStream,
        GraspUpdate,
        Hand,
        HandDescription,
        HandGrasp,
        HandGraspSolution,
        HandState,
        Mesh,
        RequiredTorque,
        Sphere,
        Synergies,
        Table,
        Tendons,
        TorqueCheck,
        audit_urdf,
        describe_urdf,
        example_hand,
        find_grasp,
    )
    from handlcp.lcp import LCP, NSNGRK, Auto, LCPSolution, Lemke, SemismoothNewton, Status, solve_lcp
    from handlcp.simulator import to_mujoco
    from handlcp.study.accuracy import AccuracyCost, PathCost, accuracy_cost, path_cost
    from handlcp.study.envelope import Envelope, envelope
    from handlcp.study.reliability import Chance, Influence, Reliability, Sample, reliability

__version__ = VERSION

__all__ = [
    "LCP", "NSNGRK", "Accuracy", "AccuracyCost", "AnisotropicCoulomb", "Audit", "Auto", "BestChange", "Box",
    "Candidate", "Chance", "Contact", "ContactCompliance", "Coulomb", "Cylinder", "Doubt", "Ellipsoid", "Envelope",
    "Environment", "Equilibria", "Explanation", "FingerForceBound", "Found", "Frictionless", "GeometricStiffness",
    "Grasp", "GraspProblem", "GraspSolution", "GraspStream", "GraspUpdate", "Hand", "HandDescription", "HandGrasp",
    "HandGraspSolution", "HandLCPError", "HandState", "Influence", "InputError", "KnownForce", "LCPSolution", "Lemke",
    "LoadLimit", "Loading", "Margins", "Mesh", "NoGraspFound", "NoSolutionFound", "NotReached", "PathCost",
    "PathSensitivity", "PrescribedForce", "Pyramid", "Reason", "Reliability", "Required", "RequiredStiffness",
    "RequiredTorque", "Residuals", "Sample", "SceneFileError", "SemismoothNewton", "Sensitivity", "SoftFinger",
    "SoftWrist", "Solutions", "Sphere", "Stage", "Status", "Suggestions", "Synergies", "Table", "Tendons",
    "TorqueCheck", "TorqueSaturation", "TotalForceBound", "TriedChange", "URDFError", "Uniqueness", "UnknownName",
    "Unsupported", "Verdict",
    "accuracy_cost", "audit_urdf", "describe_urdf", "envelope", "example_hand", "find_grasp", "path_cost",
    "reliability", "solve_lcp", "solve_many", "to_mujoco", "wrench_from_fingertip_forces",
]  # fmt: skip

# Where to import a name from when it is first asked for; those of no other room are in handlcp.grasp
_ROOMS = {
    "errors": {
        "HandLCPError", "InputError", "NoGraspFound", "NoSolutionFound", "NotReached", "SceneFileError", "URDFError",
        "UnknownName", "Unsupported",
    },
    "lcp": {"LCP", "LCPSolution", "Lemke", "NSNGRK", "Auto", "SemismoothNewton", "Status", "solve_lcp"},
    "hand": {
        "Audit", "Box", "Candidate", "Cylinder", "Doubt", "Ellipsoid", "Found", "GraspStream", "GraspUpdate", "Hand",
        "HandDescription", "HandGrasp", "HandGraspSolution", "HandState", "Mesh", "RequiredTorque", "Sphere",
        "Synergies", "Table", "Tendons", "TorqueCheck", "audit_urdf", "describe_urdf", "example_hand", "find_grasp",
    },
    "simulator": {"to_mujoco"},
    "study.accuracy": {"AccuracyCost", "PathCost", "accuracy_cost", "path_cost"},
    "study.envelope": {"Envelope", "envelope"},
    "study.reliability": {"Chance", "Influence", "Reliability", "Sample", "reliability"},
    "grasp": set[str](),
}  # fmt: skip


def __getattr__(name: str) -> Any:
    """Everything is imported when first asked for, with what it stands on and nothing else. Effects and friction laws
    in files of their own are found by their class: they need no line here.
    """
    if name in _ROOMS:  # handlcp.hand needs no import of its own
        return import_module(f"handlcp.{name}")
    if name in __all__:
        room = next((room for room, names in _ROOMS.items() if name in names), "grasp")
        value = globals()[name] = getattr(import_module(f"handlcp.{room}"), name)
        return value
    if not name.startswith("_"):
        from handlcp.grasp.effects import effect_kinds
        from handlcp.grasp.friction import friction_laws

        for kind in (*[kind for kind in effect_kinds() if kind.file_key is not None], *friction_laws()):
            if kind.__name__ == name:
                return kind
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
