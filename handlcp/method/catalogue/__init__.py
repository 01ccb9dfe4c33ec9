"""The catalogue of effects: what there is, when to use it, how to ask for it, what it costs."""

from handlcp.method.catalogue.page import Cost, anchor, cost, costs, entries, here_and_now, page, trials

__all__ = ["Cost", "anchor", "cost", "costs", "entries", "here_and_now", "page", "trials"]
