"""Errors and times for people."""

from __future__ import annotations

ROUNDING = 1e-12  # errors below say nothing about methods and faces


def share(error: float) -> str:
    """An error for people: 0 where it is rounding, powers of ten, percents from 0.01 % on, multiples from ten on."""
    if error < ROUNDING:
        return "0"
    if error < 0.995e-4:
        return f"{error:.0e}"
    return f"{100 * error:.2g} %" if error < 0.995 else f"{100 * error:.0f} %" if error < 10 else f"{error:.0f} ×"


def microseconds(seconds: float) -> str:
    """A time for people: "42 µs", "3.1 ms", "1.2 s"."""
    for size, name in ((1e-6, "µs"), (1e-3, "ms")):
        if seconds < 999.5 * size:
            value = seconds / size
            return f"{value:.0f} {name}" if value >= 9.95 else f"{value:.1f} {name}"
    return f"{seconds:.2g} s"
