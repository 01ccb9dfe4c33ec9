"""Do the cone's forces agree with Pinocchio's ADMM? On every scene of the corpus whose forces are determined."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from tests.benchmarks.admm import equilibrium
from tests.benchmarks.corpus import PeersFolder, as_case
from tests.benchmarks.report import plain_table

__all__ = ["compare", "measure"]

LIMIT = TIGHT = 1e-8  # on the difference of forces, relative; on the checker's residual of ADMM's answer
SAME = 1e-4  # farther apart, two answers that both pass the checker are two equilibria
APART = ("another equilibrium", "ADMM without answer")


def compare(folder: PeersFolder, scene: Any) -> dict[str, Any] | None:
    """Ours against ADMM's; None where we have no answer or its forces are not determined.

    difference : the largest of any force component over the largest force. kind : agrees | differs | another
    equilibrium | ADMM without answer. Where ADMM's answer is another equilibrium, it is asked again from ours, where it
    stays unless its own iteration leads away from there; `another` says that it was asked twice.
    """
    solution = as_case(scene, "cone").grasp().solve("cone", throw=False)
    if not solution.held or solution.uniqueness is None or not solution.uniqueness.forces_determined:
        return None
    P = folder.problems.cone(scene)
    size = float(abs(solution.forces).max()) or 1.0

    def difference(found: Any) -> tuple[float, float]:
        forces, twist = P.units.to_si(found.forces, found.twist)
        return (
            float(abs(forces - solution.forces.ravel()).max()) / size,
            folder.residual(scene, forces, twist, "cone"),
        )

    found = equilibrium(P.G, P.E, P.w, P.d, P.mu)
    apart, residual = difference(found)
    another = residual <= TIGHT and apart > SAME
    if another:
        f, u = solution.forces.ravel() / P.units.f0, solution.object_displacement
        at = np.r_[u[:3] + np.cross(u[3:], P.units.c), u[3:] * P.units.L] / (P.units.e0 * P.units.f0)
        apart, residual = difference(equilibrium(P.G, P.E, P.w, P.d, P.mu, start=(f, at)))
    if residual > TIGHT:
        kind = "ADMM without answer"
    else:
        kind = "agrees" if apart <= LIMIT else "differs" if apart <= SAME else "another equilibrium"
    return {
        "family": scene.family, "name": scene.name, "kind": kind, "difference": apart, "another": bool(another),
        "admm": residual, "ours": folder.residual_of(scene, solution, "cone"),
    }  # fmt: skip


def measure(console: Console, folder: PeersFolder, corpus: Path, families: Sequence[str]) -> list[dict[str, Any]]:
    """Print how far the two are apart, family by family; the rows for JSON."""
    rows = []
    for scene in folder.read(corpus, families):
        with console.status(scene.name):
            row = compare(folder, scene)
        if row is not None:
            rows.append(row)
    table = plain_table(
        "Agreement with Pinocchio's ADMM, exact cone, scenes with determined forces",
        "family", "compared", "agree\nto 1e-8", "worst\ndifference", "asked\ntwice", "another\nequilibrium",
        "ADMM without\nanswer",
        caption="Compared: ADMM's own answer passes the checker at 1e-8, and it is the same equilibrium as ours. Asked "
        "twice: it first found another one, then ours when started there. Another equilibrium: it went away from ours, "
        "which passes the checker too.",
    )  # fmt: skip
    names = list(dict.fromkeys(r["family"] for r in rows))
    for name in [*names, "all"]:
        mine = [r for r in rows if name in (r["family"], "all")]
        same = [r for r in mine if r["kind"] in ("agrees", "differs")]
        worst = f"{max(r['difference'] for r in same):.1e}" if same else "–"
        table.add_row(
            name, str(len(same)), str(sum(r["kind"] == "agrees" for r in same)), worst,
            str(sum(r["another"] for r in same)), *(str(sum(r["kind"] == k for r in mine)) for k in APART),
            style="bold" if name == "all" else None,
        )  # fmt: skip
    console.print(table)
    for r in rows:
        if r["kind"] != "agrees":
            console.print(
                f"  {r['name']}: {r['kind']}, difference {r['difference']:.1e}, residuals: ADMM {r['admm']:.1e}, "
                f"ours {r['ours']:.1e}",
                highlight=False,
            )
    return rows
