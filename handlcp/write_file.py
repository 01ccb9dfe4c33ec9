"""`write_file`: files as answers leave them: whole, or not at all.

`write_file` writes a new file beside the place that is asked for, hands it to the disk, and then moves it there. A disk
that fills up, a program that is killed: whoever looks finds the earlier file or the new one, and never a part of one.

    place                              what happens
    a file, or nothing yet             replaced; permissions stay those it had, or are what the umask leaves a new file
    a symbolic link                    stays, and the file that it points to is replaced
    one of several hard links          becomes a file of its own; the others keep the earlier content
    /dev/stdout, >(a command) in bash  written to the open descriptor, after what was printed before
    a named pipe, a device             opened and written
    a file that may not be written     refused, though its folder would allow to replace it
"""

from __future__ import annotations

import os
import secrets
import stat
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from handlcp.errors import InputError, as_path, refuse_unwritable

_MAX_SYMLINKS = 40  # symbolic links on the way to a file, as Linux has it
_NEW_FILE_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)


def write_file(argument: str, file: Any, content: str | bytes) -> Path:
    """Write a whole file, as the top of this file says, and return its path.

    argument : what the caller calls the file, for messages. content : text is written as UTF-8; half a surrogate pair,
        which that cannot express, as its escape.

    Raises InputError where the file cannot be written; an earlier file is then as it was.
    """
    path = as_path(argument, file)
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    with refuse_unwritable(argument, path):
        if (descriptor := _find_descriptor(path)) is not None:
            _flush_streams()
            write_all(_stdout_descriptor(descriptor), data)
        elif _is_special(path):
            with path.open("wb", buffering=0) as out:
                write_all(out.fileno(), data)
        else:
            _replace_file(path, data)
    return path


def check_destination(argument: str, file: Any) -> Path:
    """The path of a file, checked before a long computation: that `write_file` can write it, as far as can be known.

    What the file holds stays as it is, and a file that did not exist does not exist afterwards. Raises InputError.
    """
    path = as_path(argument, file)
    with refuse_unwritable(argument, path):
        if not path.absolute().parent.is_dir():
            raise InputError(argument, "a file in a folder that exists", repr(str(path)))
        if (descriptor := _find_descriptor(path)) is not None:
            os.fstat(_stdout_descriptor(descriptor))
        elif _is_special(path):
            _check_device(path)
        else:
            descriptor, beside = _create_temporary(_resolve_target(path))
            os.close(descriptor)
            os.unlink(beside)
    return path


# ----------------------------------------------------------------
# A file in the place of another.


def _replace_file(file: Path, data: bytes) -> None:
    target = _resolve_target(file)
    descriptor, beside = _create_temporary(target)
    try:
        try:
            write_all(descriptor, data)
            _keep_owner(descriptor, target)
            os.fsync(descriptor)  # some disks say only now that they are full
        except BaseException:
            with suppress(OSError):
                os.close(descriptor)
            raise
        os.close(descriptor)
        os.replace(beside, target)
    except BaseException:
        with suppress(OSError):
            os.unlink(beside)
        raise


def _resolve_target(file: Path) -> Path:
    """The file that a path leads to, past all links. Raises OSError for one that may not be written."""
    with suppress(FileNotFoundError):
        os.close(os.open(file, os.O_WRONLY))
    return Path(os.path.realpath(file))


def _create_temporary(target: Path) -> tuple[int, Path]:
    """An open new file in the folder of another: its descriptor and its path."""
    beside = target.with_name(f".{secrets.token_hex(8)}.tmp")
    return os.open(beside, _NEW_FILE_FLAGS, 0o666), beside


def _keep_owner(descriptor: int, target: Path) -> None:
    """Give a new file the permissions of the one whose place it takes, and its owner where we may."""
    try:
        before = os.stat(target)
    except FileNotFoundError:
        return
    if hasattr(os, "fchown"):
        now = os.fstat(descriptor)
        if (now.st_uid, now.st_gid) != (before.st_uid, before.st_gid):
            with suppress(OSError):
                os.fchown(descriptor, before.st_uid, before.st_gid)
        os.fchmod(descriptor, stat.S_IMODE(before.st_mode))


def write_all(descriptor: int, data: bytes) -> None:
    """Write everything, in as many pieces as the system takes. Raises OSError."""
    rest = memoryview(data)
    while rest:
        rest = rest[os.write(descriptor, rest) :]


# ----------------------------------------------------------------
# Places that are no files: descriptors, pipes, devices.


def _find_descriptor(file: Path) -> int | None:
    """The number of the open descriptor of this process that a path is a name of, such as /dev/stdout; None: of none.

    Opened anew, a file that stdout was redirected to would be written from its beginning.
    """
    path = os.path.abspath(file)
    for _ in range(_MAX_SYMLINKS):
        folder, name = os.path.split(path)
        folder = os.path.realpath(folder)
        if name.isdecimal() and folder in ("/dev/fd", f"/proc/{os.getpid()}/fd"):
            return int(name)
        if not os.path.islink(path):
            return None
        path = os.path.join(folder, os.readlink(path))
    return None


def _stdout_descriptor(descriptor: int) -> int:
    """Descriptor 1 is where stdout goes, wherever the command line has moved that; others are themselves."""
    if descriptor == 1:
        with suppress(AttributeError, OSError, ValueError):  # there is none, or it is no file, or closed
            return sys.stdout.fileno()
    return descriptor


def _flush_streams() -> None:
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()


def _is_special(file: Path) -> bool:
    """Whether there is something that is no plain file: a device, a pipe, a socket. Raises OSError."""
    try:
        found = os.stat(file).st_mode
    except FileNotFoundError:
        return False
    return not (stat.S_ISREG(found) or stat.S_ISDIR(found))


def _check_device(file: Path) -> None:
    """Check that a device takes data, unlike /dev/full. Raises OSError. Opening a pipe would end its reader."""
    if stat.S_ISCHR(os.stat(file).st_mode):
        with file.open("ab", buffering=0) as out:
            if not out.isatty():
                out.write(b"\n")  # such devices keep nothing
