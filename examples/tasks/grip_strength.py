"""How hard does a hand close on a split cylinder of 50 mm, with all the torque that its motors have?"""

import pathlib
import tempfile

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)
strength = hl.split_cylinder(hand, 0.05, grasps=["pinch"])
print(strength)

pinch = strength.pinch
print(f"the load cell has {pinch.force:.1f} N, and {pinch.binds[0].who} is at its limit")

picture = strength.plot(pathlib.Path(tempfile.mkdtemp()) / "split.png", title="How hard does the hand close?")
print(f"open {picture}")
