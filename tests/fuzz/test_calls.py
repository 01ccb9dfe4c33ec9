"""Whatever is passed to a public function, constructor or method: an answer, or a HandLCPError that says what is wrong.

`python -m tests.fuzz.calls 2500` makes ten times as many calls, and prints what they come to.
"""

import inspect

import pytest

import handlcp as hl
from tests.fuzz.calls import fuzz, run, trials
from tests.fuzz.public_calls import GIVEN, MADE_BY_USERS, calls
from tests.fuzz.public_objects import MADE, TIP, URDF

SEED, MANY = 0, 250
# Their objects take a second or more to make, or to be called; the command calls them, too
SLOW = {
    "lift_and_shake", "optimise", "split_cylinder", "SplitCylinder", "sweep", "report", "Best", "Study",
    "RequiredTorque", "Candidate", "Evaluation", "GraspStream", "GraspUpdate", "PathCost", "path_cost", "Mesh",
}  # fmt: skip


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """Values of calls are files, too: they are written where the test runs."""
    monkeypatch.chdir(tmp_path)


def hand(**more):
    return hl.Hand.from_urdf(URDF, TIP, **({"joint_stiffness": 1.0} | more))


def test_no_public_name_is_left_out():
    for call in calls():
        kind, _, method = call.name.partition(".")
        if method and kind not in MADE:  # nothing to call it of, but for what makes one
            assert isinstance(inspect.getattr_static(getattr(hl, kind), method), (classmethod, staticmethod)), call.name
        assert set(call.given()) <= {p.name for p in call.parameters}, call.name
    named = {call.name for call in calls()}
    assert named >= set(GIVEN)
    assert named >= {name for name in hl.__all__ if not inspect.isclass(getattr(hl, name))}
    assert named >= MADE_BY_USERS


def test_wrong_values_end_with_an_error_that_says_so():
    few = [trial for trial in trials() if trial.call.name.partition(".")[0] not in SLOW]
    found = fuzz(MANY, SEED, among=few)
    assert [f"{one.trial}: {one.word} {one.why}" for one in found if one.word in ("untyped", "silent")] == []
    assert sum(one.word == "typed" for one in found) > MANY / 2


@pytest.mark.parametrize("call", ["Grasp.solve", "Brief", "find_grasp", "HandState.grasp", "Record.to_json", "Motor"])
def test_an_unknown_keyword_is_an_input_error_and_a_type_error(call):
    """The same of functions, constructors and methods, their own and those of their bases."""
    of = {"Record.to_json": "Accuracy.to_json"}.get(call, call)
    outcome = run(next(t for t in trials() if t.call.name == of and t.kind == "unknown"))
    assert outcome.word == "typed"
    assert "takes no 'no_such_keyword'" in outcome.why
    with pytest.raises(TypeError, match=r"^Motor\(\) takes no 'continous'; did you mean 'continuous'\?$") as refused:
        hl.Motor(continous=1.0)
    assert isinstance(refused.value, hl.InputError)
    assert refused.value.argument == "continous"


def test_a_class_is_no_function_and_lists_are_no_names():
    hand = hl.example_hand("three_finger")
    grasp = hand.at((hand.lower + hand.upper) / 2).grasp(hl.Sphere(0.03), max_gap=1.0)
    with pytest.raises(hl.InputError, match=r"^progress: "):
        hl.envelope(grasp, progress=float)
    with pytest.raises(hl.InputError, match=r"^names: "):
        hl.slopes(grasp, [[1, [2, 3]]])


def test_words_of_other_books_lead_to_ours():
    hand = hl.example_hand("three_finger")
    state = hand.at((hand.lower + hand.upper) / 2)
    with pytest.raises(hl.InputError, match="did you mean 'friction'"):
        state.grasp(hl.Sphere(0.03), mu=0.5)
    ends = [hl.Contact((x, 0, 0), (-x / 0.02, 0, 0), 0.6) for x in (-0.02, 0.02)]
    grasp = hl.Grasp(ends, flexibility=1e-4)
    with pytest.raises(hl.InputError, match=r"required_grip\(most_force=\.\.\.\)"):
        grasp.check(most_force=3.0)


def test_too_few_and_too_many_arguments_are_named():
    with pytest.raises(hl.InputError, match="missing a required argument: 'objects'"):
        hl.Brief()
    with pytest.raises(hl.InputError, match=r"Coulomb\(\): too many positional arguments; it takes mu"):
        hl.Coulomb(0.5, 0.3)


def test_what_a_function_raises_itself_is_not_taken_for_a_wrong_call():
    def progress(done, total):
        raise TypeError("of the user's own")

    contacts = [hl.Contact((x, 0, 0), (-x, 0, 0)) for x in (-1.0, 1.0)]
    grasp = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    with pytest.raises(TypeError, match="of the user's own") as raised:
        hl.solve_many([grasp], progress=progress)
    assert not isinstance(raised.value, hl.InputError)


def test_signatures_stay_as_they_are_written():
    assert list(inspect.signature(hl.Coulomb).parameters) == ["mu"]
    assert "contacts" in inspect.signature(hl.Grasp).parameters
    assert list(inspect.signature(hl.Grasp.plan).parameters) == ["self", "faces", "chain"]
    assert inspect.signature(hl.find_grasp).parameters["tries"].default == 256


NAN = float("nan")
ACCEPTED_BEFORE = {
    "a stage's joint offset": (lambda: hl.Stage("push", joint_offset=[NAN]), "Stage.joint_offset"),
    "a stage's load": (lambda: hl.Stage("push", load=[True] * 6), "Stage.load"),
    "a stage's weight": (lambda: hl.Stage("push", weight="1"), "Stage.weight"),
    "friction of tendons": (lambda: hl.Tendons({"a": {"turn": 0.01}}, 1e3, friction=True), "Tendons.friction"),
    "springs beside tendons": (lambda: hl.Tendons({"a": {"turn": 0.01}}, 1e3, passive="1"), "Tendons.passive"),
    "springs of synergies": (lambda: hl.Synergies({"a": {"turn": 1.0}}, 1.0, NAN), "Synergies.joint_stiffness"),
    "a posture of springs": (lambda: hand().posed("nan"), "q"),
    "how many times as stiff": (lambda: hand().scale_stiffness(NAN), "factor"),
    "a fingertip's number": (lambda: hand().tip_kind(True), "tip"),
    "torque of a motor": (lambda: hl.Motor(1.0).share(True), "torque"),
    "a coefficient": (lambda: hl.SoftFinger(0.5, 0.003).with_mu(NAN), "mu"),
    "a number in an array": (lambda: hl.Coulomb(hl.grasp.Pyramid(8).limit(["a"])), "mu"),
    "a flag": (lambda: hl.solve_lcp(hl.LCP([[1.0]], [-1.0]), throw="no"), "throw"),
    "a solution": (lambda: hand().at([0.0]).jacobian_at([[0.0, 0.0]], (0,)), "points"),
}  # fmt: skip


@pytest.mark.parametrize("what", ACCEPTED_BEFORE)
def test_what_is_no_number_is_not_taken_for_one(what):
    call, argument = ACCEPTED_BEFORE[what]
    with pytest.raises(hl.InputError) as refused:
        call()
    assert refused.value.argument.startswith(argument)
