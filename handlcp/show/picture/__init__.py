"""The picture of a grasp."""

from handlcp.show.picture.figure import draw, save

__all__ = ["draw", "save"]
