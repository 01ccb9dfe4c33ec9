"""The page of effects: written from the code, complete, and what it tells to type works."""

import pathlib
import re
import tomllib

import numpy as np
import pytest

import handlcp as hl
from handlcp.scene import SceneFile, keys
from handlcp.studies.effect_catalogue import cost, costs, effect_scenes, entries
from tests.support import patches
from tests.support.effects import entry_for, kinds_in_the_catalogue
from tests.support.grasp import arrays
from tests.support.scripts import script

anchor, page = script("effects_page").anchor, script("effects_page").page
ROOT = pathlib.Path(__file__).parents[2]
FOLDER = ROOT / "handlcp" / "grasp" / "effects"
PAGE = (FOLDER / "README.md").read_text(encoding="utf-8")
ALL = {e.title: e for e in entries()}
ASKED = [e for e in ALL.values() if e.in_python]
SCENE = """
hand = { name = "five_finger", joint_stiffness_Nm_per_rad = 6.0 }
object = { shape = "sphere", radius_m = 0.035, position_m = [0.0, 0.0, 0.07] }
grasp = { friction = 0.6, preload_m = 0.003, gravity_m_per_s2 = [0.0, 0.0, 9.81] }
load = { force_N = [0.0, 0.0, 3.0] }
[solve]
faces = 8
"""


def masked(text):
    """Without what was measured."""
    return re.sub(r"× \d+\.\d", "× #", re.sub(r"^Measured on .*\)\.", "Measured on #.", text, flags=re.M))


def made(trial):
    return trial.grasp(trial.state(), trial.ball())


def lines(trial):
    """What `explain` says of the trial: (title, equation) of what is on."""
    return {(x.title, x.equation) for x in made(trial).explain(trial.faces).effects if x.on}


def law(entry):
    """As `explain` has it: one line for all transmissions, by the equation of the one that there is."""
    return entry.title.partition(":")[0], entry.equation


def test_the_page_is_what_the_generator_writes_but_for_what_was_measured():
    fresh = page(costs(lambda runs: dict.fromkeys(runs, 1.0)), "2000-01-01 (1 core)")
    assert masked(fresh) == masked(PAGE), "python examples/effects_page.py > handlcp/grasp/effects/README.md"
    assert masked(PAGE).count("× #") == len(ALL) - 2  # balance and contact are never left out


def test_every_effect_and_every_line_of_explain_is_on_the_page():
    headings = re.findall(r"^### (.*)$", PAGE, flags=re.M)
    assert headings == list(ALL)
    assert {kind.title for kind in kinds_in_the_catalogue()} <= set(headings)
    hand = made(effect_scenes(ALL["finger flexibility"])[0]).explain()
    contacts = hl.Grasp([hl.Contact((0, 0, 0), (1, 0, 0), hl.Coulomb(0.5))], flexibility=1e-3).explain()
    for line in (*hand.effects, *contacts.effects):
        assert any(h == line.title or h.startswith(f"{line.title}: ") for h in headings), line.title


def test_every_key_of_the_effects_table_is_on_the_page_and_every_key_on_the_page_exists():
    paths = {k.path for k in keys()}
    tables = {path.rpartition(".")[0] for path in paths}
    for path in paths:
        if path.startswith("effects."):
            assert f"`{'.'.join(path.split('.')[:2])}`" in PAGE
    for entry in ASKED:
        for key in entry.file_keys:
            assert key.strip("[]") in paths | tables, key


@pytest.mark.parametrize("entry", ASKED, ids=lambda e: e.title)
def test_what_the_page_says_in_python_asks_for_that_effect_and_no_other(entry):
    on, off = effect_scenes(entry)
    if entry.title == "object weight":  # part of the load, no line of its own
        more = arrays(made(on)).wrench - arrays(made(off)).wrench
        np.testing.assert_allclose(more, [0, 0, 0.3 * 9.81, 0, 0, 0], atol=1e-12)
        return
    assert law(entry) in lines(on)
    if on != off:
        assert law(entry) not in lines(off)
        others = lines(off) - lines(on)  # a soft finger takes the place of point contacts
        assert {title.partition(",")[0] for title, _ in others} <= {"Coulomb friction"}


@pytest.mark.parametrize("entry", ASKED, ids=lambda e: e.title)
def test_a_scene_file_with_the_pages_keys_is_the_same_grasp_as_in_python(entry):
    on, _ = effect_scenes(entry)
    scene = tomllib.loads(SCENE)
    if "plane" in on.given:
        scene["hand"]["name"] = "two_finger"
    if entry.in_file.startswith("[hand."):
        del scene["hand"]["joint_stiffness_Nm_per_rad"]
    for table, value in tomllib.loads(entry.in_file).items():
        scene[table] = scene.get(table, {}) | value if isinstance(value, dict) else value
    file = SceneFile.model_validate(scene)
    a, b = file.build(), made(on)
    assert file.solve_with.faces == on.faces
    assert repr(a.contacts) == repr(b.contacts)
    assert [e.title for e in a.effects] == [e.title for e in b.effects]
    np.testing.assert_array_equal(arrays(a).wrench, arrays(b).wrench)
    for name in ("flexibility", "offset", "gravity_torque", "joint_offset"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    np.testing.assert_array_equal(a.solve(on.faces).forces, b.solve(on.faces).forces)


def test_the_cost_is_the_difference_in_unknowns_and_the_ratio_of_times():
    c = cost(ALL["total normal-force bound"], lambda runs: {0: 2.0, 1: 3.0})
    assert (c.unknowns, c.ratio, c.more, str(c)) == (1, 1.5, "+1", "× 1.5")
    c = cost(ALL["prescribed contact force"], lambda runs: {0: 2.0, 1: 1.0})
    assert (c.unknowns, c.ratio) == (-(1 + 2 + 8), 0.5)
    assert str(cost(ALL["object balance"])) == "–"
    assert cost(ALL["Coulomb friction"]).unknowns == 5 * (2 + 8)


def test_what_the_page_says_of_the_reference_scene_is_so():
    """Bounds are reached, torque limits are not, the table bears something."""
    titles = [title for title in ALL if "bound" in title or "sat" in title]
    assert len(titles) == 3
    solved = {title: made(effect_scenes(ALL[title])[0]).solve() for title in titles}
    assert solved["total normal-force bound"].forces[:, 2].sum() == pytest.approx(6.0, rel=1e-9)
    assert solved["per-finger force bound"].forces[:, 2] == pytest.approx(np.full(5, 1.2), rel=1e-9)
    assert not solved["torque saturation"].joint_yield.any()
    assert made(effect_scenes(ALL["environment contacts"])[0]).solve().forces[-1, 2] > 0.1


def test_a_new_effect_is_on_the_page_by_its_row_in_the_catalogue_alone(monkeypatch):
    class Lower(hl.TotalForceBound):
        title, when = "lower bound", "To see that this works."

    patches.another_effect(monkeypatch, Lower)
    assert entry_for(Lower) in entries()
    found = costs(lambda runs: dict.fromkeys(runs, 1.0))
    assert f"### {Lower.title}\n\n{Lower.when}" in page(found, "")
    assert found["lower bound"].unknowns == 1
