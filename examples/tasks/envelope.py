"""How hard may a cube be pulled, in any direction, and how heavy may it be, however the hand is turned?"""

import pathlib
import tempfile

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)

pull = hl.envelope(grasp, 42)  # directions all around, and more where what gives out first changes
print(pull)
mass = hl.envelope(grasp, ("xz", 24), of="gravity")  # gravity seen from the hand, in the plane xz
print(f"turned about y, the hand holds {mass.weakest.factor:.2f} kg in every position")

page = pull.page(pathlib.Path(tempfile.mkdtemp()) / "pull.html", title="How hard the cube may be pulled")
print(f"open {page}")
