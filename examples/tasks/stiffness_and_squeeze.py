"""How stiff must the joints be, and how hard must the hand close, to keep a cube within 1 mm under 5 N?"""

import math

import numpy as np

import handlcp as hl

cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
hand = hl.example_hand("three_finger", joint_stiffness=1.0, torque_limits=math.inf)
found = []
for stiffness in (1.0, 2.0, 4.0, 8.0):  # N·m/rad
    grasp = hand.replace(joint_stiffness=stiffness).at(hand.close_on(cube)).grasp(cube, friction=0.8)
    for squeeze in (0.002, 0.004, 0.008, 0.016):  # m
        loaded = grasp.replace(squeeze=squeeze).follow((0, -5.0, 0, 0, 0, 0))
        if loaded.held and np.linalg.norm(loaded.displacement[:3]) < 1e-3:
            found.append((abs(loaded.solution.torques).max(), stiffness, squeeze))
torque, stiffness, squeeze = min(found)
print(f"{stiffness:g} N·m/rad and a squeeze of {1e3 * squeeze:g} mm do, with motors of {torque:.2f} N·m")
