import typing

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
from .grasp import (
    Accuracy as Accuracy,
    AnisotropicCoulomb as AnisotropicCoulomb,
    BestChange as BestChange,
    Contact as Contact,
    ContactCompliance as ContactCompliance,
    Coulomb as Coulomb,
    Environment as Environment,
    Equilibria as Equilibria,
    Explanation as Explanation,
    FingerForceBound as FingerForceBound,
    Flexibility as Flexibility,
    ForceBounds as ForceBounds,
    Frictionless as Frictionless,
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
    Pyramid as Pyramid,
    Reason as Reason,
    Required as Required,
    RequiredStiffness as RequiredStiffness,
    Residuals as Residuals,
    Sensitivity as Sensitivity,
    SoftFinger as SoftFinger,
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
    YCB as YCB,
    Around as Around,
    Audit as Audit,
    Box as Box,
    Candidate as Candidate,
    Cylinder as Cylinder,
    Doubt as Doubt,
    Ellipsoid as Ellipsoid,
    Found as Found,
    GraspStream as GraspStream,
    GraspUpdate as GraspUpdate,
    Hand as Hand,
    HandDescription as HandDescription,
    HandGrasp as HandGrasp,
    HandGraspSolution as HandGraspSolution,
    HandState as HandState,
    MeasuredStiffness as MeasuredStiffness,
    Mesh as Mesh,
    Motor as Motor,
    Pulley as Pulley,
    RequiredTorque as RequiredTorque,
    Route as Route,
    Site as Site,
    Sphere as Sphere,
    Synergies as Synergies,
    Table as Table,
    Tendons as Tendons,
    TorqueCheck as TorqueCheck,
    audit_urdf as audit_urdf,
    describe_urdf as describe_urdf,
    example_hand as example_hand,
    find_grasp as find_grasp,
    read_postures as read_postures,
    stiffness_from as stiffness_from,
    tendon_routes as tendon_routes,
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
from .show.report.report import report as report
from .simulator.write import to_mujoco as to_mujoco
from .study.accuracy.cost import accuracy_cost as accuracy_cost
from .study.accuracy.on_paths import PathCost as PathCost, path_cost as path_cost
from .study.accuracy.result import AccuracyCost as AccuracyCost
from .study.envelope.measure import envelope as envelope
from .study.envelope.result import Envelope as Envelope
from .study.grip_strength.measure import split_cylinder as split_cylinder
from .study.grip_strength.result import SplitCylinder as SplitCylinder
from .study.payload.result import Payload as Payload
from .study.published.finger_result import FingerStrength as FingerStrength
from .study.published.finger_strength import finger_strength as finger_strength
from .study.published.lift_and_shake import lift_and_shake as lift_and_shake
from .study.published.lift_result import LiftAndShake as LiftAndShake
from .study.published.slip_resistance import SlipResistance as SlipResistance, slip_resistance as slip_resistance
from .study.reliability.interval import Chance as Chance, Influence as Influence
from .study.reliability.result import Reliability as Reliability, Sample as Sample
from .study.reliability.study import reliability as reliability
from .study.varied import Slopes as Slopes, slopes as slopes, vary_grasp as vary_grasp

__version__: str

def __getattr__(name: str) -> typing.Any: ...  # effects and friction laws in files of their own
