from .analysis.equilibria import Equilibria as Equilibria
from .analysis.explanation import Explanation as Explanation
from .analysis.fingertips import wrench_from_fingertip_forces as wrench_from_fingertip_forces
from .analysis.required import Required as Required
from .analysis.suggestions import Suggestion as Suggestion, Suggestions as Suggestions
from .answer.force_bounds import ForceBounds as ForceBounds
from .answer.solution import Accuracy as Accuracy, GraspSolution as GraspSolution
from .answer.uniqueness import Uniqueness as Uniqueness
from .answer.verdict import Reason as Reason, Verdict as Verdict
from .assembly.problem import GraspProblem as GraspProblem
from .batch.solutions import Solutions as Solutions
from .batch.solve_many import solve_many as solve_many
from .cause.judge import Bind as Bind
from .design.best_change import BestChange as BestChange, TriedChange as TriedChange
from .design.stiffness import RequiredStiffness as RequiredStiffness
from .effects.contact_compliance import ContactCompliance as ContactCompliance
from .effects.finger_force_bound import FingerForceBound as FingerForceBound
from .effects.geometric_stiffness import GeometricStiffness as GeometricStiffness
from .effects.known_force import KnownForce as KnownForce
from .effects.prescribed_force import PrescribedForce as PrescribedForce
from .effects.soft_wrist import SoftWrist as SoftWrist
from .effects.torque_saturation import TorqueSaturation as TorqueSaturation
from .effects.total_force_bound import TotalForceBound as TotalForceBound
from .friction.anisotropic import AnisotropicCoulomb as AnisotropicCoulomb
from .friction.coulomb import Coulomb as Coulomb
from .friction.frictionless import Frictionless as Frictionless
from .friction.law import FrictionLaw as FrictionLaw
from .friction.sections import Pyramid as Pyramid
from .friction.soft_finger import SoftFinger as SoftFinger
from .grasp import Grasp as Grasp
from .limits.result import LimitEvent as LimitEvent, LimitPath as LimitPath, LoadLimit as LoadLimit
from .margins.closure import Closure as Closure
from .margins.margins import Least as Least, Margins as Margins
from .margins.wrench_space import WrenchSpace as WrenchSpace
from .model.contact import Contact as Contact
from .model.effect import Effect as Effect, effect_kinds as effect_kinds
from .model.environment import Environment as Environment
from .model.flexibility import Flexibility as Flexibility
from .model.kind import Placement as Placement
from .model.limit import FileKey as FileKey, Limit as Limit
from .model.scene import Scene as Scene
from .model.spec import GraspSpec as GraspSpec
from .parameter.parameter import Parameter as Parameter, Shown as Shown, Trial as Trial, parameters as parameters
from .path.events import Event as Event
from .path.follow import Loading as Loading
from .path.state import Stage as Stage
from .sensitivity.paths import PathSensitivity as PathSensitivity
from .sensitivity.sensitivity import Sensitivity as Sensitivity
from .verify.judge import Residuals as Residuals
