"""Pages: drawn in a real browser, self-contained, small, with the numbers and postures of the answer they show."""

import base64
import gzip
import pathlib
import re
import sys
from functools import cache
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from typer.testing import CliRunner

import handlcp as hl
from handlcp.cli import app
from handlcp.errors import InputError, Unsupported
from handlcp.geometry import Sphere
from handlcp.hand import example_hand
from handlcp.scene import load
from handlcp.viz.loading.curves import solution_at_end
from tests.support.browser import data_of, opened

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
NASTY = "</script><script>document.documentElement.dataset.pwned=1</script>\"' & <img src=x onerror=dataset.pwned=1>"


def points_of(data, layer, frame):
    """(k, 3) corners of what a layer shows in a frame, world axes."""
    buffer = gzip.decompress(base64.b64decode(data["packed"]))
    out = []
    for part in data["parts"]:
        if part["layer"] != layer:
            continue
        at, count = part["points"]
        grid = np.frombuffer(buffer, "<u2", 3 * count, at).reshape(-1, 3)
        points = np.array(part["low"]) + np.array(part["size"]) * grid / 65534
        pose = frame["object"] if layer == "object" else frame["joints"][part["joint"]]
        m = pin.XYZQUATToSE3(np.array(pose, dtype=float))
        out.append(points @ m.rotation.T + m.translation)
    return np.concatenate(out)


def largest_first(data):
    """Names of the joints by their share of the limit, in the frame that a page shows first."""
    torques = data["frames"][data["first"]]["torques"]
    shares = [(abs(t) / j["limit"], j["name"]) for t, j in zip(torques, data["joints"], strict=True)]
    return [name for _, name in sorted(shares, key=lambda pair: -pair[0])]


@cache
def soft_ball():
    """A ball that five soft fingers lose: they move far before."""
    hand = example_hand("five_finger", joint_stiffness=1.0)
    obj = Sphere(0.035, placement=(0.0, 0.0, 0.07), mass=0.3)
    state = hand.at(hand.close_on(obj))
    return state.grasp(obj, friction=hl.Coulomb(0.6), wrench=(0, 0, 20, 0, 0, 0), gravity=(0, 0, 9.81), squeeze=0.002)


@cache
def lost_ball():
    """Its loading, up to where it is lost."""
    return soft_ball().follow(steps=6)


def contacts_only(friction, load, names=("a", "b", "c"), angles=(0, 2, 4)):
    points = [np.array([np.cos(a), np.sin(a), 0]) for a in angles]
    contacts = [hl.Contact(0.03 * p, -p, friction, name=name) for p, name in zip(points, names, strict=True)]
    return hl.Grasp(contacts, load, flexibility=1e-3, preload=1e-3)


def test_a_browser_draws_the_hand_with_its_forces_and_the_loading_as_a_slider(tmp_path):
    scene = load(EXAMPLES / "cube_three_fingers.toml")
    grasp = scene.build()
    solution, h = grasp.solve(), grasp.follow(steps=4)
    page = solution.page(tmp_path / "cube.html", title=NASTY, loading=h)
    data = data_of(page)
    seen = opened(page, tmp_path, at="5")  # a step halfway
    assert "error" not in seen.told, seen.told
    assert "pwned" not in seen.told, "a title is text"
    triangles = sum(part["corners"][1] for part in data["parts"])
    assert int(seen.told["triangles"]) > triangles, "all solids, and the arrows"
    assert int(seen.told["colours"]) > 50, "shaded"
    assert float(seen.told["painted"]) > 0.03, "not blank"
    assert not seen.hidden("bar")
    assert seen.words["when"] == data["frames"][5]["label"] != data["frames"][0]["label"]
    assert data["frames"][5]["contacts"][0]["row"][1] in seen.words["contacts"]
    assert "finger_1_proximal" in seen.words["torques"]
    assert "finger_<wbr>1_<wbr>proximal" in seen.source, "where a name may break"
    order = [seen.words["torques"].index(name) for name in largest_first(data)]
    assert order == sorted(order), "in falling order of their shares in the frame shown first"


def test_a_browser_draws_an_object_that_escapes_and_names_are_text(tmp_path):
    grasp = contacts_only(hl.Coulomb(0.2), (0, 0, -3, 0, 0, 0.02), ("thumb", "index", NASTY), (0, 2, 2.6))
    solution = grasp.solve(throw=False)
    assert solution.status is hl.Status.NOT_HOLDABLE
    seen = opened(solution.page(tmp_path / "lost.html", title="An object that falls"), tmp_path)
    assert "error" not in seen.told, seen.told
    assert "pwned" not in seen.told
    assert float(seen.told["painted"]) > 0.02
    assert not seen.hidden("flee"), "the button that shows the escape"
    assert seen.hidden("bar")
    assert "NOT HELD" in seen.words["verdict"]


def test_a_page_asks_the_network_for_nothing_and_escapes_what_users_wrote(tmp_path):
    grasp = contacts_only(hl.Coulomb(0.5), (0, 0, -1, 0, 0, 0), ("a", NASTY, "c"))
    source = grasp.solve().page(tmp_path / "a.html", title=NASTY).read_text(encoding="utf-8")
    assert "default-src 'none'" in source
    own = source.replace(re.search(r"/\*\*\s+\* @license.*?</script>", source, re.S)[0], "")
    assert not re.search(r"https?:(?!//www\.w3\.org/2000/svg)", own)
    assert not re.search(r"\b(src|href)\s*=|@import|url\(|fetch\(|XMLHttpRequest|WebSocket", own.replace("src=x", ""))
    assert NASTY not in source
    assert source.count("<script") == source.count("</script>") == 3
    assert "&lt;/script&gt;" in source
    assert data_of(tmp_path / "a.html")["contacts"][1]["name"] == NASTY


def test_numbers_are_those_of_the_solution_and_of_the_steps(tmp_path):
    grasp = load(EXAMPLES / "cube_three_fingers.toml").build()
    s, h = grasp.solve(), grasp.follow(steps=4)
    data = data_of(s.page(tmp_path / "cube.html", loading=h))
    once, *steps = data["frames"]
    np.testing.assert_allclose([c["force"] for c in once["contacts"]], s.forces_world, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(once["torques"], s.torques, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(once["load"]["force"], [0, 0, -0.2 * 9.81], atol=1e-4)
    assert len(steps) == len(h.steps)
    forces = [[c["force"] for c in f["contacts"]] for f in steps]
    np.testing.assert_allclose(forces, h.steps.forces_world, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose([f["torques"] for f in steps], h.steps.torques, rtol=1e-5, atol=1e-6)
    assert [c["state"] for c in steps[-1]["contacts"]] == list(h.steps.contact_state[-1])
    assert [j["name"] for j in data["joints"]] == list(grasp.state.hand.joint_names)
    np.testing.assert_allclose([j["limit"] for j in data["joints"]], grasp.state.hand.torque_limits)


def test_in_every_step_the_fingertips_and_the_object_are_where_the_contacts_are(tmp_path):
    h = lost_ball()
    assert not h.reached
    assert abs(h.steps.displacement[-1, 2]) > 3e-3, "far more than what is tolerated below"
    data = data_of(h.page(tmp_path / "ball.html", title="lost"))
    assert len(data["frames"]) == len(h.steps)
    for frame, positions in zip(data["frames"], h.steps.positions, strict=True):
        layers = {part["layer"] for part in data["parts"]} & {"hand", "inside"}
        points = np.concatenate([points_of(data, layer, frame) for layer in sorted(layers)])
        near = [np.linalg.norm(points - p, axis=1).min() for p in positions]
        assert max(near) < 1.2e-3, frame["label"]
    ball = points_of(data, "object", data["frames"][-1])
    centre = np.array([0, 0, 0.07]) + h.displacement[:3]
    np.testing.assert_allclose(np.linalg.norm(ball - centre, axis=1), 0.035, atol=2e-6)
    assert data["path"]["events"][-1]["lost"]
    assert data["first"] == len(h.steps) - 1


@pytest.mark.parametrize("name", ["allegro_pinch", "psyonic_grasp", "planar_ring"])
def test_pages_of_hands_with_many_triangles_are_below_two_megabytes(name, tmp_path):
    scene = load(EXAMPLES / f"{name}.toml")
    page = scene.build().solve().page(tmp_path / "a.html", obj=scene.shape())
    assert page.stat().st_size < 1.2e6
    assert not data_of(page)["notes"], "nothing is simplified"


def test_an_object_of_very_many_triangles_is_simplified_and_the_page_says_so(tmp_path):
    n = 300
    a, z = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(-0.02, 0.02, n))
    r = 0.03 + 0.001 * np.sin(40 * a) * np.sin(4000 * z)
    p = np.stack([r * np.cos(a), r * np.sin(a), z], axis=-1)
    near = np.stack([p[:-1, :-1], p[:-1, 1:], p[1:, 1:]], axis=2).reshape(-1, 3, 3)
    far = np.stack([p[:-1, :-1], p[1:, 1:], p[1:, :-1]], axis=2).reshape(-1, 3, 3)
    jar = SimpleNamespace(triangles=np.concatenate([near, far]), placement=pin.SE3.Identity())
    page = contacts_only(hl.Coulomb(0.5), (0, 0, -1, 0, 0, 0)).solve().page(tmp_path / "jar.html", obj=jar)
    data = data_of(page)
    few = next(part["corners"][1] for part in data["parts"] if part["layer"] == "object")
    assert 20_000 < few <= 100_000 < len(jar.triangles)
    assert f"The object is simplified: it is drawn with {few} of its {len(jar.triangles)} triangles." in data["notes"]
    points = points_of(data, "object", data["frames"][0])
    assert abs(np.linalg.norm(points[:, :2], axis=1) - 0.03).max() < 1.2e-3
    assert page.stat().st_size < 2e6


def test_planar_grasps_soft_fingers_and_tables_have_what_they_need(tmp_path):
    ring = load(EXAMPLES / "planar_ring.toml")
    data = data_of(ring.build().solve().page(tmp_path / "ring.html"))
    assert data["planar"]
    assert all(c["mu"][0] > 0 for c in data["contacts"])
    table = load(EXAMPLES / "box_on_table.toml").build()
    data = data_of(table.solve().page(tmp_path / "table.html"))
    assert [c["environment"] for c in data["contacts"]] == [False, False, True, True, True, True]
    assert "environment" in {part["layer"] for part in data["parts"]}
    pair = [hl.Contact((x, 0, 0), (-x, 0, 0), hl.SoftFinger(0.5, 0.01)) for x in (-1.0, 1.0)]
    soft = hl.Grasp(pair, (0, 0, -1, 0.01, 0, 0), flexibility=1e-4, preload=1e-3).solve()
    data = data_of(soft.page(tmp_path / "soft.html"))
    np.testing.assert_allclose([c["moment"] for c in data["frames"][0]["contacts"]], soft.torsion, rtol=1e-5)
    np.testing.assert_allclose(data["frames"][0]["load"]["moment"], (0.01, 0, 0), atol=1e-9)
    assert any(kind == "turn" for _, kind, _, _ in data["legend"])


@pytest.mark.parametrize(
    ("path", "words"),
    [("a.png", "ends in .html"), ("no/a.html", "a folder that exists"), ("folder.html", "can be written")],
)
def test_a_file_that_cannot_be_written_is_refused_before_the_work(path, words, tmp_path):
    (tmp_path / "folder.html").mkdir()
    result = CliRunner().invoke(app, ["solve", "no_such_scene.toml", "--page", str(tmp_path / path)])
    assert result.exit_code == 2
    with pytest.raises(InputError, match=words):
        contacts_only(hl.Coulomb(0.5), (0, 0, -1, 0, 0, 0)).solve().page(tmp_path / path)


def test_without_the_package_that_brings_the_viewer_the_error_says_what_to_install(tmp_path, monkeypatch):
    s = contacts_only(hl.Coulomb(0.5), (0, 0, -1, 0, 0, 0)).solve()
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(Unsupported, match="pip install 'trimesh>="):
        s.page(tmp_path / "a.html")


def test_a_page_has_one_verdict(tmp_path):
    """That of `check`, with the loading that it is about; of a loading alone, its own word."""
    grasp = soft_ball()
    s, h = grasp.solve(throw=False), lost_ball()
    heading = re.compile(r'<p class="word \w+">(.*?)</p>')
    alone = s.page(tmp_path / "loading.html", loading=h).read_text(encoding="utf-8")
    assert heading.findall(alone) == [h.word] == ["NOT HELD"]
    judged = grasp.check(solution=s)
    assert judged.loading is not None
    told = s.page(tmp_path / "verdict.html", verdict=judged)
    assert heading.findall(told.read_text(encoding="utf-8")) == [judged.word]
    assert data_of(told)["path"]["held"] == judged.loading.held
    assert heading.findall(s.page(tmp_path / "solve.html").read_text(encoding="utf-8")) == [s.verdict.word]


def test_the_legend_says_how_far_the_object_slides_as_check_says_it(tmp_path):
    """Fingers swing past the ball before they touch it, which is no slip: 2.6 mm here, of 0.6 mm."""
    hand, ball = example_hand("three_finger", joint_stiffness=6.0), Sphere(0.035, placement=(0, 0, 0.04), mass=0.3)
    grasp = hand.at(hand.neutral).grasp(ball, links="all", closing_torque=0.4, hold_object=True)
    judged = grasp.check()
    (contacts,) = judged.about("contacts")
    slides = contacts.values["sliding_m"]
    most = max(slides.values())
    assert f"up to {1e3 * most:.2f} mm" in judged.text
    assert most < 1e-3

    h = judged.loading
    moved = abs(np.hypot(*np.moveaxis(h.steps.slip, 2, 0)).sum(axis=0)).max()
    assert moved > 3.0 * most, "tips move past the object before they touch it"
    assert h.steps.slid[-1].max() == pytest.approx(most, rel=1e-12)
    for page in (grasp.solve().page(tmp_path / "a.html", verdict=judged), h.page(tmp_path / "b.html")):
        data = data_of(page)
        (said,) = [line[3] for line in data["legend"] if line[0] == "slips"]
        assert f"it slides up to {1e3 * most:.2f} mm" in said
        column = [name.startswith("slip") for name in data["columns"]].index(True) - 1  # rows begin behind the name
        rows = {c["name"]: one["row"] for c, one in zip(data["contacts"], data["frames"][-1]["contacts"], strict=True)}
        for name, far in slides.items():
            assert float(rows[name][column]) == pytest.approx(1e3 * far, abs=0.006)
        longest = max(
            np.linalg.norm(c["slip"]) for f in data["frames"] for c in f["contacts"] if c["state"] == "sliding"
        )
        assert longest < 1.01 * most
    told = solution_at_end(h)
    np.testing.assert_allclose(np.hypot(*told.slip.T), h.steps.slid[-1], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(np.hypot(*h.steps.slip_on_the_way.T), h.steps.slid[-1], rtol=0.01)  # hardly a turn
