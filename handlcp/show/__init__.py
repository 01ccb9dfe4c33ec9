"""What people look at: verdicts, tables, pictures. The only place that imports matplotlib, and only when it draws."""

from handlcp.show.verdict import Verdict, verdict

__all__ = ["Verdict", "verdict"]
