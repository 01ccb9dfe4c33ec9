"""Tests of the questions of a designer: motors, grip, friction, stiffness, and what helps most."""
