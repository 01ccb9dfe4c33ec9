"""What a hand is, as a table to read: joints, fingertips, couplings, size."""
