"""Hands of prismatic fingers, whose grasps have closed forms."""

import handlcp as hl

_LINK = '<link name="{n}"/><link name="{n}_tip"/>'
_JOINT = (
    '<joint name="{n}_slide" type="prismatic"><parent link="base"/><child link="{n}"/><origin xyz="{x} {y} {z}"/>'
    '<axis xyz="{a} {b} {c}"/><limit lower="-1" upper="1" effort="100" velocity="1"/></joint>'
    '<joint name="{n}_end" type="fixed"><parent link="{n}"/><child link="{n}_tip"/></joint>'
)


def sliders(tmp_path, fingers, stiffness, **more):
    """A hand of fingers, each one prismatic joint: name → (place of the tip at 0, direction in which it slides)."""
    parts = ['<link name="base"/>']
    for name, (place, way) in fingers.items():
        words = dict(zip("xyzabc", (*place, *way), strict=True), n=name)
        parts += [_LINK.format(**words), _JOINT.format(**words)]
    file = tmp_path / "sliders.urdf"
    file.write_text(f'<robot name="sliders">{"".join(parts)}</robot>')
    return hl.Hand.from_urdf(file, [f"{n}_tip" for n in fingers], joint_stiffness=stiffness, **more)
