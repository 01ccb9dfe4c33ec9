import handlcp.contact.friction as _friction

from .analysis.equilibria import Equilibria as Equilibria
from .analysis.explanation import Explanation as Explanation
from .analysis.required_value import Required as Required
from .analysis.suggestions import Suggestion as Suggestion, Suggestions as Suggestions
from .assembly.problem import GraspProblem as GraspProblem
from .batch.solutions import Solutions as Solutions
from .batch.solve_many import solve_many as solve_many
from .derivatives.parameter.parameter import (
    Parameter as Parameter,
    Shown as Shown,
    Trial as Trial,
    parameters as parameters,
)
from .derivatives.path_sensitivity import PathSensitivity as PathSensitivity
from .derivatives.sensitivity import Sensitivity as Sensitivity
from .design.best_change import BestChange as BestChange, TriedChange as TriedChange
from .design.required_value import RequiredStiffness as RequiredStiffness
from .effects.compliance import ContactCompliance as ContactCompliance, SoftWrist as SoftWrist
from .effects.force_bound import FingerForceBound as FingerForceBound, TotalForceBound as TotalForceBound
from .effects.geometric_stiffness import GeometricStiffness as GeometricStiffness
from .effects.joint_torque import TorqueSaturation as TorqueSaturation
from .effects.known_force import (
    KnownForce as KnownForce,
    PrescribedForce as PrescribedForce,
    wrench_from_fingertip_forces as wrench_from_fingertip_forces,
)
from .failure.failure_mode import Bind as Bind
from .failure.reason import Reason as Reason
from .grasp import Grasp as Grasp
from .limits.result import LimitEvent as LimitEvent, LimitPath as LimitPath, LoadLimit as LoadLimit
from .margins.margins import Least as Least, Margins as Margins
from .margins.wrench_space import Closure as Closure, WrenchSpace as WrenchSpace
from .model.contact import Contact as Contact, Placement as Placement
from .model.effect import Effect as Effect, FileKey as FileKey, Limit as Limit, effect_kinds as effect_kinds
from .model.flexibility import Flexibility as Flexibility
from .model.request import Environment as Environment, GraspSpec as GraspSpec
from .model.scene import Scene as Scene
from .path.events import Event as Event
from .path.follow import Loading as Loading
from .path.state import Stage as Stage
from .solution.force_bounds import ForceBounds as ForceBounds
from .solution.solution import Accuracy as Accuracy, GraspSolution as GraspSolution
from .solution.uniqueness import Uniqueness as Uniqueness
from .solution.verdict import Verdict as Verdict
from .verify.certifier import Residuals as Residuals

AnisotropicCoulomb = _friction.AnisotropicCoulomb
Coulomb = _friction.Coulomb
Frictionless = _friction.Frictionless
FrictionLaw = _friction.FrictionLaw
Pyramid = _friction.Pyramid
SoftFinger = _friction.SoftFinger
