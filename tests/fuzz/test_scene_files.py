"""Scene files that went through the wars: refused with a typed error, or built and solved with a certified answer."""

import contextlib
import os
import random
import re
import time
from pathlib import Path

import numpy as np
import pytest

import handlcp as hl
from handlcp.scene import read
from tests.fuzz.mutations import line_moved, line_twice, mutated, no_line, truncated, with_one_of

HARD = os.environ.get("HANDLCP_HARD") == "1"
EXAMPLES = Path(__file__).parents[2] / "examples"
CONTACTS = """
title = "two fingers"
[[contact]]
position_m = [-0.01, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
friction = 0.5
name = "left"
[[contact]]
position_m = [0.01, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
tangent = [0.0, 0.0, 1.0]
[[environment]]
position_m = [0.0, 0.0, -0.01]
normal = [0.0, 0.0, 1.0]
friction = 0.3
flexibility_m_per_N = 1e-5
gap_m = 1e-4
name = "table"
[grasp]
friction = 0.6
preload_m = 1e-3
flexibility_m_per_N = [1e-4, 1e-4, 1e-4]
reference_m = [0.0, 0.0, 0.0]
[load]
force_N = [0.0, 0.0, -1.0]
torque_Nm = [0.0, 0.0, 0.0]
[effects]
total_force_bound_N = 50.0
finger_force_bound_N = 40.0
[[effects.prescribed_force]]
contact = "left"
force_N = [0.0, 0.0, 5.0]
[solve]
faces = 8
seed = 1
"""
VALUES = ["nan", "inf", "-inf", "1e400", "1e300", "-1e300", "1e-300", "0", "0.0", "-1", "-0.5", "1.5", '""', '"x"',
          '"cone"', '"frictionless"', "true", "[]", "[[]]", "{}", "{a = 1}", "[1.0, 2.0]", "[1, 2, 3]", "[nan, 0, 0]",
          "[1e200, 1e200, 1e200]", "[[1.0]]", "2026-01-01", "9223372036854775807", "99999999999999999999999", "'''x'''",
          "[true]", '["left"]', '{left = 1.0}', "1_000", "+1", "0x10"]  # fmt: skip
NUMBER = re.compile(r"(?<![\w\"])-?\d+\.?\d*(?:e-?\d+)?(?![\w\"])")


def value(rng, text):
    """A key gets a value that is none, or an absurd one."""
    lines = text.splitlines()
    i = rng.choice([i for i, line in enumerate(lines) if re.match(r"^\w+ = ", line)])
    lines[i] = lines[i].split(" = ")[0] + " = " + rng.choice(VALUES)
    return "\n".join(lines)


def one_number(rng, text):
    m = rng.choice(list(NUMBER.finditer(text)))
    x = rng.choice(["nan", "inf", "1e300", "-1e300", "0", "0.0", "-1.0", "1e-300", "1e12", "1e-12", "100"])
    return text[: m.start()] + x + text[m.end() :]


def noise(rng, text):
    return with_one_of(rng, text, ["[", "]", "=", '"', "\x00", "#", "{", "\n", "é", "'''", "\\"])


def misspelt(rng, text):
    words = list(re.finditer(r"^(\w+) =|^\[+(\w+)", text, re.M))
    m = rng.choice(words)
    k = 1 if m[1] else 2
    i = rng.randrange(m.start(k), m.end(k))
    return text[:i] + rng.choice("abc_") + text[i + 1 :]


SCENES = [str(p.relative_to(EXAMPLES).with_suffix("")) for p in EXAMPLES.rglob("*.toml") if p.stem != "stated"]
LAWS = """
[[contact]]
position_m = [-0.02, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
friction = {mu = 0.5, mu_torsion_m = 0.004, torsional_flexibility_rad_per_Nm = 2.0}
name = "thumb"
[[contact]]
position_m = [0.02, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
friction = {mu_x = 0.6, mu_y = 0.3, along = [0.0, 0.0, 1.0]}
[[contact]]
position_m = [0.0, 0.02, 0.0]
normal = [0.0, -1.0, 0.0]
[[environment]]
position_m = [0.0, 0.0, -0.01]
normal = [0.0, 0.0, 1.0]
flexibility_m_per_N = 1e-5
[grasp]
friction = 0.6
preload_m = 0.0005
flexibility_m_per_N = 1e-4
[load]
force_N = [0.1, 0.2, -1.0]
torque_Nm = [0.001, 0.0, 0.002]
[effects]
total_force_bound_N = 20.0
contact_compliance_m_per_N = 1e-5
[effects.soft_wrist]
translation_m_per_N = 1e-5
[[effects.known_force]]
contact = 2
normal_N = 1.5
"""
WRITTEN = {"contacts": CONTACTS, "laws": LAWS}
EVERY = [*sorted(SCENES), *WRITTEN]
MUTATIONS = (value, value, value, one_number, one_number, one_number, no_line, line_moved, line_twice, truncated, noise,
             misspelt)  # fmt: skip


def mutants(example):
    """(which, text) of an example, one to three mutations each."""
    original = WRITTEN.get(example) or (EXAMPLES / f"{example}.toml").read_text()
    count = (60 if example in WRITTEN else 12) * (20 if HARD else 1)
    rng = random.Random(f"{example}, 6")  # with which at least two of twelve are read
    for i in range(count):
        yield i, mutated(rng, original, MUTATIONS)[0]


@pytest.mark.parametrize(
    "example", [pytest.param(one, marks=pytest.mark.long) if one == "bottle_power_grasp" else one for one in EVERY]
)
def test_every_mutant_is_refused_or_answered(example):
    refused = answered = 0
    for i, text in mutants(example):
        try:
            s = read(text, EXAMPLES).solve(throw=False)
        except hl.HandLCPError:
            refused += 1
            continue
        except BaseException as error:
            raise AssertionError(f"mutant {i}: {type(error).__name__}: {error}\n{text}") from error
        assert str(s)
        if s.held:
            assert np.isfinite(s.forces).all(), text
            assert s.residuals.worst <= 1e-8, text
        if s.status is hl.Status.NOT_HOLDABLE:
            assert np.isfinite(s.certificate).all(), text
        answered += 1
    assert refused, "mutations that change nothing prove nothing"
    assert answered, "mutants that are all refused prove nothing"


@pytest.mark.bench
@pytest.mark.parametrize("example", EVERY)
def test_no_mutant_takes_more_than_ten_seconds(example):
    for _, text in mutants(example):
        start = time.monotonic()
        with contextlib.suppress(hl.HandLCPError):
            read(text, EXAMPLES).solve(throw=False)
        assert time.monotonic() - start < 10, text


@pytest.mark.parametrize(
    "text", ["", "\n", "\ufeff", "[", "a", "=", "[[contact]]", "[hand]", "contact = 3", "hand = []"]
)
def test_files_of_next_to_nothing_are_refused(text):
    with pytest.raises(hl.HandLCPError):
        read(text).build()
