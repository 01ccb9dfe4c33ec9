"""A study of accuracy and cost as a figure and as tables for the terminal."""

from handlcp.viz.accuracy.figure import draw, save
from handlcp.viz.accuracy.tables import all_tables

__all__ = ["all_tables", "draw", "save"]
