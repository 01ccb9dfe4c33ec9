"""A study of accuracy and cost as a figure and as tables for the terminal."""

from handlcp.show.accuracy.figure import draw, save
from handlcp.show.accuracy.tables import all_tables
from handlcp.show.accuracy.time_panel import STYLE

__all__ = ["STYLE", "all_tables", "draw", "save"]
