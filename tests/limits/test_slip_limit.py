"""How far a contact may slide: where that is reached by a closed form, who has, and in every way that it is asked."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError, UnknownName
from tests.limits.pinches import polygon
from tests.paths.corpus import case_of

C, N = 1e-3, 5.0  # flexibility of each contact [m/N], and its normal force [N]
NAMES = ("left", "right", "front", "back")


def held_by_two_pairs(slippery=0.2, rough=5.0):
    """Two contacts that slide soon and two that hold, all of one stiffness, around the z axis."""
    places = [(-0.02, 0, 0), (0.02, 0, 0), (0, -0.02, 0), (0, 0.02, 0)]
    contacts = [
        hl.Contact(p, -50.0 * np.array(p), hl.Coulomb(slippery if k < 2 else rough), name=name)
        for k, (p, name) in enumerate(zip(places, NAMES, strict=True))
    ]
    return hl.Grasp(contacts, flexibility=C, preload=C * N)


def load_with_slip(slip, slippery=0.2):
    """[N] along z with which the first pair has slid so far: it bears its friction, the second pair its springs."""
    friction = slippery * N
    return 2.0 * friction + 2.0 * (slip + C * friction) / C


Z = np.array([0, 0, 1.0, 0, 0, 0])


@pytest.mark.parametrize("faces", [4, 6, 8, 16])
def test_a_contact_slips_first_where_its_flat_law_says(faces):
    grasp = held_by_two_pairs()
    z = grasp.frames[0, :, :2].T @ (0.0, 0.0, 1.0)  # in the contact's tangents
    share = polygon(faces, np.arctan2(z[1], z[0]))
    assert grasp.load_limit(Z, faces=faces).first_slip == pytest.approx(4.0 * 0.2 * N * share, rel=1e-9)


@pytest.mark.parametrize("slip", [1e-4, 1e-3, 5e-3])
def test_a_limit_is_the_load_with_which_a_contact_has_slid_so_far(slip):
    grasp = held_by_two_pairs()
    found = grasp.load_limit(Z, max_slip=slip)
    assert found.factor == found.slides == pytest.approx(load_with_slip(slip), rel=1e-9)
    assert [(b.kind, b.who) for b in found.binds] == [("slides", "left"), ("slides", "right")]
    assert found.first_slip == pytest.approx(4.0 * 0.2 * N, rel=1e-9)
    assert "left and right have slid as far as they may" in found.why
    assert found.lost == pytest.approx(2.0 * (0.2 + 5.0) * N, rel=1e-6)


def test_a_millimetre_is_what_counts_unless_something_else_is_said():
    assert held_by_two_pairs().load_limit(Z).factor == pytest.approx(load_with_slip(1e-3), rel=1e-9)


def test_each_contact_may_have_a_distance_of_its_own_and_inf_is_any():
    grasp = held_by_two_pairs()
    near, far = load_with_slip(1e-4), load_with_slip(1e-3)
    assert grasp.load_limit(Z, max_slip={"right": 1e-4}).factor == pytest.approx(near, rel=1e-9)
    assert [b.who for b in grasp.load_limit(Z, max_slip={"right": 1e-4}).binds] == ["right"]
    assert grasp.load_limit(Z, max_slip=[1e-3, 1e-4, 1.0, 1.0]).factor == pytest.approx(near, rel=1e-9)
    assert grasp.load_limit(Z, max_slip={"left": np.inf, "right": np.inf}).slides is None
    endless = grasp.load_limit(Z, max_slip=np.inf)
    assert endless.slides is None
    assert endless.factor == endless.lost > far


@pytest.mark.parametrize("slip", [1e-4, 1e-3])
def test_a_load_without_an_end_has_one_where_a_contact_has_slid_so_far(slip):
    """A pinch above a support that bears any load: the object sinks into the support, and slides past the pinch."""
    pinch = [hl.Contact((x, 0, 0), (-50 * x, 0, 0), 0.2, name=name) for x, name in ((-0.02, "left"), (0.02, "right"))]
    grasp = hl.Grasp([*pinch, hl.Contact((0, 0, -0.02), (0, 0, 1), 0.2, name="below")], flexibility=C, preload=0.0)
    grasp = grasp.replace(preload=[C * N, C * N, 0.0])
    found = grasp.load_limit(-Z, max_slip=slip)
    sinks = slip + C * 0.2 * N  # a contact gives way by as much as its friction moves it before it slides
    assert found.factor == found.slides == pytest.approx(sinks / C + 2.0 * 0.2 * N, rel=1e-9)
    assert found.lost is None
    assert [b.who for b in found.binds] == ["left", "right"]
    assert grasp.load_limit(-Z, max_slip=np.inf).factor == np.inf


@pytest.mark.parametrize(("number", "direction"), [(50, 2), (86, 2), (104, 8)])
def test_a_limit_from_event_to_event_is_held_below_and_slides_too_far_above(number, direction):
    """On a ray that has no other end, and with a contact that slides until it lets go."""
    case = case_of(0, number)
    load = case.directions[direction]
    found = case.grasp.load_limit(load, geometry="fixed", faces=case.faces)
    assert found.binds[0].kind == "slides"
    for share, held in ((0.98, True), (1.02, False)):
        assert case.grasp.follow(share * found.factor * load, geometry="fixed", faces=case.faces).held == held


def test_a_loading_and_a_check_hold_below_that_load_alone():
    grasp, most = held_by_two_pairs(), load_with_slip(1e-3)
    for share, word in ((0.999, "HELD"), (1.001, "NOT HELD")):
        load = share * most * Z
        path = grasp.follow(load)
        assert (path.word, path.held, path.reached) == (word, word == "HELD", True)
        assert grasp.replace(wrench=load).check().word == word
        assert grasp.replace(wrench=load).check(max_slip=2e-3).word == "HELD"
        assert grasp.follow(load, max_slip=2e-3).held
    beyond = grasp.follow(1.001 * most * Z)
    assert beyond.slides.share == pytest.approx(1.0 / 1.001, rel=1e-5)
    assert [e.who for e in beyond.events if e.kind == "slides"] == ["left", "right"]
    assert "left and right have slid 1 mm" in beyond.sentence


@pytest.mark.parametrize("steps", [1, 2, 3, 5, 8, 40])
def test_what_slides_is_the_same_with_any_number_of_steps(steps):
    path = held_by_two_pairs().follow(1.2 * load_with_slip(1e-3) * Z, steps=steps)
    assert path.slides.share == pytest.approx(1.0 / 1.2, rel=1e-6)
    assert path.steps.slipped[-1, 0] == pytest.approx(1.2 * (1e-3 + 2 * C * 0.2 * N) - 2 * C * 0.2 * N, rel=1e-6)


@pytest.mark.parametrize(
    ("max_slip", "error"),
    [
        (0.0, InputError), (-1e-3, InputError), (np.nan, InputError), ("1 mm", InputError), ([1e-3], InputError),
        ({"middle": 1e-3}, UnknownName), ({"left": 0.0}, InputError), (None, InputError),
    ],
)  # fmt: skip
def test_a_distance_that_is_none_is_refused(max_slip, error):
    grasp = held_by_two_pairs()
    for ask in (grasp.load_limit, grasp.follow):
        with pytest.raises(error, match="max_slip"):
            ask(Z, max_slip=max_slip)
    with pytest.raises(error, match="max_slip"):
        grasp.check(max_slip=max_slip)
