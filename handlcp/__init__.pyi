import typing

from .errors import (
    HandLCPError as HandLCPError,
)
from .errors import (
    InputError as InputError,
)
from .errors import (
    NoGraspFound as NoGraspFound,
)
from .errors import (
    NoSolutionFound as NoSolutionFound,
)
from .errors import (
    NotReached as NotReached,
)
from .errors import (
    SceneFileError as SceneFileError,
)
from .errors import (
    UnknownName as UnknownName,
)
from .errors import (
    Unsupported as Unsupported,
)
from .errors import (
    URDFError as URDFError,
)
from .grasp.analysis.equilibria import Equilibria as Equilibria
from .grasp.analysis.explanation import Explanation as Explanation
from .grasp.analysis.fingertips import wrench_from_fingertip_forces as wrench_from_fingertip_forces
from .grasp.analysis.required import Required as Required
from .grasp.analysis.suggestions import Suggestions as Suggestions
from .grasp.answer.solution import Accuracy as Accuracy
from .grasp.answer.solution import GraspSolution as GraspSolution
from .grasp.answer.uniqueness import Uniqueness as Uniqueness
from .grasp.answer.verdict import Reason as Reason
from .grasp.answer.verdict import Verdict as Verdict
from .grasp.assembly.problem import GraspProblem as GraspProblem
from .grasp.batch.solutions import Solutions as Solutions
from .grasp.batch.solve_many import solve_many as solve_many
from .grasp.design.best_change import BestChange as BestChange
from .grasp.design.best_change import TriedChange as TriedChange
from .grasp.design.stiffness import RequiredStiffness as RequiredStiffness
from .grasp.effects.contact_compliance import ContactCompliance as ContactCompliance
from .grasp.effects.finger_force_bound import FingerForceBound as FingerForceBound
from .grasp.effects.geometric_stiffness import GeometricStiffness as GeometricStiffness
from .grasp.effects.known_force import KnownForce as KnownForce
from .grasp.effects.prescribed_force import PrescribedForce as PrescribedForce
from .grasp.effects.soft_wrist import SoftWrist as SoftWrist
from .grasp.effects.torque_saturation import TorqueSaturation as TorqueSaturation
from .grasp.effects.total_force_bound import TotalForceBound as TotalForceBound
from .grasp.friction.anisotropic import AnisotropicCoulomb as AnisotropicCoulomb
from .grasp.friction.coulomb import Coulomb as Coulomb
from .grasp.friction.frictionless import Frictionless as Frictionless
from .grasp.friction.sections import Pyramid as Pyramid
from .grasp.friction.soft_finger import SoftFinger as SoftFinger
from .grasp.grasp import Grasp as Grasp
from .grasp.limits.result import LoadLimit as LoadLimit
from .grasp.margins.margins import Margins as Margins
from .grasp.model.contact import Contact as Contact
from .grasp.model.environment import Environment as Environment
from .grasp.path.follow import Loading as Loading
from .grasp.path.state import Stage as Stage
from .grasp.sensitivity.paths import PathSensitivity as PathSensitivity
from .grasp.sensitivity.sensitivity import Sensitivity as Sensitivity
from .grasp.verify.judge import Residuals as Residuals
from .hand.design.motors import RequiredTorque as RequiredTorque
from .hand.elasticity.tendons import Synergies as Synergies
from .hand.elasticity.tendons import Tendons as Tendons
from .hand.find.candidate import Candidate as Candidate
from .hand.find.candidate import Found as Found
from .hand.find.find import find_grasp as find_grasp
from .hand.hand import Hand as Hand
from .hand.hand_grasp import HandGrasp as HandGrasp
from .hand.library import example_hand as example_hand
from .hand.objects.shapes import (
    Box as Box,
)
from .hand.objects.shapes import (
    Cylinder as Cylinder,
)
from .hand.objects.shapes import (
    Ellipsoid as Ellipsoid,
)
from .hand.objects.shapes import (
    Mesh as Mesh,
)
from .hand.objects.shapes import (
    Sphere as Sphere,
)
from .hand.objects.table import Table as Table
from .hand.robot.audit import Audit as Audit
from .hand.robot.audit import audit_urdf as audit_urdf
from .hand.robot.describe import HandDescription as HandDescription
from .hand.robot.describe import describe_urdf as describe_urdf
from .hand.robot.joint_limits import Doubt as Doubt
from .hand.solution import HandGraspSolution as HandGraspSolution
from .hand.solution import TorqueCheck as TorqueCheck
from .hand.state import HandState as HandState
from .hand.stream import GraspStream as GraspStream
from .hand.update import GraspUpdate as GraspUpdate
from .lcp.problem import LCP as LCP
from .lcp.problem import LCPSolution as LCPSolution
from .lcp.problem import Status as Status
from .lcp.solve import solve_lcp as solve_lcp
from .lcp.solvers.auto import Auto as Auto
from .lcp.solvers.lemke import Lemke as Lemke
from .lcp.solvers.newton import SemismoothNewton as SemismoothNewton
from .lcp.solvers.nsngrk import NSNGRK as NSNGRK
from .method.accuracy.cost import accuracy_cost as accuracy_cost
from .method.accuracy.on_paths import PathCost as PathCost
from .method.accuracy.on_paths import path_cost as path_cost
from .method.accuracy.result import AccuracyCost as AccuracyCost
from .simulator.write import to_mujoco as to_mujoco
from .study.envelope.measure import envelope as envelope
from .study.envelope.result import Envelope as Envelope
from .study.reliability.interval import Chance as Chance
from .study.reliability.interval import Influence as Influence
from .study.reliability.result import Reliability as Reliability
from .study.reliability.result import Sample as Sample
from .study.reliability.study import reliability as reliability

__version__: str

def __getattr__(name: str) -> typing.Any: ...  # effects and friction laws in files of their own
