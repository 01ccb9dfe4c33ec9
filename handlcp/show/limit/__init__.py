"""Load limits: the figure of one, tables of several."""

from handlcp.show.limit.draw import figure, save

__all__ = ["figure", "save"]
