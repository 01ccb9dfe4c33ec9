"""Child of `mutate_files`: reads files one by one and says in one line each what became of it.

Runs apart, with a limit on its memory, so that a crash or a hang is seen, and which file it was.
"""

import contextlib
import os
import resource
import shutil
import sys
import time
import warnings
from pathlib import Path

import handlcp as hl
from handlcp import scene
from tests.support.sweeps import check_study, table_of

GB = 2**30
LONGEST = 20_000  # letters of a message
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def read_hand(path):
    """With all its shapes, and what `audit` and `describe` say."""
    for look in (hl.audit_urdf, hl.describe_urdf):
        with contextlib.suppress(hl.HandLCPError):
            str(look(path))
    hand = hl.Hand.from_urdf(path, joint_stiffness=2.0, tip_radius=0.01)
    _ = hand.at(hand.neutral).tip_positions, str(hand.audit()), str(hand.describe().to_dict())


def read_mjcf(path):
    """Joints, springs, tendons and shapes."""
    with contextlib.suppress(hl.HandLCPError):
        hl.tendon_routes(path)
    hand = hl.Hand.from_mjcf(path, joint_stiffness=2.0)
    _ = hand.at(hand.neutral).jacobian, str(hand.audit()), str(hand.describe().to_dict())


def read_study(path):
    """What is asked of the table of a sweep."""
    study = hl.Study.load(path)
    str(study)
    _ = study.space, study.failed, list(study)
    for ask in (lambda: study.best(2), study.pareto, lambda: study.best(2, "-torque")):
        with contextlib.suppress(hl.HandLCPError):
            str(ask())


READ = {
    "urdf": read_hand, "mjcf": read_mjcf, "scene": lambda path: scene.load(path).build(), "brief": hl.Brief.from_toml,
    "study": check_study, "yaml": hl.read_postures, "npy": hl.read_postures, "csv": read_study, "parquet": read_study,
    "json": lambda path: read_study(table_of(path)), "rows": lambda path: read_study(table_of(path)),
    "mesh": lambda path: hl.Mesh(path, mass=0.1),
}  # fmt: skip


def watch(allowed):
    """Collects the files that Python opens to write, makes, moves or removes outside of these folders."""
    written = list[str]()

    def hook(event, args):
        changes = event in ("os.rename", "os.mkdir", "os.remove", "os.link", "os.symlink", "os.truncate", "os.chmod")
        opens = event == "open" and isinstance(args[2], int) and bool(args[2] & WRITES)
        if (changes or opens) and isinstance(args[0], str | bytes | os.PathLike):
            path = os.path.abspath(os.fsdecode(args[0]))
            if not path.startswith(allowed):
                written.append(path)

    sys.addaudithook(hook)
    return written


def size():
    """Most memory so far [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main(listing, first, own, limit):
    """A line a file from number `first` on: number, outcome, seconds. own : folder for this process's own files."""
    warnings.simplefilter("error")
    cache = os.environ.get("HANDLCP_CACHE_DIR", str(Path.home() / ".cache"))
    written = watch((own, cache, str(Path(hl.__file__).parent), "/dev/null"))
    empty = Path(own, "cwd")
    shutil.rmtree(empty, ignore_errors=True)
    empty.mkdir()
    os.chdir(empty)
    hl.finger_hand(2)  # imports, before memory is counted
    before = size()
    with open("/proc/self/statm", encoding="ascii") as file:
        virtual = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (virtual + 4 * GB, virtual + 4 * GB))
    lines = Path(listing).read_text(encoding="utf-8").splitlines()
    for number in range(first, len(lines)):
        kind, path = lines[number].split("\t")
        print(f"{number}\tbegins", flush=True)
        written.clear()
        began, outcome = time.process_time(), "read"
        try:
            READ[kind](Path(path))
        except hl.HandLCPError as error:
            outcome = "refused" if len(str(error)) < LONGEST else "untyped: a message that nobody reads"
        except MemoryError:
            outcome = "memory"
        except BaseException as error:
            outcome = f"untyped {type(error).__name__}: {str(error)[:200]}"
        took = time.process_time() - began
        if size() - before > 2 * GB:
            outcome = "memory"
        if took > limit:
            outcome = "hang"
        if written or os.listdir(empty):
            outcome = f"written {[*written, *os.listdir(empty)][:3]}"
        print(f"{number}\t{outcome!r}\t{took:.2f}", flush=True)
        if outcome == "memory" or outcome.startswith("written"):
            return  # begin anew


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3], float(sys.argv[4]))
