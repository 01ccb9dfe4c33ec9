"""What if friction drops by a tenth? The answer without another solve, and which finger it comes down to."""

import numpy as np

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)  # N·m/rad
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.3)
friction = 0.8
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=friction, grip_force=6.0)
solution = grasp.solve()

sensitivity = solution.sensitivity()
margin = solution.friction_margin
drop = sensitivity.friction_margin_by_friction @ np.full(3, -0.1 * friction)
print("friction to spare, in N: now, and with a tenth less friction")
for name, now, less in zip(grasp.names, margin, margin + drop, strict=True):
    print(f"  {name}: {now:.2f}, {less:.2f}")
print(sensitivity)
