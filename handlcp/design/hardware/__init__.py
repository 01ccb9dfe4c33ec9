"""Beside hardware: what makers and papers state of hands, and the same computed from the hands' files."""
