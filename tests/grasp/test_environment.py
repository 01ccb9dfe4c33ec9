"""Environment contacts against closed forms: tables and walls beside fingers, who carries what, what cannot hold."""

import numpy as np
import pytest

import handlcp as hl
from handlcp.errors import InputError
from tests.grasp.scenes import ring
from tests.support.grasp import arrays
from tests.support.texts import says, without_numbers

A, W = 0.02, 3.0  # m: half an edge of the box; N: its weight
STIFF, SOFT = 1e-5, 1e-4  # m/N of the table, and of the fingers
SECTIONS = [4, 8, "cone"]
EXACT = {"rtol": 1e-9, "atol": 1e-14}
DOWN = (0, 0, -W, 0, 0, 0)


def floor(flexibility=STIFF, mu=0.5, gap=0.0, height=0.0):
    """The four corners of a box of edge 2 A on a table."""
    corners = [(x, y, height) for x in (-A, A) for y in (-A, A)]
    return hl.Environment([hl.Contact(p, (0, 0, 1), hl.Coulomb(mu)) for p in corners], flexibility, gap)


def sides(mu=0.8):
    """Two fingers that pinch the box along x at half its height, x axes up."""
    return [
        hl.Contact((-A, 0, A), (1, 0, 0), hl.Coulomb(mu), tangent=(0, 0, 1), name="left"),
        hl.Contact((A, 0, A), (-1, 0, 0), hl.Coulomb(mu), tangent=(0, 0, 1), name="right"),
    ]


def pinched(load, *effects, mu=0.8):
    """The box between two fingers on a soft table."""
    more = {"preload": 2e-3, "environment": floor(), "effects": effects}
    return hl.Grasp(sides(mu), load, flexibility=SOFT, **more)


def top(mu=0.5):
    return [hl.Contact((0, 0, 2 * A), (0, 0, -1), hl.Coulomb(mu), name="top")]


# ---------------------------------------------------------------- closed forms
@pytest.mark.parametrize("flexibility", [0.0, STIFF])
@pytest.mark.parametrize("faces", SECTIONS)
def test_a_table_under_a_spring_finger_carries_the_weight_and_the_squeeze(faces, flexibility):
    """Springs in series: r (C + E / 4) = δ - W E / 4 where the table's four corners give way by E; rigid: r = δ / C."""
    squeeze = 1e-3
    g = hl.Grasp(top(), DOWN, flexibility=SOFT, preload=squeeze, environment=floor(flexibility), reference=(0, 0, A))
    s = g.solve(faces)
    push = (squeeze - W * flexibility / 4) / (SOFT + flexibility / 4)
    np.testing.assert_allclose(s.normal_force[0], push, **EXACT)
    np.testing.assert_allclose(s.normal_force[1:].sum(), W + push, **EXACT)
    np.testing.assert_allclose(s.object_displacement[2], -(W + push) * flexibility / 4, **EXACT)
    if flexibility:
        np.testing.assert_allclose(s.normal_force[1:], (W + push) / 4, **EXACT)


@pytest.mark.parametrize("faces", SECTIONS)
def test_the_weight_is_shared_in_the_ratio_of_the_stiffnesses(faces):
    """Two pinching fingers give way by C each along the vertical, four corners by E: k_f = 2 / C, k_t = 4 / E, and the
    table's share of the weight is k_t / (k_f + k_t). The object sinks by W / (k_f + k_t).
    """
    g = hl.Grasp(sides(), DOWN, flexibility=SOFT, preload=2e-3, environment=floor(), reference=(0, 0, A))
    s = g.solve(faces)
    fingers, table = 2 / SOFT, 4 / STIFF
    np.testing.assert_allclose(s.forces_world[2:, 2].sum(), W * table / (fingers + table), **EXACT)
    np.testing.assert_allclose(s.forces_world[:2, 2], W * fingers / (fingers + table) / 2, **EXACT)
    np.testing.assert_allclose(s.normal_force[:2], 2e-3 / SOFT, **EXACT)
    np.testing.assert_allclose(s.object_displacement, [0, 0, -W / (fingers + table), 0, 0, 0], **EXACT)
    assert s.names == ("left", "right", *(f"environment {k}" for k in (1, 2, 3, 4)))


def test_a_table_below_a_gap_carries_nothing_until_the_object_has_sunk_by_it():
    """The fingers alone let it sink by W C / 2; a rigid table at less than that takes W - 2 gap / C."""
    sinks = W * SOFT / 2
    for gap, carried in ((1.5 * sinks, 0.0), (0.25 * sinks, 0.75 * W)):
        environment = floor(0.0, gap=gap)
        s = hl.Grasp(sides(), DOWN, flexibility=SOFT, preload=2e-3, environment=environment).solve()
        np.testing.assert_allclose(s.normal_force[2:].sum(), carried, **EXACT)
        np.testing.assert_allclose(s.gap[2:], max(gap - sinks, 0.0), atol=1e-15)


def test_an_overlap_of_the_environment_is_a_squeeze():
    """A wall that overlaps the object by δ pushes it against a spring finger: r = δ / C, as if the finger had it."""
    finger = [hl.Contact((-A, 0, 0), (1, 0, 0), hl.Coulomb(0.5))]
    wall = hl.Environment([hl.Contact((A, 0, 0), (-1, 0, 0), hl.Coulomb(0.5), name="wall")], gap=-1e-3)
    s = hl.Grasp(finger, (0, 0, -1, 0, 0, 0), flexibility=SOFT, environment=wall).solve()
    np.testing.assert_allclose(s.normal_force, 10.0, **EXACT)
    other = hl.Grasp(finger, (0, 0, -1, 0, 0, 0), flexibility=SOFT, preload=1e-3, environment=wall).solve()
    np.testing.assert_allclose(other.normal_force, 20.0, **EXACT)


@pytest.mark.parametrize("faces", [4, "cone"])
@pytest.mark.parametrize("flexibility", [0.0, STIFF])
def test_a_box_pushed_sideways_sticks_below_the_limit_and_nothing_holds_it_above(faces, flexibility):
    """A smooth finger without stiffness of its own pushes nothing; the push P is in the load. Sliding starts at μ W,
    along x, the middle of a face of the 4-face pyramid turned by 45°: there the limit is μ W cos 45°.
    """
    limit = 0.5 * W * (np.cos(np.pi / 4) if faces == 4 else 1.0)
    finger = [hl.Contact((-A, 0, 0), (1, 0, 0), hl.Frictionless())]

    def under(push):
        load = (push, 0, -W, 0, 0, 0)  # at the table's height: no moment
        return hl.Grasp(finger, load, offset=[(0, 0, 1e-3)], environment=floor(flexibility)).solve(faces, throw=False)

    s = under(0.999 * limit)
    assert "sliding" not in s.contact_state
    assert s.contact_state[0] == "separated"
    np.testing.assert_allclose(s.forces_world[1:].sum(0), [-0.999 * limit, 0, W], **EXACT)
    np.testing.assert_allclose(s.object_displacement[0], 0.999 * limit * flexibility / 4, **EXACT)
    assert under(1.001 * limit).status is hl.Status.NOT_HOLDABLE
    assert under(1.001 * limit).certificate[0] > 0
    said = without_numbers(under(1.001 * limit).diagnosis)
    says(said, "slides out")


def test_a_finger_that_pushes_a_box_against_its_friction_slides_it_until_its_spring_is_spent():
    """A spring finger squeezed by δ pushes sideways with r = μ W: the box slides by δ - μ W C, on the exact cone."""
    finger = [hl.Contact((-A, 0, 0), (1, 0, 0), hl.Frictionless())]
    s = hl.Grasp(finger, DOWN, flexibility=SOFT, preload=1e-3, environment=floor(0.0)).solve("cone")
    np.testing.assert_allclose(s.normal_force[0], 0.5 * W, **EXACT)
    np.testing.assert_allclose(s.object_displacement[0], 1e-3 - 0.5 * W * SOFT, **EXACT)
    assert s.contact_state == ("sliding", *["sliding"] * 4)


def test_in_a_plane_a_table_is_two_contacts():
    """A square between a smooth finger above and the line below, off centre by b: lever rule on a soft table."""
    finger = [hl.Contact((0.0, 2 * A), (0.0, -1.0), hl.Frictionless())]
    table = hl.Environment([hl.Contact((x, 0.0), (0.0, 1.0), hl.Coulomb(0.5)) for x in (-A, A)], STIFF)
    b = 0.5 * A
    s = hl.Grasp(finger, (0, -W, -b * W), flexibility=SOFT, environment=table).solve()  # the weight acts at x = b
    np.testing.assert_allclose(s.normal_force, [0, W / 4, 3 * W / 4], **EXACT)


# ---------------------------------------------------------------- what is determined
def test_four_corners_of_a_rigid_table_leave_forces_open_and_a_soft_table_determines_them():
    for flexibility in (0.0, STIFF):
        s = hl.Grasp(sides(), DOWN, flexibility=SOFT, preload=2e-3, environment=floor(flexibility)).solve()
        assert s.uniqueness.forces_determined is (flexibility > 0.0)


# ---------------------------------------------------------------- effects
def test_the_total_bound_is_on_the_hands_squeeze_alone():
    """The table carries more than the bound allows the hand, and the fingers keep to it."""
    s = pinched((0, 0, -30.0, 0, 0, 0), hl.TotalForceBound(6.0)).solve()
    np.testing.assert_allclose(s.normal_force[:2], 3.0, rtol=1e-9)
    assert s.normal_force[2:].sum() > 20.0
    np.testing.assert_allclose(s.extra["z̄"], 2e-3 - 3.0 * SOFT, rtol=1e-9)
    assert (abs(s.gap) < 1e-12).all()


def test_what_a_hand_bounded_too_low_would_need_counts_the_fingers_alone():
    """Of 20 N sideways the table's friction bears 0.5 · 30 N, smooth fingers the other 5 N; they may push with 3 N."""
    s = pinched((20.0, 0, -30.0, 0, 0, 0), hl.TotalForceBound(3.0), mu=0.0).solve("cone", throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    says(s.diagnosis, "3 N", "5 N")


@pytest.mark.parametrize("bounds", [3.0, [3.0, np.inf], [3.0, np.inf, np.inf, np.inf, np.inf, np.inf]])
def test_a_bound_for_each_finger_leaves_the_table_alone(bounds):
    s = pinched((0, 0, -30.0, 0, 0, 0), hl.FingerForceBound(bounds)).solve()
    np.testing.assert_allclose(s.normal_force[0], 3.0, rtol=1e-9)
    assert len(s.extra["z̄_i"]) == (2 if bounds == 3.0 else 1)
    assert s.normal_force[2:].sum() > 20.0


def test_a_table_that_yields_is_a_bound_for_each_contact():
    """Its corners bear 0.5 N each at most: the fingers bear the rest of the weight."""
    s = pinched(DOWN, hl.FingerForceBound([np.inf] * 2 + [0.5] * 4)).solve()
    np.testing.assert_allclose(s.normal_force[2:], 0.5, rtol=1e-9)
    np.testing.assert_allclose(s.forces_world[:2, 2].sum(), W - 2.0, rtol=1e-9)


def test_a_soft_wrist_carries_the_fingers_and_not_the_table():
    """In series with both fingers along z: the wrist gives way by C_w under both, so k_f = 1 / (C / 2 + C_w)."""
    g = pinched(DOWN, hl.SoftWrist([0, 0, 2e-4, 0, 0, 0]))
    np.testing.assert_array_equal(arrays(g).flexibility[6:, 6:], g.flexibility[6:, 6:])
    np.testing.assert_array_equal(arrays(g).flexibility[6:, :6], 0.0)
    fingers, table = 1 / (SOFT / 2 + 2e-4), 4 / STIFF
    carried = g.solve().forces_world[2:, 2].sum()
    np.testing.assert_allclose(carried, W * table / (fingers + table), **EXACT)


@pytest.mark.parametrize("blocks", ["one", "fingers", "all"])
def test_the_objects_surface_gives_way_under_fingers_and_table(blocks):
    soft = np.eye(3) * 3e-5
    given = {"one": 3e-5, "fingers": [soft] * 2, "all": [soft] * 6}[blocks]
    g = pinched(DOWN, hl.ContactCompliance(given))
    more = np.diag([3e-5] * 6 + [0.0 if blocks == "fingers" else 3e-5] * 12)
    np.testing.assert_array_equal(arrays(g).flexibility, g.flexibility + more)


def test_a_fixture_may_push_with_a_known_force():
    g = pinched(DOWN, *[hl.PrescribedForce(k, (0, 0, 0.5)) for k in (2, 3, 4, 5)])
    np.testing.assert_allclose(g.solve().forces_world[:2, 2].sum(), W - 2.0, **EXACT)


# ---------------------------------------------------------------- the same grasp, changed and explained


def test_required_preload_squeezes_the_fingers_alone():
    """Pulled up by P, the table out of reach: 2 μ δ / C = P on the exact cone, wherever the table is."""
    pull = 4.0
    g = hl.Grasp(sides(), (0, 0, pull, 0, 0, 0), flexibility=SOFT, environment=floor())
    required = g.required_preload("cone", 1e-6)
    np.testing.assert_allclose(required.value, pull * SOFT / 1.6, rtol=2e-6)


def test_what_is_not_held_is_said_of_contacts_and_preload_of_fingers():
    """In a plane: two fingers beside a box, without squeeze, that is pulled off a line."""
    fingers = [hl.Contact((x, A), (-x / A, 0.0), hl.Coulomb(0.8)) for x in (-A, A)]
    line = hl.Environment([hl.Contact((x, 0.0), (0.0, 1.0)) for x in (-A, A)], STIFF)
    s = hl.Grasp(fingers, (0, 4.0, 0), flexibility=SOFT, environment=line).solve(throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    says(without_numbers(s.diagnosis), "no finger squeezes")


def test_a_grasp_with_an_environment_is_the_grasp_with_as_many_contacts_more():
    """Same unknowns, same numbers, same answer, bit for bit: only who is a finger is known besides."""
    contacts, data = ring(np.random.default_rng(3), n=5)
    m = 2
    E = np.asarray(data["flexibility"]).copy()
    E[:9, 9:] = E[9:, :9] = 0.0
    whole = hl.Grasp(contacts, data["wrench"], flexibility=E, preload=[0.02] * 3 + [-0.001] * m)
    rest = hl.Environment(contacts[3:], E[9:, 9:], 0.001)
    parted = hl.Grasp(contacts[:3], data["wrench"], flexibility=E[:9, :9], preload=0.02, environment=rest)
    for faces in SECTIONS:
        a, b = whole.solve(faces, throw=False), parted.solve(faces, throw=False)
        np.testing.assert_array_equal(a.forces, b.forces)
        assert a.status is b.status


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("change", "argument"),
    [
        ({"environment": "table"}, "environment"),
        ({"environment": []}, "environment"),
        ({"environment": hl.Table((0, 0, 0))}, "environment"),
        ({"environment": [hl.Coulomb(0.5)]}, "environment[0]"),
        ({"environment": hl.Environment([hl.Contact((0.0, 0.0), (0.0, 1.0))])}, "contacts"),
        ({"environment": floor(), "preload": [1e-3] * 6}, "preload"),
        ({"environment": floor(), "offset": np.zeros((5, 3))}, "offset"),
        ({"environment": floor(), "flexibility": np.eye(18)}, "flexibility"),
        ({"environment": floor(), "effects": [hl.FingerForceBound([1.0] * 3)]}, "effects[0].limits"),
        ({"environment": floor(), "effects": [hl.ContactCompliance([np.eye(3)] * 3)]}, "effects[0].flexibility"),
        ({"environment": floor(), "effects": [hl.TorqueSaturation()]}, "effects[0]"),
    ],
)
def test_bad_input_names_the_argument(change, argument):
    with pytest.raises(InputError) as info:
        hl.Grasp(sides(), **change)
    assert info.value.argument == argument


def test_contacts_without_a_name_are_numbered_over_all_environments():
    g = hl.Grasp(sides(), environment=[floor(), floor(height=1e-3), hl.Environment(top())])
    assert g.names[2:] == (*(f"environment {k}" for k in range(1, 9)), "top")
    assert arrays(g).environment == 9


def test_bad_numbers_of_an_environment_are_refused():
    for more in ({"flexibility": -1.0}, {"flexibility": np.ones(4)}, {"gap": [0.0, 0.0]}, {"gap": np.nan}):
        with pytest.raises(InputError) as info:
            hl.Environment(top(), **more)
        assert info.value.argument == next(iter(more))
    with pytest.raises(InputError):
        hl.Environment([])
    with pytest.raises(AttributeError):
        floor().gap = 1.0


def test_offsets_of_an_ellipse_in_the_environment_stay_when_others_are_replaced():
    """They are kept in contact axes, not in those of its friction law."""
    contacts, data = ring(np.random.default_rng(2), n=3)
    ribbed = hl.Environment([hl.Contact((0, 0, 0), (0, 0, 1), hl.AnisotropicCoulomb(0.2, 0.8))])
    g = hl.Grasp(contacts, **data, environment=ribbed)
    every = np.random.default_rng(3).normal(size=(4, 3)) * 1e-3
    moved = g.replace(offset=every, preload=0.0)
    np.testing.assert_array_equal(moved.offset, every)
    np.testing.assert_array_equal(moved.replace(preload=1e-3).offset[3], every[3])
