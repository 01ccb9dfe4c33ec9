"""The grip with which all loads hold and the motors need least, found by following every grip that is tried."""

from __future__ import annotations

from handlcp.check import Array
from handlcp.grasp.design.least import closed_in
from handlcp.hand.design.trials import Trial, Trials

_MOST = 2.0**8  # times the grip that the search starts from
_CHANGES = (0.2, 0.08, 0.03)  # of one finger's grip
_BETTER = 1e-3  # a change that gains less is none


def least(trials: Trials, starts: list[Array], tolerance: float) -> tuple[Trial, Trial | None]:
    """The best grip found, and the largest share of it that does not hold (None: less holds, too, and needs no less).
    Where nothing holds, the first is the one that gets furthest.

    starts : grips (k,) [N] to go on from, the most promising first; a later one counts only where none before it holds.
    """
    found = (_scaled(trials, start, tolerance)[0] for start in starts)
    best = next((one for one in found if one.holds), None)
    if best is None:
        return max(trials.tried.values(), key=lambda one: one.reached), None
    better = _varied(trials, best)
    least_of_it = _scaled(trials, better.force, tolerance)
    return least_of_it if least_of_it[0].need <= better.need else (better, least_of_it[1])


def _scaled(trials: Trials, force: Array, tolerance: float) -> tuple[Trial, Trial | None]:
    """The least multiple of a grip that holds, to a relative tolerance; and the one below it that does not. Where none
    holds: the one that gets furthest.
    """

    def at(factor: float) -> Trial:
        return trials(factor * force)

    value, fails = closed_in(lambda x: at(x).holds, 1.0, _MOST, tolerance, lambda x: at(x).reached < 0.0)
    if value is None:
        return at(fails), None
    return at(value), at(fails) if fails < value else None


def _varied(trials: Trials, best: Trial) -> Trial:
    """One finger after the other, as long as that helps: with its new grip, all others as they were."""
    for change in _CHANGES:
        moved = True
        while moved:
            moved = False
            for finger in range(len(best.force)):
                for factor in (1.0 - change, 1.0 + change):
                    force = best.force.copy()
                    force[finger] *= factor
                    found = trials.below(force, (1.0 - _BETTER) * best.need)
                    if found is not None:
                        best, moved = found, True
                        break
    return best
