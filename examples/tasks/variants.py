"""A table of 500 variants: friction, mass and squeeze, each solved, as a data frame."""

import itertools

import numpy as np

import handlcp as hl

hand = hl.example_hand("three_finger", joint_stiffness=6.0)
cube = hl.Box(0.05, placement=(0, 0, 0.08), mass=0.2)
grasp = hand.at(hand.close_on(cube)).grasp(cube, friction=0.8)

variants = list(itertools.product(np.linspace(0.4, 1.0, 10), np.linspace(0.1, 0.5, 10), (1e-3, 2e-3, 4e-3, 6e-3, 8e-3)))
solutions = hl.solve_many(grasp.replace(friction=mu, mass=kg, squeeze=s) for mu, kg, s in variants)
table = solutions.to_frame()
table[["friction", "mass", "squeeze"]] = variants
print(table[table.held].nsmallest(5, "utilisation")[["friction", "mass", "squeeze", "utilisation", "binding"]])
