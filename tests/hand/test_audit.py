"""The audit: every doubt about a URDF's numbers, and what to pass instead."""

from __future__ import annotations

from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import pytest

from handlcp.errors import UnknownName, URDFError
from handlcp.hand import Audit, Hand, audit_urdf, example_hand
from tests.support.hand import SHIPPED, allegro, psyonic, urdf

from .conftest import MIMIC

ROBOTS = Path(
    str(metadata.distribution("example-robot-data").locate_file("cmeel.prefix/share/example-robot-data/robots"))
)


def joint(
    name: str,
    limit: str = '<limit lower="-1" upper="1" effort="2" velocity="1"/>',
    axis: str = "0 0 1",
    kind: str = "revolute",
    body: str = '<inertial><mass value="1"/></inertial>',
) -> str:
    """A palm and one joint."""
    return (
        f'<link name="{name}_link">{body}</link><joint name="{name}" type="{kind}"><parent link="palm"/>'
        f'<child link="{name}_link"/><axis xyz="{axis}"/>{limit}</joint>'
    )


def audit(write: Callable[[str], Path], *joints: str) -> Audit:
    """The audit of a robot made of these joints."""
    return audit_urdf(write(f'<robot name="r"><link name="palm"/>{"".join(joints)}</robot>'))


def about(found: Audit, name: str) -> str:
    """Everything said about a joint."""
    return " | ".join(d.what for d in found.about(name))


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_hands_leave_one_doubt(name: str) -> None:
    """Only that a URDF has no place for joint stiffness; a stiffness by name answers it."""
    (only,) = audit_urdf(urdf(name))
    assert "stiffness" in only.what
    assert "joint_stiffness" in only.advice
    hand = example_hand(name)
    assert [d.joint for d in hand.audit()] == ["hand"]
    assert not example_hand(name, joint_stiffness=dict.fromkeys(hand.joint_names, 2.0)).audit()


def test_allegro_s_fifteen_newton_metres_are_a_placeholder() -> None:
    """All sixteen joints at 15 N·m; passing torque limits answers it. joint_12.0 cannot stand at zero."""
    file, _ = allegro()
    found = audit_urdf(file)
    assert "every effort limit is 15 N·m" in about(found, "joint_3.0")
    assert "neutral" in about(found, "joint_12.0")
    assert "torque_limits" in str(found)
    assert "15 N·m" not in str(example_hand("allegro").audit())
    assert "15 N·m" in str(example_hand("allegro", torque_limits=None).audit())
    partly = example_hand("allegro", torque_limits={"joint_0.0": 0.7}).audit()
    assert not partly.about("joint_0.0")
    assert partly.about("joint_1.0")


@pytest.mark.parametrize(
    "file", ["double_pendulum_description/urdf/double_pendulum.urdf", "romeo_description/urdf/romeo.urdf"]
)
def test_zero_efforts_are_found(file: str) -> None:
    """double_pendulum and romeo come with zero effort limits."""
    assert any("effort limit is zero" in d.what for d in audit_urdf(ROBOTS / file))


def test_finger_edu_has_a_thousand_newton_metres() -> None:
    """1000 N·m on every joint of a finger."""
    assert "1000 N·m" in str(audit_urdf(ROBOTS / "finger_edu_description/robots/finger_edu.urdf"))


def test_mimic_tags_are_reported_with_how_they_are_read() -> None:
    """The psyonic's tags name joints that do not exist; the audit says what they are taken for."""
    file, _ = psyonic()
    text = str(audit_urdf(file, base="LeftPsyonicAbilityBaseLink"))
    assert "Left_index_q2: mimics 'index_q1', which does not exist; read as 1.05851 × Left_index_q1 +0.723498" in text
    assert "Right_" not in text
    with pytest.raises(UnknownName, match="LeftPsyonicAbilityBaseLink"):
        audit_urdf(file, base="Hand")


def test_each_kind_of_doubt(write: Callable[[str], Path]) -> None:
    """One broken number a joint: each is found, and only where it is."""
    found = audit(
        write,
        joint("fine"),
        joint("zero", '<limit lower="-1" upper="1" effort="0" velocity="1"/>'),
        joint("endless", '<limit lower="-1" upper="1" effort="inf" velocity="1"/>'),
        joint("silent", '<limit lower="-1" upper="1" velocity="1"/>'),
        joint("crossed", '<limit lower="1" upper="-1" effort="2" velocity="1"/>'),
        joint("stuck", '<limit lower="0" upper="0" effort="2" velocity="1"/>'),
        joint("wide", '<limit lower="-4" upper="4" effort="2" velocity="1"/>'),
        joint("away", '<limit lower="0.5" upper="1" effort="2" velocity="1"/>'),
        joint("flat", axis="0 0 0"),
        joint("odd", axis="0 0 north"),
        joint("long", axis="0 0 3"),
        joint("bare", body=""),
        joint("light", body='<inertial><mass value="0"/></inertial>'),
        joint("round", "", kind="continuous"),
    )
    expected = {
        "zero": "zero",
        "endless": "infinite",
        "silent": "absent",
        "crossed": "above the upper",
        "stuck": "cannot move",
        "wide": "full turn",
        "away": "neutral",
        "flat": "axis is zero",
        "odd": "no number",
        "long": "length 3",
        "bare": "no <inertial>",
        "light": "not positive",
        "round": "effort limit is absent",
    }
    assert not found.about("fine")
    for name, words in expected.items():
        assert words in about(found, name), name
    assert all(d.advice for d in found)
    assert len(found) == len(list(found)) == len(found[:])


def test_placeholders_are_equal_and_round(write: Callable[[str], Path]) -> None:
    """100 on every joint is a placeholder; 100 and 90, or 3.7 twice, are not; nor is one joint alone."""

    def efforts(*values: float) -> str:
        limits = [f'<limit lower="-1" upper="1" effort="{v}" velocity="1"/>' for v in values]
        return str(audit(write, *(joint(f"j{i}", limit) for i, limit in enumerate(limits))))

    assert "placeholder" in efforts(100, 100)
    assert "placeholder" not in efforts(100, 90)
    assert "placeholder" not in efforts(3.7, 3.7)
    assert "placeholder" not in efforts(100)


def test_audit_of_a_hand_from_a_model(write: Callable[[str], Path]) -> None:
    """A Pinocchio model is audited as far as it knows."""
    model = Hand.from_urdf(write(MIMIC), joint_stiffness=1.0).model
    found = Hand.from_urdf(model, joint_stiffness=1.0).audit()
    assert "effort limit is absent or infinite" in about(found, "w")


def test_audit_prints_as_a_table() -> None:
    """A rich table, and one line when there is nothing to say."""
    from io import StringIO

    from rich.console import Console

    out = StringIO()
    Console(file=out, width=120).print(audit_urdf(allegro()[0]))
    assert "what to pass instead" in out.getvalue()
    assert str(Audit("some.urdf", ())) == "some.urdf: no doubts"


def test_files_that_are_no_urdf_are_refused(write: Callable[[str], Path], tmp_path: Path) -> None:
    """The same typed error as for a hand."""
    with pytest.raises(URDFError, match="does not exist"):
        audit_urdf(tmp_path / "none.urdf")
    with pytest.raises(URDFError, match="line 1"):
        audit_urdf(write("<robot"))
