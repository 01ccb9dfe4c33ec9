"""What an answer looks like: a picture, plain data. Made by `handlcp.show`, which stands above this room."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handlcp.views import view


class Data:
    """Base of answers that are plain data, and tables."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """The whole answer as plain data: SI units in the key names, None for what is not a finite number."""
        raise NotImplementedError

    def to_json(self, path: Any = None) -> str | Path:
        """The same as JSON: the text, or the file that it was written to. Raises InputError for a file that cannot be
        written.
        """
        written: str | Path = view("to_json")(self.to_dict(), path)
        return written


class Shown(Data):
    """Base of solutions that can be looked at."""

    def plot(self, path: Any = None, *, obj: Any = None, title: str = "", verdict: Any = None) -> Any:
        """The picture of the grasp: a matplotlib figure, or the file that it was written to.

        path : of a png, svg or pdf file; None: the figure itself, which a notebook shows. obj : what to draw as the
        object where the grasp knows none. verdict : of `grasp.check()`, and drawn is the end of the loading that it
        is about, where that is reached; None: what this solution alone says.
        Raises InputError for an unknown format or a missing folder, Unsupported without matplotlib.
        """
        return view("plot")(self, path, obj, title, verdict)

    def page(
        self, path: Any, *, obj: Any = None, title: str = "", verdict: Any = None, loading: Any = None
    ) -> Path:  # fmt: skip
        """A page to turn the grasp on: one HTML file that needs no network. Returns the file.

        path : it ends in .html. obj : as in `plot`. loading : what `grasp.follow()` returned, which the page shows step
        by step; None: the loading that the verdict is about, if any. verdict : of `grasp.check()`; None: whether the
        loading reached its end, or without a loading what this solution alone says.
        Raises InputError for a file that cannot be written, Unsupported without trimesh, which brings the viewer.
        """
        written: Path = view("page")(self, path, obj, title, verdict, loading)
        return written

    def to_dict(self) -> dict[str, Any]:
        """The whole answer as plain data: SI units in the key names, None for what is not a finite number."""
        found: dict[str, Any] = view("to_dict")(self)
        return found

    def to_frame(self, of: str = "contacts") -> Any:
        """A pandas table, indexed by name. SI units in the names of the columns; NaN where there is no answer.

        of : "contacts": state, normal_N, friction_N, friction_used, friction_margin_N, slip_m, gap_m, the force in
        contact axes (x_N, y_N, z_N) and in world axes, and of soft fingers the moment about the normal. "joints":
        torque_Nm, limit_Nm, utilisation, margin_Nm, yield_rad.
        Raises InputError for anything else, and for joints without a hand; Unsupported without pandas.
        """
        return view("solution_frame")(self, of)

    def _repr_html_(self) -> str:
        """What a notebook shows: the verdict, the contacts, the joints."""
        text: str = view("html")(self)
        return text
