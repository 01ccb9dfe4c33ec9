"""Where a hand comes from: a URDF, an MJCF file, a Pinocchio model. All become one `Description`."""
