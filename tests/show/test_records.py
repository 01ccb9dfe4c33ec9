"""Records, every class of them: plain data that JSON brings back, with shapes and units as they are described."""

import builtins
import json
import sys
import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import handlcp as hl
from handlcp.record import to_plain
from handlcp.simulator import compare, simulate_limit
from handlcp.studies.accuracy import accuracy_cost
from handlcp.studies.paper import run
from tests.design import optima
from tests.design.hands import pinch as levers
from tests.hand.conftest import MIMIC
from tests.support.published import gripper
from tests.support.records import described, doc_of, kinds, within

BOX = hl.Box(0.05, (0, 0, 0.08), mass=0.2)
PUSH = (1.0, 0, 0, 0, 0, 0)
CONTRACT = tomllib.loads(Path(__file__).with_name("records.toml").read_text(encoding="utf-8"))
ONE_BY_ONE = ("Sensitivity", "Solutions")  # their dictionaries are made of what was asked for


@cache
def pinch(law=None, squeeze=1e-3):
    """Two points that press on an object along x, and have no hand."""
    law = hl.Coulomb(0.5) if law is None else law
    contacts = [hl.Contact((s * 0.02, 0, 0), (-s, 0, 0), law) for s in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=squeeze)


@cache
def hand(**more):
    return hl.example_hand("three_finger", **({"joint_stiffness": 6.0} | more))


@cache
def held(**more):
    """A cube in a hand."""
    return hand().at(hand().close_on(BOX)).grasp(BOX, hl.Coulomb(0.8), squeeze=5e-3, **more)


def pulled_by_tendons():
    names = hand().joint_names
    tendons = hl.Tendons({f"tendon {k}": {name: 0.01} for k, name in enumerate(names)}, 1e3, 6.0)
    loose = hand(joint_stiffness=tendons)
    return loose.at(hand().close_on(BOX)).grasp(BOX, hl.Coulomb(0.8), squeeze=5e-3).solve()


def motors():
    with TemporaryDirectory() as folder:
        return levers(Path(folder)).required_torque({"down": PUSH, "up": PUSH})


def lifted():
    with TemporaryDirectory() as folder:
        return hl.lift_and_shake(gripper(Path(folder), 10.0), 1.0, 0.08, friction=0.5, tries=4)


def simulated(make):
    pytest.importorskip("mujoco")
    return make()


EXAMPLES = {
    "GraspSolution Accuracy": lambda: pinch().solve(accuracy=1e-6),
    "HandGraspSolution TorqueCheck": lambda: held().solve(),
    "HandGraspSolution Effort, of tendons": pulled_by_tendons,
    "GraspSolution, not held": lambda: pinch(squeeze=0.0).solve(throw=False),
    "MeasuredStiffness": lambda: hl.stiffness_from([0.0, 0.1, 0.21, 0.3], [0.0, 0.5, 1.0, 1.5]),
    "Verdict": lambda: held().check(),
    "Loading Event Summary": lambda: held().follow((20.0, 0, 0, 0, 0, 0), steps=2),
    "Loading, of points": lambda: pinch().follow(steps=2),
    "Equilibria": lambda: pinch().equilibria(faces=4),
    "Explanation": lambda: held().explain(),
    "Suggestions": lambda: held().suggest(),
    "Required": lambda: pinch(squeeze=0.0).required_preload(tolerance=0.5),
    "LoadLimit LimitEvent Reached FailureMode": lambda: held().load_limit(PUSH, geometry="fixed"),
    "LoadLimit, of points": lambda: pinch().load_limit(PUSH),
    "Margins Least Closure WrenchSpace": lambda: held(wrench=PUSH).margins(),
    "RequiredStiffness": lambda: held().required_stiffness(2e-3, tolerance=0.5),
    "BestChange TriedChange": lambda: pinch().best_change(),
    "RequiredTorque": motors,
    "ForceBounds": lambda: held().solve().force_bounds(pads=(0.5, 2.0)),
    "ForceBounds, of points": lambda: pinch().solve().force_bounds(),
    "Sensitivity": lambda: held().solve().sensitivity(),
    "Slopes": lambda: hl.slopes(held(), ["finger_1_tip.pad"]),
    "Solutions": lambda: hl.solve_many([pinch(), pinch(squeeze=0.0)]),
    "Audit": lambda: hand().audit(),
    "HandDescription": lambda: hand().describe(),
    "HandDescription, of joints that follow": lambda: hl.describe_urdf(MIMIC),
    "Found Candidate": lambda: hl.find_grasp(hand(), hl.Sphere(0.03, mass=0.1), friction=0.8, tries=2),
    "Reliability Sample": lambda: hl.reliability(pinch(), {"friction": 0.2, "load": 0.1}, 64, workers=1),
    "Envelope": lambda: hl.envelope(held(), directions=6, geometry="fixed", faces=8),
    "Payload Orientation": lambda: held().payload(geometry="fixed", faces=8),
    "SplitCylinder Grip": lambda: hl.split_cylinder(hand(), 0.05, grasps=["pinch"]),
    "FingerStrength FingerForce": lambda: hl.finger_strength(hand()),
    "SlipResistance": lambda: hl.slip_resistance(pinch(), (0, 0, 1)),
    "LiftAndShake ShakenObject": lifted,
    "Evaluation ObjectCase": lambda: hl.evaluate(hand(), hl.Brief({"ball": hl.Sphere(0.03, mass=0.1)}, tries=2)),
    "Best Kink": lambda: replace(optima.run(budget=2), kinks=(hl.Kink("force", "payload by force …", 1.0, 2.0),)),
    "Envelope, of wrenches": lambda: hl.envelope(pinch(), np.eye(6)),
    "AccuracyCost": lambda: accuracy_cost(
        pinch(), methods=["NSNGRK polished"], faces=[8], tolerances=[1e-9], left_out=False, repeats=1
    ),
    "PathCost PathRow": lambda: hl.path_cost(pinch(), accuracies=(1e-1, 1e-2), repeats=1),
    "PaperReport": run,
    "Comparison Simulation": lambda: simulated(lambda: compare(held(), None, "together", steps=2, seconds=0.2)),
    "SimulatedLimit LimitTrack": lambda: simulated(lambda: simulate_limit(held(), PUSH, 1.0, seconds=0.2, settle=0.05)),
}  # fmt: skip


def names_in(what):
    """The records of an example, as its key names them: those before the comma."""
    return what.partition(",")[0].split()


@pytest.fixture(scope="module", params=EXAMPLES)
def example(request):
    """(what it is, names of the records in it, the example)."""
    return request.param, names_in(request.param), EXAMPLES[request.param]()


def test_there_is_an_example_of_every_record():
    assert {name for what in EXAMPLES for name in names_in(what)} == kinds()


def test_a_record_is_plain_data_that_json_brings_back(example):
    what, names, found = example
    assert type(found).__name__ == names[0]
    told = found.to_dict()
    assert names[0] == "Solutions" or to_plain(told) == told
    assert json.loads(found.to_json()) == to_plain(told)
    assert not [v for v in found.to_row().values() if isinstance(v, dict)]
    assert ", ".join(told) == CONTRACT["keys"][what]


def test_tables_have_the_columns_that_they_had(example):
    what, names, found = example
    if not hasattr(found, "to_frame") or names[0] == "Sensitivity":
        pytest.skip("it is no table, or one of each derivative")
    pytest.importorskip("pandas")
    assert ", ".join(found.to_frame()) == CONTRACT["columns"][what]


def test_what_is_in_a_record_has_the_shape_and_the_unit_that_it_is_described_with(example):
    _, names, found = example
    every = list(within(found))
    assert {type(r).__name__ for r in every} >= set(names) or names[0] in ONE_BY_ONE
    for record in every:
        counts = {}
        for one, value in described(record):
            where = f"{type(record).__name__}: {one.key}"
            if value is not None and one.shape and one.shape != ("twist",):
                shape = np.shape(value)
                assert len(shape) == len(one.shape), where
                for letter, size in zip(one.shape, shape, strict=True):
                    assert counts.setdefault(letter, int(letter) if letter.isdigit() else size) == size, where
            if one.key.endswith(getattr(record, "held_as", "…")):  # of an envelope, whose factors may be anything
                assert one.unit == record.unit, where
            elif one.unit and "." not in one.path:
                assert all(unit in doc_of(record, one.path) for unit in one.unit.split(", ")), where


# ---------------------------------------------------------------- tables
def test_a_solution_is_a_table_of_its_contacts_and_one_of_its_joints():
    pytest.importorskip("pandas")
    s = held().solve()
    contacts, joints = s.to_frame(), s.to_frame("joints")
    assert contacts.index.tolist() == list(s.names)
    np.testing.assert_array_equal(contacts[["x_N", "y_N", "z_N"]], s.forces)
    np.testing.assert_array_equal(contacts["friction_used"], s.friction_used)
    assert contacts["state"].tolist() == list(s.contact_state)
    assert joints.index.tolist() == list(hand().joint_names)
    np.testing.assert_array_equal(joints["torque_Nm"], s.torques)
    np.testing.assert_array_equal(joints["margin_Nm"], s.torque_margin)
    loading = held().follow(steps=4)
    steps = loading.to_frame()
    np.testing.assert_array_equal(steps["finger_1_tip.force_z"], loading.steps.forces[:, 0, 2])
    np.testing.assert_array_equal(steps["finger_1_distal.torque"], loading.steps.torques[:, 1])
    many = hl.solve_many([pinch(), pinch(squeeze=0.0)])
    np.testing.assert_array_equal(many.to_frame()["finger 1.force_z"], many.forces[:, 0, 2])


def test_without_pandas_the_extra_is_named(monkeypatch):
    pytest.importorskip("pandas")
    s, real = pinch().solve(), builtins.__import__

    def hidden(name, *rest, **more):
        if name.partition(".")[0] == "pandas":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.delitem(sys.modules, "pandas")
    monkeypatch.setattr(builtins, "__import__", hidden)
    with pytest.raises(hl.Unsupported, match=r"pip install .pandas"):
        s.to_frame()
