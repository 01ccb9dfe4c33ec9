"""The numbers that a grasp is made of, a class each.

A parameter is found by its class (`parameter.py`): the files of this folder are imported, whatever their names, and
each class says everything about its parameter. Sensitivities, reliability, best change, advice and required values take
parameters from here by name. Adding one is adding a class.
"""

from importlib import import_module
from pkgutil import iter_modules

from handlcp.grasp.derivatives.parameter.parameter import (
    Parameter,
    find_parameter,
    find_present_parameter,
    parameters,
    parameters_by_effort,
    present_parameters,
)

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

__all__ = [
    "Parameter", "find_parameter", "find_present_parameter", "parameters", "parameters_by_effort",
    "present_parameters",
]  # fmt: skip
