"""What is wrong in the paper's tables, equation by equation: misprints, displacements that do not fit, Example 4.

`handlcp paper` says which equations the printed forces miss. This script asks the printed displacements, too:

    (5),(13)   slip                   the printed displacement of the object, at a contact, gives the printed slip
    (3),(4)    unilateral contact     0 ≤ r_N ⟂ ε_N ≥ 0: where a finger presses there is no gap
    (11),(12)  slip and its faces     a finger slides against the faces that its force is on, and against no other

Signs are lost in print. Forces get those that balance best, displacements those that fit the printed slips best. The
paper gives no flexibilities for Examples 3 to 5: E_T of Example 2 and E_T = E_N are tried.

Then it shows that Example 4 has no elastic equilibrium, with all choices of contact modes solved, that a squeeze of
5 µm gives one, and what Example 5 would be with the E_T that its slips fit.

Run it: `python examples/paper/misprints.py`, some seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from scipy.optimize import nnls

import handlcp as hl
from handlcp.studies import paper

ON_FACE = 1e-3  # a force counts as on a face within this share of the largest force: generous to the printed numbers
FITS, FITS_SLIPS = 1e-4, 0.02  # misses that are allowed, as shares of the largest elastic displacement
WITH_FRICTION = range(3, 11)  # tables
FACES = (4, 6, 8)


@dataclass(frozen=True)
class Motion:
    """The printed displacement of the object with the signs and the E_T that fit the printed slips best.

    twist (6,) [m, rad] about the origin. tangential : that E_T [m/N]. slip_miss : the worst difference to a printed
    slip [m]. slip (n, 2), gap (n,) [m] : that follow from it; NaN where the force of a finger is known beforehand.
    """

    twist: np.ndarray
    tangential: float
    slip_miss: float
    slip: np.ndarray
    gap: np.ndarray


def printed_slips(table: Any, contacts: int) -> np.ndarray:
    """(n, 2) magnitudes along the contact axes x, y [m]; NaN where nothing is printed."""
    out = np.full((contacts, 2), np.nan)
    for finger, numbers in table.slip.items():
        out[finger - 1] = [number.value for number in numbers]
    return out


def ruled(grasp: hl.Grasp) -> np.ndarray:
    """(n,) bool: contacts whose force follows from laws; that of the others is known beforehand."""
    known = [effect.contact for effect in grasp.effects if isinstance(effect, hl.PrescribedForce)]
    return ~np.isin(np.arange(len(grasp.contacts)), known)


def rough(grasp: hl.Grasp) -> np.ndarray:
    """(n,) bool: those with friction among them."""
    return ruled(grasp) & np.array([contact.friction.mu > 0 for contact in grasp.contacts])


def motion(number: int) -> Motion:
    """Of all signs of the printed displacement, and of both flexibilities, those that fit the printed slips best."""
    table = paper.table(number)
    grasp = paper.example(table.example).grasp
    forces, _ = paper.signed_forces(grasp, table)
    E_T, _, E_N = np.diagonal(grasp.flexibility)[:3]
    positions = np.array([contact.position for contact in grasp.contacts])
    slips, laws = printed_slips(table, len(positions)), ruled(grasp)
    given = np.isfinite(slips[:, 0])
    found = []
    for signs in product((1.0, -1.0), repeat=6):
        twist = np.multiply(signs, [number.value for number in table.object])
        at = twist[:3] + np.cross(twist[3:], positions)
        moves = np.einsum("nji,nj->ni", grasp.frames, at)  # in contact axes
        gap = np.where(laws, moves[:, 2] + E_N * forces[:, 2], np.nan)
        for tangential in (E_T,) if table.example == 2 else (E_T, E_N):
            slip = moves[:, :2] + tangential * forces[:, :2]
            miss = float(abs(abs(slip) - slips)[given].max())
            found.append(Motion(twist, float(tangential), miss, np.where(laws[:, None], slip, np.nan), gap))
    return min(found, key=lambda one: one.slip_miss)


def off_its_faces(grasp: hl.Grasp, faces: int, forces: np.ndarray, slip: np.ndarray) -> float:
    """The worst distance [m] of a slip from -Nλ, λ ≥ 0, over the faces N that the force is on."""
    normals, worst = hl.Pyramid(faces).normals, 0.0
    on = paper.friction_excess(grasp, faces, forces) >= -ON_FACE * abs(forces).max()
    for i in np.flatnonzero(rough(grasp)):
        N = normals[:, on[i]]
        worst = max(worst, float(nnls(N, -slip[i])[1]) if N.size else float(np.linalg.norm(slip[i])))
    return worst


def misses(number: int) -> dict[str, tuple[float, bool]]:
    """What the printed displacements of a table miss: equation → (miss [m], whether it holds as far as digits tell)."""
    table = paper.table(number)
    fit = motion(number)
    grasp = paper.example(table.example, tangential=fit.tangential).grasp
    forces, _ = paper.signed_forces(grasp, table)
    elastic = abs(grasp.flexibility @ forces.ravel()).reshape(-1, 3)[ruled(grasp)].max()
    gap = float(np.nanmax(abs(fit.gap)))
    slide = off_its_faces(grasp, table.faces, forces, np.nan_to_num(fit.slip))
    return {
        "slip (5), (13)": (fit.slip_miss, bool(fit.slip_miss <= FITS_SLIPS * elastic)),
        "unilateral contact (3), (4)": (gap, bool(gap <= FITS * elastic)),
        "slip and its faces (11), (12)": (slide, bool(slide <= FITS_SLIPS * elastic)),
    }


def recovered(number: int) -> dict[tuple[int, str], float]:
    """(finger, axis) → force [N] that follows from balance, where a slip is printed in its place."""
    table = paper.table(number)
    forces, _ = paper.signed_forces(paper.example(table.example).grasp, table)
    return {(finger, axis): float(forces[finger - 1, "otn".index(axis)]) for finger, axis in table.overwritten}


def example_4() -> dict[tuple[float, int], hl.Equilibria]:
    """(E_T [m/N], faces) → all equilibria of Example 4 as printed: there is none, and that is proved."""
    E_T, _, E_N = np.diagonal(paper.example(4).grasp.flexibility)[:3]
    return {
        (float(value), faces): paper.example(4, tangential=value).grasp.equilibria(faces)
        for value in (E_T, E_N)
        for faces in FACES
    }


def with_preload() -> hl.Equilibria:
    """All equilibria of Example 4 with 5 µm of squeeze on fingers 1 and 2: the same search finds one."""
    return paper.example(4, preload=paper.PRELOAD).grasp.equilibria(8)


def example_5() -> np.ndarray:
    """(5,) N normal forces of Example 5 with the E_T that the slips of Table 10 fit; not the printed ones either."""
    grasp = paper.example(5, tangential=motion(10).tangential).grasp
    return grasp.solve(paper.table(10).faces).normal_force


def main(out: Console | None = None) -> None:
    """Print what is wrong, and check that it is."""
    out = out or Console()
    table = Table("table", "equation", "miss [µm]", "", "E_T that fits [m/N]", box=SIMPLE_HEAD)
    for number in WITH_FRICTION:
        fits = f"{motion(number).tangential:.2g}"
        for k, (equation, (miss, holds)) in enumerate(misses(number).items()):
            first = (f"Table {number}", fits) if k == 0 else ("", "")
            table.add_row(first[0], equation, f"{1e6 * miss:.3f}", "holds" if holds else "missed", first[1])
    out.print("The printed displacements in the paper's own equations", style="bold")
    out.print(table)
    for number in WITH_FRICTION:
        for r in paper.table(number).readings:
            out.print(f"Table {number}, force {r.finger} {r.axis}: {r.printed} reads {r.read}: {r.why}.")
    for (finger, axis), force in recovered(9).items():
        out.print(f"Table 9, force {finger} {axis} repeats a slip; balance gives {force:.5g} N.")
    out.print("\nExample 4, all choices of contact modes", style="bold")
    for (tangential, faces), found in example_4().items():
        assert not found.found, "an elastic equilibrium that the paper could have had"
        assert found.complete
        out.print(f"E_T = {tangential:.2g} m/N, {faces} faces: {found.why}")
    (held,) = with_preload()
    forces = ", ".join(f"{force:.5g}" for force in held.normal_force)
    out.print(f"5 µm of squeeze on fingers 1 and 2, 8 faces: r_N = {forces} N, {held.contact_state[0]}")
    forces = ", ".join(f"{force:.6g}" for force in example_5())
    out.print(f"\nExample 5 with E_T = {motion(10).tangential:.2g} m/N: r_N = {forces} N, not those of Table 10.")


if __name__ == "__main__":
    main()
