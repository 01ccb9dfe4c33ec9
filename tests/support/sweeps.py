"""Doors into sweeps: spaces of parameters, which designs start together, tables and journals, main effects."""

from handlcp.cli.design import load_hand
from handlcp.design.space import Space
from handlcp.design.sweep.cells import points
from handlcp.design.sweep.journal import Journal, beside
from handlcp.design.sweep.study_file import load
from handlcp.design.sweep.sweep import check_names
from handlcp.design.sweep.work import Maker


def check_study(path):
    """What `handlcp sweep` does with a study file before it evaluates a design: it is loaded, and its first made."""
    file = load(path, load_hand)
    room = Space(file.tables.space)
    check_names(room)
    cube = points(room, file.tables.sampling, file.tables.samples, file.tables.seed)
    maker, values = Maker(file.make, file.brief), room.point(cube[0])
    maker.check(values)
    maker.hand(values)
    maker.asked(values)


def journal_of(table, sweep, rows):
    """A journal beside a table that is not there."""
    with Journal(beside(table), sweep) as journal:
        journal.append(rows)


def table_of(path):
    """The table whose description, or journal, this file is."""
    return path.with_name(path.name.removesuffix(".json").removesuffix(".rows"))
