"""Which frames or points are fingertips: what the user names, or what a robot shows."""
