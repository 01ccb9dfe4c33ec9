"""What would help is worked out when somebody asks; without proofs a solve stops at "not found"."""

import pytest

import handlcp as hl
from tests.grasp.scenes import pinch
from tests.support.patches import advice_is_watched


def test_a_no_asks_for_its_squeeze_when_it_is_read(monkeypatch):
    asked = advice_is_watched(monkeypatch)
    g = pinch(squeeze=0.0)
    s = g.solve(throw=False)
    with pytest.raises(hl.NoSolutionFound) as caught:
        g.solve()
    assert s.status is hl.Status.NO_EQUILIBRIUM
    assert not asked
    assert "would hold it" in s.diagnosis
    assert "would hold it" in str(caught.value)
    assert len(asked) == 2
    assert g.replace(preload=1.01 * s.required_preload).solve().held
    assert len(asked) == 2, "kept once it is known"


def test_a_batch_asks_for_no_advice_and_its_solutions_know_where_to_ask(monkeypatch):
    asked = advice_is_watched(monkeypatch)
    solutions = hl.solve_many([pinch(squeeze=0.0)] * 3)
    assert solutions.statuses == (hl.Status.NO_EQUILIBRIUM,) * 3
    assert not asked
    least = pinch(squeeze=0.0).required_preload().value
    assert (1 - 1e-9) * least <= solutions[1].required_preload <= 1.1 * least, "rounded up to two digits"


@pytest.mark.parametrize("faces", [8, "cone"])
def test_without_proof_a_solve_stops_at_not_found(faces):
    missing = pinch(squeeze=0.0)
    s = missing.solve(faces, throw=False, proof=False)
    assert s.status is hl.Status.UNDECIDED
    assert len(s.trace) == 2, "the first stage, and whether anything could hold it"
    assert s.required_preload is None
    prop = hl.Grasp([hl.Contact((0, 0, 0), (0, 0, 1), hl.Coulomb(0.5))], (0, 0, 5.0, 0, 0, 0), flexibility=1e-4)
    assert prop.solve(faces, throw=False, proof=False).status is hl.Status.NOT_HOLDABLE
    assert pinch().solve(faces, proof=False).held


def test_without_proof_an_accuracy_asks_for_none_either():
    s = pinch(squeeze=0.0).solve(accuracy=1e-3, throw=False, proof=False)
    assert s.status is hl.Status.UNDECIDED
    assert not any(line.startswith("search") for line in s.trace)


def test_proof_is_asked_for_or_not():
    for bad in ("no", 1, None):
        with pytest.raises(hl.InputError, match="proof"):
            pinch().solve(proof=bad)
