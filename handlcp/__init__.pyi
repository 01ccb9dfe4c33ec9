import typing

from .actuation import (
    Around as Around,
    MeasuredStiffness as MeasuredStiffness,
    Motor as Motor,
    Pulley as Pulley,
    Route as Route,
    Site as Site,
    Synergies as Synergies,
    Tendons as Tendons,
    stiffness_from as stiffness_from,
)
from .contact.friction import (
    AnisotropicCoulomb as AnisotropicCoulomb,
    Coulomb as Coulomb,
    Frictionless as Frictionless,
    Pyramid as Pyramid,
    SoftFinger as SoftFinger,
)
from .design.brief import Brief as Brief
from .design.evaluate import evaluate as evaluate
from .design.evaluation import Evaluation as Evaluation
from .design.finger_hand import finger_hand as finger_hand
from .design.optimise.best import Best as Best, Kink as Kink
from .design.optimise.optimise import optimise as optimise
from .design.study import Study as Study
from .design.sweep.sweep import sweep as sweep
from .errors import (
    HandLCPError as HandLCPError,
    InputError as InputError,
    NoGraspFound as NoGraspFound,
    NoSolutionFound as NoSolutionFound,
    NotReached as NotReached,
    RequirementNotMet as RequirementNotMet,
    SceneFileError as SceneFileError,
    UnknownName as UnknownName,
    Unsupported as Unsupported,
    URDFError as URDFError,
)
from .geometry import (
    YCB as YCB,
    Box as Box,
    Cylinder as Cylinder,
    Ellipsoid as Ellipsoid,
    Mesh as Mesh,
    Sphere as Sphere,
    Table as Table,
)
from .grasp import (
    Accuracy as Accuracy,
    BestChange as BestChange,
    Contact as Contact,
    ContactCompliance as ContactCompliance,
    Environment as Environment,
    Equilibria as Equilibria,
    Explanation as Explanation,
    FingerForceBound as FingerForceBound,
    Flexibility as Flexibility,
    ForceBounds as ForceBounds,
    GeometricStiffness as GeometricStiffness,
    Grasp as Grasp,
    GraspProblem as GraspProblem,
    GraspSolution as GraspSolution,
    KnownForce as KnownForce,
    Loading as Loading,
    LoadLimit as LoadLimit,
    Margins as Margins,
    PathSensitivity as PathSensitivity,
    PrescribedForce as PrescribedForce,
    Reason as Reason,
    Required as Required,
    RequiredStiffness as RequiredStiffness,
    Residuals as Residuals,
    Sensitivity as Sensitivity,
    SoftWrist as SoftWrist,
    Solutions as Solutions,
    Stage as Stage,
    Suggestions as Suggestions,
    TorqueSaturation as TorqueSaturation,
    TotalForceBound as TotalForceBound,
    TriedChange as TriedChange,
    Uniqueness as Uniqueness,
    Verdict as Verdict,
    solve_many as solve_many,
    wrench_from_fingertip_forces as wrench_from_fingertip_forces,
)
from .hand import (
    Candidate as Candidate,
    Found as Found,
    GraspStream as GraspStream,
    GraspUpdate as GraspUpdate,
    Hand as Hand,
    HandGrasp as HandGrasp,
    HandGraspSolution as HandGraspSolution,
    HandState as HandState,
    RequiredTorque as RequiredTorque,
    TorqueCheck as TorqueCheck,
    example_hand as example_hand,
    find_grasp as find_grasp,
    read_postures as read_postures,
)
from .lcp import (
    LCP as LCP,
    NSNGRK as NSNGRK,
    Auto as Auto,
    LCPSolution as LCPSolution,
    Lemke as Lemke,
    SemismoothNewton as SemismoothNewton,
    Status as Status,
    solve_lcp as solve_lcp,
)
from .robot import (
    Audit as Audit,
    Doubt as Doubt,
    HandDescription as HandDescription,
    audit_urdf as audit_urdf,
    describe_urdf as describe_urdf,
    tendon_routes as tendon_routes,
)
from .simulator.export import to_mujoco as to_mujoco
from .studies.accuracy.cost import accuracy_cost as accuracy_cost
from .studies.accuracy.on_paths import PathCost as PathCost, path_cost as path_cost
from .studies.accuracy.result import AccuracyCost as AccuracyCost
from .studies.envelope.measure import envelope as envelope
from .studies.envelope.result import Envelope as Envelope
from .studies.grip_strength.measure import split_cylinder as split_cylinder
from .studies.grip_strength.result import SplitCylinder as SplitCylinder
from .studies.payload.result import Payload as Payload
from .studies.perturbation import Slopes as Slopes, slopes as slopes, vary_grasp as vary_grasp
from .studies.published.finger_strength import FingerStrength as FingerStrength, finger_strength as finger_strength
from .studies.published.lift_and_shake import LiftAndShake as LiftAndShake, lift_and_shake as lift_and_shake
from .studies.published.slip_resistance import SlipResistance as SlipResistance, slip_resistance as slip_resistance
from .studies.reliability.chance import Chance as Chance, Influence as Influence
from .studies.reliability.estimate import Reliability as Reliability, Sample as Sample, reliability as reliability
from .viz.report.report import report as report

__version__: str

def __getattr__(name: str) -> typing.Any: ...  # effects and friction laws in files of their own
