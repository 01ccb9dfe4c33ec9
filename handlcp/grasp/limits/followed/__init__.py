"""Load limits with the geometry followed: contacts are detected anew while the object moves and the joints bend."""
