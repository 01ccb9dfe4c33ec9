"""Derivatives of hands' grasps against central differences of whole solves, with every effect and every parameter."""

import numpy as np
import pytest

import handlcp as hl
from tests.hand.composition import EFFECTS, HANDS, made
from tests.support.sensitivity import HANDS_OF_LIBRARY, misses

# Every effect on the five-finger hand, which finds its contacts on a ball; some of them on others
SOME = ("soft fingers", "soft wrist", "geometric stiffness")
CASES = [(name, effect) for name in HANDS for effect in ("none", *(EFFECTS if name == "five" else SOME))]
FACES = [("five", effect) for effect in ("none", "soft fingers", "anisotropic friction", "torque saturation")]


def entry(sensitivity, parameter, planar):
    """One entry of a parameter, the same every time; of a planar grasp one that stays in the plane."""
    shape = sensitivity.of("displacement", parameter).shape[1:]
    rng = np.random.default_rng(len(parameter))
    found = tuple(int(rng.integers(k)) for k in shape)
    within = {"wrench": (0,), "positions": (found[0], 0), "normals": (found[0], 1), "lengths": (found[0], 1)}
    return within.get(parameter, found) if planar else found


def check(grasp, faces, without=()):
    solution = grasp.solve(faces)
    found = solution.sensitivity()
    assert not [k for k in found.kinks if not k.by]  # of all parameters
    for parameter in found.parameters:
        if parameter in without or (parameter == "lengths" and grasp.spec.planar):
            continue
        index = entry(found, parameter, grasp.spec.planar)
        if parameter == "friction":
            index = (max(i for i, c in enumerate(grasp.contacts) if c.mu > 0.0),)
        missed = misses(grasp, solution, faces, parameter, index)
        assert max(missed.values()) < 1e-6, (parameter, index, missed)


@pytest.mark.parametrize(("name", "effect"), [c for c in CASES if c != ("ring", "geometric stiffness")])
def test_derivatives_are_those_of_whole_solves(name, effect):
    coupled = effect in ("tendons", "synergies")  # hands whose stiffness is not a matrix that a test could pass
    check(made(name, () if effect == "none" else (effect,)).grasp, "cone", ("stiffness",) if coupled else ())


@pytest.mark.parametrize(("name", "effect"), FACES)
def test_derivatives_on_a_pyramid_are_those_of_whole_solves(name, effect):
    check(made(name, () if effect == "none" else (effect,)).grasp, 8)


@pytest.mark.parametrize("name", HANDS_OF_LIBRARY)
def test_derivatives_of_every_example_hand(name):
    """Contacts where the fingertips are, pointing at their middle, squeezed by 2 mm."""
    hand = hl.example_hand(name, joint_stiffness=5.0, pad_flexibility=3e-4)
    state = hand.at(hand.neutral + 0.3 * np.minimum(hand.upper - hand.neutral, 1.0))
    tips = state.tip_positions
    middle = tips.mean(axis=0)
    contacts = [hl.Contact(p, (middle - p) / np.linalg.norm(middle - p), hl.SoftFinger(0.9, 0.01, 2.0)) for p in tips]
    grasp = state.grasp(contacts, wrench=(0.02, 0.01, -0.03, 0, 0, 0), preload=2e-3, reference=middle)
    if not grasp.solve(throw=False).held:
        pytest.skip("this posture holds nothing")
    check(grasp, "cone", ("squeeze", "joint_offset", "torque_limits"))
