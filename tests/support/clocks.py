"""Clocks that stand in for the machine's, so that no test depends on how busy it is."""


class Ticking:
    """In place of the module `time`: every look at it takes so many seconds, and nothing else takes any."""

    def __init__(self, tick):
        self.now, self.tick = 0.0, tick

    def perf_counter(self):
        """A look [s]."""
        self.now += self.tick
        return self.now

    monotonic = perf_counter


def a_quarter_less(runs):
    """Times of runs, each run once: two seconds for everything (-1), half a second less without an effect (≥ 0); none
    for a run that ends in no answer.
    """
    return {k: 2.0 if k < 0 else 1.5 for k, run in runs.items() if run()}
