"""Tables and numbers for people."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
from rich.console import Console

from handlcp import Contact, Coulomb, Frictionless, Grasp, words as units
from handlcp.geometry import Box
from handlcp.hand import example_hand
from handlcp.viz import terminal_table as tables
from tests.support.texts import says


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


def test_a_column_of_lengths_has_one_unit():
    column = units.choose_length_unit([2e-5, 0.0, 5e-6])
    assert (column.name, column(2e-5), column(0.0)) == ("µm", "20.00", "0")
    column = units.choose_length_unit([2e-3, 5e-6])
    assert (column.name, column(2e-3), column(5e-6)) == ("mm", "2.00", "0.005")


@pytest.mark.parametrize("width", [80, 100])
def test_tables_fit_a_narrow_terminal_with_numbers_in_columns(width):
    hand, box = example_hand("three_finger", joint_stiffness=6.0), Box(0.05, (0, 0, 0.08), 0.2)
    grasp = hand.at(hand.close_on(box)).grasp(box, Coulomb(0.8), preload=5e-3)
    s = grasp.solve()
    for table in (
        tables.effect_table(grasp.explain()),
        tables.contact_table(s),
        tables.torque_table(s.torque_check),
    ):
        text = printed(table, width)
        assert max(map(len, text.splitlines())) <= width
        assert "…" not in text
    rows = [line for line in printed(tables.contact_table(s), width).splitlines() if "_tip" in line]
    assert len(rows) == 3
    assert len({row.index(".") for row in rows}) == 1, "decimal points stand in a column"
    assert "closest" in printed(tables.torque_table(s.torque_check), width)


def test_an_overloaded_joint_stands_out():
    hand, box = example_hand("three_finger", joint_stiffness=6.0, torque_limits=0.2), Box(0.05, (0, 0, 0.08), 0.2)
    s = hand.at(hand.close_on(box)).grasp(box, Coulomb(0.8), preload=5e-3).solve()
    rows = {line.split()[0]: line for line in printed(tables.torque_table(s.torque_check)).splitlines() if "%" in line}
    over = {r.joint for r in s.torque_check if r.utilisation > 1}
    (remark,) = {re.split("[█·]", rows[joint])[-1].strip() for joint in over}
    says(remark, "limit")
    assert {joint for joint, row in rows.items() if remark in row} == over


def test_names_with_brackets_are_printed_as_they_are():
    contacts = [
        Contact((0.03, 0, 0), (-1, 0, 0), name="[red]thumb[/red]"),
        Contact((-0.03, 0, 0), (1, 0, 0), Frictionless()),
    ]
    grasp = Grasp(contacts, None, flexibility=1e-3, preload=1e-3)
    text = printed(tables.contact_table(grasp.solve()))
    assert "[red]thumb[/red]" in text
    assert "–" in text, "no friction limit for a frictionless contact"
