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
    Explanation,
    Frictionless,
    Grasp,
    GraspProblem,
    GraspSolution,
    PrescribedForce,
    Pyramid,
    Residuals,
    TotalForceBound,
    Uniqueness,
)
from handlcp.lcp import LCP, NSNGRK, Auto, LCPSolution, Lemke, SemismoothNewton, Status, solve_lcp

__version__ = "0.1.0"

__all__ = [
    "LCP",
    "NSNGRK",
    "Auto",
    "Contact",
    "Coulomb",
    "Explanation",
    "Frictionless",
    "Grasp",
    "GraspProblem",
    "GraspSolution",
    "HandLCPError",
    "InputError",
    "LCPSolution",
    "Lemke",
    "NoSolutionFound",
    "NotReached",
    "PrescribedForce",
    "Pyramid",
    "Residuals",
    "SceneFileError",
    "SemismoothNewton",
    "Status",
    "TotalForceBound",
    "URDFError",
    "Uniqueness",
    "UnknownName",
    "Unsupported",
    "solve_lcp",
]
