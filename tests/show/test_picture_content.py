"""What pictures show beside forces: moments, motions, links without geometry, fingertips, links inside the object."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import handlcp as hl
from handlcp.viz.picture.body import hand_bodies, undrawn_tip_shapes
from handlcp.viz.picture.camera import camera_against
from handlcp.viz.picture.figure import draw_solution
from handlcp.viz.picture.overlay import RotationArc
from tests.show.picture_cases import bare_hand, case, ring
from tests.support import patches


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    patches.coarse_pictures(monkeypatch)


def legend(name, **more):
    grasp, solution, obj, title = case(name)
    return " | ".join(t.get_text().replace("\N{NO-BREAK SPACE}", " ").replace("\n", " ")
                      for t in draw_solution(grasp, solution, obj, title, **more).legends[0].get_texts())  # fmt: skip


# ---------------------------------------------------------------- moments
@pytest.mark.parametrize("towards", [(0, 0, 1), (1, 0.3, 0.4), (1, 0, 0), (0.2, 1, -0.7)])
@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, -0.8)])
def test_an_arc_turns_as_a_right_hand_screw_and_is_never_a_line(axis, towards):
    camera = camera_against(np.array(towards, dtype=float), np.array([0.0, 1, 0]))
    turn = RotationArc(np.array([0.1, 0.2, 0.3]), np.array(axis, dtype=float), 0.02)
    points = turn.screen_points(camera) - camera.project(turn.centre)
    area = 0.5 * float((points[:-1, 0] * points[1:, 1] - points[:-1, 1] * points[1:, 0]).sum())
    along = float(np.array(axis, dtype=float) @ camera.axes[2])
    assert abs(area) > 0.3 * 0.02**2, "the arc is open"
    if abs(along) > 1e-9:
        assert np.sign(area) == np.sign(along), "towards the viewer it turns to the left"
    assert np.linalg.norm(points, axis=1).max() <= 0.02 * (1 + 1e-9)


def test_a_dollar_in_a_title_is_a_dollar(tmp_path):
    grasp, solution, obj, _ = case("cube_three_fingers")
    figure = draw_solution(grasp, solution, obj, "$5 for a $^$ hand")
    assert [t.get_text() for t in figure.texts if "$" in t.get_text() and not t.get_parse_math()] == [
        "$5 for a $^$ hand"
    ]
    figure.savefig(tmp_path / "title.png")  # mathematics that is none would end it


def test_what_is_drawn_of_a_load_is_statically_the_load():
    # A force whose line of action passes by the contacts, given about a point far away
    offset = np.array([0.0, 4.0, 0.0])
    force = np.array([0.0, 0.0, -1.0])
    contacts = [hl.Contact(c.position, c.normal, c.friction) for c in ring(3).contacts]
    near = hl.Grasp(contacts, (*force, 0, 0, 0), flexibility=1e-3, preload=3e-3)
    about = np.cross(-offset, force)
    far = hl.Grasp(contacts, (*force, *about), flexibility=1e-3, preload=3e-3, reference=offset)
    words = [
        " | ".join(t.get_text() for t in draw_solution(g, g.solve()).legends[0].get_texts() if "object" in t.get_text())
        for g in (near, far)
    ]
    assert words[0] == words[1]
    assert "torque" not in words[1]


# ---------------------------------------------------------------- slips
def test_every_slip_is_drawn_or_named_in_the_legend():
    said = legend("unequal_slips")
    assert "slip of the object, × 20 (up to 0.79 mm)" in said
    assert "slip not drawn" not in said
    assert slip_arrows("unequal_slips") == 2
    said = legend("paper/planar_frictionless")
    _, solution, *_ = case("paper/planar_frictionless")
    sliding = [n for n, state in zip(solution.names, solution.contact_state, strict=True) if state == "sliding"]
    drawn = slip_arrows("paper/planar_frictionless")
    missing = [n for n in sliding if n in said.partition("slip not drawn")[2]]
    assert drawn + len(missing) == len(sliding) == 3


def slip_arrows(name):
    grasp, solution, obj, title = case(name)
    figure = draw_solution(grasp, solution, obj, title)
    purple = (0xA0 / 255, 0x30 / 255, 0x7A / 255)
    return sum(np.allclose(p.get_facecolor()[:3], purple) for p in figure.axes[0].patches)


# ---------------------------------------------------------------- hands
def test_links_without_geometry_are_sticks_from_joint_to_joint():
    given = case("cube_three_fingers")[0].state
    whole = {b.link for b in hand_bodies(given) if not b.link.endswith("_tip")}
    state = bare_hand().at(given.q)
    sticks = hand_bodies(state)
    assert {b.link for b in sticks} == whole, "every link is drawn, by its name"
    ends = np.concatenate([b.triangles.reshape(-1, 3) for b in sticks])
    for tip in state.tip_positions:
        assert np.linalg.norm(ends - tip, axis=1).min() < 0.005, "a stick ends at each fingertip"
    some = hand_bodies(bare_hand(lambda link: not link.startswith("finger_2")).at(given.q))
    assert {b.link for b in some} >= whole
    kept = [b for b in hand_bodies(given) if not b.link.startswith("finger_2")]
    shown = [b for b in some if not b.link.startswith("finger_2")]
    assert len(kept) == len(shown)
    for a, b in zip(kept, shown, strict=True):
        np.testing.assert_array_equal(a.triangles, b.triangles)


def test_a_fingertip_is_drawn_where_its_contact_is_not_on_the_hand():
    cube = case("cube_three_fingers")[0]
    assert undrawn_tip_shapes(cube, hand_bodies(cube.state)) == [], "its visual geometry is the ball that touches"
    bare = case("bare_hand")[0]
    shown = undrawn_tip_shapes(bare, hand_bodies(bare.state))
    assert len(shown) == 3
    for triangles, tip, p in zip(shown, bare.state.tip_positions, [c.position for c in bare.contacts], strict=True):
        np.testing.assert_allclose(np.linalg.norm(triangles.reshape(-1, 3) - tip, axis=1), 0.008, rtol=1e-9)
        assert np.linalg.norm(triangles.reshape(-1, 3) - p, axis=1).min() < 1.5e-3, "the contact lies on it"
    assert "fingertip shape that finds the contact" in legend("bare_hand")
    assert "fingertip shape" not in legend("cube_three_fingers")


def test_stripes_mark_what_is_inside_the_object(monkeypatch):
    monkeypatch.undo()
    image = rendered("links_inside")
    cube = rendered("cube_three_fingers")
    near = [(abs(i - np.array([0xC6, 0x66, 0x14])).max(-1) < 26).sum() for i in (image, cube)]
    assert near[0] > 800 > 50 > near[1]


def rendered(name):
    grasp, solution, obj, title = case(name)
    figure = draw_solution(grasp, solution, obj, title)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[80:, :700, :3].astype(int)


# ---------------------------------------------------------------- the state that is drawn
def said(figure):
    return " ".join(t.get_text() for t in figure.texts)


# ---------------------------------------------------------------- What answers offer of pictures and data


@pytest.fixture(scope="module")
def solution():
    contacts = [hl.Contact((x, 0, 0), (-x, 0, 0), hl.SoftFinger(0.5, 0.01)) for x in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3).solve()


def test_under_the_verdict_of_check_the_end_of_its_loading_is_drawn():
    """The labels' forces are those at the end: friction remembers the squeeze, and they differ from one solve's."""
    hand, can = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    grasp = hand.at(hand.close_on(can)).grasp(can, hl.Coulomb(0.8), squeeze=5e-3, wrench=(1.0, 1.5, 0, 0, 0, 0))
    s, v = grasp.solve(), grasp.check()
    assert v.loading.reached

    def labels(solution):
        return {f"{normal:.3g} + " for normal in solution.normal_force}

    def told(figure):
        return " ".join(t.get_text() for t in [*figure.texts, *(t for ax in figure.axes for t in ax.texts)])

    one, end = told(s.plot()), told(s.plot(verdict=v))
    assert labels(s) != labels(v.loading.solution)
    assert all(label in one for label in labels(s))
    assert all(label in end for label in labels(v.loading.solution))
    assert "squeezed and loaded" in end
    assert "squeezed and loaded" not in one
