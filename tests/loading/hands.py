"""Hands, and grasps by them, that several tests follow; those of prismatic fingers have closed forms."""

import numpy as np

import handlcp as hl

G = 9.81


def cube(squeeze=0.003, friction=0.8, **more):
    """A cube between three fingers, all of which stick."""
    hand = hl.example_hand("three_finger", joint_stiffness=6.0)
    box = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    return hand.at(hand.close_on(box)).grasp(box, friction=friction, squeeze=squeeze, **more)


def ball(stiffness=6.0, squeeze=0.003, friction=None, mass=0.3, limits=None, **more):
    """A ball under a hand with five fingers that hangs."""
    given = {} if limits is None else {"torque_limits": limits}
    hand = hl.example_hand("five_finger", joint_stiffness=stiffness, **given)
    sphere = hl.Sphere(0.035, (0, 0, 0.07), mass=mass)
    friction = hl.Coulomb(0.6) if friction is None else friction
    return hand.at(hand.close_on(sphere)).grasp(sphere, friction, gravity=(0, 0, G), squeeze=squeeze, **more)


def box_on_a_table():
    """A box between two fingers that stands on a rigid table; they hang, so that +z is down."""
    hand = hl.example_hand("two_finger", joint_stiffness=6.0, pad_flexibility=2e-4)
    box = hl.Box((0.05, 0.05, 0.07), (0, 0, 0.09), mass=0.5)
    table = hl.Table((0, 0, 0.125), (0, 0, -1), hl.Coulomb(0.4), flexibility=0)
    state = hand.at(hand.close_on(box))
    return state.grasp(box, hl.Coulomb(0.8), gravity=(0, 0, G), squeeze=0.002, environment=table)


def gripper(pads, y=0.0, stiffness=5.0, squeeze=0.004):
    """A ball between a thumb and two fingers opposite to it, whose joints all turn about y: along y only pads give
    way. y : of the ball, off the middle.
    """
    cylinder = "<origin xyz='0 0 {0}'/><geometry><cylinder radius='0.008' length='{1}'/></geometry>"
    parts = ["<robot name='gripper'><link name='palm'/>"]
    for name, x, beside, yaw in (
        ("thumb", -0.038, 0, 0),
        ("index", 0.038, -0.022, np.pi),
        ("ring", 0.038, 0.022, np.pi),
    ):
        link, base = "palm", f"<origin xyz='{x} {beside} 0.008' rpy='0 0 {yaw}'/>"
        for part, length, effort in (("a", 0.045, 0.7), ("b", 0.038, 0.4)):
            parts.append(
                f"<joint name='{name}_{part}' type='revolute'><parent link='{link}'/><child link='{name}_link_{part}'/>"
                f"{base}<axis xyz='0 1 0'/><limit lower='-0.8' upper='1.6' effort='{effort}' velocity='4'/></joint>"
                f"<link name='{name}_link_{part}'><collision>{cylinder.format(length / 2, length)}</collision></link>"
            )
            link, base = f"{name}_link_{part}", f"<origin xyz='0 0 {length}'/>"
    hand = hl.Hand.from_urdf("".join([*parts, "</robot>"]), joint_stiffness=stiffness, pad_flexibility=pads)
    sphere = hl.Sphere(0.03, (0, y, 0.085), mass=0.2)
    return hand.at(hand.close_on(sphere)).grasp(sphere, friction=0.6, squeeze=squeeze)


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
