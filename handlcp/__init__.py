"""Grasp forces, slips, object motion and joint torques of robot hands, by linear complementarity.

import handlcp as hl

g = hl.Grasp([hl.Contact(...), ...], wrench, flexibility=1e-4)
s = g.solve()
print(s)
"""

from typing import TYPE_CHECKING, Any

from handlcp.errors import (
    HandLCPError,
    InputError,
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
    PrescribedForce,
    Pyramid,
    Required,
    Residuals,
    SoftFinger,
    SoftWrist,
    Solutions,
    Suggestions,
    TorqueSaturation,
    TotalForceBound,
    Uniqueness,
    solve_many,
    wrench_from_fingertip_forces,
)
from handlcp.grasp.effects import effect_kinds
from handlcp.grasp.friction import friction_laws
from handlcp.hand import (
    Audit,
    Box,
    Cylinder,
    Doubt,
    Ellipsoid,
    GraspStream,
    GraspUpdate,
    Hand,
    HandGrasp,
    HandGraspSolution,
    HandState,
    Mesh,
    Sphere,
    Synergies,
    Table,
    Tendons,
    TorqueCheck,
    audit_urdf,
    example_hand,
)
from handlcp.lcp import LCP, NSNGRK, Auto, LCPSolution, Lemke, SemismoothNewton, Status, solve_lcp
from handlcp.version import VERSION

if TYPE_CHECKING:
    from handlcp.study.accuracy import AccuracyCost, accuracy_cost

__version__ = VERSION

__all__ = [
    "LCP", "NSNGRK", "Accuracy", "AccuracyCost", "AnisotropicCoulomb", "Audit", "Auto", "Box", "Contact",
    "ContactCompliance", "Coulomb", "Cylinder", "Doubt", "Ellipsoid", "Environment", "Equilibria", "Explanation",
    "FingerForceBound", "Frictionless", "GeometricStiffness", "Grasp", "GraspProblem", "GraspSolution", "GraspStream",
    "GraspUpdate", "Hand", "HandGrasp", "HandGraspSolution", "HandLCPError", "HandState", "InputError", "KnownForce",
    "LCPSolution", "Lemke", "Mesh", "NoSolutionFound", "NotReached", "PrescribedForce", "Pyramid", "Required",
    "Residuals", "SceneFileError", "SemismoothNewton", "SoftFinger", "SoftWrist", "Solutions", "Sphere", "Status",
    "Suggestions", "Synergies", "Table", "Tendons", "TorqueCheck", "TorqueSaturation", "TotalForceBound", "URDFError",
    "Uniqueness", "UnknownName", "Unsupported", "accuracy_cost", "audit_urdf", "example_hand", "solve_lcp",
    "solve_many", "wrench_from_fingertip_forces",
]  # fmt: skip

_STUDIES = {"AccuracyCost": "handlcp.study.accuracy", "accuracy_cost": "handlcp.study.accuracy"}


def __getattr__(name: str) -> Any:
    """Studies are imported when first asked for, so that a solve need not wait for them. Effects and friction laws in
    files of their own are found by their class: they need no line here.
    """
    from importlib import import_module

    if name in _STUDIES:
        value = globals()[name] = getattr(import_module(_STUDIES[name]), name)
        return value
    for kind in (*[kind for kind in effect_kinds() if kind.file_key is not None], *friction_laws()):
        if kind.__name__ == name:
            return kind
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
