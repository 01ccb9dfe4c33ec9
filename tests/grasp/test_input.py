"""Bad input gives one typed error that names the argument, what was expected and what came."""

import pickle

import numpy as np
import pytest

import handlcp as hl
from tests.grasp.scenes import pinch
from tests.support.grasp import load_about
from tests.support.texts import says

P, N = (0, 0, 0), (0, 0, 1)
TWO = [hl.Contact((0, 0, 0), (0, 0, 1)), hl.Contact((0, 0, 1), (0, 0, -1))]
NAN = float("nan")


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (dict(position=(0, 0), normal=N), "normal"),
        (dict(position=(0, 0, 0, 0), normal=N), "position"),
        (dict(position=(0, NAN, 0), normal=N), "position"),
        (dict(position="here", normal=N), "position"),
        (dict(position=P, normal=(0, 0, 2)), "normal"),
        (dict(position=P, normal=(0, 0, 0)), "normal"),
        (dict(position=P, normal=(0, 0, NAN)), "normal"),
        (dict(position=P, normal=N, tangent=(0, 0, 3)), "tangent"),
        (dict(position=P, normal=N, tangent=(0, 0, 0)), "tangent"),
        (dict(position=P, normal=N, tangent=(1, 0)), "tangent"),
        (dict(position=P, normal=N, friction=-0.5), "friction"),
        (dict(position=P, normal=N, friction="rubber"), "friction"),
        (dict(position=P, normal=N, name=3), "name")
    ]
)  # fmt: skip
def test_contacts(arguments, name):
    with pytest.raises(hl.InputError) as e:
        hl.Contact(**arguments)
    assert e.value.argument == name


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (dict(contacts=[]), "contacts"),
        (dict(contacts=3), "contacts"),
        (dict(contacts=[1, 2]), "contacts[0]"),
        (dict(contacts=[TWO[0], hl.Contact((0, 0), (0, 1))]), "contacts"),
        (dict(wrench=(1, 2, 3)), "wrench"),
        (dict(wrench=(1, 2, 3, 4, 5, NAN)), "wrench"),
        (dict(flexibility=-1e-4), "flexibility"),
        (dict(flexibility=NAN), "flexibility"),
        (dict(flexibility=(1e-4, 1e-4, -1e-4)), "flexibility"),
        (dict(flexibility=np.eye(5)), "flexibility"),
        (dict(flexibility=-np.eye(6)), "flexibility"),
        (dict(flexibility=np.triu(np.ones((6, 6)))), "flexibility"),
        (dict(flexibility=np.array([np.eye(3), -np.eye(3)])), "flexibility[1]"),
        (dict(preload=NAN), "preload"),
        (dict(preload=(1, 2, 3)), "preload"),
        (dict(preload=[1, [2, 3]]), "preload"),
        (dict(flexibility=[1, [2, 3]]), "flexibility"),
        (dict(offset=(0, 0, 0)), "offset"),
        (dict(reference=(0, 0)), "reference"),
        (dict(effects=[3]), "effects[0]"),
        (dict(effects=[hl.TotalForceBound(1), hl.TotalForceBound(2)]), "effects[1]"),
        (dict(effects=[hl.PrescribedForce(2, (0, 0, 1))]), "effects[0].contact"),
        (dict(plane=(1, 0)), "plane"),
        (dict(plane=(0, 0, 1)), "plane"),
        (dict(plane=(2, 0, 0)), "plane"),
        (dict(plane=(1, 0, 0), wrench=(1, 0, 0, 0, 0, 0)), "wrench"),
        (dict(plane=(1, 0, 0), wrench=(1, 0, 0)), "wrench")
    ]
)  # fmt: skip
def test_grasps(change, name):
    good = dict(contacts=TWO, wrench=(0, 0, -1, 0, 0, 0), flexibility=1e-4)
    with pytest.raises(hl.InputError) as e:
        hl.Grasp(**(good | change))
    assert e.value.argument == name


def test_forces_above_the_reference_turn_about_it():
    """Lifted by h along the normal a, a force f has the moment h a × f."""
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    np.testing.assert_allclose(load_about((2, 3, 4), z, 0.1), (2, 3, 0, -0.3, 0.2, 4))
    np.testing.assert_allclose(load_about((2, 3, 4), -z, -0.1), (2, 3, 0, -0.3, 0.2, -4))
    load_about((0, 2, 3, 7, -0.3, 0.2), x, 0.1)
    for wrong in [(0, 2, 3, 7, 0, 0), (0, 2, 3, 7, 0.3, -0.2)]:
        with pytest.raises(hl.InputError) as caught:
            load_about(wrong, x, 0.1)
        assert caught.value.argument == "wrench"
        says(caught.value.expected, "0.1 m")


ONES, NOTHING = np.ones((3, 2)), np.zeros((1, 3, 3))


@pytest.mark.parametrize(
    ("make", "values", "named"),
    [
        (hl.Coulomb, [(-0.1,), (NAN,), (float("inf"),), ("0.5",), (None,), (True,)], r"Coulomb\.mu"),
        (lambda faces: pinch().solve(faces), [(2,), (0,), (-8,), (8.0,), ("eight",), (True,)], "faces"),
        (hl.TotalForceBound, [(0,), (-1,), (NAN,), ("x",)], "TotalForceBound"),
        (hl.FingerForceBound, [(0.0,), (-1.0,), (NAN,), ("a",), (None,)], r"FingerForceBound\.limits"),
        (hl.FingerForceBound, [([1.0, 0.0],), ([1.0, "a"],), ([[1.0]],)], r"FingerForceBound\.limits"),
        (hl.PrescribedForce, [(-1, N), (0, (0, 1)), (0.5, N), (0, (0, 0, NAN))], "PrescribedForce"),
        (hl.SoftFinger, [(-0.1, 0.1), (0.0, 0.1)], "mu"),
        (hl.SoftFinger, [(0.5, NAN)], "mu_torsion"),
        (hl.SoftFinger, [(0.5, 0.1, -1.0)], "torsional_flexibility"),
        (hl.KnownForce, [(0, (None, None, None))], r"KnownForce\.force"),
        (hl.KnownForce, [(0, (None, None, -1.0))], r"KnownForce\.force\[2\]"),
        (hl.KnownForce, [(0, (1.0, NAN, None))], r"KnownForce\.force\[1\]"),
        (hl.KnownForce, [(-1, (1.0, None, None))], r"KnownForce\.contact"),
        (hl.Flexibility, [(np.ones((4, 2)), np.eye(2), NOTHING)], "Flexibility.jacobian"),
        (hl.Flexibility, [(np.full((3, 2), NAN), np.eye(2), NOTHING)], "Flexibility.jacobian"),
        (hl.Flexibility, [(ONES, np.eye(3), NOTHING)], "Flexibility.root"),
        (hl.Flexibility, [(ONES, np.eye(2), np.zeros((2, 3, 3))), (ONES, np.eye(2), NOTHING - 1)], "Flexibility.pads"),
    ],
)
def test_what_laws_effects_and_flexibilities_refuse(make, values, named):
    for value in values:
        with pytest.raises(hl.InputError, match=named):
            make(*value)


def test_a_solver_that_knows_no_cones_says_so():
    with pytest.raises(hl.Unsupported) as caught:
        pinch().solve("cone", hl.Lemke())
    says(str(caught.value), "Lemke")


def test_results_and_contacts_are_read_only():
    s = pinch().solve()
    for a in (s.forces, s.forces_world, s.gap, s.slip, s.object_displacement, TWO[0].position, TWO[0].rotation):
        with pytest.raises(ValueError, match="read-only"):
            a[0] = 1


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 0.6, 0.8), (0.48, 0.6, 0.64)])
def test_frames_are_right_handed_with_the_normal_last(normal):
    R = hl.Contact(P, normal).rotation
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(np.cross(R[:, 2], R[:, 0]), R[:, 1], atol=1e-15)
    np.testing.assert_allclose(R[:, 2], normal)


HUGE = 10**400


@pytest.mark.parametrize(
    "make",
    [
        lambda: hl.Coulomb(HUGE),
        lambda: hl.Box(HUGE),
        lambda: hl.Contact((HUGE, 0, 0), N),
        lambda: hl.Contact(np.array([1 + 1j, 0, 0]), N),
        lambda: hl.Contact(("0", "0", "0"), N),
        lambda: hl.Contact((1e200, 0, 0), N),
        lambda: pinch(squeeze=1e200),
        lambda: pinch(load=(0, 0, 1e308)),
        lambda: pinch(flexibility=1e308),
        lambda: hl.Grasp(np.array(1.0)),
        lambda: hl.Grasp(TWO, effects=np.array(1.0)),
        lambda: pinch().solve(99999999999),
        lambda: pinch().solve(HUGE),
        lambda: hl.LCP([[HUGE]], [1]),
        lambda: hl.LCP(np.eye(1), [1], units=0),
        lambda: hl.Lemke(max_iterations="x"),
        lambda: hl.Lemke(seed=-1),
        lambda: hl.NSNGRK(polish="x"),
        lambda: hl.SemismoothNewton(max_iterations=1e308),
    ],
)
def test_what_no_float_or_memory_can_hold_is_refused(make):
    with pytest.raises(hl.InputError):
        make()


@pytest.mark.parametrize("size", [1e-60, 1e-30, 1e30, 1e60])
def test_extreme_numbers_end_in_an_answer_or_not_but_never_in_a_warning(size):
    for more in ({"squeeze": size}, {"load": (0, 0, -size)}, {"flexibility": size}, {"mu": size}):
        s = pinch(**more).solve(throw=False)
        assert not s.held or np.isfinite(s.forces).all()


@pytest.mark.parametrize("name", ["positions", "frames", "wrench", "reference", "flexibility", "offset"])
def test_a_specification_refuses_arrays_that_do_not_fit_its_contacts(name):
    spec = hl.Grasp([hl.Contact((x, 0, 0), (-x, 0, 0)) for x in (-1, 1)], flexibility=1e-4).spec
    with pytest.raises(hl.InputError, match=rf"GraspSpec\.{name}: expected shape .* with 2 contacts"):
        spec.replace(**{name: np.zeros((1, 7))})


@pytest.mark.parametrize(
    "more", [{"wrench": np.zeros(6)}, {"effects": [hl.TotalForceBound(1.0)]}, {"plane": (0, 0, 1)}]
)
def test_nothing_stands_beside_a_specification(more):
    grasp = hl.Grasp([hl.Contact((x, 0, 0), (-x, 0, 0)) for x in (-1, 1)], flexibility=1e-4)
    with pytest.raises(hl.InputError, match="a GraspSpec, which says all"):
        hl.Grasp(grasp.spec, **more)


@pytest.mark.parametrize(
    "error",
    [
        hl.InputError("friction", "a number", "abc"),
        hl.UnknownName("joint", "a joint", ["thumb"], ["thumb_1"]),
        hl.NotReached("target", "fingers that touch", {"index": 0.01}),
        hl.RequirementNotMet(["payload 1 kg, 2 kg asked for"]),
        hl.NoGraspFound("none", {"sampled": 3}),
        hl.Unsupported("known forces"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_comes_out_of_another_process_as_it_was(error):
    copy = pickle.loads(pickle.dumps(error))
    assert (type(copy), str(copy), vars(copy)) == (type(error), str(error), vars(error))
