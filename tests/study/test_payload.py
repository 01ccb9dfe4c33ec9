"""Payloads: closed forms of pinches, `check` below and above, the worst direction, what turns with gravity."""

from functools import cache

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import handlcp as hl
from tests.design.hands import pinch as levers
from tests.hand.levers import L
from tests.support.patches import contacts_take_long
from tests.support.paths import give_up_beyond
from tests.support.squeezed import MU, G, K, N, R, cube, flat_pinch, pinch
from tests.support.texts import says

AXES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]


@cache
def of_cube(orientations=6, acceleration=0.0, geometry=None, accuracy=None):
    return cube().payload(orientations, acceleration, geometry=geometry, accuracy=accuracy)


def masses(p):
    return [row.mass for row in p.by_orientation]


# ---------------------------------------------------------------- closed forms
def test_a_pinch_holds_2_mu_n_over_g_across_its_normals_and_anything_along_them():
    p = pinch().payload()
    np.testing.assert_array_equal([row.direction for row in p.by_orientation], AXES)
    np.testing.assert_allclose(masses(p), [np.inf] * 2 + [2 * MU * N / G] * 4, rtol=1e-6)
    assert p.mass == pytest.approx(2 * MU * N / G, rel=1e-6)
    assert {(b.kind, b.who) for b in p.binds} == {("slips", "left"), ("slips", "right")}
    assert p.by_orientation[0].binds == ()
    assert p.by_orientation[0].says == "nothing gives out"


@pytest.mark.parametrize("a", [3.0, 9.81, 20.0])
def test_a_pinch_that_accelerates_holds_the_least_of_six_ways(a):
    """A force F along (x, t) slips at F |t| / 2 = μ (N - F |x| / 2): a mass m pulls with m (g d - s)."""
    p = pinch().payload(acceleration=a)

    def least(d):
        pulls = [G * np.array(d) - a * np.array(s) for s in AXES]
        return min(2 * MU * N / t for v in pulls if (t := np.hypot(v[1], v[2]) + MU * abs(v[0])) > MU * abs(v[0]))

    np.testing.assert_allclose(masses(p), [least(d) for d in AXES], rtol=1e-6)
    down = p.by_orientation[5]
    np.testing.assert_allclose(down.acceleration, (0, 0, a))
    assert down.mass == pytest.approx(2 * MU * N / (G + a), rel=1e-6)


@pytest.mark.parametrize("a", [0.0, 5.0])
def test_the_worst_direction_of_a_pinch_leans_by_its_friction_angle(a):
    """|t| + μ |x| is most, √(1 + μ²), where |x| / |t| = μ."""
    p = pinch().payload("any", a)
    assert p.mass == pytest.approx(2 * MU * N / ((G + a) * np.sqrt(1 + MU**2)), rel=1e-4)
    assert abs(p.direction[0]) == pytest.approx(MU / np.sqrt(1 + MU**2), abs=0.02)
    np.testing.assert_allclose(p.by_orientation[-1].acceleration, -a * p.direction, atol=1e-12)
    assert len(p.by_orientation) == 7
    assert p.tried > 100


def test_a_finger_gives_out_at_its_torque_over_its_lever(tmp_path):
    """Gravity along the normals adds half of the weight to one of two fingers that are as stiff as each other."""
    grip, most = 4.0, 5.0
    p = levers(tmp_path, limits=L * most, grip_force=grip).payload()
    along = [row for row in p.by_orientation if row.direction[0]]
    np.testing.assert_allclose([row.mass for row in along], 2 * (most - grip) / G, rtol=1e-4)
    assert [[(b.kind, b.who) for b in row.binds] for row in along] == [
        [("torque", f"{side}_joint")] for side in ("right", "left")
    ]


def test_a_planar_pinch_has_four_orientations_and_leans_in_its_plane():
    p = flat_pinch().payload("any")
    np.testing.assert_allclose(masses(p)[:4], [np.inf] * 2 + [2 * MU * N / G] * 2, rtol=1e-6)
    assert p.mass == pytest.approx(2 * MU * N / (G * np.sqrt(1 + MU**2)), rel=1e-4)
    assert p.direction[2] == 0.0


def test_what_nothing_limits_is_an_answer():
    contacts = [hl.Contact(tuple(-R * np.array(d)), d, MU) for d in AXES]
    free = hl.Grasp(contacts, flexibility=K, preload=K * N).payload(max_slip=np.inf)
    assert np.isinf(free.mass)
    assert free.binds == ()
    assert "any mass is held" in str(free)
    assert free.to_dict()["mass_kg"] is None


# ---------------------------------------------------------------- against `check`, which follows a heavier object
def doubts(verdict):
    """What keeps a verdict from HELD; that a link has come to where the object is, a load limit does not look at."""
    return {r.code for r in verdict.reasons if r.severity == "decides"} - {"link_inside"}


@pytest.mark.parametrize("way", [1, 3, 5])
def test_the_object_is_held_just_below_its_payload_and_lost_just_above(way):
    row = of_cube().by_orientation[way]
    for share, holds in ((0.97, True), (1.03, False)):
        verdict = cube().replace(mass=share * row.mass, gravity=G * row.direction).check()
        assert (not doubts(verdict)) is holds, str(verdict)


@pytest.mark.long
@pytest.mark.parametrize("way", [1, 4])
def test_a_hand_that_accelerates_is_one_under_another_gravity(way):
    row = of_cube(6, 5.0, accuracy=0.01).by_orientation[way]
    assert row.limit.accuracy <= 0.01
    pull = G * row.direction - row.acceleration
    assert np.linalg.norm(row.acceleration) == pytest.approx(5.0)
    for share, holds in ((0.97, True), (1.03, False)):
        assert cube().replace(mass=share * row.mass, gravity=pull).check().ok is holds
    others = [s for s in AXES if not np.allclose(5.0 * np.array(s), row.acceleration)]
    for s in others:  # no other way to accelerate is worse
        pull = G * row.direction - 5.0 * np.array(s)
        assert cube().replace(mass=0.97 * row.mass, gravity=pull).check().ok


@pytest.mark.long
def test_no_direction_of_an_envelope_is_worse_than_the_worst():
    p = of_cube("any", geometry="fixed")
    env = hl.envelope(cube(), 362, of="gravity", geometry="fixed")
    assert p.mass <= env.weakest.factor * (1 + 1e-9)
    assert p.mass == pytest.approx(env.weakest.factor, rel=0.01)
    assert p.mass == p.by_orientation[-1].mass <= min(masses(p)[:6])


@pytest.mark.long
def test_where_paths_take_long_the_worst_direction_is_found_in_this_posture_and_rows_are_followed_all_the_same(
    monkeypatch,
):
    contacts_take_long(monkeypatch)
    p, fixed = cube().payload("any"), of_cube("any", geometry="fixed")
    assert masses(p)[:6] == masses(of_cube())
    assert (p.geometry, p.searched, p.tried) == ("followed", "fixed", fixed.tried)
    np.testing.assert_array_equal(p.by_orientation[-1].direction, fixed.by_orientation[-1].direction)
    worst = cube().replace(mass=0.0).load_limit((*(G * fixed.by_orientation[-1].direction), 0, 0, 0))
    assert p.by_orientation[-1].mass == pytest.approx(worst.factor, rel=1e-6)
    says(p.asked, str(p.tried))


# ---------------------------------------------------------------- what is asked
def test_the_mass_that_the_object_has_and_another_load_are_left_out():
    other = cube().replace(mass=0.01, load=(0.3, 0, 0, 0, 0, 0)).payload(geometry="fixed")
    np.testing.assert_allclose(masses(other), masses(of_cube(geometry="fixed")), rtol=1e-9)
    assert other.object_mass == 0.01


def test_the_mass_is_at_the_centre_of_mass_wherever_the_reference_is():
    aside = cube(reference=(0.0, 0.03, 0.12)).payload()
    np.testing.assert_allclose(aside.at, (0, 0, 0.08))
    np.testing.assert_allclose(masses(aside), masses(of_cube()), rtol=1e-6)


@pytest.mark.parametrize("a", [0.0, 5.0])
def test_the_fingers_weight_turns_with_gravity_and_is_accelerated(a):
    heavy = cube(finger_weight=True)
    for row in heavy.payload(acceleration=a, geometry="fixed").by_orientation[::3]:
        pull = G * row.direction - row.acceleration
        one = heavy.replace(mass=0.0, gravity=pull).load_limit((*pull, 0, 0, 0), geometry="fixed")
        assert row.mass == pytest.approx(one.factor, rel=1e-9)
        assert row.binds == one.binds


def test_bad_questions_are_refused():
    asked = ("orientations", 5), ("orientations", "all"), ("acceleration", -1.0), ("geometry", "free"), ("accuracy", 0)
    for name, value in asked:
        with pytest.raises(hl.InputError, match=name):
            pinch().payload(**{name: value})


# ---------------------------------------------------------------- as data and as a picture


def test_the_picture_has_a_bar_for_each_orientation(tmp_path):
    for p in (pinch().payload("any"), of_cube(6, 5.0, geometry="fixed")):
        figure = p.plot(title="How heavy may it be?")
        FigureCanvasAgg(figure).draw()
        (ax,) = figure.axes
        assert len(ax.patches) == len(p.by_orientation)
        widths = [bar.get_width() for bar in ax.patches]
        finite = np.isfinite(masses(p))
        np.testing.assert_allclose(np.array(widths)[finite], np.array(masses(p))[finite])
        assert (np.array(widths)[~finite] == ax.get_xlim()[1]).all()
        inside = [t.get_window_extent() for t in ax.texts]
        assert all(box.x1 <= figure.bbox.width for box in inside)
    assert of_cube().plot(tmp_path / "payload.png").read_bytes().startswith(b"\x89PNG")


def test_a_path_that_is_given_up_is_a_lower_bound_and_says_so(monkeypatch):
    """From three times the load on no step finds a state, and the object neither moves on nor rests."""
    give_up_beyond(3.0, monkeypatch)
    limit = cube().load_limit((0, 0, -0.1, 0, 0, 0), geometry="followed")
    assert limit.factor == pytest.approx(3.0, rel=1e-3)
    assert [b.kind for b in limit.binds] == ["undecided"]
    assert limit.why.startswith("held up to 3 times the load, and undecided beyond: ")
    give_up_beyond(0.1, monkeypatch)
    p = cube().payload(geometry="followed")
    assert p.by_orientation[0].undecided
    assert p.headline.startswith("at least ")
    assert "≥ " in str(p)
