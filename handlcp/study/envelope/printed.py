"""An envelope as text: the weakest and the strongest direction, what gives out where, what compliance gives away."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp import words
from handlcp.check import Array
from handlcp.grasp.failure.failure_text import NOTHING_FAILS, describe_failures
from handlcp.study.envelope.ask import FOLLOWED
from handlcp.text_table import TextTable, wrapped

_ROWS = 8  # causes of a table; the rest are one row
_WHAT = {"force": "a force", "torque": "a torque", "gravity": "gravity", "wrench": "the load"}
_AXES = ("x", "y", "z")


def printed(env: Any) -> str:
    """An envelope as the text that prints: see `Envelope.__str__`."""
    if env.strongest.factor == 0.0:
        return "\n".join([wrapped(_head(env), "  "), wrapped(headline(env), "  ")])
    told = (_head(env), *_extremes(env), given_away(env), geometry(env), _accuracy(env))
    lines = [wrapped(line, "  ") for line in told if line]
    return "\n".join([*lines, "", str(_table(env))])


def headline(env: Any) -> str:
    """The weakest direction and what gives out there, in one sentence."""
    w, left = env.weakest, int(np.isnan(env.factors).sum())
    where = _way(env, w.number)
    if np.isnan(w.factor):
        return f"undecided {where}: no limit was found, although friction and torque limits end any load"
    if np.isinf(w.factor):
        return f"{NOTHING_FAILS}, in no direction"
    if env.strongest.factor == 0.0:
        return f"the grasp does not hold without a load: {_what(env, w)}"
    but = f" but {left} that are undecided" if left else ""
    held = f"the grasp holds {amount(env, w.factor)}{_in_any(env)}{but}"
    return f"{held}; weakest {where}: {_what(env, w)}"


def geometry(env: Any) -> str:
    """What stays where it is while the load grows, and what else one may ask for."""
    if env.geometry == FOLLOWED:
        return "fingers and object move under the load, and contacts are detected anew"
    return (
        'contacts stay where they are in this posture; geometry="followed" (--followed) lets fingers and object move: '
        "slower, and for soft hands the numbers can differ much"
    )


def _accuracy(env: Any) -> str:
    """How near the factors are to those of finer steps, where that was asked for."""
    asked = env.question.accuracy
    if asked is None:
        return ""
    off = np.where(np.isnan(env.accuracy), np.inf, env.accuracy)
    k, m = int(off.argmax()), int((off <= asked).sum())
    few = "all" if m == len(off) else f"{m} of"
    text = f"estimated to be within {words.percent(asked)} in {few} {len(off)} directions"
    return text if m == len(off) else f"{text}; off by {words.percent(float(off[k]))} {_way(env, k)}"


def amount(env: Any, factor: float) -> str:
    """A factor with its unit in words, such as "3.2 N", "0.41 kg (2.1 times the object's)", "1.3 times the wrench"."""
    if np.isnan(factor):
        return "undecided"
    if np.isinf(factor):
        return "any load"
    if env.of == "force":
        return words.force(factor)
    if env.of == "torque":
        return words.torque(factor)
    if env.of == "gravity":
        mass = env.question.load.mass
        return f"{factor:.3g} kg" + (f" ({factor / mass:.3g} times the object’s)" if mass else "")
    return f"{factor:.3g} times the wrench"


def direction(d: Array) -> str:
    """A unit vector (3,) in words, such as "+x" or "(0.71, 0, -0.71)"."""
    k = int(abs(d).argmax())
    if abs(d[k]) > 1.0 - 1e-9:
        return f"{'+' if d[k] > 0 else '-'}{_AXES[k]}"
    return "(" + ",\N{NO-BREAK SPACE}".join(f"{round(x, 2) + 0.0:g}" for x in d.tolist()) + ")"


def _what(env: Any, extreme: Any) -> str:
    return describe_failures(extreme.binds, env.grasp.spec)


def _in_any(env: Any) -> str:
    around = env.plane is None and len(env.triangles)
    return " in every direction" if around else " in every direction of the plane" if env.plane is not None else ""


def _way(env: Any, k: int) -> str:
    """Direction k of an envelope in words, such as "along +x"; of wrenches, which one."""
    return f"with wrench {k + 1}" if env.of == "wrench" else f"along {direction(env.directions[k])}"


def _head(env: Any) -> str:
    """The question of an envelope in words: which load, in how many directions."""
    load, m = env.question.load, len(env.factors)
    what = _WHAT[env.of]
    if env.of == "force":
        unit = words.length_unit(load.at.tolist())
        what += " at (" + ", ".join(unit(x) for x in load.at.tolist()) + f") {unit.name}"
    around = "in a plane" if env.plane is not None else "all around" if len(env.triangles) else ""
    ways = "wrenches" if env.of == "wrench" else "directions"
    return f"how much it holds: {what}, {m} {ways}{f' {around}' if around else ''}"


def _extremes(env: Any) -> list[str]:
    w, s = env.weakest, env.strongest
    return [
        f"weakest: {amount(env, w.factor)} {_way(env, w.number)}: {_what(env, w)}",
        f"strongest: {amount(env, s.factor)} {_way(env, s.number)}: {_what(env, s)}",
    ]


def given_away(env: Any) -> str:
    """What passive compliance gives away, in words; "" where nothing is known of it."""
    c = env.compliance
    if np.isnan(c.median):
        return ""
    least, ways = amount(env, float(env.bound.min())), "wrenches" if env.of == "wrench" else "directions"
    weakest = "of the weakest wrench" if env.of == "wrench" else "in the weakest direction"
    text = f"friction and torque limits alone would allow {least} {weakest}"
    if env.geometry == FOLLOWED:  # which may end in postures that hold more
        return f"in this posture, {text}"
    if c.least > 1.0 - 1e-6:
        return f"{text}; the compliant fingers hold all that these limits allow"
    where, half, least = _way(env, c.number), words.percent(c.median), words.percent(c.least)
    return (
        f"{text}; the compliant fingers do not create all of these forces: in half of the {ways} they hold at most "
        f"{half} of what the limits allow there, {where} only {least}"
    )


def _table(env: Any) -> TextTable:
    """A row for each cause, the most frequent first."""
    shown, rest = env.causes[:_ROWS], env.causes[_ROWS:]
    if len(rest) == 1:
        shown, rest = env.causes, ()
    rows = [(c.says, words.percent(c.share), *_numbers(env, c.least, c.median)) for c in shown]
    if rest:
        least = min([c.least for c in rest], key=lambda x: (np.isnan(x), x))
        rows.append((f"{len(rest)} more", words.percent(sum(c.share for c in rest)), *_numbers(env, least, np.nan)))
    unit = f"\n{env.unit}" if env.unit else ""
    return TextTable(("what gives out first", "directions", f"least{unit}", f"median{unit}"), tuple(rows), "<>>>")


def _numbers(env: Any, *values: float) -> list[str]:
    return ["any" if np.isinf(x) else "" if np.isnan(x) else f"{x:.3g}" for x in values]
