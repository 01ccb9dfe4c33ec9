"""The paper, reproduced: Examples 1 to 5 and Tables 1 to 10 of Ai & Li, Sensors 2025, 25(7), 2309, beside ours."""

from handlcp.study.paper.data import Example, PaperTable, example, table
from handlcp.study.paper.render import paper_command
from handlcp.study.paper.report import PaperReport, run
from handlcp.study.paper.tables import Comparison, compare, compare_all

__all__ = [
    "Comparison", "Example", "PaperReport", "PaperTable", "compare", "compare_all", "example", "paper_command", "run",
    "table",
]  # fmt: skip
