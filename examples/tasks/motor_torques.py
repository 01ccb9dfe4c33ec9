"""Which motors lift 1.5 kg, and bear a push, with a safety factor of 1.5? The torque of each joint, and its grip."""

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=60.0)  # N·m/rad
bottle = hl.Cylinder(radius=0.025, length=0.14, placement=(0, 0, 0.13), mass=1.5)
grasp = hand.at(hand.close_on(bottle)).grasp(bottle, friction=0.6)

brief = {"lift": {}, "tilted": {"gravity": (0, -6.9, -6.9)}, "push": (0, 4.0, 0, 0, 0, 0)}
motors = grasp.required_torque(brief, safety=1.5)
print(motors)
