"""The catalogue of effects: what there is, when to use it, how to ask for it, what it costs."""

from handlcp.study.catalogue.cost import Cost, cost, costs
from handlcp.study.catalogue.effects import entries
from handlcp.study.catalogue.page import anchor, here_and_now, page
from handlcp.study.catalogue.reference import trials

__all__ = ["Cost", "anchor", "cost", "costs", "entries", "here_and_now", "page", "trials"]
