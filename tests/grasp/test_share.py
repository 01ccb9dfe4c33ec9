"""What each effect costs: every effect that can be left out is compared, and with a scene that has the same answer."""

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import cube_example, pinch, ring
from tests.support import patches
from tests.support.clocks import a_quarter_less
from tests.support.steps import shares
from tests.support.texts import says


def flat():
    contacts = [hl.Contact((-0.01, 0), (1, 0)), hl.Contact((0.01, 0.001), (-1, 0)), hl.Contact((0, -0.01), (0, 1))]
    wrist = hl.SoftWrist((1e-3, 1e-3, 0, 0, 0, 0.5), (0, 0, -0.1))
    return hl.Grasp(contacts, (0.2, -1.0, 0.001), flexibility=1e-4, preload=2e-4, effects=[wrist])


def loaded():
    contacts, data = ring(np.random.default_rng(3))
    known = hl.PrescribedForce(0, (0.1, 0.0, 4.0))
    effects = [known, hl.TotalForceBound(40.0), hl.ContactCompliance(1e-4), hl.SoftWrist(np.full(6, 1e-3))]
    return hl.Grasp(contacts, **data, effects=effects)


def sliding():
    contacts, data = ring(np.random.default_rng(4), mu=0.25)
    return hl.Grasp(contacts, **data)


def heavy():
    hand = hl.example_hand("five_finger", joint_stiffness=5.0)
    ball = hl.Sphere(0.03, (0, 0, 0.085), density=900)
    return hand.at(hand.close_on(ball, squeeze=4e-3)).grasp(ball, finger_weight=True)


def soft_patches():
    contacts, data = ring(np.random.default_rng(6))
    laws = [hl.SoftFinger(0.6, 0.006, 2.0), hl.AnisotropicCoulomb(0.9, 0.7), hl.Coulomb(0.6), hl.SoftFinger(0.5, 0.004)]
    foot = hl.Contact((0, 0, 0), (0, 0, 1), hl.AnisotropicCoulomb(0.4, 0.3))
    stand = hl.Environment([foot], 1e-3, -1e-4)
    return hl.Grasp([c.with_friction(f) for c, f in zip(contacts, laws, strict=True)], **data, environment=stand)


def tight(limit=0.3, **more):
    """Soft fingers on joints with limits; what is left out may change who is soft."""
    box, patch = hl.Box(0.05, (0, 0, 0.08), mass=0.02), hl.SoftFinger(0.6, 0.006, 2.0)
    hand = hl.example_hand("three_finger", joint_stiffness=6.0, pad_flexibility=2e-4, torque_limits=limit)
    laws = dict(zip(hand.fingertips, (patch, hl.Coulomb(0.7), patch), strict=True))
    state = hand.at(hand.close_on(box))
    return state.grasp(box, laws, preload=0.006, joint_offset=[0.01] * 6, **more)


def limited():
    return tight(effects=[hl.TorqueSaturation(), hl.ContactCompliance(1e-4)])


def given():
    return tight(1.0, effects=[hl.TorqueSaturation(), hl.PrescribedForce(0, tight().solve().forces[0])])


def resting():
    table = hl.Table((0, 0, 0.055), friction=hl.Coulomb(0.3), flexibility=1e-3)
    return tight(environment=table, finger_weight=True)


SCENES = {
    "pinch": pinch, "cube": cube_example, "plane": flat, "effects": loaded, "sliding": sliding, "hand": heavy,
    "patches": soft_patches, "limited": limited, "given": given, "resting": resting
}  # fmt: skip
ALWAYS = {"object balance", "unilateral contact"}


@pytest.mark.parametrize("faces", [8, "cone"])
@pytest.mark.parametrize("name", SCENES)
def test_the_scene_without_an_effect_has_the_answer_that_it_is_started_at(name, faces):
    """Each run ends in a certified answer, and its share is what leaving it out saves."""
    g = SCENES[name]()
    solution = g.solve(faces, throw=False)
    e = shares(g, faces, solution, a_quarter_less)
    assert solution.held
    assert e.seconds == 2.0
    for line in e.effects:
        assert line.share == (0.25 if line.on and line.title not in ALWAYS else None), line.title


def test_an_answer_is_reached_from_itself_in_no_steps(monkeypatch):
    """The scene without friction, or without flexibility, is solved by the old forces: nothing is searched for."""
    g, seen = sliding(), patches.watched_first_stage(monkeypatch)
    solution = g.solve("cone")
    assert "sliding" in solution.contact_state
    shares(g, "cone", solution, a_quarter_less)
    assert len(seen) > 2
    for found in seen:
        assert found.iterations == 0
        np.testing.assert_allclose(found.forces[:, 2], solution.forces[:, 2], rtol=1e-6, atol=1e-8)


def test_without_an_answer_nothing_is_measured():
    g = pinch(load=(0, 0, -1e3))
    e = g.explain(measure=True)
    assert e == g.explain()
    assert e.seconds is None


def line_of(explanation, title):
    """What is said of one effect, without line breaks."""
    lines = str(explanation).splitlines()
    first = next(k for k, line in enumerate(lines) if title in line)
    more = next((k for k in range(first + 1, len(lines)) if not lines[k].startswith("     ")), len(lines))
    return " ".join(" ".join(lines[first:more]).split())


def test_explain_measures_when_asked_and_says_so(monkeypatch):
    patches.shares_of_a_quarter(monkeypatch)
    g = loaded()
    assert all(line.share is None for line in g.explain().effects)
    e = g.explain(measure=True)
    assert e.seconds == 2.0
    assert {line.title: line.share for line in e.effects if line.on and line.title not in ALWAYS} == dict.fromkeys(
        (line.title for line in g.explain().effects if line.on and line.title not in ALWAYS), 0.25
    )
    assert {line.share for line in e.effects if not line.on or line.title in ALWAYS} == {None}
    says(str(e).splitlines()[-1], "2000000 µs")
    says(line_of(e, "soft wrist"), "25 %")
    assert g.explain().rcond is None, "nothing is eliminated on the cone"
    assert f"{1.0 / g.explain(8).rcond:.1e}" in str(g.explain(8))
