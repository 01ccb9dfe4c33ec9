"""Each sentence of the table of SECURITY.md, and of its list about compiled code, has a test here or names one."""

import json
import os
import pathlib
import re

import numpy as np
import pytest

import handlcp as hl
from handlcp import scene
from handlcp.design.sweep.study_file import DESIGN_NUMBERS
from handlcp.design.sweep.table import write_table
from tests.fuzz import mutate_files, seed_files
from tests.support.files import read_limits
from tests.support.sweeps import check_study

ROOT = pathlib.Path(__file__).parents[1]
PAGE = ROOT / ".github" / "SECURITY.md"
PROVEN = {
    # Of compiled code
    "A folder that others than the user can write, or that belongs to somebody else than the user or root, is refused.":
        "tests/lcp/test_kernels.py::test_what_others_may_have_written_is_never_run",
    "A folder below one that anyone can write is refused, too, unless that has the sticky bit of /tmp.":
        "tests/lcp/test_kernels.py::test_a_folder_below_one_that_anyone_can_write_is_refused",
    "A file that others can write, or that belongs to somebody else, is not read.":
        "tests/lcp/test_kernels.py::test_what_others_may_have_written_is_never_run",
    "It is compiled anew and replaced.":
        "tests/lcp/test_kernels.py::test_a_file_that_others_could_write_is_replaced_by_one_that_they_cannot",
    "Folders are made for all to read and one to write (755), files likewise (644).":
        "tests/lcp/test_kernels.py::test_others_may_read_what_is_kept_and_a_folder_that_they_can_write_is_refused",
    # Of files, where a test elsewhere proves it
    "All of it: it is a program, which xacrodoc expands.":
        "tests/hand/test_input.py::test_a_xacro_file_is_the_hand_that_its_urdf_is",
    "Links, joints, shapes and numbers.": "tests/hand/test_kinematics.py::test_psyonic_follows_its_urdf",
}  # fmt: skip


def proves(*sentences):
    """Marks a test of these sentences."""
    PROVEN.update(dict.fromkeys(sentences, "here"))
    return lambda test: test


def sentences():
    """All of the table and of the list about compiled code."""
    text = PAGE.read_text(encoding="utf-8")
    cells = [cell for row in re.findall(r"^\| (?!file|---)(.*) \|$", text, re.M) for cell in row.split(" | ")[1:]]
    listed = " ".join(text.split("## Compiled code")[1].split("## ")[0].split("\n\n")[2].split())
    cells += re.split(r"(?:^|\s)- ", listed)
    return [one for cell in cells for one in re.split(r"(?<=\.) (?=[A-Z])", cell.strip()) if one]


def test_each_sentence_of_the_page_has_a_test_and_no_test_a_sentence_that_is_gone():
    assert set(sentences()) == set(PROVEN)
    for where in set(PROVEN.values()) - {"here"}:
        file, _, name = where.partition("::")
        assert f"def {name}" in (ROOT / file).read_text(encoding="utf-8"), where


@pytest.fixture
def seeds(tmp_path):
    """Kind → valid files."""
    return seed_files.write_seeds(tmp_path)


# ---------------------------------------------------------------- Any file.


@pytest.fixture(scope="module")
def small_run(tmp_path_factory):
    return mutate_files.run(tmp_path_factory.mktemp("mutants"), 130, seed=47)


@proves("It runs nothing.", "It writes no file that the caller did not name.",
        "It ends in nothing but an answer or a `HandLCPError`.")  # fmt: skip
def test_damaged_files_of_all_kinds_end_typed_in_time_and_memory_and_write_nothing(small_run):
    """Among them pickles, a tag of YAML that would touch a file, and studies that name a file to write."""
    assert not small_run.wrong, str(small_run)
    assert small_run.found["read"] + small_run.found["refused"] == small_run.found["files"] == 130


def test_the_seeds_of_the_run_are_read_so_that_mutants_reach_beyond_the_first_check(seeds, tmp_path):
    from tests.fuzz.read_files import READ

    for kind, files in seeds.items():
        for file in files:
            if file.suffix != ".npy":  # of one array, and of a pickle
                READ[kind](file)


@proves("Up to a size, and to a count of what it describes, before anything is built of it.")
@pytest.mark.parametrize(("kind", "text", "said"), [
    ("urdf", "<robot>" + "<a/>" * 100_001 + "</robot>", "100000 elements"),
    ("urdf", "<robot " + " ".join(f'a{i}="1"' for i in range(300_000)) + "/>", "100 attributes"),
    ("urdf", "<robot>" + "<a>" * 300, "200 deep"),
    ("urdf", "<robot>" + " " * 5_000_000 + "</robot>", "5 MB"),
    ("mjcf", '<mujoco><size nkey="100000000"/></mujoco>', "nkey of <size>"),
    ("scene", "a" + ".a" * 20_000 + " = 1", "64 dots"), ("scene", "a = [" + "1," * 100_001 + "]", "100000 values"),
    ("scene", "a = " + "[" * 40 + "]" * 40, "32 arrays"), ("scene", "#" * 1_000_001, "1 MB"),
    ("yaml", "[" * 40 + "]" * 40, "32 lists"),
])  # fmt: skip
def test_what_is_too_large_is_refused_by_name(tmp_path, kind, text, said):
    file = tmp_path / f"file.{dict(urdf='urdf', mjcf='xml', scene='toml', yaml='yaml')[kind]}"
    file.write_text(text, encoding="utf-8")
    read = {"urdf": lambda: hl.Hand.from_urdf(file, joint_stiffness=1.0), "mjcf": lambda: hl.Hand.from_mjcf(file),
            "scene": lambda: scene.load(file), "yaml": lambda: hl.read_postures(file)}[kind]  # fmt: skip
    with pytest.raises(hl.InputError, match=said):
        read()


# ---------------------------------------------------------------- URDF, xacro, MJCF, meshes.


@proves("A DOCTYPE is refused, so that no entity grows or reads another file.")
@pytest.mark.parametrize("entity", ['"aaaa"', 'SYSTEM "file:///etc/hostname"'])
def test_a_doctype_is_refused(entity):
    with pytest.raises(hl.URDFError, match="DOCTYPE"):
        hl.Hand.from_urdf(f'<!DOCTYPE r [<!ENTITY a {entity}>]><robot name="&a;"/>', joint_stiffness=1.0)


@proves("Macros in a string are refused.")
def test_macros_in_a_string_are_refused():
    text = '<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:property name="a" value="1"/></robot>'
    with pytest.raises(hl.URDFError, match="macros in the XML string"):
        hl.Hand.from_urdf(text, joint_stiffness=1.0)


@proves("The model that MuJoCo compiles, with its includes.")
def test_includes_of_mjcf_are_read_and_counted(seeds, tmp_path):
    body = seed_files.MJCF.partition("<worldbody>")[2].partition("</worldbody>")[0]
    (tmp_path / "body.xml").write_text(f"<mujoco>{body}</mujoco>", encoding="utf-8")
    whole = tmp_path / "whole.xml"
    whole.write_text(seed_files.MJCF.replace(body, '<include file="body.xml"/>'), encoding="utf-8")
    assert hl.Hand.from_mjcf(whole, joint_stiffness=2.0).joint_names == ("right_joint",)  # which left_joint leads
    many = f'<mujoco><replicate count="20000">{body}</replicate></mujoco>'
    (tmp_path / "body.xml").write_text(many, encoding="utf-8")
    with pytest.raises(hl.URDFError, match="10000 elements"):
        hl.Hand.from_mjcf(whole, joint_stiffness=2.0)


@proves("Copies, keys, pictures, heights and steps are counted before MuJoCo begins.")
def test_small_mjcf_files_that_build_much_never_reach_mujoco(tmp_path, monkeypatch):
    mujoco = pytest.importorskip("mujoco")
    monkeypatch.setattr(mujoco.MjModel, "from_xml_path", lambda _: pytest.fail("it began"))
    for kind, name, data in seed_files.bombs(tmp_path / "victim"):
        if kind == "mjcf" and name != "memory.xml":  # which is reserved, and not taken
            (tmp_path / f"bomb_{name}").write_bytes(data)
            with pytest.raises(hl.URDFError):
                hl.Hand.from_mjcf(tmp_path / f"bomb_{name}", joint_stiffness=2.0)


@proves("MuJoCo leaves no log file.")
def test_a_warning_of_mujoco_is_written_nowhere(tmp_path, monkeypatch):
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "child.xml").write_text(
        '<mujoco model="c"><option impratio="10"/>' + seed_files.MJCF.partition("</asset>")[2].replace(
            '<geom type="mesh" mesh="tip"/>', '<geom size="0.01"/>'), encoding="utf-8")  # fmt: skip
    (tmp_path / "both.xml").write_text(
        '<mujoco><compiler conflict="warning"/><asset><model name="c" file="child.xml"/></asset><worldbody><frame>'
        '<attach model="c" body="palm" prefix="x"/></frame></worldbody></mujoco>', encoding="utf-8")  # fmt: skip
    monkeypatch.chdir(tmp_path)
    before = mujoco.MjLogConfig.get().logto_file
    hl.Hand.from_mjcf("both.xml", joint_stiffness=2.0)
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()
    assert mujoco.MjLogConfig.get().logto_file == before, "others' settings stay"
    mujoco.MjModel.from_xml_path("both.xml")
    assert (tmp_path / "MUJOCO_LOG.TXT").exists() == before, "this file has a warning"


@proves("STL, OBJ, DAE and PLY.")
def test_four_formats_of_meshes_are_read_and_no_other(seeds, tmp_path):
    for file in seeds["mesh"]:
        assert hl.Mesh(file, mass=0.1).volume == pytest.approx(0.02**3 / 6, rel=1e-6)
    for name in ("tip.glb", "tip.blend", "tip"):
        (tmp_path / name).write_bytes(seed_files.meshes()["tip.obj"])
        with pytest.raises(hl.InputError, match="STL, OBJ, DAE or PLY"):
            hl.Mesh(tmp_path / name, mass=0.1)


@proves("Nodes of Collada are counted as often as they are copied.")
@pytest.mark.parametrize(("levels", "copies", "circle", "said"), [
    (30, 2, False, "10000 nodes"), (1, 10_001, False, "10000 nodes"), (3, 1, True, "stand in each other"),
])  # fmt: skip
def test_copies_of_nodes_are_counted(tmp_path, levels, copies, circle, said):
    file = tmp_path / "part.dae"
    file.write_text(seed_files.collada(3, 2), encoding="utf-8")
    assert hl.Mesh(file, mass=0.1).volume == pytest.approx(8 * 0.02**3 / 6, rel=1e-6)
    file.write_text(seed_files.collada(levels, copies, circle), encoding="utf-8")
    with pytest.raises(hl.InputError, match=said):
        hl.Mesh(file, mass=0.1)


def test_words_among_the_numbers_of_collada_are_refused(tmp_path):
    """Assimp never comes past 1e400 among whole numbers."""
    file = tmp_path / "part.dae"
    file.write_text(seed_files.collada().replace("0 2 1", "0 1e400 1"), encoding="utf-8")
    with pytest.raises(hl.InputError, match="1e400"):
        hl.Mesh(file, mass=0.1)


def _binary_ply(corner):
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    head += "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
    faces = [np.uint8(3).tobytes() + row.tobytes() for row in seed_files.FACES.astype("<i4")]
    faces[0] = np.uint8(3).tobytes() + np.array([0, corner, 1], "<i4").tobytes()
    return head.encode() + seed_files.CORNERS.astype("<f4").tobytes() + b"".join(faces)


@proves("A PLY file lists nothing that is not there.")
def test_a_ply_file_is_what_its_header_says(tmp_path):
    """Each of these ended the process, or read what lies beside its memory."""
    file, text = tmp_path / "part.ply", seed_files.meshes()["tip.ply"]
    file.write_bytes(_binary_ply(2))
    assert hl.Mesh(file, mass=0.1).volume == pytest.approx(0.02**3 / 6, rel=1e-6)
    damaged = [text.replace(b"3 0 2 1", b"x 0 2 1"), text.replace(b"3 0 2 1", b"3 0 9 1"),
               text.replace(b"3 0 2 1", b"3 0 -1 1"), text.replace(b"3 0 2 1", b" 0.02 0.0\n3 0 2 1"),
               text.replace(b"vertex 4", b"vertex 4000000"), text.replace(b"property float y\n", b""),
               text.replace(b"3 1 2 3\n", b""), _binary_ply(4), _binary_ply(2)[:-1]]  # fmt: skip
    for data in damaged:
        file.write_bytes(data)
        with pytest.raises(hl.InputError, match="what its header lists"):
            hl.Mesh(file, mass=0.1)


@proves("An OBJ file waits for no device.")
def test_an_obj_file_with_materials_from_a_device_is_refused(tmp_path):
    file = tmp_path / "part.obj"
    file.write_bytes(seed_files.meshes()["tip.obj"].replace(b"tip.mtl", b"/dev/null"))
    with pytest.raises(hl.InputError, match="materials"):
        hl.Mesh(file, mass=0.1)


def test_a_scale_beyond_any_hand_is_refused_by_name(seeds, tmp_path):
    with pytest.raises(hl.URDFError, match=r"mesh scale"):
        hl.Hand.from_urdf(seed_files.MESH_URDF.replace("1 1 1", "1e300 1 1"), joint_stiffness=1.0)


# ---------------------------------------------------------------- TOML.


@proves("Keys that are listed.")
def test_a_key_that_is_not_listed_is_refused(tmp_path):
    (tmp_path / "scene.toml").write_text("import = 1\n", encoding="utf-8")
    with pytest.raises(hl.SceneFileError, match="import"):
        scene.load(tmp_path / "scene.toml")


@proves("A study passes numbers of a design to functions, and no name of a file to write.")
@pytest.mark.parametrize("where", ["[hand]", "[space]"])
@pytest.mark.parametrize("line", ['file = "VICTIM"', 'file = ["VICTIM", "other"]', 'name = "x"', 'motors = "x"'])
def test_a_study_names_no_file_to_write(seeds, tmp_path, where, line):
    victim = tmp_path / "victim.txt"
    victim.write_text("somebody's", encoding="utf-8")
    line = line.replace("VICTIM", victim.as_posix())
    study = tmp_path / "bad.toml"
    study.write_text(seed_files.STUDY.replace(where, f"{where}\n{line}"), encoding="utf-8")
    with pytest.raises(hl.UnknownName, match="a number of finger_hand"):
        check_study(study)
    assert victim.read_text(encoding="utf-8") == "somebody's"


def test_what_a_study_may_say_of_a_brief_is_numbers_too(seeds, tmp_path):
    study = tmp_path / "bad.toml"
    for name in ("objects", "loads", "from_toml"):
        study.write_text(f'{seed_files.STUDY}"brief.{name}" = "x"\n', encoding="utf-8")
        with pytest.raises(hl.UnknownName, match="a number of the brief"):
            check_study(study)


def test_each_argument_of_finger_hand_is_a_number_of_a_study_or_known_not_to_be():
    import inspect

    assert set(inspect.signature(hl.finger_hand).parameters) == {*DESIGN_NUMBERS, "motors", "name", "file"}


@proves("Its table stays in its folder or below it.")
@pytest.mark.parametrize("out", ["../outside.csv", "/OUT/outside.csv", "link/outside.csv", "a\\u0000.csv"])
def test_the_table_of_a_study_stays_in_its_folder(tmp_path, out):
    folder, other = tmp_path / "study", tmp_path / "other"
    folder.mkdir()
    other.mkdir()
    seed_files.write_seeds(folder)
    (folder / "link").symlink_to(other)
    study = folder / "bad.toml"
    study.write_text(seed_files.STUDY.replace("study_out.csv", out.replace("/OUT", other.as_posix())), encoding="utf-8")
    with pytest.raises(hl.InputError, match=r"^out: expected a file in the folder of the study"):
        check_study(study)
    (folder / "below").mkdir()
    study.write_text(seed_files.STUDY.replace("study_out.csv", "below/out.csv"), encoding="utf-8")
    check_study(study)


# ---------------------------------------------------------------- YAML, arrays.


def postures(tmp_path, text):
    file = tmp_path / "grasps.yaml"
    file.write_text(text, encoding="utf-8")
    return hl.read_postures(file)


@proves("Mappings, lists, numbers and words.")
@pytest.mark.parametrize(
    "value", [".nan", "nan", ".inf", "2001-01-01", "2001-99-99", "9" * 400, "'0.3'", "true", "~", "[1]"]
)
def test_joint_values_are_numbers(tmp_path, value):
    pytest.importorskip("yaml")
    first, second = postures(tmp_path, seed_files.YAML)
    assert first.q == second.q == {"index": 0.3, "thumb": -0.01}, "an alias stands for what it names"
    with pytest.raises(hl.InputError, match="cspace_position"):
        postures(tmp_path, seed_files.YAML.replace("0.3", value))


@proves("A tag makes no object.")
def test_a_tag_of_yaml_makes_no_object(tmp_path):
    pytest.importorskip("yaml")
    victim = tmp_path / "victim"
    with pytest.raises(hl.InputError):
        postures(tmp_path, f"!!python/object/apply:os.mkdir ['{victim.as_posix()}']")
    assert not victim.exists()


@proves("An alias is counted as often as it stands for something.")
def test_aliases_of_aliases_are_counted(tmp_path):
    pytest.importorskip("yaml")
    text = "a: &a0 [x, x, x, x, x, x, x, x, x]\n"
    text += "".join(f"b{i}: &a{i + 1} [{', '.join([f'*a{i}'] * 9)}]\n" for i in range(9))
    with pytest.raises(hl.InputError, match="1000000 values"):
        postures(tmp_path, text)
    with pytest.raises(hl.InputError, match="aliases of what came before"):
        postures(tmp_path, "grasps: &a {b: *a}")


@proves("Arrays of numbers, truth values and texts.")
def test_arrays_of_other_kinds_are_refused(tmp_path):
    for array in (np.zeros(2, dtype=[("a", float)]), np.zeros(2, dtype="S3"), np.zeros(2, dtype="M8[s]")):
        np.savez(tmp_path / "grasps.npz", grasp_qpos=array)
        with pytest.raises(hl.InputError, match="no numbers"):
            hl.read_postures(tmp_path / "grasps.npz")


@proves("A pickle is not read.")
def test_a_pickle_is_not_read(tmp_path):
    class Runs:
        def __reduce__(self):
            return (os.mkdir, (str(tmp_path / "ran"),))

    np.save(tmp_path / "evil.npy", np.array([Runs()], dtype=object), allow_pickle=True)
    np.savez(tmp_path / "evil.npz", allow_pickle=True, grasp_qpos=np.array([Runs()], dtype=object))
    for name in ("evil.npy", "evil.npz"):
        with pytest.raises(hl.InputError, match="a pickle, which can run anything"):
            hl.read_postures(tmp_path / name)
    assert not (tmp_path / "ran").exists()
    np.load(tmp_path / "evil.npy", allow_pickle=True)
    assert (tmp_path / "ran").exists(), "it would have run"


@proves("An array is no larger than what the file holds.")
def test_an_array_that_is_larger_than_its_file_is_refused(tmp_path, monkeypatch):
    np.save(tmp_path / "large.npy", np.zeros(2))
    data = (tmp_path / "large.npy").read_bytes()
    (tmp_path / "large.npy").write_bytes(data.replace(b"(2,), }", b"(999999999999,), }").replace(b" " * 11, b"", 1))
    with pytest.raises(hl.InputError, match="16 bytes for an array"):
        hl.read_postures(tmp_path / "large.npy")
    np.savez_compressed(tmp_path / "packed.npz", grasp_qpos=np.zeros(1_000_000))
    with read_limits(arrays=100_000), pytest.raises(hl.InputError, match="when it is unpacked"):
        hl.read_postures(tmp_path / "packed.npz")


def test_arrays_of_texts_are_no_numbers_and_texts_of_no_letters_are_refused(tmp_path):
    np.savez(tmp_path / "texts.npz", q=np.array(["1", "2", "3"]), placement=np.zeros(7))
    with pytest.raises(hl.InputError, match="q: expected numbers, got an array of <U1"):
        hl.read_postures(tmp_path / "texts.npz")
    with open(tmp_path / "letters.npz", "wb") as out:
        np.savez(out, q=np.frombuffer(b"\xff" * 12, "<U1"), placement=np.zeros(7))
    with pytest.raises(hl.InputError, match="texts of letters that do not exist"):
        hl.read_postures(tmp_path / "letters.npz")


# ---------------------------------------------------------------- Tables of sweeps.


@proves("Numbers and words, of a design each row.")
@pytest.mark.parametrize(("file", "old", "new"), [
    ("table.csv.json", "{", "null#"), ("table.csv.json", '"sobol"', "[" * 100_000 + "]" * 100_000),
    ("table.csv.json", '"low": 0.0', '"low": "x"'),
    ("table.csv", "soft", "a" * 131_073), ("table.csv", "design", "number"), ("table.csv", "\n0,", "\nx,"),
    ("table.csv", "\n0,", "\n[0],"), ("table.csv", "0.001", "word"), ("table.csv", "1.5", "9" * 400),
    ("table.csv", "\n1,", "\n0,"), ("table.csv", "true", "NaN"),
])  # fmt: skip
def test_damaged_tables_are_refused(seeds, tmp_path, file, old, new):
    path = tmp_path / file
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new) if new != "null#" else "null", encoding="utf-8")
    with pytest.raises(hl.InputError, match=r"^path: .*another file, or damaged"):
        hl.Study.load(tmp_path / "table.csv")


def test_a_table_that_does_not_say_all_of_its_sweep_makes_no_hands_again(tmp_path):
    said = {name: value for name, value in seed_files.SWEEP.items() if name != "sampling"}
    write_table(tmp_path / "table.csv", said, seed_files.rows())
    assert len(hl.Study.load(tmp_path / "table.csv")) == 3
    with pytest.raises(hl.InputError, match="says all of its sweep"):
        hl.Study.load(tmp_path / "table.csv", hl.finger_hand(2), hl.Brief(hl.Sphere(0.03, mass=0.1)))


def test_a_table_that_excel_saved_is_the_same(seeds, tmp_path):
    """With a mark before the text, other ends of lines, TRUE and FALSE."""
    file, before = tmp_path / "table.csv", hl.Study.load(tmp_path / "table.csv").columns
    text = file.read_text(encoding="utf-8").replace("true", "TRUE").replace("false", "FALSE")
    file.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(text.splitlines()).encode())
    assert hl.Study.load(file).columns == before
    assert hl.Study.load(file).best(1).columns["holds"] == [True]


@proves("A table unpacks to no more than 500 MB and 20 million cells.")
def test_a_small_table_that_unpacks_to_much_is_refused(tmp_path):
    pytest.importorskip("pyarrow")
    rows = [{"design": k, "x": 0.5, "kind": "s" * 1000} for k in range(5000)]
    write_table(tmp_path / "table.parquet", seed_files.SWEEP, rows)
    assert len(hl.Study.load(tmp_path / "table.parquet")) == 5000
    for limits in ({"cells": 14_999}, {"rows": 1_000_000}):
        with read_limits(**limits), pytest.raises(hl.InputError, match="another file, or damaged"):
            hl.Study.load(tmp_path / "table.parquet")
    write_table(tmp_path / "table.csv", seed_files.SWEEP, rows)
    with read_limits(cells=14_999), pytest.raises(hl.InputError, match="14999 cells"):
        hl.Study.load(tmp_path / "table.csv")


def test_the_rows_of_a_sweep_that_has_begun_are_looked_at_as_well(seeds, tmp_path):
    (file,) = seeds["rows"]
    table = file.with_name("begun.csv")
    assert len(hl.Study.load(table)) == 3
    _, *rows = file.read_bytes().splitlines(keepends=True)
    for head in (b"null\n", b"[]\n", b"{}\n", json.dumps({"space": 3}).encode() + b"\n"):
        file.write_bytes(head + b"".join(rows))
        with pytest.raises(hl.InputError, match="sweep"):
            hl.Study.load(table)


def test_a_study_of_designs_that_all_failed_says_why(tmp_path):
    rows = [{"design": k, "x": 0.5, "kind": "soft", "error": "InputError: too thin"} for k in range(3)]
    study = hl.Study(seed_files.SWEEP, rows)
    with pytest.raises(hl.InputError, match=r"^study: .*3 that failed, most often: InputError: too thin"):
        study.best(2)
    assert study.best(2, by="x").columns["design"] == [0, 1], "columns that are there still sort"
