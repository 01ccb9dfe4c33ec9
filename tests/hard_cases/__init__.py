"""Hard cases: families of grasps, seeded, each scene with an answer that is known before it is solved.

`python -m tests.hard_cases [count]` prints solved, undecided and wrong of every family at every number of faces.
"""
