"""What tables, verdicts, records and pictures say of contacts that are no finger's."""

from __future__ import annotations

import pathlib
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from handlcp import Contact, Coulomb, Environment, Grasp
from handlcp.scene import load
from handlcp.viz import terminal_table as tables
from handlcp.viz.picture.body import environment_bodies, stub_bodies
from handlcp.viz.picture.figure import draw_solution
from handlcp.viz.solution_output import solution_record
from tests.show.test_picture import contacts_only, volume
from tests.show.test_tables import printed
from tests.support.grasp import arrays
from tests.support.texts import says, without_numbers

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def box():
    grasp = load(EXAMPLES / "box_on_table.toml").build()
    return grasp, grasp.solve()


def on_a_table(load=(0, 0, -1.0)):
    top = [Contact((0, 0, 0.04), (0, 0, -1), Coulomb(0.5))]
    feet = [Contact((x, y, 0), (0, 0, 1), Coulomb(0.5)) for x in (-0.02, 0.02) for y in (-0.02, 0.02)]
    wall = Contact((0.02, 0, 0.02), (-1, 0, 0), Coulomb(0.5), name="wall")
    around = Environment([*feet, wall], 1e-5, [0, 0, 0, 0, 1e-3])
    return Grasp(top, (*load, 0, 0, 0), flexibility=1e-4, preload=1e-3, environment=around)


def below(table):
    """What is said under the rows."""
    rows = [i for i, line in enumerate(table.splitlines()) if re.search("sticking|sliding", line)]
    return without_numbers(" ".join(table.splitlines()[rows[-1] + 1 :]))


def test_the_tables_heading_is_contact_where_not_all_are_fingers(box):
    grasp, _ = box
    text = printed(tables.contact_table(grasp.solve(8)))
    says(below(text), "friction")
    assert "contact  " in text
    assert "table 4" in text
    assert "finger " not in text
    grasp = contacts_only()
    text = printed(tables.contact_table(grasp.solve(8)))
    says(below(text), "friction")
    assert "finger  " in text
    assert "contact " not in text


def test_the_verdict_speaks_of_contacts():
    grasp = on_a_table()
    s = grasp.solve()
    says(s.verdict.text, "wall")
    fingers = contacts_only()
    stuck = replace(s, contact_state=("sticking",) * len(s.names))
    says(stuck.verdict.text, "contacts")
    says(fingers.solve().verdict.text, "fingers")


def test_a_record_says_which_contacts_are_the_environments(box):
    grasp, s = box
    contacts = solution_record(grasp, s, grasp.explain())["contacts"]
    assert [c["environment"] for c in contacts] == [False] * 2 + [True] * 4


def test_contacts_in_one_plane_share_a_slab_below_it():
    grasp = on_a_table()
    table, wall = environment_bodies(grasp)
    size = arrays(grasp).units.length
    corners = table.triangles.reshape(-1, 3)
    assert corners[:, 2].max() == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(np.ptp(corners[:, :2], axis=0), 0.04 + size)
    assert volume(table.triangles) == pytest.approx((0.04 + size) ** 2 * 0.1 * size), "it winds outwards"
    assert wall.triangles[..., 0].min() == pytest.approx(0.02)
    assert len(stub_bodies(grasp)) == 1, "a rod for the finger alone"
    assert environment_bodies(contacts_only()) == []


def test_the_picture_names_the_tables_contacts(box):
    words = [t.get_text() for t in draw_solution(*box).findobj(Text)]
    assert any("table 3" in w for w in words)
    says("; ".join(w for w in words if "force" in w), "contact", "sticking")
    assert not any("finger" in w and "force" in w for w in words)
