"""What accuracy costs in one scene: time against error, method by method, and the error of leaving an effect out."""

from handlcp.study.accuracy.as_printed import AsPrinted
from handlcp.study.accuracy.cost import accuracy_cost
from handlcp.study.accuracy.methods import METHODS
from handlcp.study.accuracy.on_paths import PathCost, PathRow, path_cost
from handlcp.study.accuracy.result import AccuracyCost, FaceLaw, LeftOut, Reference, Row

__all__ = [
    "METHODS",
    "AccuracyCost",
    "AsPrinted",
    "FaceLaw",
    "LeftOut",
    "PathCost",
    "PathRow",
    "Reference",
    "Row",
    "accuracy_cost",
    "path_cost",
]
