"""Tests that others publish: finger strength, slip resistance, and a rated payload that is lifted and shaken."""

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)  # N·m/rad
strength = hl.finger_strength(hand)
print(strength)

pipe = hl.Cylinder(0.025, 0.15, placement=(0, 0, 0.1))  # m
grasp = hand.at(hand.close_on(pipe)).grasp(pipe, friction=0.6, grip_force=4.0)
slip = hl.slip_resistance(grasp)
print(slip)

shaken = hl.lift_and_shake(hand, 0.4, opening=0.07, friction=0.8)  # kg, m
print(shaken)
