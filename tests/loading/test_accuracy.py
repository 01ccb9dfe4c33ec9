"""Steps follow their errors: the same answer with any number of them, and errors that fall with the accuracy asked."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest

import handlcp as hl

POSTURE = (
    0.10518547587733394, 0.046748611186605664, 0.0806481486807253, 0.03584348471855967, 0.07100119751900984,
    0.0315560231424481, 0.0905194262861335, 0.040230607184663814, 0.11089077055776722, 0.04928418464835277,
)  # fmt: skip
PAYLOAD = 1.37227  # [kg] with which the can is lost along +y


@cache
def can(mass):
    """A can in five soft fingers, all of which slide, in directions that turn all the way."""
    hand = hl.example_hand("five_finger", joint_stiffness=12.78702796756963, pad_flexibility=4.692255319388647e-05)
    turned = pin.rpy.rpyToMatrix(0, 0, np.arctan2(-0.9934828531243154, -0.11398166759602102))
    at = np.array([-0.00144316507663256, 0.00172294039562275, 0.06860650914435865])
    cylinder = hl.Cylinder(0.02718178783073347, 0.06774961587705546, placement=pin.SE3(turned, at), mass=0.038)
    law = hl.SoftFinger(0.9671549739506784, 0.004)
    grasp = hand.at(POSTURE).grasp(cylinder, law, squeeze=0.0040516570397499604)
    return grasp.replace(mass=mass, gravity=(0, 9.81, 0))


@cache
def finest():
    return can(0.9 * PAYLOAD).follow(steps=1, accuracy=1e-5)


@pytest.mark.parametrize("steps", [1, 2, 3, 5, 8, 40])
def test_the_number_of_steps_decides_nothing(steps):
    """With 2, 4, 8 and 16 steps a stage such a grasp was once called lost, with 6 and 12 held."""
    path, exact = can(0.9 * PAYLOAD).follow(steps=steps), finest()
    assert path.word == "HELD"
    size = abs(exact.steps.forces[-1]).max()
    assert abs(path.steps.forces[-1] - exact.steps.forces[-1]).max() <= 2e-3 * size
    np.testing.assert_allclose(path.steps.slipped[-1], exact.steps.slipped[-1], rtol=2e-3, atol=1e-6)
    assert path.accuracy <= 1e-3


def test_errors_fall_as_the_accuracy_that_is_asked():
    """Slope one: a tenth of the accuracy divides the error by five at least."""
    exact = finest().steps.forces[-1]
    asked = np.array([1e-2, 1e-3, 1e-4])
    found = [can(0.9 * PAYLOAD).follow(steps=1, accuracy=x) for x in asked]
    errors = np.array([abs(path.steps.forces[-1] - exact).max() for path in found]) / abs(exact).max()
    assert (errors <= 3.0 * asked).all()
    assert (errors[1:] <= errors[:-1] / 5.0).all()
    assert [path.accuracy <= x for path, x in zip(found, asked, strict=True)] == [True] * 3


def test_a_check_holds_what_the_payload_says_and_no_more():
    most = can(0.1).payload().by_orientation
    along = next(row for row in most if np.allclose(row.direction, (0, 1, 0)))
    assert can(0.97 * along.mass).check().word == "HELD"
    assert can(1.03 * along.mass).check().word == "NOT HELD"
