"""`cache_folders`: where compiled code may lie, under a name that changes with its source."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import threading
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[2]
_CONSTANT_FILES = ("tolerances.py", "status.py")  # files without a kernel whose numbers kernels take over
_PROBE_FILE = "probe"  # a file that is written to see whether one can be
_MAX_OLD_FOLDERS = 3  # folders of earlier sources that are left when a new one is made

write_lock = threading.Lock()  # held while a file is written: whoever ends the process waits for it
_unwritable_folders: dict[Path, str] = {}  # folder → why nothing could be written there


@cache
def fingerprint() -> str | None:
    """16 digits that stand for the contents of all files with kernels; None where the source cannot be read.

    A kernel is compiled together with those that it calls, from whatever file: so all of them count.
    """
    digest = hashlib.sha256()
    try:
        for file in sorted(_PACKAGE.rglob("*.py")):
            text = file.read_bytes()
            if b"\n@kernel" in text or file.name in _CONSTANT_FILES:
                digest.update(str(file.relative_to(_PACKAGE)).encode() + b"\0" + text + b"\0")
    except OSError:
        return None
    return digest.hexdigest()[:16]


@cache
def cache_folders() -> tuple[Path, ...]:
    """Where compiled code of this source may lie, best first: what HANDLCP_CACHE_DIR or NUMBA_CACHE_DIR names, else the
    package's own folder and then the user's cache folder. They need not exist. Empty where there is no fingerprint.
    """
    mark = fingerprint()
    name = f"{sys.implementation.cache_tag}-{mark}"
    return () if mark is None else tuple(root / name for root in _root_folders())


def _root_folders() -> list[Path]:
    for variable, below in (("HANDLCP_CACHE_DIR", "."), ("NUMBA_CACHE_DIR", "handlcp")):
        if given := os.environ.get(variable):
            return [Path(os.path.expanduser(given), below).absolute()]
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or os.path.expanduser("~/.cache")
    own = [_PACKAGE / "__pycache__" / "kernels"]
    return [*own, Path(home, "handlcp")] if os.path.isabs(home) else own  # "~" stays where there is no home


def _trusted_folders() -> list[Path]:
    """Those of the folders that are ours or root's, and that nobody else can write or replace: what lies there is
    run.
    """
    return [folder for folder in cache_folders() if not _is_open_to_others(folder)]


def _is_open_to_others(folder: Path) -> bool:
    """Whether others can write there, or put another folder in its place: rename it, in a folder above that anyone can
    write without the sticky bit of /tmp.
    """
    if os.name != "posix":
        return False
    with contextlib.suppress(OSError):
        if _is_writable_by_others(folder.stat()):
            return True
    for above in {*folder.parents, *folder.resolve().parents}:  # of links, of what they stand for as well
        with contextlib.suppress(OSError):
            if above.stat().st_mode & (stat.S_IWOTH | stat.S_ISVTX) == stat.S_IWOTH:
                return True
    return False


def _is_writable_by_others(found: os.stat_result) -> bool:
    """Whether somebody else than us and root has, or may change, what this is about; on Windows nobody is asked."""
    return os.name == "posix" and (bool(found.st_mode & 0o022) or found.st_uid not in (os.getuid(), 0))


def writable_folder() -> Path | None:
    """The folder that new code will go to, as far as can be seen without writing; None: there is none."""
    for folder in _trusted_folders():
        above = next((f for f in (folder, *folder.parents) if f.exists()), folder)
        if folder not in _unwritable_folders and above.is_dir() and os.access(above, os.W_OK):
            return folder
    return None


def is_kept(name: str) -> bool:
    """Whether there is compiled code of this kernel, for whatever types of arguments."""
    for folder in _trusted_folders():
        with contextlib.suppress(OSError):
            if any(entry.startswith(f"{name}-") for entry in os.listdir(folder)):
                return True
    return False


def file_stamp(name: str) -> int:
    """A number that changes when the file of this name is written anew; 0 where there is none."""
    for folder in _trusted_folders():
        with contextlib.suppress(OSError):
            return (folder / name).stat().st_mtime_ns
    return 0


def count_kept_kernels() -> tuple[int, Path | None]:
    """How many kernels have compiled code in the first folder that has any, and that folder; (0, None): none has."""
    for folder in _trusted_folders():
        with contextlib.suppress(OSError):
            if names := {file.name.rpartition("-")[0] for file in folder.glob("*.nbc")}:
                return len(names), folder
    return 0, None


def read_file(name: str) -> bytes | None:
    """The contents of the file of this name, from the first folder that has it whole, and written by us or root; None:
    none has.
    """
    for folder in _trusted_folders():
        with contextlib.suppress(OSError), (folder / name).open("rb") as file:
            if _is_writable_by_others(os.fstat(file.fileno())):  # of the open file: nobody can put another in its place
                continue
            data = file.read()
            if data[:32] == hashlib.sha256(data[32:]).digest():  # not truncated
                return data[32:]
    return None


def write_file(name: str, data: bytes) -> str | None:
    """Write the file of this name into the first folder that takes it, at once or not at all: other processes may read
    and write there. Returns None, or why no folder takes it, in words.
    """
    why = "its source cannot be read"
    for folder in cache_folders():
        if _is_open_to_others(folder):
            _unwritable_folders[folder] = f"{folder}: others can write there or above, and what lies there is run"
        if folder not in _unwritable_folders:
            try:
                with write_lock:
                    _write(folder, name, hashlib.sha256(data).digest() + data)
            except OSError as error:
                _unwritable_folders[folder] = f"{folder}: {error.strerror or error}"
            else:
                return None
        why = _unwritable_folders[folder]
    return why


def why_unwritable() -> str | None:
    """Why no folder takes anything, in words; None where one does. Something is written, and removed again."""
    why = write_file(_PROBE_FILE, b"")
    for folder in cache_folders():
        with contextlib.suppress(OSError):
            (folder / _PROBE_FILE).unlink()
    return why


def make_folder(folder: Path) -> None:
    """Make it, as a new one of this source."""
    if not folder.is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        folder.chmod(0o755)
        _forget_old(folder)


def _write(folder: Path, name: str, data: bytes) -> None:
    make_folder(folder)
    handle, beside = tempfile.mkstemp(dir=folder, prefix=".")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(beside, 0o644)  # who may read the package may read what is compiled of it
        os.replace(beside, folder / name)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(beside)
        raise


def _forget_old(folder: Path) -> None:
    """Remove all but the newest folders of earlier sources beside this one; of this interpreter alone."""
    tag = folder.name.removesuffix(folder.name.rpartition("-")[2])
    with contextlib.suppress(OSError):
        old = [f for f in folder.parent.glob(f"{tag}{'[0-9a-f]' * 16}") if f != folder]
        for one in sorted(old, key=lambda f: f.stat().st_mtime)[:-_MAX_OLD_FOLDERS]:
            shutil.rmtree(one, ignore_errors=True)
