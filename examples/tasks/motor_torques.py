"""Which motors lift 1.5 kg with a safety factor of 1.5? The least grip that holds, and the torque of each joint."""

import math

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=20.0, torque_limits=math.inf)  # N·m/rad; no limits yet
bottle = hl.Cylinder(radius=0.025, length=0.14, placement=(0, 0, 0.13), mass=1.5 * 1.5)
grasp = hand.at(hand.close_on(bottle)).grasp(bottle, friction=0.6)

grip = next(newtons for newtons in range(1, 100) if grasp.replace(grip_force=newtons).follow().reached)
held = grasp.replace(grip_force=grip).follow()
motors = dict(zip(hand.joint_names, abs(held.solution.torques), strict=True))
print(f"a grip of {grip} N a finger holds the bottle; the motors need, in N·m:")
for joint, torque in motors.items():
    print(f"  {joint}: {torque:.2f}")
