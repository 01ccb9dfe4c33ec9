"""The scripts of the folder `examples`, imported as a user's own would be."""

import importlib.util
import pathlib
import sys
from functools import cache

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


@cache
def script(path):
    """A script by its path below `examples`, such as "paper/misprints"."""
    name = f"examples_{path.replace('/', '_')}"
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{path}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module
