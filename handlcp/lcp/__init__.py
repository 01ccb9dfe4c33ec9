"""The mathematics: (mixed) linear complementarity problems, solvers, and a certifier that trusts none of them.

Knows nothing of grasps or robots.
"""

from handlcp.lcp.certify import certify, is_farkas, natural_residual
from handlcp.lcp.contact import ContactProblem, FrictionSets, Pattern
from handlcp.lcp.problem import LCP, LCPSolution, Proposal, Status, stage_line
from handlcp.lcp.scaling import Units
from handlcp.lcp.solve import proposals, solve_lcp
from handlcp.lcp.solvers.auto import BRIEFLY, FIRST_STAGE, LONGER, SOON, Auto, as_chain
from handlcp.lcp.solvers.base import ContactSolver, Solver
from handlcp.lcp.solvers.lemke import Lemke
from handlcp.lcp.solvers.newton import SemismoothNewton
from handlcp.lcp.solvers.nsngrk import NSNGRK

__all__ = [
    "BRIEFLY",
    "FIRST_STAGE",
    "LCP",
    "LONGER",
    "NSNGRK",
    "SOON",
    "Auto",
    "ContactProblem",
    "ContactSolver",
    "FrictionSets",
    "LCPSolution",
    "Lemke",
    "Pattern",
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
    "stage_line",
]
