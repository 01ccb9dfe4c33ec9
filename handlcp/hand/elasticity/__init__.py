"""How a hand deflects under load: joint springs, tendons, synergies and pads."""
