"""Tables and numbers for people."""

import io

import numpy as np
import pytest
from rich.console import Console

from handlcp import Contact, Frictionless, Grasp
from tests.support.show import tables, units


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
