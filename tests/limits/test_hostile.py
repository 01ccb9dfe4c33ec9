"""Load limits of scenes that nobody would draw: an answer that obeys its own laws, or an error that is typed."""

import numpy as np
import pytest

import handlcp as hl
from tests.support.limits import balanced
from tests.support.squeezed import cube
from tests.support.texts import says

KINDS = (
    "plain", "frictionless", "one", "gaps", "rigid", "small", "large", "soft", "anisotropic", "planar", "table",
    "stiff and weak",
)  # fmt: skip
SEEDS = {"soft": (1,), "table": (1,), "small": (0,), "rigid": (0,)}  # the others take seconds: loaded in steps
NEAR = 1e-6  # as closely as the ends of curves are found


def scene(kind, seed, length=1.0, force=1.0):
    """(grasp, load) in other units: lengths are multiplied by `length` and forces by `force`."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    flat = kind == "planar"
    n, dim = (1 if kind == "one" else int(rng.integers(2, 5))), 2 if flat else 3
    normals = rng.normal(size=(n, dim))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    if n > 1:
        normals[1] = -normals[0]
    tilted = normals + 0.1 * rng.normal(size=(n, dim))
    tilted /= np.linalg.norm(tilted, axis=1)[:, None]
    mu = 0.0 if kind == "frictionless" else rng.uniform(0.2, 1.0)
    law = hl.Coulomb(mu)
    if kind == "soft":
        law = hl.SoftFinger(mu, 0.005 * length, 3.0)
    elif kind == "anisotropic":
        law = hl.AnisotropicCoulomb(mu, 0.5 * mu)
    contacts = [hl.Contact(-0.03 * length * a, b, law) for a, b in zip(normals, tilted, strict=True)]
    A = rng.normal(size=(dim * n, dim * n))
    size = {"rigid": 0.0, "small": 1e-9, "large": 1e3}.get(kind, 1e-4)
    E = size * (A @ A.T / n + 0.1 * np.eye(dim * n))
    if kind == "stiff and weak":
        E[:dim] *= 1e-4
        E[:, :dim] *= 1e-4
    squeeze = rng.uniform(1.0, 10.0, n) * (size or 1e-4)
    if kind == "gaps":
        squeeze[0] = -3e-4
    around = None
    if kind == "table":
        at = [(x, y, -0.03) for x in (-0.02, 0.02) for y in (-0.02, 0.02)]
        feet = [hl.Contact(tuple(length * np.array(p)), (0, 0, 1), hl.Coulomb(0.5)) for p in at]
        around = hl.Environment(feet, flexibility=1e-5 * length / force)
    load = np.append(rng.normal(size=dim), 0.02 * rng.normal(size=1 if flat else 3))
    load[dim:] *= length
    E *= length / force
    return hl.Grasp(contacts, flexibility=E, preload=squeeze * length, environment=around), load * force


def limit(grasp, load, faces, length=1.0):
    """None where the scene is refused, by an error that is typed. A contact may slide 1e-3 in these units of length."""
    try:
        return grasp.load_limit(load, geometry="fixed", faces=faces, max_slip=1e-3 * length)
    except hl.HandLCPError:
        return None


# Gaps, with circular friction, take as long as all others together.
KINDS_AND_FACES = [
    pytest.param(kind, faces, marks=pytest.mark.long if (kind, faces) == ("gaps", "cone") else ())
    for kind in KINDS
    for faces in (6, "cone")
]


@pytest.mark.parametrize(("kind", "faces"), KINDS_AND_FACES)
def test_a_limit_obeys_its_own_laws(kind, faces):
    answered = 0
    for seed in SEEDS.get(kind, (0, 1)):
        grasp, load = scene(kind, seed)
        found = limit(grasp, load, faces)
        if found is None:
            continue
        answered += 1
        assert found.factor >= 0.0
        assert bool(found.binds) == np.isfinite(found.factor)
        assert found.why
        assert str(found)
        assert [e.factor for e in found.events] == sorted(e.factor for e in found.events)
        assert limit(grasp, 2.0 * load, faces).factor == pytest.approx(0.5 * found.factor, rel=NEAR)
        assert found.factor <= found.bound * (1.0 + 1e-6) + 1e-9
    assert answered, "a kind of scene that is never answered proves nothing"


@pytest.mark.parametrize(("kind", "faces"), KINDS_AND_FACES)
def test_less_than_a_limit_is_held_when_it_comes_in_steps_and_more_is_not(kind, faces):
    """Too low a limit fails the second, too high a one the first. That an object slides through is only seen once it
    has slid for a while.
    """
    for seed in SEEDS.get(kind, (0, 1)):
        grasp, load = scene(kind, seed)
        found = limit(grasp, load, faces)
        assert found is not None
        factor, load = found.factor, found.wrench
        less = 0.98 * factor if factor < np.inf else 3.0 * max([e.factor for e in found.events], default=1.0)
        if less > 0.0:
            end = grasp.follow(less * load, geometry="fixed", faces=faces, steps=12)
            assert end.reached
            assert balanced(end, less * load)
        if factor < np.inf:
            more = (1.02 if factor == found.lost else 1.3) * factor or 1e-3
            end = grasp.follow(more * load, geometry="fixed", faces=faces, steps=12)
            assert not (end.held and balanced(end, more * load))


@pytest.mark.parametrize("kind", ["plain", "planar", "table"])
@pytest.mark.parametrize(("length", "force"), [(1e3, 1.0), (1.0, 1e-3), (1e-3, 1e6)])
def test_units_of_length_and_force_change_no_factor(kind, length, force):
    for seed in SEEDS.get(kind, (0, 1)):
        one, other = limit(*scene(kind, seed), 6), limit(*scene(kind, seed, length, force), 6, length)
        assert other.factor == pytest.approx(one.factor, rel=NEAR)
        assert other.binds == one.binds


@pytest.mark.parametrize(
    "wrench", [np.zeros(6), np.full(6, np.nan), [np.inf, 0, 0, 0, 0, 0], [1.0, 2.0, 3.0], "down", 1.0]
)
def test_a_load_that_is_none_is_refused(wrench):
    grasp, _ = scene("plain", 0)
    with pytest.raises(hl.InputError, match="wrench"):
        grasp.load_limit(wrench)


def test_a_grasp_without_a_load_is_told_which_way_its_weight_acts():
    grasp = cube()
    with pytest.raises(hl.InputError) as caught:
        grasp.load_limit()
    says(str(caught.value), "wrench", "(0, 0, -1, 0, 0, 0)")
    with pytest.raises(hl.InputError) as caught:
        grasp.replace(mass=0).load_limit()
    says(str(caught.value), "wrench")


@pytest.mark.parametrize("given", [{"motion": 0.0}, {"motion": -1.0}, {"turn": np.nan}, {"geometry": "soft"}])
def test_what_is_no_tolerance_is_refused(given):
    grasp, load = scene("plain", 0)
    with pytest.raises(hl.InputError, match=next(iter(given))):
        grasp.load_limit(load, **given)
