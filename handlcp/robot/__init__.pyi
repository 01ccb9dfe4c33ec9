from .audit import Audit as Audit, audit_urdf as audit_urdf
from .description import tendon_routes as tendon_routes
from .hand_description import HandDescription as HandDescription, describe_urdf as describe_urdf
from .joint import Doubt as Doubt
