"""Links that are no contacts and come into the object while the load grows: beyond that a load limit says nothing."""

import pytest

import handlcp as hl

# A block on a wide palm, and a post beside it that the block would meet after `WAY`
WAY, HALF, MASS = 0.012, 0.02, 0.5  # m, m, kg
SCENE = f"""
<robot name="yard">
  <link name="palm"><collision><origin xyz="0 0 -0.01"/><geometry><box size="0.3 0.2 0.02"/></geometry></collision>
  </link>
  <link name="post"><collision><origin xyz="{HALF + WAY + 0.01} 0 0.02"/><geometry><box size="0.02 0.02 0.04"/>
  </geometry></collision></link>
  <joint name="hinge" type="revolute"><parent link="palm"/><child link="post"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="0.5" effort="20" velocity="1"/></joint>
</robot>
"""


SOFT = 0.02  # m/N along the palm, as rubber feet are that shear


def pushed(max_gap=1e-3):
    """The load limit along the palm, towards the post."""
    pads = {"palm": [SOFT, SOFT, 1e-5]}
    hand = hl.Hand.from_urdf(SCENE, fingertips=["post"], joint_stiffness=50.0, pad_flexibility=pads)
    block = hl.Box((2 * HALF, 2 * HALF, 0.03), (0.0, 0.0, 0.015), mass=MASS)
    grasp = hand.at([0.0]).grasp(block, links="all", friction=0.9, max_gap=max_gap)
    return grasp.load_limit((1, 0, 0, 0, 0, 0))


def test_a_limit_ends_where_a_link_that_is_no_contact_comes_into_the_object():
    """Four pads in parallel give way by F SOFT / 4; soon after WAY the block is in the post."""
    limit = pushed()
    assert [(b.kind, b.who) for b in limit.binds] == [("undecided", "the object")]
    assert limit.factor == pytest.approx(4 * (WAY + 1e-3) / SOFT, rel=2e-3)  # a link may be in it by a millimetre
    assert "post" in limit.why
    assert "larger max_gap" in limit.why
    assert limit.lost is None
    assert limit.slides is None
    assert limit.marks["undecided"].factor == limit.factor
    assert all(e.factor <= limit.factor for e in limit.events)


def test_with_the_link_among_the_contacts_the_limit_is_known():
    """As the words advise."""
    limit = pushed(max_gap=2 * WAY)
    assert "undecided" not in {b.kind for b in limit.binds}
    assert limit.factor > 1.2 * pushed().factor
    assert any(e.kind == "touches" and e.who.startswith("post") for e in limit.events)
