"""The documents whose tests are calls here, as the answers cite them."""

from __future__ import annotations

GRASP_STRENGTH = "NIST SP 1227 (draft, October 2018), grasp strength; ASTM work item WK83863"
FINGER_STRENGTH = "NIST SP 1227 (draft, October 2018), finger strength"
SLIP_RESISTANCE = "NIST SP 1227 (draft, October 2018), slip resistance"
LIFT_AND_SHAKE = "NVIDIA SimReady Foundation, FET028, gripper_close_lift_sphere and gripper_close_lift_cube 1.4.0"
