"""`grasp.replace(x=…)` is the grasp made afresh with that argument, to the last bit."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import ring
from tests.support.grasp import arrays

FLOOR = hl.Environment([hl.Contact((0, 0, -0.03), (0, 0, 1), 0.3)], 1e-4, 1e-5)
OTHER = {
    "wrench": (1.0, 0, 0, 0, 0, 0.1),
    "flexibility": (1e-4, 2e-4, 3e-4),
    "preload": (1e-3, 2e-3, 0.0),
    "offset": np.full((3, 3), -1e-4),
    "friction": hl.AnisotropicCoulomb(0.3, 0.5),
    "effects": [hl.TotalForceBound(30.0)],
    "environment": [FLOOR, hl.Environment([hl.Contact((0, 0, 0.03), (0, 0, -1), name="lid")])],
}


def asked():
    contacts, data = ring(np.random.default_rng(4), n=3)
    return contacts, data | {
        "offset": np.full((3, 3), 2e-4),
        "environment": FLOOR,
        "effects": [hl.SoftWrist([1e-5] * 3 + [0.01] * 3)],
    }


def afresh(**changes):
    contacts, data = asked()
    if "friction" in changes:
        law = changes.pop("friction")
        contacts = [c.with_friction(law) for c in contacts]
    return hl.Grasp(contacts, **(data | changes))


def assert_same(a, b):
    for part in ("positions", "frames", "flexibility", "offset", "force", "moment", "mu"):
        np.testing.assert_array_equal(getattr(arrays(a), part), getattr(arrays(b), part), err_msg=part)
    assert a.names == b.names
    assert [type(e) for e in a.effects] == [type(e) for e in b.effects]
    quick = hl.Auto(search_seconds=0.0)
    np.testing.assert_array_equal(
        a.solve(solver=quick, throw=False, proof=False).forces, b.solve(solver=quick, throw=False, proof=False).forces
    )


@pytest.mark.parametrize("name", OTHER)
def test_it_is_the_grasp_made_with_that_argument(name):
    change = {name: OTHER[name]}
    assert_same(afresh().replace(**change), afresh(**change))
    specified = hl.Grasp(afresh().spec.replace())  # a specification that does not know its arguments
    if name != "preload":  # of which it knows the whole offset
        expected = afresh(preload=0.0, **change) if name == "offset" else afresh(**change)
        assert_same(specified.replace(**change), expected)


def test_things_are_taken_away():
    assert_same(afresh().replace(effects=(), environment=()), afresh(effects=(), environment=None))


def test_friction_by_finger_leaves_the_others_theirs():
    contacts, data = asked()
    named = [c.with_name(f"f{k}") for k, c in enumerate(contacts)]
    grasp = hl.Grasp(named, **data).replace(friction={"f1": 0.25})
    assert [c.friction for c in grasp.contacts[:3]] == [contacts[0].friction, hl.Coulomb(0.25), contacts[2].friction]
    assert grasp.contacts[3].friction == hl.Coulomb(0.3), "the environment's stays"
    with pytest.raises(hl.UnknownName):
        grasp.replace(friction={"thumb": 0.2})
    with pytest.raises(hl.InputError) as refused:
        grasp.replace(friction={"f1": "rubber"})
    assert refused.value.argument == "friction['f1']"


def test_a_law_that_says_where_its_axes_lie_turns_the_contacts():
    contacts, data = asked()
    law = hl.AnisotropicCoulomb(0.3, 0.5, along=(0, 0, 1))
    turned = hl.Grasp(contacts, **data).replace(friction=law)
    made = hl.Grasp([hl.Contact(c.position, c.normal, law) for c in contacts], **data)
    np.testing.assert_allclose(turned.frames, made.frames, atol=1e-15)
    np.testing.assert_allclose(
        turned.frames[:3, 2, 1], 0.0, atol=1e-15, err_msg="x takes all of the z axis that it can"
    )
