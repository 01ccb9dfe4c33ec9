"""The mechanics: contacts, friction laws, effects, and grasps assembled from them. Imports lcp, knows no robot.

GraspSpec → build → Scene → assemble → propose → verify → answer          (README.md in `handlcp` walks one number
through it)
"""

from handlcp.grasp.analysis.equilibria import Equilibria
from handlcp.grasp.analysis.explanation import Explanation
from handlcp.grasp.analysis.fingertips import wrench_from_fingertip_forces
from handlcp.grasp.analysis.required import Required
from handlcp.grasp.analysis.suggestions import Suggestion, Suggestions
from handlcp.grasp.answer.accuracy import Accuracy
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.uniqueness import Uniqueness
from handlcp.grasp.answer.verdict import Reason, Verdict
from handlcp.grasp.assembly.problem import GraspProblem
from handlcp.grasp.batch.solutions import Solutions
from handlcp.grasp.batch.solve_many import solve_many
from handlcp.grasp.cause.cause import Bind
from handlcp.grasp.design.best_change import BestChange, TriedChange
from handlcp.grasp.design.stiffness import RequiredStiffness
from handlcp.grasp.effects import Effect, effect_kinds
from handlcp.grasp.effects.contact_compliance import ContactCompliance
from handlcp.grasp.effects.finger_force_bound import FingerForceBound
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.known_force import KnownForce
from handlcp.grasp.effects.prescribed_force import PrescribedForce
from handlcp.grasp.effects.soft_wrist import SoftWrist
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.effects.total_force_bound import TotalForceBound
from handlcp.grasp.friction import (
    AnisotropicCoulomb,
    Coulomb,
    FrictionLaw,
    Frictionless,
    Pyramid,
    SoftFinger,
)
from handlcp.grasp.grasp import Grasp
from handlcp.grasp.limits.result import LimitEvent, LimitPath, LoadLimit
from handlcp.grasp.margins.closure import Closure
from handlcp.grasp.margins.margins import Least, Margins
from handlcp.grasp.margins.wrench_space import WrenchSpace
from handlcp.grasp.model.contact import Contact
from handlcp.grasp.model.environment import Environment
from handlcp.grasp.model.file_key import FileKey
from handlcp.grasp.model.limit import Limit
from handlcp.grasp.model.placement import Placement
from handlcp.grasp.model.scene import Scene
from handlcp.grasp.model.spec import GraspSpec
from handlcp.grasp.path.events import Event
from handlcp.grasp.path.follow import Loading
from handlcp.grasp.path.program import Stage
from handlcp.grasp.sensitivity.paths import PathSensitivity
from handlcp.grasp.sensitivity.sensitivity import Sensitivity
from handlcp.grasp.verify.judge import Residuals

__all__ = [
    "Accuracy", "AnisotropicCoulomb", "BestChange", "Bind", "Closure", "Contact", "ContactCompliance", "Coulomb",
    "Effect", "Environment", "Equilibria", "Event", "Explanation", "FileKey", "FingerForceBound", "FrictionLaw",
    "Frictionless", "GeometricStiffness", "Grasp", "GraspProblem", "GraspSolution", "GraspSpec", "KnownForce", "Least",
    "Limit", "LimitEvent", "LimitPath", "LoadLimit", "Loading", "Margins", "PathSensitivity", "Placement",
    "PrescribedForce", "Pyramid", "Reason", "Required", "RequiredStiffness", "Residuals", "Scene", "Sensitivity",
    "SoftFinger", "SoftWrist", "Solutions", "Stage", "Suggestion", "Suggestions", "TorqueSaturation", "TotalForceBound",
    "TriedChange", "Uniqueness", "Verdict", "WrenchSpace", "effect_kinds", "solve_many", "wrench_from_fingertip_forces",
]  # fmt: skip
