"""How heavy may the object be, however the hand is turned, at rest and on an arm that accelerates by 5 m/s²?"""

import pathlib
import tempfile

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)

rest = grasp.payload()
print(rest)
moving = grasp.payload(acceleration=5.0)
print(f"at rest {rest.mass:.2f} kg, accelerating {moving.mass:.2f} kg, where {moving.says}")

picture = rest.plot(pathlib.Path(tempfile.mkdtemp()) / "payload.png", title="How heavy may the cube be?")
print(f"open {picture}")
