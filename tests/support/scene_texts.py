"""Scene files, or parts of them, that tests of several effects complete."""

# A box between two fingers; ends in [hand], so that its keys may follow
BOX_IN_TWO_FINGERS = """
[object]
shape = "box"
size_m = [0.03, 0.04, 0.06]
position_m = [0.0, 0.0, 0.08]
[hand]
name = "two_finger"
"""

# Two contacts face to face, no hand
TWO_CONTACTS = """
[[contact]]
position_m = [0.03, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
name = "thumb"
[[contact]]
position_m = [-0.03, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
"""
