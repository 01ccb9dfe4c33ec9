"""What answers offer of pictures and data."""

import pytest

import handlcp as hl


@pytest.fixture(scope="module")
def solution():
    contacts = [hl.Contact((x, 0, 0), (-x, 0, 0), hl.SoftFinger(0.5, 0.01)) for x in (-1.0, 1.0)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3).solve()


def test_under_the_verdict_of_check_the_end_of_its_loading_is_drawn():
    """The labels' forces are those at the end: friction remembers the squeeze, and they differ from one solve's."""
    hand, can = hl.example_hand("three_finger", joint_stiffness=6.0), hl.Box(0.05, (0, 0, 0.08), mass=0.2)
    grasp = hand.at(hand.close_on(can)).grasp(can, hl.Coulomb(0.8), squeeze=5e-3, wrench=(1.0, 1.5, 0, 0, 0, 0))
    s, v = grasp.solve(), grasp.check()
    assert v.loading.reached

    def labels(solution):
        return {f"{normal:.3g} + " for normal in solution.normal_force}

    def told(figure):
        return " ".join(t.get_text() for t in [*figure.texts, *(t for ax in figure.axes for t in ax.texts)])

    one, end = told(s.plot()), told(s.plot(verdict=v))
    assert labels(s) != labels(v.loading.solution)
    assert all(label in one for label in labels(s))
    assert all(label in end for label in labels(v.loading.solution))
    assert "squeezed and loaded" in end
    assert "squeezed and loaded" not in one


def test_a_file_that_cannot_be_written_is_named(solution, tmp_path):
    with pytest.raises(hl.InputError, match="a file that can be written"):
        solution.to_json(tmp_path / "missing" / "grasp.json")
