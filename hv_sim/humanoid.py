"""The 28-degree-of-freedom humanoid (15 bodies, 48.9 kg) that AMP, ASE and HumanVLA use, as MJCF built in code.

Offsets, masses, joint ranges, servo gains and torque limits are those of that model; the armature is ours: 0.1 kg
m^2 on every
joint (a geared robot's value), which keeps 120 Hz physics as accurate as 240 Hz (0.02 chatters where a servo
saturates).
"""

from __future__ import annotations

import mujoco
import numpy as np

CONTROL_HZ = 30
STANDING_HEIGHT_M = 0.865
"""Pelvis height of `standing_qpos`, whose knees are slightly bent (straight legs and flat feet give 0.881)."""

BODY_NAMES = (
    "pelvis", "torso", "head",
    "right_upper_arm", "right_lower_arm", "right_hand",
    "left_upper_arm", "left_lower_arm", "left_hand",
    "right_thigh", "right_shin", "right_foot",
    "left_thigh", "left_shin", "left_foot",
)  # fmt: skip
NUM_BODIES = len(BODY_NAMES)

JOINT_NAMES = (
    "abdomen_x", "abdomen_y", "abdomen_z", "neck_x", "neck_y", "neck_z",
    "right_shoulder_x", "right_shoulder_y", "right_shoulder_z", "right_elbow",
    "left_shoulder_x", "left_shoulder_y", "left_shoulder_z", "left_elbow",
    "right_hip_x", "right_hip_y", "right_hip_z", "right_knee", "right_ankle_x", "right_ankle_y", "right_ankle_z",
    "left_hip_x", "left_hip_y", "left_hip_z", "left_knee", "left_ankle_x", "left_ankle_y", "left_ankle_z",
)  # fmt: skip
NUM_JOINTS = len(JOINT_NAMES)

ROBOT_NQ = 7 + NUM_JOINTS
ROBOT_NV = 6 + NUM_JOINTS

# group -> (kp [N m/rad], kd [N m s/rad], torque limit [N m])
SERVO_GAINS = {
    "abdomen": (1000.0, 100.0, 200.0),
    "neck": (100.0, 10.0, 50.0),
    "shoulder": (400.0, 40.0, 100.0),
    "elbow": (300.0, 30.0, 70.0),
    "hip": (500.0, 50.0, 200.0),
    "knee": (500.0, 50.0, 150.0),
    "ankle": (400.0, 40.0, 90.0),
}
ARMATURE = 0.1

# Right side and centre, degrees; x and z ranges of the left limbs are mirrored.
_RANGE_DEG = {
    "abdomen_x": (-60, 60), "abdomen_y": (-60, 90), "abdomen_z": (-50, 50),
    "neck_x": (-50, 50), "neck_y": (-40, 60), "neck_z": (-45, 45),
    "shoulder_x": (-180, 45), "shoulder_y": (-180, 60), "shoulder_z": (-90, 90),
    "elbow": (-160, 0),
    "hip_x": (-60, 15), "hip_y": (-140, 60), "hip_z": (-60, 35),
    "knee": (0, 160),
    "ankle_x": (-30, 30), "ankle_y": (-55, 55), "ankle_z": (-40, 40),
}  # fmt: skip


def _joint_range_deg(name: str) -> tuple[float, float]:
    side, _, rest = name.partition("_")
    if side not in ("right", "left"):
        return _RANGE_DEG[name]
    low, high = _RANGE_DEG[rest]
    return (-high, -low) if side == "left" and rest.endswith(("_x", "_z")) else (low, high)


def _servo_gains(name: str) -> tuple[float, float, float]:
    return next(gains for group, gains in SERVO_GAINS.items() if group in name)


JOINT_RANGE_RAD = np.radians([_joint_range_deg(n) for n in JOINT_NAMES])
"""(28, 2) lower and upper joint limits in radians."""
KP, KD, TORQUE_LIMIT = np.array([_servo_gains(n) for n in JOINT_NAMES]).T
"""(28,) servo stiffness in N m/rad, damping in N m s/rad and torque limit in N m, in `JOINT_NAMES` order."""

# Collision bits: the robot collides with itself and with everything, the environment with the robot and with itself.
ROBOT_CONTYPE, ENVIRONMENT_CONTYPE, ALL_CONAFFINITY = 1, 2, 3

HAND_FRICTION = [1.0, 0.002, 0.0001]
"""Sliding, torsional (m) and rolling (m). With little torsion an object gripped above its centre hangs upright
between the hands while the forearms turn; with .01 it turned with them by half a radian."""

_SKIN = (0.80, 0.83, 0.88, 1.0)
_DARK = (0.22, 0.25, 0.31, 1.0)
_ACCENT = (0.16, 0.45, 0.75, 1.0)

_AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}

# body pairs that never need to collide: they overlap at rest or cannot meet
_NO_SELF_COLLISION = (
    ("torso", "right_lower_arm"), ("torso", "left_lower_arm"),
    ("pelvis", "right_upper_arm"), ("pelvis", "left_upper_arm"),
    ("pelvis", "right_shin"), ("pelvis", "left_shin"),
    ("head", "right_upper_arm"), ("head", "left_upper_arm"), ("head", "pelvis"),
    ("torso", "right_thigh"), ("torso", "left_thigh"),
)  # fmt: skip


def configure_physics(spec: mujoco.MjSpec, physics_hz: int = 120) -> None:
    """Sets time step, integrator and solver, and the contact time constant to twice the time step.

    Args:
        spec: the model under construction, complete with its geoms (their `solref` is written).
        physics_hz: physics steps per second; 120 is the coarsest rate whose results are reported.

    Raises:
        ValueError: `physics_hz` is not a multiple of the control rate.
    """
    if physics_hz <= 0 or physics_hz % CONTROL_HZ:
        raise ValueError(f"physics_hz: {physics_hz} is not a positive multiple of {CONTROL_HZ}; valid: 120, 240, 480")
    spec.option.timestep = 1.0 / physics_hz
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    spec.option.iterations = 10
    spec.option.ls_iterations = 10
    spec.option.noslip_iterations = 3  # without them a squeezed box creeps out of the hands (6 % of the speed)
    # what lies still costs nothing until it is touched: a furnished room steps two to four times as fast
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    for geom in spec.geoms:
        geom.solref = [2.0 / physics_hz, 1.0]


def add_humanoid(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """Adds the humanoid to the world body. Call it before any other body is added.

    It then owns bodies 1..15 (`BODY_NAMES`), qpos[0:35], qvel[0:34] and ctrl[0:28], the camera `head`
    (90 degrees, in the head's frame at (.10, 0, .175), tilted 20 degrees down) and one contact sensor per body,
    `contact_<body>` (found, position): the deepest contact of the body with the static world. Sets the spec's angles
    to radians.
    """
    spec.compiler.degree = False
    pelvis = spec.worldbody.add_body(name="pelvis", pos=[0, 0, STANDING_HEIGHT_M])
    pelvis.add_freejoint(name="root")
    _sphere(pelvis, "pelvis", (0, 0, 0.07), 0.09, 2226, _DARK)
    _sphere(pelvis, "pelvis_upper", (0, 0, 0.205), 0.07, 2226, _DARK)

    torso = _child(pelvis, "torso", (0, 0, 0.236151), ("abdomen_x", "abdomen_y", "abdomen_z"))
    _sphere(torso, "torso", (0, 0, 0.12), 0.11, 1794, _ACCENT)
    for side, sign in (("right", -1), ("left", 1)):
        start, end = (-0.0061125, sign * 0.0458, 0.23), (-0.0180, sign * 0.1400, 0.2418)
        _capsule(torso, f"{side}_clavicle", start, end, 0.045, 1100, _ACCENT)

    head = _child(torso, "head", (0, 0, 0.223894), ("neck_x", "neck_y", "neck_z"))
    _sphere(head, "head", (0, 0, 0.175), 0.095, 1081, _SKIN)
    tilt = np.radians(20.0)
    forward = np.array([np.cos(tilt), 0, -np.sin(tilt)])
    right = np.array([0.0, -1.0, 0.0])
    up = np.cross(right, forward)
    frame = np.stack([right, up, -forward], axis=1)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, frame.ravel())
    head.add_camera(name="head", pos=[0.10, 0, 0.175], quat=quat, fovy=90)

    for side, sign in (("right", -1), ("left", 1)):
        _add_arm(torso, side, sign)
    for side, sign in (("right", -1), ("left", 1)):
        _add_leg(pelvis, side, sign)

    # Masses are the table's; the geoms only distribute them.
    for name, mass in BODY_MASS_KG.items():
        geoms = [g for g in spec.body(name).geoms if g.density > 0]
        volumes = np.array([_volume(g) * g.density for g in geoms])
        for geom, share in zip(geoms, volumes / volumes.sum(), strict=True):
            geom.mass = float(mass * share)

    for name, (kp, kd, limit) in zip(JOINT_NAMES, zip(KP, KD, TORQUE_LIMIT, strict=True), strict=True):
        servo = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=float(kp), kv=float(kd))
        servo.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        servo.forcerange = [-float(limit), float(limit)]

    for first, second in _NO_SELF_COLLISION:
        spec.add_exclude(bodyname1=first, bodyname2=second)
    for body in BODY_NAMES:
        found_pos = sum(
            1 << int(f) for f in (mujoco.mjtConDataField.mjCONDATA_FOUND, mujoco.mjtConDataField.mjCONDATA_POS)
        )
        sensor = spec.add_sensor(name=f"contact_{body}", type=mujoco.mjtSensor.mjSENS_CONTACT)
        sensor.objtype, sensor.objname = mujoco.mjtObj.mjOBJ_BODY, body
        sensor.reftype, sensor.refname = mujoco.mjtObj.mjOBJ_BODY, "world"
        sensor.intprm = [found_pos, 1, 1]  # data, reduce = mindist, num
    return pelvis


BODY_MASS_KG = {
    "pelvis": 9.996, "torso": 12.011, "head": 3.882,
    "right_upper_arm": 1.499, "right_lower_arm": 1.0, "right_hand": 0.5,
    "left_upper_arm": 1.499, "left_lower_arm": 1.0, "left_hand": 0.5,
    "right_thigh": 4.502, "right_shin": 3.0, "right_foot": 1.0,
    "left_thigh": 4.502, "left_shin": 3.0, "left_foot": 1.0,
}  # fmt: skip


def standing_qpos(position_xy_m: np.ndarray | tuple[float, float], yaw_rad: float) -> np.ndarray:
    """(35,) generalised position: standing at the given place and yaw in the world frame, arms hanging, knees
    slightly bent."""
    qpos = np.zeros(ROBOT_NQ)
    hip, knee = -0.20, 0.40
    leg = 0.421546 * np.cos(hip) + 0.40987 * np.cos(knee + hip)
    qpos[:3] = position_xy_m[0], position_xy_m[1], leg + 0.05
    qpos[3:7] = np.cos(yaw_rad / 2), 0.0, 0.0, np.sin(yaw_rad / 2)
    pose = {"hip_y": hip, "knee": knee, "ankle_y": -(hip + knee), "shoulder_y": 0.05, "elbow": -0.35}
    for i, name in enumerate(JOINT_NAMES):
        side, _, rest = name.partition("_")
        if side in ("right", "left"):
            qpos[7 + i] = pose.get(rest, 0.0)
        if rest == "shoulder_x":
            qpos[7 + i] = -0.12 if side == "right" else 0.12
    return qpos


def _child(
    parent: mujoco.MjsBody, name: str, pos: tuple[float, float, float], joints: tuple[str, ...]
) -> mujoco.MjsBody:
    body = parent.add_body(name=name, pos=list(pos))
    for joint in joints:
        axis = _AXES.get(joint[-1], (0, 1, 0)) if joint[-2] == "_" else (0, 1, 0)
        low, high = np.radians(_joint_range_deg(joint))
        body.add_joint(
            name=joint,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=list(axis),
            range=[low, high],
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
            armature=ARMATURE,
            damping=[0.5 if "neck" in joint else 1.0, 0.0, 0.0],
        )
    return body


def _add_arm(torso: mujoco.MjsBody, side: str, sign: int) -> None:
    joints = tuple(f"{side}_shoulder_{axis}" for axis in "xyz")
    upper = _child(torso, f"{side}_upper_arm", (-0.02405, sign * 0.18311, 0.2435), joints)
    _capsule(upper, f"{side}_upper_arm", (0, 0, -0.05), (0, 0, -0.23), 0.045, 982, _SKIN)
    lower = _child(upper, f"{side}_lower_arm", (0, 0, -0.274788), (f"{side}_elbow",))
    _capsule(lower, f"{side}_lower_arm", (0, 0, -0.0525), (0, 0, -0.1875), 0.04, 1056, _SKIN)
    hand = lower.add_body(name=f"{side}_hand", pos=[0, 0, -0.258947])
    geom = _sphere(hand, f"{side}_hand", (0, 0, 0), 0.04, 1865, _ACCENT)
    geom.friction, geom.condim, geom.priority = HAND_FRICTION, 4, 1


def _add_leg(pelvis: mujoco.MjsBody, side: str, sign: int) -> None:
    thigh = _child(pelvis, f"{side}_thigh", (0, sign * 0.084887, 0), tuple(f"{side}_hip_{axis}" for axis in "xyz"))
    _capsule(thigh, f"{side}_thigh", (0, 0, -0.06), (0, 0, -0.36), 0.055, 1269, _SKIN)
    shin = _child(thigh, f"{side}_shin", (0, 0, -0.421546), (f"{side}_knee",))
    _capsule(shin, f"{side}_shin", (0, 0, -0.045), (0, 0, -0.355), 0.05, 1014, _SKIN)
    foot = _child(shin, f"{side}_foot", (0, 0, -0.40987), tuple(f"{side}_ankle_{axis}" for axis in "xyz"))
    geom = foot.add_geom(name=f"{side}_foot", type=mujoco.mjtGeom.mjGEOM_BOX, pos=[0.045, 0, -0.0225])
    geom.size, geom.density, geom.rgba = [0.0885, 0.045, 0.0275], 1141, list(_DARK)
    geom.friction, geom.condim = [1.0, 0.05, 0.005], 3
    _set_robot_collision(geom)


def _sphere(body: mujoco.MjsBody, name: str, pos: tuple, radius: float, density: float, rgba: tuple) -> mujoco.MjsGeom:
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=list(pos), size=[radius, 0, 0])
    geom.density, geom.rgba, geom.friction = density, list(rgba), [1.0, 0.05, 0.005]
    _set_robot_collision(geom)
    return geom


def _capsule(
    body: mujoco.MjsBody, name: str, start: tuple, end: tuple, radius: float, density: float, rgba: tuple
) -> mujoco.MjsGeom:
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[*start, *end], size=[radius, 0, 0])
    geom.density, geom.rgba, geom.friction = density, list(rgba), [1.0, 0.05, 0.005]
    _set_robot_collision(geom)
    return geom


def _set_robot_collision(geom: mujoco.MjsGeom) -> None:
    geom.contype, geom.conaffinity = ROBOT_CONTYPE, ALL_CONAFFINITY


def _volume(geom: mujoco.MjsGeom) -> float:
    size = geom.size
    if geom.type == mujoco.mjtGeom.mjGEOM_SPHERE:
        return 4 / 3 * np.pi * size[0] ** 3
    if geom.type == mujoco.mjtGeom.mjGEOM_BOX:
        return 8 * size[0] * size[1] * size[2]
    length = float(np.linalg.norm(np.array(geom.fromto[3:]) - np.array(geom.fromto[:3])))
    return np.pi * size[0] ** 2 * length + 4 / 3 * np.pi * size[0] ** 3
