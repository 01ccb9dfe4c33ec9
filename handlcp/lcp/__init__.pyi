from .certificate import certify as certify, is_farkas as is_farkas, natural_residual as natural_residual
from .contact_problem import ContactProblem as ContactProblem, FrictionSets as FrictionSets, Pattern as Pattern
from .lemke import Lemke as Lemke
from .problem import (
    LCP as LCP,
    LCPSolution as LCPSolution,
    Proposal as Proposal,
    Status as Status,
    Units as Units,
    stage_line as stage_line,
)
from .solve import (
    BRIEF_SEARCH_STAGE as BRIEF_SEARCH_STAGE,
    FIRST_STAGE as FIRST_STAGE,
    LONG_SEARCH_STAGE as LONG_SEARCH_STAGE,
    STAGES_BETWEEN_SEARCHES as STAGES_BETWEEN_SEARCHES,
    STATIC_STAGE as STATIC_STAGE,
    Auto as Auto,
    as_chain as as_chain,
    is_static as is_static,
    proposals as proposals,
    solve_lcp as solve_lcp,
)
from .solver import (
    NSNGRK as NSNGRK,
    ContactSolver as ContactSolver,
    SemismoothNewton as SemismoothNewton,
    Solver as Solver,
)
