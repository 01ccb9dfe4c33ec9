"""What accuracy costs in one scene: time against error, method by method, and the error of leaving an effect out."""

from handlcp.method.accuracy.cost import accuracy_cost
from handlcp.method.accuracy.methods import METHODS
from handlcp.method.accuracy.on_paths import PathCost, PathRow, path_cost
from handlcp.method.accuracy.result import AccuracyCost, FaceLaw, LeftOut, Reference, Row

__all__ = [
    "METHODS",
    "AccuracyCost",
    "FaceLaw",
    "LeftOut",
    "PathCost",
    "PathRow",
    "Reference",
    "Row",
    "accuracy_cost",
    "path_cost",
]
