"""Programs that tests start, and processes that compute: what they hear, and how much room they have on the disk."""

import os
import signal
import subprocess
import sys
from pathlib import Path

_ROOT = Path(__file__).parents[2]
_LIMIT = """
import resource, sys
sys.dont_write_bytecode = True  # half a file of it would be read as a whole one by whoever imports it next
def room(most):
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, resource.RLIM_INFINITY))
"""


def hears_ctrl_c():
    """Arguments of `subprocess.Popen` for a program that Ctrl-C ends, as one that a shell starts in the foreground.

    Who runs the tests in the background of a script, or under nohup, ignores it, and so would all that they start.
    """
    return {"preexec_fn": _hear} if os.name == "posix" else {}


def _hear():
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def on_a_full_disk(program):
    """What a program of Python prints, in a process of its own, in which `room(most)` says how large a file may become
    [B]: a write that needs more takes a part, and then fails, as on a disk that fills up. Needs no rights.
    """
    own = os.environ | {"PYTHONPATH": os.pathsep.join([str(_ROOT), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-c", _LIMIT + program]
    done = subprocess.run(command, capture_output=True, text=True, env=own, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "", "nothing is said past the errors that are caught"
    return done.stdout
