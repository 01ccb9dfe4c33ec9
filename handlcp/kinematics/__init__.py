"""Motions of rigid bodies and of trees of joints, as arrays. Imports lcp, knows no contact."""
