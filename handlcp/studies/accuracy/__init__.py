"""What accuracy costs in one scene: time against error, method by method, and the error of leaving an effect out."""

from handlcp.studies.accuracy.as_printed import AsPrinted
from handlcp.studies.accuracy.cost import accuracy_cost
from handlcp.studies.accuracy.methods import METHODS
from handlcp.studies.accuracy.result import AccuracyCost

__all__ = ["METHODS", "AccuracyCost", "AsPrinted", "accuracy_cost"]
