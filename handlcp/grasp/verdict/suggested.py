"""What to change: effects left out that matter to an answer, and where a grasp fails, what was tried and holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlcp.grasp.analysis.suggestions import Suggestion, Suggestions, suggest
from handlcp.grasp.answer.solution import GraspSolution
from handlcp.grasp.answer.verdict import Reason, Verdict
from handlcp.grasp.friction import Section
from handlcp.grasp.model.spec import GraspSpec


def suggested(
    spec: GraspSpec, section: Section, solution: GraspSolution, least: float, verdict: Verdict
) -> Suggestions:
    """Verdict : of this grasp by `check`, or the solution's own where that is HELD. Without an answer no effect can be
    judged; then its advice is all there is.
    """
    effects = suggest(spec, section, solution, least) if solution.held else Suggestions((), (), (), least)
    if verdict.ok and solution.held:
        return effects
    advice = verdict.about("advice")
    helps = tuple([_suggestion(r) for r in advice if "change" in r.values])
    tried = tuple([text for r in advice for text in r.values.get("tried", ())])
    return replace(effects, found=(*helps, *effects.found), word=verdict.word, tried=tried)


def _suggestion(r: Reason) -> Suggestion:
    change, value = r.values["change"], r.values["value"]
    ask = {
        "squeeze": f"squeeze or preload, {value:g} m more",
        "less squeeze": f"squeeze or preload × {value:g}",
        "friction": f"friction={value:g}",
        "stiffness": f"joint_stiffness × {value:g}",
        "grip": "another placement of the object",
    }
    return Suggestion(change, np.inf, r.sentence, ask[change])
