"""Derivatives of hands' grasps against central differences of whole solves, with every effect and every parameter."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hand.composition import EFFECTS, HANDS, made
from tests.support.sensitivity import misses

ON = ("cone", 8)


def indices(sensitivity, parameter):
    """Some entries of a parameter, the same every time."""
    shape = sensitivity.of("displacement", parameter).shape[1:]
    rng = np.random.default_rng(len(parameter))
    return {tuple(int(rng.integers(k)) for k in shape) for _ in range(2)}


@pytest.mark.parametrize("faces", ON)
@pytest.mark.parametrize("effect", ["none", *EFFECTS])
@pytest.mark.parametrize("name", HANDS)
def test_derivatives_are_those_of_whole_solves(name, effect, faces):
    if name == "ring" and (faces == 8 or effect == "geometric stiffness"):
        pytest.skip("a plane has no pyramids")
    grasp = made(name, () if effect == "none" else (effect,)).grasp
    solution = grasp.solve(faces, throw=False)
    if not solution.held:
        pytest.skip("no answer to differentiate")
    found = solution.sensitivity()
    if found.kinks:
        pytest.skip("at a kink")
    for parameter in found.parameters:
        if parameter == "stiffness" and effect in ("tendons", "synergies"):
            continue
        for index in indices(found, parameter):
            if parameter == "friction" and not grasp.contacts[index[0]].mu > 0.0:
                continue
            missed = misses(grasp, solution, faces, parameter, index)
            assert max(missed.values()) < 1e-6, (parameter, index, missed)
