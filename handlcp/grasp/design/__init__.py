"""What has to be built: torques, grips, stiffnesses that are enough."""
