"""The mathematics: (mixed) linear complementarity problems, solvers, and a certifier that trusts none of them.

Knows nothing of grasps or robots.
"""

from handlcp.lcp.certify import certify, is_farkas, natural_residual
from handlcp.lcp.contact import ContactProblem
from handlcp.lcp.problem import LCP
from handlcp.lcp.result import LCPSolution, Proposal
from handlcp.lcp.scaling import Units
from handlcp.lcp.solve import proposals, solve_lcp
from handlcp.lcp.solvers.auto import Auto, as_chain
from handlcp.lcp.solvers.base import ContactSolver, Solver
from handlcp.lcp.solvers.lemke import Lemke
from handlcp.lcp.solvers.newton import SemismoothNewton
from handlcp.lcp.solvers.nsngrk import NSNGRK
from handlcp.lcp.solvers.printed import AsPrinted
from handlcp.lcp.status import Status

__all__ = [
    "LCP",
    "NSNGRK",
    "AsPrinted",
    "Auto",
    "ContactProblem",
    "ContactSolver",
    "LCPSolution",
    "Lemke",
    "Proposal",
    "SemismoothNewton",
    "Solver",
    "Status",
    "Units",
    "as_chain",
    "certify",
    "is_farkas",
    "natural_residual",
    "proposals",
    "solve_lcp",
]
