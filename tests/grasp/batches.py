"""Batches for the tests, and whether two of them have the same answers to the last bit."""

import pickle
from concurrent.futures import Executor, Future

import numpy as np

import handlcp as hl
from tests.grasp.scenes import cube_example, pinch, ring

QUICK = hl.Auto(search_seconds=0)


def mixture():
    """Held and not, planar and not, with and without friction and effects, of several sizes; one of them twice."""
    rng = np.random.default_rng(8)
    out = []
    for k in range(24):
        contacts, more = ring(rng, 2 + k % 4, mu=(0.6, 0.0, 0.2)[k % 3])
        out.append(hl.Grasp(contacts, **more))
    flat = [hl.Contact((-0.01, 0), (1, 0)), hl.Contact((0.01, 0.001), (-1, 0)), hl.Contact((0, -0.01), (0, 1))]
    out.append(hl.Grasp(flat, (0.2, -1.0, 0.001), flexibility=1e-4, preload=2e-4))
    bound = hl.TotalForceBound(5.0)
    out += [cube_example(), pinch(), pinch(load=(0, 0, -100.0)), pinch(effects=[bound]), out[0]]
    return out


def soft_and_anisotropic():
    """Scaled coordinates, moments, a free force: spatial grasps of four contacts."""
    laws = (hl.SoftFinger(0.5, 0.004), hl.AnisotropicCoulomb(0.7, 0.3), hl.Coulomb(0.6), hl.Frictionless())
    out = []
    for seed in range(4):
        contacts, more = ring(np.random.default_rng(seed))
        own = [hl.Contact(c.position, c.normal, law) for c, law in zip(contacts, laws, strict=True)]
        out.append(hl.Grasp(own, **more))
    contacts, more = ring(np.random.default_rng(1))
    out.append(hl.Grasp(contacts, **more, effects=[hl.PrescribedForce(0, (0.0, 0.0, 1.0))]))
    out.append(hl.Grasp(contacts, **(more | {"flexibility": 0.0, "preload": 0.0}), reference=(0.1, 0.0, 0.2)))
    return out


def hand_grasp(**more):
    """Five fingers around a ball."""
    hand = hl.example_hand("five_finger", joint_stiffness=5.0)
    ball = hl.Sphere(0.03, placement=(0, 0, 0.085), mass=0.2)
    return hand.at(hand.close_on(ball, squeeze=3e-3)).grasp(ball, **more)


def four():
    """Four fingers that hold their object under any small load."""
    contacts, more = ring(np.random.default_rng(0))
    return hl.Grasp(contacts, **more)


def sweep(grasp, count, strength=1.0, seed=0):
    """The grasp under other loads, some newtons away."""
    rng = np.random.default_rng(seed)
    size = strength * np.array([1, 1, 1, 0.015, 0.015, 0.015])
    return [grasp.replace(wrench=grasp.spec.wrench + size * pull) for pull in rng.normal(size=(count, 6))]


def assert_same_bits(a, b):
    """Two sequences of solutions say the same."""
    assert len(a) == len(b)
    for k in range(len(a)):
        one, two = a[k], b[k]
        assert type(one) is type(two)
        assert (one.status, one.trace, one.contact_state) == (two.status, two.trace, two.contact_state)
        assert (one.iterations, one.cause, one.diagnosis) == (two.iterations, two.cause, two.diagnosis)
        for name in ("forces", "forces_world", "gap", "slip", "object_displacement"):
            assert getattr(one, name).tobytes() == getattr(two, name).tobytes()
        assert repr(one.residuals) == repr(two.residuals)
        if hasattr(one, "torques"):
            assert one.torques.tobytes() == two.torques.tobytes()


class Later(Executor):
    """Runs what it is given at once, through pickles, as a cluster would, and counts it."""

    def __init__(self):
        self.sent = []

    def submit(self, run, /, *cargo):
        future = Future()
        self.sent.append(len(pickle.dumps((run, cargo))))
        run, cargo = pickle.loads(pickle.dumps((run, cargo)))
        future.set_result(pickle.loads(pickle.dumps(run(*cargo))))
        return future
