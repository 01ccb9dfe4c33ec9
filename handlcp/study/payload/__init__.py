"""The largest mass that a grasp holds however the hand is turned, at rest and while it accelerates."""

from handlcp.study.payload.ask import payload
from handlcp.study.payload.result import Orientation, Payload

__all__ = ["Orientation", "Payload", "payload"]
