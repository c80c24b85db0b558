"""The body a motor prior was made for: link offsets, masses, joint limits and servo gains of the 28-DoF humanoid.

A policy must know the body it drives without importing the simulator, so these numbers stand here a second time;
`tests/hv_policy/motor/test_embodiment.py` compares each of them with the simulated model.
"""

from __future__ import annotations

import math

import torch

CONTROL_DT_S = 1.0 / 30.0
GRAVITY = 9.81

BODY_NAMES = (
    "pelvis", "torso", "head",
    "right_upper_arm", "right_lower_arm", "right_hand",
    "left_upper_arm", "left_lower_arm", "left_hand",
    "right_thigh", "right_shin", "right_foot",
    "left_thigh", "left_shin", "left_foot",
)  # fmt: skip
PELVIS, TORSO, HEAD = 0, 1, 2
# (right, left) everywhere a pair of limbs is stacked
UPPER_ARMS, LOWER_ARMS, HANDS = [3, 6], [4, 7], [5, 8]
THIGHS, SHINS, FEET = [9, 12], [10, 13], [11, 14]

ARM_JOINTS = [[6, 7, 8, 9], [10, 11, 12, 13]]
LEG_JOINTS = [[14, 15, 16, 17, 18, 19, 20], [21, 22, 23, 24, 25, 26, 27]]

TORSO_OFFSET_M = (0.0, 0.0, 0.236151)
SHOULDER_OFFSET_M = (-0.02405, 0.18311, 0.2435)  # left; the right one is mirrored
UPPER_ARM_M, FOREARM_M = 0.274788, 0.258947
HIP_WIDTH_M = 0.084887  # half the distance between the hips
THIGH_M, SHIN_M = 0.421546, 0.40987
ANKLE_HEIGHT_M = 0.05
HAND_RADIUS_M = 0.04
TOTAL_MASS_KG = 48.891

BODY_MASS_KG = torch.tensor([9.996, 12.011, 3.882, 1.499, 1.0, 0.5, 1.499, 1.0, 0.5, 4.502, 3.0, 1.0, 4.502, 3.0, 1.0])
# centre of mass of each body in its own frame, m
BODY_COM_M = torch.zeros(15, 3)
BODY_COM_M[PELVIS, 2] = 0.1132
BODY_COM_M[TORSO] = torch.tensor([-0.0022, 0.0, 0.1407])
BODY_COM_M[HEAD, 2] = 0.175
BODY_COM_M[UPPER_ARMS, 2] = -0.14
BODY_COM_M[LOWER_ARMS, 2] = -0.12
BODY_COM_M[THIGHS, 2] = -0.21
BODY_COM_M[SHINS, 2] = -0.2
BODY_COM_M[FEET] = torch.tensor([0.045, 0.0, -0.0225])


def _per_joint(
    abdomen: float, neck: float, shoulder: float, elbow: float, hip: float, knee: float, ankle: float
) -> torch.Tensor:
    arm = [shoulder] * 3 + [elbow]
    leg = [hip] * 3 + [knee] + [ankle] * 3
    return torch.tensor([abdomen] * 3 + [neck] * 3 + arm * 2 + leg * 2)


KP = _per_joint(1000.0, 100.0, 400.0, 300.0, 500.0, 500.0, 400.0)
TORQUE_LIMIT = _per_joint(200.0, 50.0, 100.0, 70.0, 200.0, 150.0, 90.0)
DAMPING_TIME_S = 0.1
"""kd / kp of every servo: the target leads the wanted position by this much of the wanted velocity."""

_R = math.radians
_CENTRE = [(-60, 60), (-60, 90), (-50, 50), (-50, 50), (-40, 60), (-45, 45)]
_RIGHT_ARM = [(-180, 45), (-180, 60), (-90, 90), (-160, 0)]
_LEFT_ARM = [(-45, 180), (-180, 60), (-90, 90), (-160, 0)]
_RIGHT_LEG = [(-60, 15), (-140, 60), (-60, 35), (0, 160), (-30, 30), (-55, 55), (-40, 40)]
_LEFT_LEG = [(-15, 60), (-140, 60), (-35, 60), (0, 160), (-30, 30), (-55, 55), (-40, 40)]
JOINT_LOW, JOINT_HIGH = torch.tensor(
    [[_R(low), _R(high)] for low, high in _CENTRE + _RIGHT_ARM + _LEFT_ARM + _RIGHT_LEG + _LEFT_LEG]
).unbind(1)

# joint order reflected in the sagittal plane, and the sign that each reflected joint takes
MIRROR_JOINTS = torch.tensor([0, 1, 2, 3, 4, 5, 10, 11, 12, 13, 6, 7, 8, 9, *range(21, 28), *range(14, 21)])
MIRROR_JOINT_SIGN = torch.tensor([-1.0, 1, -1, -1, 1, -1] + [-1.0, 1, -1, 1] * 2 + [-1.0, 1, -1, 1, -1, 1, -1] * 2)
