"""Physical effects, one a file, each with its equation on top.

An effect declares its unknowns and stamps its blocks; a scene without it has none of them. Adding an effect is adding
a file here and a row in `handlcp.grasp.catalogue`; README.md beside this file, the list of them all, is written from
what their classes say.
"""

from handlcp.grasp.effects.anisotropic_friction import AnisotropicFriction
from handlcp.grasp.effects.base import Effect
from handlcp.grasp.effects.compliance import Compliance, softened, stamped
from handlcp.grasp.effects.contact_compliance import ContactCompliance
from handlcp.grasp.effects.coulomb_cone import CoulombCone
from handlcp.grasp.effects.coulomb_planar import CoulombPlanar
from handlcp.grasp.effects.coulomb_pyramid import CoulombPyramid
from handlcp.grasp.effects.finger_flexibility import FingerFlexibility
from handlcp.grasp.effects.finger_force_bound import FingerForceBound
from handlcp.grasp.effects.geometric_stiffness import GeometricStiffness
from handlcp.grasp.effects.known_force import KnownForce
from handlcp.grasp.effects.limit import Limit
from handlcp.grasp.effects.object_balance import ObjectBalance
from handlcp.grasp.effects.prescribed_force import PrescribedForce
from handlcp.grasp.effects.soft_finger_cone import SoftFingerCone
from handlcp.grasp.effects.soft_finger_pyramid import SoftFingerPyramid
from handlcp.grasp.effects.soft_wrist import SoftWrist
from handlcp.grasp.effects.torque_saturation import TorqueSaturation
from handlcp.grasp.effects.total_force_bound import TotalForceBound
from handlcp.grasp.effects.unilateral_contact import UnilateralContact

__all__ = [
    "AnisotropicFriction",
    "Compliance",
    "ContactCompliance",
    "CoulombCone",
    "CoulombPlanar",
    "CoulombPyramid",
    "Effect",
    "FingerFlexibility",
    "FingerForceBound",
    "GeometricStiffness",
    "KnownForce",
    "Limit",
    "ObjectBalance",
    "PrescribedForce",
    "SoftFingerCone",
    "SoftFingerPyramid",
    "SoftWrist",
    "TorqueSaturation",
    "TotalForceBound",
    "UnilateralContact",
    "softened",
    "stamped",
]
