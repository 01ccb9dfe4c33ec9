"""When kernels are compiled, what is kept of that, and that nothing about it is ever an error."""

import os
import pathlib
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import handlcp as hl
from handlcp.cli.warm_jobs import JOBS
from handlcp.lcp.compiler.compile_policy import MANY_CALLS, compile_now
from tests.support import kernels as k

ROOT = pathlib.Path(__file__).parents[2]


def process(code, folder, **environment):
    """A new Python process with a cache of its own."""
    env = {n: v for n, v in os.environ.items() if n != "HANDLCP_KERNELS"}
    env |= {"HANDLCP_CACHE_DIR": str(folder)} | environment
    return subprocess.Popen(
        [sys.executable, "-c", code], cwd=ROOT, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


# ---------------------------------------------------------------- lazy
def test_importing_the_package_loads_nothing_and_a_first_answer_no_compiler(tmp_path):
    code = """
import sys
import handlcp as hl
loaded = {"numpy", "scipy", "numba", "rich", "pinocchio", "typer"} & set(sys.modules)
assert not loaded, loaded
out = [(1, 0, 0), (-0.6, 0.8, 0), (-0.6, -0.8, 0)]
c = [hl.Contact((x / 100, y / 100, z), (-x, -y, z), hl.Coulomb(0.5)) for x, y, z in out]
assert hl.Grasp(c, (0, 0, -1, 0, 0, 0), flexibility=1e-4, preload=1e-3).solve().held
parts = {name.split(".")[1] for name in sys.modules if name.startswith("scipy.")} - {"version"}
loaded = {"numba", "rich", "pinocchio", "typer", "pydantic"} & set(sys.modules)
loaded |= {part for part in parts if not part.startswith("_")}
assert not loaded, loaded
"""
    done = process(code, tmp_path)
    assert done.communicate() == ("", "")
    assert done.returncode == 0
    assert not list(tmp_path.iterdir())


def test_every_public_name_is_found_and_listed():
    assert set(hl.__all__) <= set(dir(hl))
    assert {getattr(hl, name).__name__ for name in hl.__all__} == set(hl.__all__)
    assert hl.lcp.LCP is hl.LCP
    with pytest.raises(AttributeError, match="no attribute 'Nothing'"):
        _ = hl.Nothing


# ---------------------------------------------------------------- when
def test_a_kernel_runs_as_python_until_compiling_pays(tmp_path):
    kernel = k.anew(k.small())
    with k.cached_in(tmp_path), k.automatic(), k.alone():
        k.run_small(kernel)
        k.run_small(kernel)
        assert not k.is_compiled(kernel)
        with k.impatient():
            kernel.spent = 1.0  # more than loading takes
            np.testing.assert_array_equal(k.run_small(kernel), [1.0, 2.0, 3.0])
        assert k.is_compiled(kernel)


def test_arguments_of_other_types_run_as_python_again(tmp_path):
    kernel = k.anew(k.small())
    with k.cached_in(tmp_path), k.automatic():
        with compile_now():
            k.run_small(kernel)
        assert len(kernel.jit.signatures) == 1
        out = np.zeros(3, np.float32)
        kernel(np.eye(3), np.ones(3), np.ones(3), out)
        np.testing.assert_array_equal(out, 2.0)
        assert len(kernel.jit.signatures) == 1


def test_read_only_arrays_and_constants_need_no_code_of_their_own(tmp_path):
    constant = np.eye(3)
    constant.flags.writeable = False
    with k.cached_in(tmp_path), k.automatic(), compile_now():
        for M in (constant, np.eye(3)):
            kernel, out = k.anew(k.small()), np.zeros(3)
            for _ in range(2):
                kernel(M, np.arange(3.0), np.ones(3), out)
                np.testing.assert_array_equal(out, [1.0, 2.0, 3.0])
            assert len(kernel.jit.signatures) == 1
        assert k.loaded(kernel) == 1, "what was compiled for the first is loaded for the second"
        assert called_with_constants(k.decorated) == (7.0, 1)


def called_with_constants(decorated):
    """(what a kernel returns, for how many sets of types it was compiled) that another calls in two ways."""

    @decorated
    def scaled(x, by):
        return x * by

    @decorated
    def both(x, by):
        return scaled(x, 2) + scaled(x, 3) + scaled(x, by)

    return both(1.0, 2), len(scaled.jit.signatures)


def test_a_slice_of_another_shape_is_an_error(tmp_path):
    @k.decorated
    def put(out, x):
        out[:2] = x

    with k.cached_in(tmp_path), k.automatic(), compile_now(), pytest.raises(ValueError, match="another shape"):
        put(np.zeros(3), np.ones(3))


def test_at_once_compiles_at_the_first_call_where_there_are_many(tmp_path):
    few, many = k.anew(k.small()), k.anew(k.small())
    with k.cached_in(tmp_path), k.automatic():
        with compile_now(MANY_CALLS - 1):
            k.run_small(few)
        assert not k.is_compiled(few)
        with compile_now(MANY_CALLS), ThreadPoolExecutor(2) as pool:  # other threads, too
            list(pool.map(lambda _: k.run_small(many), range(4)))
        assert len(many.jit.signatures) == 1


@pytest.mark.parametrize("word", ["auto", "compiled", "interpreted"])
def test_a_word_in_the_environment_decides(monkeypatch, word):
    assert k.mode(monkeypatch, word) == word


def test_another_word_is_refused(monkeypatch):
    with pytest.raises(hl.InputError, match='HANDLCP_KERNELS: expected "auto", "compiled" or "interpreted"'):
        k.mode(monkeypatch, "fast")


def test_a_kernel_of_another_package_is_compiled_and_not_kept(tmp_path):
    @k.decorated
    def double(x):
        return 2.0 * x

    with k.cached_in(tmp_path), k.automatic(), compile_now():
        assert double(4.0) == 8.0
        assert k.is_compiled(double)
    assert not list(tmp_path.iterdir())


def test_a_kernel_is_pickled_by_its_name():
    assert pickle.loads(pickle.dumps(k.small())) is k.small()


# ---------------------------------------------------------------- what is kept
def test_a_second_process_loads_what_the_first_compiled(tmp_path):
    for hits in (0, 1):
        kernel = k.anew(k.small())
        with k.cached_in(tmp_path), k.automatic():
            with compile_now():
                k.run_small(kernel)
            assert k.loaded(kernel) == hits
    kernel = k.anew(k.small())
    with k.cached_in(tmp_path), k.automatic():
        kernel.spent = 1.0  # as Python, which is longer than loading takes
        k.run_small(kernel)
        assert k.loaded(kernel) == 1


@pytest.mark.parametrize(
    "spoil", [lambda data: data[: len(data) // 2], lambda data: b"", lambda data: b"garbage" * 100], ids=range(3)
)
def test_a_spoilt_file_is_compiled_anew_without_a_word(tmp_path, capfd, spoil):
    for hits in (0, 0, 1):
        kernel = k.anew(k.small())
        with k.cached_in(tmp_path), k.automatic(), compile_now():
            np.testing.assert_array_equal(k.run_small(kernel), [1.0, 2.0, 3.0])
            file = next(k.folder_of_cache().glob("*.nbc"))
        assert k.loaded(kernel) == hits
        if spoil is not None:
            file.write_bytes(spoil(file.read_bytes()))
            spoil = None
    assert capfd.readouterr().err == ""


def test_a_file_that_holds_something_else_is_compiled_anew(tmp_path):
    with k.cached_in(tmp_path), k.automatic(), compile_now():
        k.run_small(k.anew(k.small()))
        name = next(k.folder_of_cache().glob("*.nbc")).name
        k.put(name, pickle.dumps(("of another time",)))
        np.testing.assert_array_equal(k.run_small(k.anew(k.small())), [1.0, 2.0, 3.0])


def test_where_nothing_can_be_written_one_hint_says_what_to_do(tmp_path, capfd, monkeypatch):
    k.said_afresh(monkeypatch, 60.0)
    (tmp_path / "file").write_text("no folder")
    for _ in range(2):
        with k.cached_in(tmp_path / "file" / "below"), k.automatic(), compile_now():
            np.testing.assert_array_equal(k.run_small(k.anew(k.small())), [1.0, 2.0, 3.0])
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert "Set HANDLCP_CACHE_DIR to a folder that can be written" in said


@pytest.mark.skipif(os.name != "posix", reason="modes of files are POSIX")
def test_others_may_read_what_is_kept_and_a_folder_that_they_can_write_is_refused(tmp_path, capfd, monkeypatch):
    k.said_afresh(monkeypatch, 60.0)
    with k.cached_in(tmp_path), k.automatic(), compile_now():
        k.run_small(k.anew(k.small()))
        folder = k.folder_of_cache()
        file = next(folder.glob("*.nbc"))
        assert (folder.stat().st_mode & 0o777, file.stat().st_mode & 0o777) == (0o755, 0o644)
        folder.chmod(0o777)
        kernel = k.anew(k.small())
        np.testing.assert_array_equal(k.run_small(kernel), [1.0, 2.0, 3.0])
        assert k.loaded(kernel) == 0
    assert "others can write there" in capfd.readouterr().err


@pytest.mark.skipif(os.name != "posix", reason="modes of files are POSIX")
@pytest.mark.parametrize(("mode", "loads"), [(0o777, 0), (0o1777, 1), (0o755, 1)])
@pytest.mark.parametrize("linked", [False, True])
def test_a_folder_below_one_that_anyone_can_write_is_refused(tmp_path, capfd, monkeypatch, mode, loads, linked):
    """Whoever can write there can rename the folder, and put another in its place."""
    k.said_afresh(monkeypatch, 60.0)
    above = tmp_path / "above"
    (above / "kept").mkdir(parents=True)
    (tmp_path / "link").symlink_to(above / "kept")
    with k.cached_in(tmp_path / "link" if linked else above / "kept"), k.automatic(), compile_now():
        k.run_small(k.anew(k.small()))
        above.chmod(mode)
        kernel = k.anew(k.small())
        np.testing.assert_array_equal(k.run_small(kernel), [1.0, 2.0, 3.0])
        assert k.loaded(kernel) == loads
    assert ("others can write there or above" in capfd.readouterr().err) == (not loads)
    above.chmod(0o755)


def given_away(path, monkeypatch):
    """Let it belong to another user, or this process to one that it does not belong to."""
    if os.getuid() == 0:
        os.chown(path, 65534, -1)
    else:
        monkeypatch.setattr("os.getuid", lambda: 65534)


@pytest.mark.skipif(os.name != "posix", reason="modes of files are POSIX")
@pytest.mark.parametrize("whose", ["others can write it", "another's file", "another's folder"])
def test_what_others_may_have_written_is_never_run(tmp_path, monkeypatch, whose):
    k.said_afresh(monkeypatch, 60.0)
    with k.cached_in(tmp_path), k.automatic(), compile_now():
        k.run_small(k.anew(k.small()))
        file = next(k.folder_of_cache().glob("*.nbc"))
        if whose == "others can write it":
            file.chmod(0o646)
        else:
            given_away(file if whose == "another's file" else file.parent, monkeypatch)
        kernel = k.anew(k.small())
        np.testing.assert_array_equal(k.run_small(kernel), [1.0, 2.0, 3.0])
        assert k.loaded(kernel) == 0


@pytest.mark.skipif(os.name != "posix", reason="modes of files are POSIX")
def test_a_file_that_others_could_write_is_replaced_by_one_that_they_cannot(tmp_path):
    with k.cached_in(tmp_path), k.automatic(), compile_now():
        k.run_small(k.anew(k.small()))
        file = next(k.folder_of_cache().glob("*.nbc"))
        file.chmod(0o666)
        for hits in (0, 1):
            kernel = k.anew(k.small())
            k.run_small(kernel)
            assert (k.loaded(kernel), file.stat().st_mode & 0o777) == (hits, 0o644)


def test_a_full_disk_is_no_error(tmp_path, capfd, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    k.said_afresh(monkeypatch, 60.0)
    monkeypatch.setattr("os.replace", full)
    with k.cached_in(tmp_path), k.automatic(), compile_now():
        np.testing.assert_array_equal(k.run_small(k.anew(k.small())), [1.0, 2.0, 3.0])
        assert not list(k.folder_of_cache().iterdir())
    assert "No space left on device" in capfd.readouterr().err


@pytest.mark.parametrize("home", [None, "/dev/null", "relative"])
def test_a_home_that_is_none_leaves_the_packages_own_folder(monkeypatch, home):
    for name in ("HANDLCP_CACHE_DIR", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.delenv(name, raising=False)
    if home is not None:
        monkeypatch.setenv("HOME", home)
    assert k.roots()[0].parts[-3:] == ("handlcp", "__pycache__", "kernels")
    assert all(root.is_absolute() for root in k.roots())


@pytest.mark.long
def test_several_processes_may_fill_a_cache_at_a_time(tmp_path):
    code = """
import numpy as np
from tests.support.kernels import loaded, small
w = np.zeros(3)
small()(np.eye(3), np.arange(3.0), np.ones(3), w)
print(w, loaded(small()))
"""
    several = [process(code, tmp_path, HANDLCP_KERNELS="compiled") for _ in range(3)]
    for done in [*several, process(code, tmp_path, HANDLCP_KERNELS="compiled")]:
        out, err = done.communicate()
        assert (out[:10], done.returncode) == ("[1. 2. 3.]", 0)
        assert all(line.startswith("handlcp: compiling") for line in err.splitlines())  # on a busy machine
    last = process(code, tmp_path, HANDLCP_KERNELS="compiled")
    assert last.communicate() == ("[1. 2. 3.] 1\n", "")


SOLVES = """
import numpy as np
from tests.support.kernels import is_compiled, large, loaded, small
if {other_first}:
    small()(np.eye(3), np.arange(3.0), np.ones(3), np.zeros(3))
x = np.zeros(2)
large()(np.array([[0.0, 2.0], [4.0, 0.0]]), np.array([2.0, 4.0]), x, np.zeros(2, dtype=np.int64), 1e-12)
print(x, loaded(large()))
"""


def solved(folder, other_first=False):
    """What a new process prints that solves two equations by a kernel which calls others where they are."""
    running = process(SOLVES.format(other_first=other_first), folder, HANDLCP_KERNELS="compiled")
    out, err = running.communicate()
    assert running.returncode == 0, err
    return out


@pytest.mark.long
def test_code_is_loaded_with_what_it_calls_or_compiled_anew(tmp_path):
    """A kernel that is called where it is may be gone from the cache, or come from another process under another
    symbol: code that called it would end the process.
    """
    one, other = tmp_path / "one", tmp_path / "other"
    assert [solved(one), solved(one)] == ["[1. 1.] 0\n", "[1. 1.] 1\n"]
    assert solved(other, other_first=True) == "[1. 1.] 0\n"
    called = next(one.rglob("*_pivot_anywhere-*.nbc"))
    theirs = next(other.rglob(called.name))
    assert called.read_bytes() != theirs.read_bytes()
    called.write_bytes(theirs.read_bytes())
    assert [solved(one), solved(one)] == ["[1. 1.] 0\n", "[1. 1.] 1\n"]
    called.unlink()
    assert [solved(one), solved(one)] == ["[1. 1.] 0\n", "[1. 1.] 1\n"]


def test_folders_of_earlier_sources_do_not_pile_up(tmp_path):
    with k.cached_in(tmp_path):
        tag = k.folder_of_cache().name.rpartition("-")[0]
        for i in range(6):
            (tmp_path / f"{tag}-{i:016x}").mkdir()
        (tmp_path / "mine").mkdir()
        k.put("a", b"b")
        left = {p.name for p in tmp_path.iterdir()}
        assert len(left) == 5
        assert {"mine", k.folder_of_cache().name} <= left


def test_the_fingerprint_covers_the_constants_that_kernels_take_over():
    assert len(k.known_files()) > 20
    assert [(file.name, name) for file, name, source in k.constants() if source not in k.known_files()] == []


@pytest.mark.parametrize(("patience", "lines"), [(0.0, 2), (60.0, 0)])
def test_compiling_that_takes_long_says_so_once_and_again_where_it_takes_much_longer(
    capfd, monkeypatch, patience, lines
):
    import time

    k.said_afresh(monkeypatch, patience)
    for seconds in (10.0, 15.0, 30.0, 30.0):
        with k.waiting(seconds):
            time.sleep(0.05)
    said = capfd.readouterr().err.splitlines()
    assert len(said) == lines
    for line, seconds in zip(said, (10, 30), strict=False):
        assert line.startswith(f"handlcp: compiling, about {seconds} s, once; kept in ")


@pytest.mark.parametrize(("name", "job"), JOBS, ids=[name for name, _ in JOBS])
def test_what_is_compiled_beforehand_runs(name, job):
    job()
