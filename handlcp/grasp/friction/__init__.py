"""Friction laws, one a file, and the sections (cone, pyramid, interval) in which a solver takes them.

A law is found by its class: the files of this folder are imported, whatever their names. Adding a law is adding a file.
"""

from importlib import import_module
from pkgutil import iter_modules

from handlcp.grasp.friction.anisotropic import AnisotropicCoulomb
from handlcp.grasp.friction.coulomb import Coulomb
from handlcp.grasp.friction.frictionless import Frictionless
from handlcp.grasp.friction.given import as_law, laws_by_name
from handlcp.grasp.friction.law import FrictionLaw, friction_laws
from handlcp.grasp.friction.limit_set import limit_set
from handlcp.grasp.friction.sections import Cone, Interval, Pyramid, Section, as_section
from handlcp.grasp.friction.soft_finger import SoftFinger

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

__all__ = [
    "AnisotropicCoulomb",
    "Cone",
    "Coulomb",
    "FrictionLaw",
    "Frictionless",
    "Interval",
    "Pyramid",
    "Section",
    "SoftFinger",
    "as_law",
    "as_section",
    "friction_laws",
    "laws_by_name",
    "limit_set",
]
