"""Doors into the studies: what is left out and planned, the paper's settings, limits in many directions."""

from handlcp.studies.accuracy.cost import variants
from handlcp.studies.accuracy.methods import settings


def left_out(grasp):
    """The grasp without each effect that the study of accuracy leaves out, by the effect's name."""
    return {name: without for name, _, without in variants(grasp)}


def planned_rows(methods, faces, tolerances):
    """How many rows a study of these methods has in a scene with pyramids, where nobody asks for faces or tolerances
    and these are the study's own.
    """
    return sum(map(len, settings(tuple(methods), (faces, False), (tolerances, False), True).values()))
