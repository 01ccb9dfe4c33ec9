"""A hand that nobody here knows: what is in its file, where its fingertips are, which of its numbers to doubt."""

import importlib.metadata

import handlcp as hl

share = importlib.metadata.distribution("example-robot-data").locate_file("cmeel.prefix/share")
urdf = f"{share}/example-robot-data/robots/allegro_hand_description/urdf/allegro_left_hand.urdf"

hand = hl.Hand.from_urdf(urdf, joint_stiffness=5.0)
print(hand.describe())
audit = hand.audit()
print(audit)
