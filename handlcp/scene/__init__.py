"""Scene files: one grasp, written as TOML.

    import handlcp.scene

    scene = handlcp.scene.load("examples/cube_three_fingers.toml")
    grasp = scene.build()       # a Grasp, or a HandGrasp when the file has a [hand]
    solution = scene.solve()

`import handlcp` does not import this package: pydantic is paid for by those who read scene files.
"""

from handlcp.scene.build import SceneFile, load, read
from handlcp.scene.keys import Key, keys

__all__ = ["Key", "SceneFile", "keys", "load", "read"]
