"""A page to share: one file that opens in any browser, without a network, and can be turned."""

import pathlib
import tempfile

import handlcp as hl

hand = hl.example_hand("five_finger", joint_stiffness=6.0)
ball = hl.Sphere(0.035, placement=(0, 0, 0.07), mass=0.3)
grasp = hand.at(hand.close_on(ball)).grasp(ball, friction=0.6, gravity=(0, 0, 9.81), squeeze=0.003)  # it hangs

page = pathlib.Path(tempfile.mkdtemp()) / "grasp.html"
grasp.follow().page(page, title="A ball from above")  # with the loading as a slider
print(f"open {page}: {page.stat().st_size / 1e6:.1f} MB")
