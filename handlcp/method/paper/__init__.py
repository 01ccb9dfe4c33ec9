"""The paper, reproduced: Examples 1 to 5 and Tables 1 to 10 of Ai & Li, Sensors 2025, 25(7), 2309, beside ours."""

from handlcp.method.paper.data import Example, PaperTable, example, table
from handlcp.method.paper.render import paper_command
from handlcp.method.paper.report import PaperReport, run
from handlcp.method.paper.tables import Comparison, compare, compare_all

__all__ = [
    "Comparison", "Example", "PaperReport", "PaperTable", "compare", "compare_all", "example", "paper_command", "run",
    "table",
]  # fmt: skip
