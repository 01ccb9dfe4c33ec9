"""A parallel gripper whose answers can be written down, for tests that others publish; and what they reach inside."""

import handlcp as hl

_JAW = """
  <link name="{name}"><collision><geometry><sphere radius="0.008"/></geometry></collision></link>
  <joint name="{name}_slide" type="prismatic"><parent link="palm"/><child link="{name}"/><axis xyz="{way} 0 0"/>
    <origin xyz="{x} 0 0.1"/><limit lower="0" upper="0.05" effort="{effort}" velocity="1"/></joint>
"""


def gripper(folder, effort, **more):
    """Two jaws that slide towards each other along x, each a ball that presses with at most `effort` [N]."""
    jaws = [_JAW.format(name=name, way=way, x=-0.05 * way, effort=effort) for name, way in (("left", 1), ("right", -1))]
    path = folder / "gripper.urdf"
    path.write_text(f'<robot name="gripper"><link name="palm"/>{"".join(jaws)}</robot>', encoding="utf-8")
    settings = {"joint_stiffness": 2e4, "pad_flexibility": 1e-5, "fingertips": ["left", "right"]} | more
    return hl.Hand.from_urdf(path, **settings)
