"""What answers offer of pictures and data."""

import json

import pytest

import handlcp as hl


@pytest.fixture(scope="module")
def solution():
    contacts = [hl.Contact((x, 0, 0), (-x, 0, 0), hl.SoftFinger(0.5, 0.01)) for x in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3).solve()


def test_an_answer_draws_itself(solution, tmp_path):
    assert solution.plot(title="two fingers").axes
    assert solution.plot(tmp_path / "grasp.png").read_bytes().startswith(b"\x89PNG")


def test_an_answer_is_plain_data_that_json_brings_back(solution, tmp_path):
    found = solution.to_dict()
    assert found["contacts"][0]["force_N"] == pytest.approx(list(solution.forces[0]))
    assert json.loads(solution.to_json()) == found
    assert json.loads(solution.to_json(tmp_path / "grasp.json").read_text(encoding="utf-8")) == found


def test_everything_that_is_found_is_plain_data():
    contacts = [hl.Contact((0.02 * x, 0, 0), (-x, 0, 0), hl.Coulomb(0.5)) for x in (-1.0, 1.0)]
    grasp = hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3)
    for found in (
        grasp.check(), grasp.follow(steps=2), grasp.equilibria(faces=4), grasp.explain(), grasp.suggest(),
        grasp.required_friction(tolerance=0.1),
    ):  # fmt: skip
        assert json.loads(found.to_json()), type(found).__name__
    assert grasp.check().loading.reached
    assert grasp.follow(steps=2).to_dict()["reached"] is True
    assert len(grasp.equilibria(faces=4).to_dict()["found"]) == len(grasp.equilibria(faces=4))


def test_a_file_that_cannot_be_written_is_named(solution, tmp_path):
    with pytest.raises(hl.InputError, match="a file that can be written"):
        solution.to_json(tmp_path / "missing" / "grasp.json")
