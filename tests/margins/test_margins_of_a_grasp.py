"""The margins of one grasp together: the nearest finger and joint, the load, what they say, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

import handlcp as hl
import handlcp.scene
from tests.margins.test_bound import bounds

MU, PUSH, PULL, E = 0.5, 4.0, 1.2, 1e-3


def pinch(pull=PULL, mu=(MU, MU), push=PUSH):
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), hl.Coulomb(m)) for s, m in zip((-1.0, 1.0), mu, strict=True)]
    return hl.Grasp(contacts, (0, 0, -pull, 0, 0, 0), flexibility=E, preload=push * E)


@pytest.fixture(scope="module")
def cube():
    return handlcp.scene.load("examples/cube_three_fingers.toml").build()


def test_the_friction_margin_is_that_of_the_finger_that_uses_most():
    m = pinch(mu=(0.9, MU)).margins()
    assert m.friction.who == "finger 2"
    assert m.friction.amount == pytest.approx(MU * PUSH - PULL / 2, rel=1e-9)
    assert m.friction.share == pytest.approx(1 - PULL / 2 / (MU * PUSH), rel=1e-9)


def test_the_safety_factor_of_a_pinch_is_2_mu_n_over_the_load():
    m = pinch().margins()
    assert m.safety == pytest.approx(2 * MU * PUSH / PULL, rel=1e-9)
    assert {b.who for b in m.load.binds} == {"finger 1", "finger 2"}


def test_the_torque_margin_is_that_of_the_joint_nearest_its_limit(cube):
    m, s = cube.margins(), cube.solve()
    check = s.torque_check
    assert m.torque.who == check.binding
    k = check.utilisation.argmax()
    assert m.torque.amount == pytest.approx(check.limit[k] - abs(check.torque[k]), rel=1e-6)
    assert m.torque.share == pytest.approx(1 - check.utilisation.max(), rel=1e-6)
    assert m.safety is None  # nothing loads it but its weight
    assert m.force_closure.closed
    assert m.form_closure.closed is False


def test_without_an_answer_the_contacts_still_have_their_measures():
    m = pinch(pull=20.0).margins()
    assert not m.solution.held
    assert m.friction is m.torque is None
    assert m.epsilon >= 0.0
    assert "no equilibrium was found" in str(m)


def test_a_contact_that_slides_says_so_and_no_margin_is_minus_zero():
    """Of two pairs, the smoother one bears all it can, and the other the rest."""
    ways = [(np.array(d, dtype=float), m) for d, m in (((1, 0, 0), 0.2), ((0, 1, 0), 0.9))]
    contacts = [hl.Contact(0.02 * s * d, -s * d, hl.Coulomb(m)) for d, m in ways for s in (-1.0, 1.0)]
    m = hl.Grasp(contacts, (0, 0, -6.0, 0, 0, 0), flexibility=E, preload=PUSH * E).margins()
    assert m.friction.amount == pytest.approx(0.0, abs=1e-6)
    text = str(m)
    row = next(line for line in text.splitlines() if line.startswith("friction"))
    assert "slides already" in row
    assert "-0" not in row


def test_without_friction_there_is_no_friction_margin():
    axes = np.vstack([np.eye(3), -np.eye(3)])
    contacts = [hl.Contact(0.02 * a, -a, hl.Frictionless()) for a in axes]
    m = hl.Grasp(contacts, flexibility=E, preload=1e-3).margins()
    assert m.friction is None
    assert m.force_closure.closed is m.form_closure.closed is False  # a ball turns


@pytest.mark.parametrize("seed", range(2))
def test_loading_never_holds_more_than_friction_alone_could(seed):
    rng = np.random.default_rng(seed)
    out = rng.normal(size=(4, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    contacts = [hl.Contact(0.03 * p, -p, hl.Coulomb(0.6)) for p in out]
    bound = hl.FingerForceBound(6.0)
    g = hl.Grasp(contacts, flexibility=E, preload=2e-3, effects=[bound])
    w = np.append(rng.normal(size=3), np.zeros(3))
    reached = g.load_limit(w, faces=8).factor
    assert reached <= bounds(g, [w], 8).factors[0] * (1 + 1e-8) + 1e-9


def test_it_is_a_table(cube):
    m = cube.margins()
    frame = m.to_frame()
    assert frame.loc["epsilon", "value"] == pytest.approx(m.epsilon)
    assert frame.loc["friction", "who"] == m.friction.who


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"length": "long"}, "length"),
        ({"solution": 3}, "solution"),
    ],
)
def test_what_makes_no_sense_is_refused(given, name):
    with pytest.raises(hl.InputError) as caught:
        pinch().margins(**given)
    assert caught.value.argument == name
