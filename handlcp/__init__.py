"""Grasp forces, slips, object motion and joint torques of robot hands, by linear complementarity.

import handlcp as hl

g = hl.Grasp([hl.Contact(...), ...], wrench, flexibility=1e-4)
s = g.solve()
print(s)
"""

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
    Contact,
    Coulomb,
    Equilibria,
    Explanation,
    Frictionless,
    Grasp,
    GraspProblem,
    GraspSolution,
    PrescribedForce,
    Pyramid,
    Required,
    Residuals,
    TotalForceBound,
    Uniqueness,
)
from handlcp.hand import (
    Audit,
    Box,
    Cylinder,
    Doubt,
    Ellipsoid,
    Hand,
    HandGrasp,
    HandGraspSolution,
    HandState,
    Mesh,
    Sphere,
    TorqueCheck,
    audit_urdf,
    example_hand,
)
from handlcp.lcp import LCP, NSNGRK, Auto, LCPSolution, Lemke, SemismoothNewton, Status, solve_lcp
from handlcp.version import VERSION

__version__ = VERSION

__all__ = [
    "LCP",
    "NSNGRK",
    "Audit",
    "Auto",
    "Box",
    "Contact",
    "Coulomb",
    "Cylinder",
    "Doubt",
    "Ellipsoid",
    "Equilibria",
    "Explanation",
    "Frictionless",
    "Grasp",
    "GraspProblem",
    "GraspSolution",
    "Hand",
    "HandGrasp",
    "HandGraspSolution",
    "HandLCPError",
    "HandState",
    "InputError",
    "LCPSolution",
    "Lemke",
    "Mesh",
    "NoSolutionFound",
    "NotReached",
    "PrescribedForce",
    "Pyramid",
    "Required",
    "Residuals",
    "SceneFileError",
    "SemismoothNewton",
    "Sphere",
    "Status",
    "TorqueCheck",
    "TotalForceBound",
    "URDFError",
    "Uniqueness",
    "UnknownName",
    "Unsupported",
    "audit_urdf",
    "example_hand",
    "solve_lcp",
]
