"""The script behind the README's figures, with a tiny budget."""

import importlib.util
import io
import pathlib

import numpy as np
import pytest
from rich.console import Console

from handlcp.scene import load

ENOUGH = 3600.0  # s, a budget that no busy machine spends
EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("accuracy_cost", EXAMPLES / "accuracy_cost.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_it_prints_its_tables_writes_its_pictures_and_measures_what_mechanics_asks_for(script, tmp_path):
    few = {"methods": ["cone, Newton", "Lemke"], "faces": [4, 8], "tolerances": [1e-9], "repeats": 1, "left_out": False}
    costs, path = (
        script.what_accuracy_costs(seconds=ENOUGH, **few),
        script.what_a_path_costs(accuracies=(1e-1, 1e-2), repeats=1),
    )
    said = io.StringIO()
    paths = script.write(costs, path, tmp_path, Console(file=said, width=100))
    assert [p.name for p in paths] == ["accuracy_cost.png", "path_cost.png"]
    assert all(p.stat().st_size > 20_000 for p in paths)
    (_, hand), (_, cube) = costs
    # Five fingers hold 0.3 kg alike; the hand hangs, so that +z is down
    frames = load(EXAMPLES / "ball_five_fingers.toml").build().frames
    down = np.einsum("ij,ij->i", frames[:, 2], np.array(hand.reference.forces))
    np.testing.assert_allclose(-down, 0.3 * 9.81 / 5, rtol=1e-3)
    # On the cube 8 inscribed faces give the forces of Table 6, which are not those on the cone
    exact, eight = np.array(cube.reference.forces), np.array([0.934263, 0.934263, 3.96422])
    assert dict(cube.pyramids())[8] * abs(exact).max() >= abs(exact[:, 2] - eight).max() > 0.02
    assert "Example 3" in said.getvalue()
