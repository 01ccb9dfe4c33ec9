"""The figure of NSNGRK's convergence: rates in natural units, and the effect of the paper's stop rule in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from handlcp.method.convergence import Convergence, Run
from handlcp.show.file import Figure, drawn, new_figure
from handlcp.show.style import BLUE, INK, RED, SMALL, TEXT, panel, spread
from handlcp.words import percent

WIDTH, HEIGHT = 10.0, 4.9  # inches
HEAD = 12.5  # points
NATURAL, UNIFORM, GIVEN = BLUE, "#B87800", RED  # the palette's orange, darker for text
LINES: dict[str, Any] = {"linewidth": 0.9, "alpha": 0.8}
DASHED = (0, (4, 2.5))
AFTER = 3.0  # steps shown in the right half, in multiples of the steps to the stop rule
ROW = 0.054  # height of a line of text in the left panel, as a share of the panel's

Mark = tuple[str, float]  # a name and a value


def save(result: Convergence, path: Any, title: str = "", printed: Mark | None = None) -> Path:
    """Draw and write a file; see `draw`. Raises InputError for an unknown format or a folder that does not exist."""
    file: Path = drawn(path, draw, result, title, printed)
    return file


def draw(result: Convergence, title: str = "", printed: Mark | None = None) -> Figure:
    """The figure. title : of the scene. printed : a name and a value to mark in the panel of values.

    Left, natural units: ‖Φ‖ over steps with greedy and with uniform sampling, a line for every seed; dashed: the rates
    that conditioning predicts. Right, the user's units: ‖Φ‖ with the stop rule above, and below the value on which
    seeds disagree most, which natural units determine. Raises Unsupported when matplotlib is not installed.
    """
    figure = new_figure(figsize=(WIDTH, HEIGHT), dpi=100)
    figure.text(0.012, 0.975, title, fontsize=HEAD, weight="bold", color=INK, va="top", parse_math=False)
    kinds = f"Kaczmarz steps alone, no exact ending; a line is one seed, {len(result.select())} of each kind"
    stops = [r.stop for r in result.select("given") if r.stop is not None]
    what = f"{kinds}; dots: where the stop rule ends a run." if stops else f"{kinds}."
    figure.text(0.012, 0.908, what, fontsize=TEXT, color=INK, va="top")
    steps = AFTER * float(np.median(stops)) if stops else float(result.select("given")[0].history[-1, 0])
    _rates(figure.add_axes((0.075, 0.115, 0.415, 0.665)), result)
    top, bottom = (figure.add_axes((0.585, y, 0.255, 0.275)) for y in (0.505, 0.115))
    panel(top, f"As given, in metres and newtons: {'it stops' if stops else 'no end'}", "", "‖Φ‖")
    _residuals(top, result, steps)
    name = f"{'… but where? ' if stops else ''}{result.names[result.disputed]}, seed by seed"
    panel(bottom, name, "steps", result.quantity)
    _values(bottom, result, steps, printed)
    return figure


def _rates(ax: Any, result: Convergence) -> None:
    """The left panel: natural units."""
    greedy, uniform = result.select(), result.select(sampling="uniform")
    settled = all(r.converged for r in (*greedy, *uniform))
    title = "every run converges, linearly" if settled else "linear once the active set settles"
    panel(ax, f"Natural units: {title}", "steps, in thousands", "‖Φ‖")
    ax.set_yscale("log")
    for runs, colour in ((uniform, UNIFORM), (greedy, NATURAL)):
        for run in runs:
            ax.plot(run.history[:, 0] / 1e3, run.history[:, 1], color=colour, **LINES)
    quick = max(float(r.history[-1, 0]) for r in greedy)
    last = max(quick, *(float(r.history[-1, 0]) for r in uniform))
    _dashed(ax, greedy[0], greedy[0].bound, (0.5 * quick, last), NATURAL)
    slow = [("uniform sampling:", UNIFORM)]
    if all(r.converged for r in uniform):
        least = result.bound(sampling="uniform")
        _dashed(ax, uniform[0], 2.0 * uniform[0].bound, (0.2 * last, 0.9 * last), INK)
        slow.append((f"{_digit(result.rate(sampling='uniform'))} steps a digit;", UNIFORM))
        slow.append((f"conditioning predicts {_digit(2.0 * least)} (dashed),", INK))
        slow.append((f"{_digit(least)} at most", INK))
    else:
        slow.append(("not there after so many steps", UNIFORM))
    rate, bound = _digit(result.rate()), _digit(result.bound())
    fast = ["greedy sampling:", f"{rate} steps a digit;", f"its bound: {bound} (dashed)"]
    ax.set_xlim(0.0, 1.02 * last / 1e3)
    _lines(ax, 0.985, 0.985, slow, "right")
    left = 0.03 + (quick / last if quick < 0.5 * last else 0.0)
    _lines(ax, left, 0.025 + ROW * len(fast), [(line, NATURAL) for line in fast], "left")


def _dashed(ax: Any, run: Run, rate: float, ends: tuple[float, float], colour: str) -> None:
    """A line of that rate through the middle of the run."""
    k, norm = run.history[len(run.history) // 2]
    x = np.array(ends)
    ax.plot(x / 1e3, norm * np.exp(-rate * (x - k)), color=colour, linewidth=1.3, linestyle=DASHED, zorder=5)


def _digit(rate: float) -> str:
    """Steps that gain a decimal digit, to two figures, such as "15 000"."""
    steps = np.log(10.0) / rate
    size = 10.0 ** max(np.floor(np.log10(steps)) - 1.0, 0.0)
    return f"{round(steps / size) * size:,.0f}".replace(",", " ")


def _lines(ax: Any, x: float, y: float, lines: Sequence[tuple[str, str]], side: str) -> None:
    """Lines of text with their colours, from (x, y) down, in shares of the panel."""
    for k, (text, colour) in enumerate(lines):
        ax.text(x, y - k * ROW, text, transform=ax.transAxes, fontsize=SMALL, color=colour, ha=side, va="top", zorder=8)


def _residuals(ax: Any, result: Convergence, steps: float) -> None:
    """The upper right panel: the user's units."""
    ax.set_yscale("log")
    for run in result.select("given"):
        k, norm = run.history[run.history[:, 0] <= steps].T
        ax.plot(k, norm, color=GIVEN, **LINES)
    ax.axhline(result.stop, color=INK, linewidth=1.1, linestyle=DASHED, zorder=2)
    ax.set_xlim(0.0, steps)
    ax.tick_params(labelbottom=False)
    e = round(np.log10(result.stop))
    power = f"$10^{{{e}}}$" if abs(result.stop / 10.0**e - 1.0) < 1e-9 else f"{result.stop:.1g}"
    rule, across = f"stop rule\n‖Φ‖ < {power}", ax.get_yaxis_transform()
    ax.text(1.03, result.stop, rule, transform=across, fontsize=SMALL, color=INK, va="center")


def _values(ax: Any, result: Convergence, steps: float, printed: Mark | None) -> None:
    """The lower right panel: the value on which seeds disagree most."""
    i, given, natural = result.disputed, result.select("given"), result.select("natural")
    for runs, colour in ((natural, NATURAL), (given, GIVEN)):
        for run in runs:
            k = np.append(run.looks[run.looks < steps], steps)
            ax.plot(k, np.interp(k, run.looks, run.values[:, i]), color=colour, **LINES)
            if runs is given and run.stop is not None:
                dot = {"markersize": 4.5, "color": GIVEN, "markeredgecolor": "white", "zorder": 6}
                ax.plot([run.stop], [run.stopped[i]], "o", **dot)
    ends = np.array([r.stopped[i] for r in given])
    answer = float(result.answer[i])
    marks = [*ends.tolist(), answer, *([] if printed is None else [printed[1]])]
    low, high = min(marks), max(marks)
    ax.set_ylim(low - 0.25 * (high - low), high + 0.15 * (high - low))
    ax.set_xlim(0.0, steps)
    distance = result.spread("given")
    apart = f"seeds {percent(distance)} apart" if distance > 1e-3 else f"{np.median(ends):.3g}"
    together = f"all end at {answer:.3g}" if all(r.converged for r in natural) else f"certified: {answer:.3g}"
    labels = [(answer, f"natural units:\n{together}", NATURAL), (float(np.median(ends)), f"as given:\n{apart}", GIVEN)]
    if printed is not None:
        ax.plot([steps], [printed[1]], "D", markersize=5, color=INK, clip_on=False, zorder=7)
        labels.append((printed[1], f"{printed[0]}: {printed[1]:.3g}", INK))
    _beside(ax, labels)


def _beside(ax: Any, labels: list[tuple[float, str, str]]) -> None:
    """Write labels (value, text, colour) at the right edge, as near to their heights as there is room."""
    low, high = ax.get_ylim()
    labels = sorted(labels)
    tall = [0.02 + 0.13 * (1 + text.count("\n")) for _, text, _ in labels]
    wanted = [(value - low) / (high - low) - 0.5 * t for (value, _, _), t in zip(labels, tall, strict=True)]
    places = spread(wanted, tall, -np.inf, 1.0)
    for y, (_, text, colour) in zip(places, labels, strict=True):
        ax.text(1.05, y, text, transform=ax.transAxes, fontsize=SMALL, color=colour, va="bottom", linespacing=1.15)
