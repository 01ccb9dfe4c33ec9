"""Friction laws, and the sections (cone, pyramid, interval) in which a solver takes them.

The package's laws are in `law.py`; another may be a file of its own. A law is found by its class: the files of this
folder are imported, whatever their names. Adding a law is adding a file.
"""

from importlib import import_module
from pkgutil import iter_modules

from handlcp.contact.friction.law import (
    AnisotropicCoulomb,
    Coulomb,
    FrictionLaw,
    Frictionless,
    SoftFinger,
    as_law,
    friction_laws,
    laws_by_name,
)
from handlcp.contact.friction.section import Cone, Interval, Pyramid, Section, as_section, limit_set

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
