"""Fingers of two joints whose answers can be written down: links A and B, straight up along z in the posture zero."""

from handlcp.hand import Hand

A, B = 0.05, 0.03  # m, of the links

_FINGER = """
  <link name="{n}_1"/><link name="{n}_2"/><link name="{n}_tip"/>
  <joint name="{n}_root" type="revolute"><parent link="palm"/><child link="{n}_1"/><axis xyz="0 {s} 0"/>
    <origin xyz="{x} 0 0"/><limit lower="-2" upper="2" effort="50" velocity="1"/></joint>
  <joint name="{n}_end" type="revolute"><parent link="{n}_1"/><child link="{n}_2"/><axis xyz="0 {s} 0"/>
    <origin xyz="0 0 {A}"/><limit lower="-2" upper="2" effort="50" velocity="1"/></joint>
  <joint name="{n}_f" type="fixed"><parent link="{n}_2"/><child link="{n}_tip"/><origin xyz="0 0 {B}"/></joint>
"""


def chain_hand(write, **more):
    """Two such fingers, "left" at x = -10 mm and "right" at 10 mm; positive angles move a tip inwards."""
    fingers = "".join(_FINGER.format(n=n, x=x, s=s, A=A, B=B) for n, x, s in (("left", -0.01, 1), ("right", 0.01, -1)))
    settings = {"pad_flexibility": 0.0} | more
    return Hand.from_urdf(write(f'<robot name="chains"><link name="palm"/>{fingers}</robot>'), **settings)
