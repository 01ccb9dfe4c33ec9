"""Physical effects, each with its equation.

The package's are in a few files, by what they act on; another may be a file of its own. An effect is found by its
class (`handlcp.grasp.model.effect`): the files of this folder are imported, whatever their names, and each says
everything about its effect. Adding an effect is adding a file. README.md beside this file, the list of them all, is
written from what their classes say.
"""

from importlib import import_module
from pkgutil import iter_modules

from handlcp.grasp.model.effect import Effect, effect_kinds

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

__all__ = ["Effect", "effect_kinds"]
