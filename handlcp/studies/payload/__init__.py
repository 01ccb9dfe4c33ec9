"""The largest mass that a grasp holds however the hand is turned, at rest and while it accelerates."""

from handlcp.studies.payload.largest_mass import find_payload
from handlcp.studies.payload.result import Orientation, Payload

__all__ = ["Orientation", "Payload", "find_payload"]
