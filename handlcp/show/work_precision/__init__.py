"""The figure of a study of accuracy and cost."""

from handlcp.show.work_precision.figure import draw, save
from handlcp.show.work_precision.time_panel import STYLE

__all__ = ["STYLE", "draw", "save"]
