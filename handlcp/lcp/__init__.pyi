from .certify import certify as certify, is_farkas as is_farkas, natural_residual as natural_residual
from .contact import ContactProblem as ContactProblem, FrictionSets as FrictionSets, Pattern as Pattern
from .problem import (
    LCP as LCP,
    LCPSolution as LCPSolution,
    Proposal as Proposal,
    Status as Status,
    stage_line as stage_line,
)
from .scaling import Units as Units
from .solve import proposals as proposals, solve_lcp as solve_lcp
from .solvers.auto import (
    BRIEFLY as BRIEFLY,
    FIRST_STAGE as FIRST_STAGE,
    LONGER as LONGER,
    SOON as SOON,
    Auto as Auto,
    as_chain as as_chain,
)
from .solvers.base import ContactSolver as ContactSolver, Solver as Solver
from .solvers.lemke import Lemke as Lemke
from .solvers.newton import SemismoothNewton as SemismoothNewton
from .solvers.nsngrk import NSNGRK as NSNGRK
