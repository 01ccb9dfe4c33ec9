"""What must a hand be built with? Torques and grips for a brief of loads; least squeeze, stiffness; what helps most."""
