"""An effect, a friction law, a parameter and a solver are each one class: those of this file are in use at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

import handlcp as hl
from handlcp.grasp import Effect, FileKey, FrictionLaw, GraspSpec, Limit, Parameter, Shown, Trial, effect_kinds
from handlcp.lcp import Proposal
from handlcp.scene import read
from tests.support.registry import definitions_of_a_test
from tests.support.scene_texts import TWO_CONTACTS

MU, SQUEEZE, SOFTNESS, THICK = 0.5, 2e-3, 1e-4, 2e-3

PINCH = f"""{TWO_CONTACTS}
[grasp]
friction = FRICTION
flexibility_m_per_N = 1e-4
preload_m = 2e-3
[load]
force_N = [0.0, 0.0, -1.0]
"""


@pytest.fixture(scope="module")
def own() -> Iterator[Any]:
    """The classes, defined as a user would define them, and forgotten after the tests of this file."""
    with definitions_of_a_test():

        @dataclass(frozen=True)
        class PairBound(Effect):
            """The two jaws of a parallel gripper share one motor: the sum of the first two normal forces is bounded."""

            most: float

            title = "force bound of a pair"
            equation = "0 ≤ s ⟂ most - r_N,0 - r_N,1 ≥ 0"
            when = "One motor drives two jaws."
            in_python = "effects=[PairBound(20.0)]"
            in_file = "effects.pair_bound_N = 20.0"
            brings = "1"
            source = "closed form in this file"
            file_key = FileKey("pair_bound_N", float, "a number > 0", "the most that two jaws push together")

            def why(self, scene: Any) -> str:
                return f"asked for: {self.most:g} N"

            def limits(self, scene: Any) -> tuple[Limit, ...]:
                rows = np.zeros((1, scene.components))
                rows[0, [2, 5]] = 1.0
                return (Limit("pair", rows, np.array([self.most])),)

        @dataclass(frozen=True)
        class Ribbed(FrictionLaw):
            """Ribs along y: half as much friction across them as along x."""

            mu: float

            call: ClassVar[str] = "Ribbed(mu)"
            file_keys: ClassVar[Any] = ({"mu_of_ribs": "mu"}, {})

            @property
            def scale(self) -> tuple[float, float]:
                return 1.0, 0.5

            def with_mu(self, mu: float) -> Ribbed:
                return Ribbed(mu)

        class RubberThickness(Parameter):
            """(1,) [m] of the rubber on the jaws, to which their flexibility is proportional."""

            name, spread, step = "rubber_thickness", "rubber_thickness", 1e-8

            def shape(self, spec: GraspSpec) -> tuple[int, ...]:
                return (1,)

            def values(self, spec: GraspSpec) -> Any:
                return np.array([THICK])

            def varied(self, spec: GraspSpec, k: int, step: float) -> GraspSpec:
                return spec.replace(flexibility=spec.flexibility * (1.0 + step / THICK))

            def shown(self, answer: Any) -> Shown:
                return Shown("rubber +10 %", [("both jaws", 0.1 * self.values(answer.spec))])

            def shares(self, spec: GraspSpec, share: float) -> Iterator[tuple[str, GraspSpec | None]]:
                yield "thinner rubber", self.scaled(spec, 1.0 - share)

            def trials(self, spec: GraspSpec, why: str) -> Iterator[Trial]:
                for factor in (0.5, 0.25, 0.1) if why == "forces" else ():
                    made = self.scaled(spec, factor)
                    assert made is not None
                    yield Trial("rubber", factor, f"rubber {factor:g} × as thick", made)

        yield SimpleNamespace(PairBound=PairBound, Ribbed=Ribbed, RubberThickness=RubberThickness)


class TryAll:
    """Every active set, one after the other."""

    def propose(self, problem: Any, start: Any = None) -> Proposal:
        M, q, free = problem.M, problem.q, problem.free
        for tried, active in enumerate(itertools.product((False, True), repeat=int((~free).sum())), 1):
            on, z = free.copy(), np.zeros(len(q))
            on[~free] = active
            z[on] = np.linalg.lstsq(M[np.ix_(on, on)], -q[on])[0]
            w = M @ z + q
            if (abs(np.where(free, w, np.minimum(z, w))) <= 1e-12).all():
                return Proposal(z, tried, "found")
        return Proposal(np.zeros(len(q)), tried, "tried them all")


class Guess:
    """A solver that claims what is not so."""

    def propose(self, problem: Any, start: Any = None) -> Proposal:
        return Proposal(np.full(len(problem.q), 0.7), 1, "converged")


def pinch(law: Any, effects: Any = ()) -> hl.Grasp:
    contacts = [hl.Contact((x, 0, 0), (-np.sign(x), 0, 0), law) for x in (-0.01, 0.01)]
    return hl.Grasp(contacts, (0, 0, -1, 0, 0, 0), flexibility=SOFTNESS, preload=SQUEEZE, effects=effects)


@pytest.mark.parametrize("faces", [8, "cone"])
def test_an_effect_of_this_file_bounds_the_forces_as_its_closed_form_says(own: Any, faces: Any) -> None:
    """Each jaw would push with squeeze / softness = 20 N; half of the bound is left to each."""
    np.testing.assert_allclose(pinch(hl.Coulomb(MU)).solve(faces).forces[:, 2], SQUEEZE / SOFTNESS)
    s = pinch(hl.Coulomb(MU), [own.PairBound(6.0)]).solve(faces)
    np.testing.assert_allclose(s.forces[:, 2], 3.0)
    # The motor gives way until the squeeze that is left makes these forces
    np.testing.assert_allclose(s.extra["pair"], [SQUEEZE - 3.0 * SOFTNESS])
    assert s.residuals.passes


def test_an_effect_of_this_file_may_leave_nothing_that_holds(own: Any) -> None:
    """μ Σ r_N < the load: no forces balance it within the bound."""
    s = pinch(hl.Coulomb(MU), [own.PairBound(1.9)]).solve("cone", throw=False)
    assert s.status is hl.Status.NO_EQUILIBRIUM
    assert s.certificate is not None
    assert pinch(hl.Coulomb(MU), [own.PairBound(2.1)]).solve("cone").held


def test_an_effect_of_this_file_is_explained_and_listed(own: Any) -> None:
    grasp = pinch(hl.Coulomb(MU), [own.PairBound(6.0)])
    assert "force bound of a pair: asked for: 6 N" in str(grasp.explain())
    assert "force bound of a pair: not asked for" in str(pinch(hl.Coulomb(MU)).explain())
    assert own.PairBound in effect_kinds()
    assert hl.PairBound is own.PairBound  # found by its class


def test_what_is_left_free_is_not_claimed_beside_an_effect_that_moves_contacts_by_itself(own: Any) -> None:
    """Nobody but the effect knows what its own `opening` leaves free."""

    class Own(own.PairBound):  # no title of its own: no effect of the catalogue
        title = ""

        def opening(self, scene: Any, extra: Any) -> Any:
            return super().opening(scene, extra)

    s = pinch(hl.Coulomb(MU), [Own(6.0)]).solve("cone")
    np.testing.assert_allclose(s.forces[:, 2], 3.0)
    assert s.uniqueness is None
    assert "what is left free was not examined" in str(s)
    assert pinch(hl.Coulomb(MU), [own.PairBound(6.0)]).solve("cone").uniqueness is not None


def test_a_scene_file_asks_for_an_effect_of_this_file_by_its_key(own: Any) -> None:
    scene = read(PINCH.replace("FRICTION", "0.5") + "[effects]\npair_bound_N = 6.0\n")
    assert scene.build().effects == (own.PairBound(6.0),)
    np.testing.assert_allclose(scene.solve().forces[:, 2], 3.0)
    with pytest.raises(hl.InputError, match=r"effects\.pair_bound_N: expected a number > 0"):
        read(PINCH.replace("FRICTION", "0.5") + '[effects]\npair_bound_N = "much"\n')


@pytest.mark.parametrize("faces", [8, "cone"])
def test_a_law_of_this_file_holds_as_its_ellipse_does(own: Any, faces: Any) -> None:
    """Ribbed is AnisotropicCoulomb with half the friction along y."""
    mine, known = (
        pinch(law).replace(wrench=(0, 3, -1, 0, 0, 0)) for law in (own.Ribbed(MU), hl.AnisotropicCoulomb(MU, MU / 2))
    )
    np.testing.assert_allclose(mine.solve(faces).forces, known.solve(faces).forces, atol=1e-9)
    assert own.Ribbed(MU).toward(0.0, 1.0) == MU / 2


def test_a_scene_file_writes_a_law_of_this_file_with_its_keys(own: Any) -> None:
    grasp = read(PINCH.replace("FRICTION", "{mu_of_ribs = 0.5}")).build()
    assert [c.friction for c in grasp.contacts] == [own.Ribbed(0.5)] * 2
    assert grasp.required_friction().value < 0.5


def test_derivatives_by_a_parameter_of_this_file_are_those_of_its_closed_form(own: Any) -> None:
    """r_N = squeeze / softness, and the softness is proportional to the thickness: dr_N / dt = -r_N / t."""
    s = pinch(hl.Coulomb(MU)).solve().sensitivity()
    assert "rubber_thickness" in s.parameters
    expected = np.full(2, -SQUEEZE / SOFTNESS / THICK)
    np.testing.assert_allclose(s.forces_by_rubber_thickness[:, 2, 0], expected, rtol=1e-7)
    (row,) = [line.split() for line in str(s).splitlines() if line.startswith("rubber +10 %")]
    assert row[3:6] == ["both", "jaws", f"{-0.1 * SQUEEZE / SOFTNESS:+.3g}"]


def test_a_parameter_of_this_file_varies_in_reliability(own: Any) -> None:
    """The pinch holds up to 2 μ squeeze / softness = 20 N: under 19 N a rubber 5.3 % thicker drops it."""
    found = hl.reliability(pinch(hl.Coulomb(MU)).replace(wrench=(0, 0, -19, 0, 0, 0)), {"rubber_thickness": 0.05}, 256)
    factors = found.values[:, 0]
    np.testing.assert_array_equal(found.codes == 0, factors <= 20.0 / 19.0)
    assert 0.8 < found.chance_held.value < 0.9


def test_a_parameter_of_this_file_is_tried_by_best_change_and_by_advice(own: Any) -> None:
    grasp = pinch(hl.Coulomb(MU))
    found = next(t for t in grasp.best_change(share=0.1).tried if t.what == "thinner rubber")
    assert found.gain == pytest.approx(1.0 / 0.9 - 1.0, rel=1e-6)
    said = [r for r in grasp.replace(wrench=(0, 0, -30, 0, 0, 0)).check().reasons if r.values.get("change") == "rubber"]
    assert [r.values["value"] for r in said] == [0.5]  # 40 N instead of 20 N
    assert said[0].sentence == "rubber 0.5 × as thick would hold it"


def test_a_solver_of_this_file_solves_problems_and_grasps() -> None:
    s = hl.solve_lcp(hl.LCP([[2.0, 1.0], [1.0, 2.0]], [-1.0, 1.0]), TryAll())
    np.testing.assert_allclose(s.z, [0.5, 0.0])
    assert s.trace[0].startswith("TryAll: found, 3 iterations")
    grasp = pinch(hl.Coulomb(MU))
    np.testing.assert_allclose(grasp.solve(3, TryAll()).forces, grasp.solve(3).forces, atol=1e-9)


def test_a_solver_that_claims_what_is_not_so_is_not_believed() -> None:
    assert hl.solve_lcp(hl.LCP([[1.0]], [-3.0]), Guess(), throw=False).status is hl.Status.UNDECIDED
    with pytest.raises(hl.NoSolutionFound):
        pinch(hl.Coulomb(MU)).solve(3, Guess())
