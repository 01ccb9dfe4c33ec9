"""Tests of hands that others publish, as calls: how hard a finger presses, when an object slips, lift and shake."""
