"""What the pictures of an envelope say in words: the headline, and the colours with their causes."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlcp import words
from handlcp.show.envelope.surface import NOTHING, Surface
from handlcp.show.style import BOLD, GREY, INK, SMALL, title_lines, width, wrapped
from handlcp.study.envelope import Envelope
from handlcp.study.envelope.printed import geometry, given_away, headline

ROW, LINE = 0.215, 0.215  # inches
LEFT, ACROSS = 0.018, 0.964
TITLE = "What gives out first: share of the directions, and how much is held there"
_LETTERS = 60  # of a cause in its column


def head(figure: Any, env: Envelope, title: str) -> float:
    """Title, weakest direction, what compliance gives away; returns where that ends, in inches below the top."""
    inches, y = float(figure.get_size_inches()[1]), 0.17
    for line in title_lines(figure, title):
        figure.text(LEFT, 1.0 - y / inches, line, color=INK, **BOLD)
        y += 0.30
    y += 0.06 if title else 0.0
    style: dict[str, Any] = {"fontsize": 10.5, "va": "top"}
    for text, colour in ((headline(env), INK), (given_away(env), GREY), (geometry(env), GREY)):
        for line in wrapped(figure, f"{text[:1].upper()}{text[1:]}.", 150, ACROSS, **style) if text else []:
            figure.text(LEFT, 1.0 - y / inches, line, color=colour, **style)
            y += LINE
    return y


def lines_of(env: Envelope, s: Surface, bound: str) -> list[tuple[str, str, str]]:
    """(kind, colour, text) of each line; kind: "patch", or how the bound is drawn."""
    unit = f" {env.unit}" if env.unit else ""
    found = []
    for key in s.keys:
        least = "" if key.colour == NOTHING else f", {key.least:.3g}{unit} and more"
        least = ", drawn as far as the bound" if np.isnan(key.least) else least
        found.append(("patch", key.colour, f"{key.says}: {words.percent(key.share)}{least}"))
    if s.bound_beyond:
        found.append((bound, INK, "without compliance: friction and torque limits alone"))
    return found


class Legend:
    """In two columns. bound : how it is drawn, "line" or "dashed"."""

    def __init__(self, env: Envelope, s: Surface, bound: str = "dashed") -> None:
        self.lines = lines_of(env, s, bound)
        self.note = ""
        if s.cut:
            unit = f" {env.unit}" if env.unit else ""
            self.note = f"Cut at {s.reach:.3g}{unit}: what reaches farther is drawn there."
        self.rows = (len(self.lines) + 1) // 2

    @property
    def height(self) -> float:
        """Inches, with the heading."""
        return 0.34 + ROW * (self.rows + bool(self.note)) + 0.08

    def draw(self, figure: Any, top: float) -> None:
        """Below `top`, in inches."""
        from matplotlib.lines import Line2D
        from matplotlib.patches import Rectangle

        tall = float(figure.get_size_inches()[1])
        wide = float(figure.get_size_inches()[0])
        figure.text(LEFT, 1.0 - (top + 0.1) / tall, TITLE,
                    fontsize=SMALL, weight="bold", color=INK, va="center")  # fmt: skip
        column = 0.5
        for k, (kind, colour, text) in enumerate(self.lines):
            x = LEFT + column * (k // self.rows)
            y = 1.0 - (top + 0.34 + ROW * (k % self.rows)) / tall
            if kind == "patch":
                box = Rectangle((x, y - 0.06 / tall), 0.24 / wide, 0.12 / tall, transform=figure.transFigure,
                                facecolor=colour, edgecolor="#55555566", linewidth=0.5)  # fmt: skip
                figure.add_artist(box)
            else:
                dash: Any = "-" if kind == "line" else (0, (4, 2))
                figure.add_artist(Line2D([x, x + 0.24 / wide], [y, y], color=colour, linewidth=1.0, linestyle=dash,
                                         transform=figure.transFigure))  # fmt: skip
            shown = _fitting(figure, text, column - 0.24 / wide - 0.03)
            figure.text(x + 0.32 / wide, y, shown, fontsize=SMALL, color=INK, va="center")
        if self.note:
            y = 1.0 - (top + 0.34 + ROW * self.rows) / tall
            figure.text(LEFT, y, self.note, fontsize=SMALL, color=GREY, va="center")


def _fitting(figure: Any, text: str, across: float) -> str:
    """With "…" in its cause where it is wider than this share of the figure."""
    says, colon, rest = text.partition(": ")
    while width(figure, says + colon + rest, fontsize=SMALL) > across * figure.bbox.width and len(says) > 12:
        says = says.removesuffix(" …")[:-3].rstrip() + " …"
    return says + colon + rest
