"""The picture of a grasp."""

from handlcp.show.picture.figure import draw

__all__ = ["draw"]
