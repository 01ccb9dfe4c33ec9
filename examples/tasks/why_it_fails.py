"""Why does this grasp lose the object, and what would help? Ask, change one thing, ask again."""

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.9)
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8, squeeze=0.005)

verdict = grasp.check()
print(verdict)  # where and why it is lost; what was tried and would hold
more = next(reason.values for reason in verdict.reasons if reason.values.get("change") == "squeeze")
better = grasp.replace(squeeze=0.005 + more["value"]).check()
print(better)
