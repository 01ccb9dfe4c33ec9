"""A hand whose answers can be written down: fingers of one joint and length L that push towards each other."""

from handlcp import Contact, Coulomb, Environment
from handlcp.hand import Hand

L, K, PAD, MU = 0.08, 20.0, 1e-4, 0.5  # m, N·m/rad, m/N, –
C = L * L / K + PAD  # m/N of a tip along its normal; PAD along its tangents
MASS = 0.05  # kg at the middle of each finger, for those who weigh it

_FINGER = """
  <link name="{name}"><inertial><origin xyz="0 0 {half}"/><mass value="{mass}"/>
    <inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link><link name="{name}_tip"/>
  <joint name="{name}_joint" type="revolute"><parent link="palm"/><child link="{name}"/><axis xyz="0 {axis} 0"/>
    <origin xyz="{x} 0 0"/><limit lower="-1" upper="1" effort="50" velocity="1"/></joint>
  <joint name="{name}_end" type="fixed"><parent link="{name}"/><child link="{name}_tip"/>
    <origin xyz="0 0 {length}"/></joint>
"""


def along(stiffness):
    """[N/m] of a tip along its normal, joint and pad."""
    return 1.0 / (L * L / stiffness + PAD)


def lever_hand(write, **more):
    """Two fingers, "left" at x = -10 mm and "right" at 10 mm; a positive angle moves a tip inwards by L times it."""
    sizes = {"length": L, "half": L / 2, "mass": MASS}
    left = _FINGER.format(name="left", x=-0.01, axis=1, **sizes)
    right = _FINGER.format(name="right", x=0.01, axis=-1, **sizes)
    settings = {"joint_stiffness": K, "pad_flexibility": PAD} | more
    return Hand.from_urdf(write(f'<robot name="levers"><link name="palm"/>{left}{right}</robot>'), **settings)


def lever_pinch(hand, force=(0.0, 0.0, -1.0), mu=MU, **more):
    """Both tips on an object between them, tangents up, under a force."""
    contacts = [Contact((side * 0.01, 0, L), (-side, 0, 0), Coulomb(mu), tangent=(0, 0, 1)) for side in (-1.0, 1.0)]
    return hand.at([0.0, 0.0]).grasp(contacts, wrench=(*force, 0, 0, 0), reference=(0, 0, L), **more)


def lever_against_a_wall(write, wall, **more):
    """The left finger alone, which presses an object against a wall that gives way by `wall` [m/N]."""
    left = _FINGER.format(name="left", x=-0.01, axis=1, length=L, half=L / 2, mass=MASS)
    settings = {"joint_stiffness": K, "pad_flexibility": PAD} | more
    hand = Hand.from_urdf(write(f'<robot name="lever"><link name="palm"/>{left}</robot>'), **settings)
    ours, theirs = (Contact((-s * 0.01, 0, L), (s, 0, 0), Coulomb(MU), tangent=(0, 0, 1)) for s in (1.0, -1.0))
    behind = Environment([theirs], wall)
    return hand.at([0.0]).grasp([ours], wrench=[0.0] * 6, reference=(0, 0, L), environment=behind)
