"""The figure of a study of accuracy and cost."""

from handlcp.method.work_precision.figure import draw, save
from handlcp.method.work_precision.time_panel import STYLE

__all__ = ["STYLE", "draw", "save"]
