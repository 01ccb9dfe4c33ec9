"""What a hand is: its URDF, joints, limits and fingertips, and the posture they are in. Imports elasticity."""
