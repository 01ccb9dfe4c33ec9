"""How much pull does a grasp hold along each axis, beside the weight, and what gives out first?"""

import numpy as np

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)  # N·m/rad
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)  # m, kg
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)

limits = [grasp.load_limit(np.append(way, np.zeros(3))) for way in (*np.eye(3), *-np.eye(3))]
for limit in limits:
    print(f"{limit.wrench[:3]}: {limit.factor:.2f} N, {limit.why}")
weakest = min(limits, key=lambda limit: limit.factor)
