"""Whatever an answer prints fits 80 columns, in units that people read, without rounding noise."""

import io
import pathlib
import re
from functools import cache

import numpy as np
import pytest
from rich.console import Console

import handlcp as hl
from handlcp import Contact, Frictionless, Grasp, words as units
from handlcp.scene import load
from handlcp.studies.accuracy import accuracy_cost
from handlcp.viz import terminal_table as tables
from tests.support.show import html

ROOT = pathlib.Path(__file__).parents[2] / "examples"
SCENES = sorted([*ROOT.glob("*.toml"), *ROOT.glob("paper/*.toml")])
NOISE = re.compile(r"e-1\d|\bnan\b|\binf\b|(?<![\w.])-0(?:\.0+)?(?![\d.])")
LONG = "a_finger_with_a_name_that_no_table_has_room_for_in_eighty_columns_of_a_terminal"


def fits(thing, *facts):
    """Printed, it is readable; and its text."""
    text = str(thing)
    assert max(map(len, text.splitlines())) <= 80, text
    assert not NOISE.search(text), f"{NOISE.search(text)} in {text}"
    for fact in facts:
        assert fact in text, f"no {fact!r} in {text}"
    return text


@cache
def solved(file):
    grasp = load(file).build()
    return grasp, grasp.solve("cone")


def pinch(law=None, pull=1.0, squeeze=1e-3, names=("", ""), **more):
    law = hl.Coulomb(0.5) if law is None else law
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), law, name=n or None) for s, n in zip((-1.0, 1.0), names,
                                                                                         strict=True)]  # fmt: skip
    return hl.Grasp(contacts, (0, 0, -pull, 0, 0, 0), flexibility=1e-4, preload=squeeze, **more)


@pytest.mark.parametrize("file", SCENES, ids=lambda f: f.stem)
def test_what_every_example_scene_answers_can_be_read(file):
    grasp, s = solved(file)
    fits(s, *s.names, "normal", "of limit")
    fits(s.verdict, s.verdict.word)
    fits(grasp.check(faces="cone", solution=s))
    fits(grasp.explain("cone"), "on ", "off ")
    fits(grasp.suggest(s, "cone"))
    if hasattr(s, "torque_check"):
        fits(s.torque_check, s.torque_check.binding)
    if not any("Force" in type(e).__name__ and "Bound" not in type(e).__name__ for e in grasp.spec.effects):
        h = grasp.follow(steps=4)
        fits(h)
        fits(h.solution)
    page = html(s)
    assert "<link" not in page
    assert s.verdict.word in page
    for name in s.names:
        assert name in page


def test_the_other_answers_can_be_read():
    grasp = pinch()
    fits(grasp.equilibria(faces=4))
    fits(grasp.required_preload(tolerance=0.1))
    fits(pinch(squeeze=0.0).required_preload(tolerance=0.1), "mm")
    fits(grasp.required_friction(tolerance=0.1))
    fits(pinch(squeeze=0.0).required_friction(tolerance=0.1))
    fits(hl.solve_many([grasp, pinch(squeeze=0.0)]), "SOLVED")
    fits(accuracy_cost(grasp, methods=["NSNGRK polished"], faces=[8], tolerances=[1e-9], left_out=False, repeats=1))
    fits(grasp.solve(accuracy=1e-3), "force error")
    fits(grasp.solve(accuracy=1e-3).accuracy)


def test_names_longer_than_a_line_are_broken_over_lines():
    grasp = pinch(names=(LONG, LONG[::-1]))
    _, table, *_ = fits(grasp.solve("cone")).split("\n\n")
    assert LONG in "".join(re.findall(r"^[a-z_]+", table, re.M)), "its parts are below each other"
    fits(grasp.check())
    fits(grasp.equilibria(faces=4))
    fits(pinch(names=(LONG, LONG[::-1]), squeeze=0.0).solve(throw=False))
    fits(pinch(names=(LONG, LONG[::-1]), pull=0.999).follow(steps=4))


def test_a_solution_without_an_answer_says_why_and_prints_no_numbers():
    lost = pinch(pull=100.0).solve(throw=False)
    fits(lost, "NOT HELD")
    assert np.isnan(lost.forces).all()
    assert "normal" not in str(lost)
    assert "NOT HELD" in html(lost)
    pyramid = pinch(pull=1.0, squeeze=0.01).replace(wrench=(0, 0, 0, 9, 0, 0)).solve(faces=6, throw=False)
    fits(pyramid, "6-face pyramids")


def test_nothing_that_is_rounding_is_printed_as_a_number():
    s = pinch(pull=0.0).solve("cone")
    text = fits(s)
    assert "moves (0, 0, 0)" in text
    assert re.search(r"sticking\s+10\.00\s+0\.00", text), "the friction of a pinch without a load"


@pytest.mark.parametrize(("size", "unit"), [(1e-4, "mN"), (1e-6, "µN"), (1.0, "N"), (1e5, "kN")])
def test_forces_have_the_prefix_that_fits(size, unit):
    """The same pinch under loads of all sizes: a squeeze of 10 N times the size, and 0.5 N of friction times it."""
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(0.5)) for s in (-1.0, 1.0)]
    grasp = hl.Grasp(contacts, (0, 0, -size, 0, 0, 0), flexibility=1e-4 / size, preload=1e-3)
    text = fits(grasp.solve("cone"))
    assert text.split("\n\n")[1].splitlines()[1].split()[0] == unit
    said = {"mN": 1e-3, "µN": 1e-6, "N": 1.0, "kN": 1e3}[unit]
    assert f"{10 * size / said:.0f}" in text


def test_friction_that_is_all_but_used_up_is_a_warning_beside_held():
    bold = pinch(pull=0.98 * 2 * 0.5 * 10.0).solve("cone").verdict
    assert bold.word == "HELD"
    (warned,) = bold.about("friction")
    assert (warned.severity, "98 %" in warned.sentence) == ("warning", True)
    calm = pinch(pull=0.5 * 2 * 0.5 * 10.0).solve("cone").verdict
    assert "50 %" in calm.text
    assert [r.severity for r in calm.about("friction")] == ["note"]


# ---------------------------------------------------------------- Tables and numbers for people


def printed(table, width=80):
    out = io.StringIO()
    Console(file=out, width=width).print(table)
    return out.getvalue()


@pytest.mark.parametrize(
    ("metres", "text"),
    [
        (4.2e-4, "0.42 mm"),
        (1.23e-5, "12 µm"),
        (2.5e-7, "0.25 µm"),
        (1e-13, "0 mm"),
        (0.0, "0 mm"),
        (0.1, "100 mm"),
        (np.nan, "–"),
    ],
)
def test_lengths_in_millimetres_or_micrometres(metres, text):
    assert units.format_length(metres) == text


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (units.format_force(1.5283), "1.53 N"),
        (units.format_force(12345.6), "12346 N"),
        (units.format_torque(0.30066), "0.301 N·m"),
        (units.format_torque(0.0042), "4.2 mN·m"),
        (units.format_torque(0.0), "0 N·m"),
        (units.format_percent(0.376), "38 %"),
        (units.format_percent(0.0612), "6.1 %"),
        (units.format_percent(0.0), "0 %"),
        (units.format_percent(np.nan), "–"),
        (units.format_angle(np.radians(0.58)), "0.58°"),
    ],
)
def test_numbers_fit_their_size(call, text):
    assert call == text


def test_names_with_brackets_are_printed_as_they_are():
    contacts = [
        Contact((0.03, 0, 0), (-1, 0, 0), name="[red]thumb[/red]"),
        Contact((-0.03, 0, 0), (1, 0, 0), Frictionless()),
    ]
    grasp = Grasp(contacts, None, flexibility=1e-3, preload=1e-3)
    text = printed(tables.contact_table(grasp.solve()))
    assert "[red]thumb[/red]" in text
    assert "–" in text, "no friction limit for a frictionless contact"
