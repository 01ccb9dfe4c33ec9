"""The mechanics: contacts, friction laws, effects, and grasps assembled from them. Imports lcp, knows no robot."""

from handlcp.grasp.achieved import Accuracy
from handlcp.grasp.assemble import GraspProblem
from handlcp.grasp.certify import Residuals
from handlcp.grasp.contact import Contact
from handlcp.grasp.effects import (
    ContactCompliance,
    Effect,
    FingerForceBound,
    GeometricStiffness,
    KnownForce,
    PrescribedForce,
    SoftWrist,
    TorqueSaturation,
    TotalForceBound,
)
from handlcp.grasp.environment import Environment
from handlcp.grasp.explain import Explanation
from handlcp.grasp.fingertips import wrench_from_fingertip_forces
from handlcp.grasp.friction import AnisotropicCoulomb, Coulomb, Friction, Frictionless, SoftFinger
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.many import Solutions, solve_many
from handlcp.grasp.others import Equilibria
from handlcp.grasp.pyramid import Pyramid
from handlcp.grasp.required import Required
from handlcp.grasp.solution import GraspSolution
from handlcp.grasp.suggest import Suggestion, Suggestions
from handlcp.grasp.uniqueness import Uniqueness

__all__ = [
    "Accuracy",
    "AnisotropicCoulomb",
    "Contact",
    "ContactCompliance",
    "Coulomb",
    "Effect",
    "Environment",
    "Equilibria",
    "Explanation",
    "FingerForceBound",
    "Friction",
    "Frictionless",
    "GeometricStiffness",
    "Grasp",
    "GraspProblem",
    "GraspSolution",
    "KnownForce",
    "PrescribedForce",
    "Pyramid",
    "Required",
    "Residuals",
    "SoftFinger",
    "SoftWrist",
    "Solutions",
    "Suggestion",
    "Suggestions",
    "TorqueSaturation",
    "TotalForceBound",
    "Uniqueness",
    "solve_many",
    "wrench_from_fingertip_forces",
]
