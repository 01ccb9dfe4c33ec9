"""Where the output goes: pipes that close, full disks, terminals without UTF-8, and libraries that print."""

from __future__ import annotations

import codecs
import os
import signal
import stat
import sys
import unicodedata
from io import TextIOWrapper

# What the package's words and tables use beyond ASCII, for terminals that cannot show it
_SPELT = {
    "–": "-", "—": "-", "−": "-", "…": "...", "·": ".", "•": "*", "█": "#", "─": "-", "━": "-", "│": "|", "┃": "|",
    "×": "x", "÷": "/", "±": "+-", "≈": "~", "∝": "~", "∼": "~", "≤": "<=", "≥": ">=", "≠": "!=", "≪": "<<", "≫": ">>",
    "∞": "inf", "√": "sqrt ", "Σ": "sum ", "°": " deg", "µ": "u", "‖": "|", "⟂": "_|_", "→": "->", "←": "<-", "↑": "^",
    "↓": "v", "✓": "ok", "✗": "no", "∈": "in", "∂": "d", "“": '"', "”": '"', "‘": "'", "’": "'", "„": '"', "ß": "ss",
}  # fmt: skip


def open_streams() -> None:
    """Make stdout this program's own, and both streams able to print anything. Ends the program where stdout has no
    room.

    What C code prints on stdout, such as a stray line of HiGHS, is discarded. A reader that closes the pipe, such as
    `head`, ends the program without a word, as it does others (141 in the shell).
    """
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    codecs.register_error("spelt", spelt)
    out = sys.stdout
    for stream in (out, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="spelt")
    if not isinstance(out, TextIOWrapper) or out is not sys.__stdout__:
        return
    if full(1):
        lost()
        raise SystemExit(2)
    ours, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = open(ours, "w", encoding=out.encoding, errors="spelt")  # noqa: SIM115


def full(descriptor: int) -> bool:
    """Whether a device takes nothing, as /dev/full does. Asked before the work; of a disk that is known afterwards."""
    if not stat.S_ISCHR(os.fstat(descriptor).st_mode) or os.isatty(descriptor):
        return False
    try:
        os.write(descriptor, b"\n")  # such a device keeps nothing
    except OSError:
        return True
    return False


def lost(why: str = "No space left on device") -> None:
    """Say on stderr that stdout took no output, and keep quiet about what is still in its buffer."""
    print(f"Error: output: expected a stream that takes it, got {why}", file=sys.stderr)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def spelt(error: UnicodeError) -> tuple[str, int]:
    """For `codecs.register_error`: characters that an encoding lacks, as a typewriter has them."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_ascii(c) for c in error.object[error.start : error.end]), error.end


def _ascii(character: str) -> str:
    if (known := _SPELT.get(character)) is not None:
        return known
    if unicodedata.combining(character):
        return ""
    name = unicodedata.name(character, "")
    if name.startswith(("GREEK SMALL LETTER ", "GREEK CAPITAL LETTER ")):
        letter = name.split()[3].lower()
        return letter if "SMALL" in name else letter.capitalize()
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return plain or "?"
