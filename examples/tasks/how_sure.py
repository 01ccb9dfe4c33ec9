"""How sure is this grasp, when friction, mass, springs and places are known to some percent?"""

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.25)
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.7, squeeze=0.005)

spread = {"friction": 0.15, "mass": 0.1, "stiffness": 0.1, "positions": 1e-3}  # shares, and metres
sure = hl.reliability(grasp, spread, 2000)
print(sure)  # chances with their intervals, the worst sample and why it fails, what matters most
print(sure.worst.verdict)
