"""Scenes: the MuJoCo model that a task describes, with what a policy may know about its objects.

Layout, the same for every task with K movable objects, so that one batch runs many tasks: the robot comes first (bodies
1..15, qpos[0:35], qvel[0:34], ctrl[0:28]); object k is body 16 + k with a free joint at qpos[35+7k : 42+7k] and
qvel[34+6k : 40+6k] and `OBJECT_GEOMS` geoms, `OBJECT_COLLIDERS` of which collide; the floor, walls and furniture are
`STATIC_GEOMS` geoms of the world body, `STATIC_COLLIDERS` of which collide (mjData has room for each body's bounding
volume tree, so both numbers matter). What a task leaves of these is filled with invisible geoms that touch nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from hv_sim.basis_point_set import basis_point_set
from hv_sim.humanoid import ALL_CONAFFINITY, ENVIRONMENT_CONTYPE, add_humanoid, configure_physics, standing_qpos
from hv_sim.materials import add_materials
from hv_sim.objects import BuiltObject
from hv_sim.parts import Part, Prism, prisms
from hv_sim.paths import OccupancyGrid, occupancy_grid
from hv_sim.rooms import FLOORS, WALL_HEIGHT_M
from hv_sim.task import Room, Task, TaskError, built_object, furniture_parts, room_parts

OBJECT_GEOMS, OBJECT_COLLIDERS = 24, 6
STATIC_GEOMS, STATIC_COLLIDERS = 352, 64
FIRST_OBJECT_BODY = 16
_PADDING_GROUP = 5
_PADDING_CONTYPE = 4
"""A bit that nothing answers: such a geom counts as one that collides, in the bounding volume tree, and never does."""

_PARKED_M = (100.0, 100.0, 100.0)
"""Where padding of the world body lies: far off along every axis, so that the first cut of the bounding volume tree
leaves it aside (collision of a scene: 12 us a step; 17 us with the padding under the floor)."""

_GEOM_TYPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "plane": mujoco.mjtGeom.mjGEOM_PLANE,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}


@dataclass(frozen=True)
class Scene:
    """A compiled task. K objects in the task's order, S sub-tasks; world frame, metres.

    Attributes:
        model: the MuJoCo model.
        task: what it was made from.
        object_names: K names.
        half_extents_m: (K, 3) of the objects' bounding boxes, in whose centres the object frames sit.
        built: the K objects as they were made.
        bps: (K, 200, 3) float32 basis point sets (`hv_sim.basis_point_set`).
        grasps_o: (K, 4, 2, 3) contact points in the object's frame of the (left, right) hand of a robot that faces
            along the object's +x, +y, -x, -y axis.
        grasp_ok: (K, 4) bool: nothing of the object is in the way there.
        initial_qpos: (nq,) robot standing at its start, objects where the task puts them.
        subtask_object: (S,) index of the object of each sub-task.
        goal_pos_w: (S, 3) where its centre shall be.
        goal_rot_w: (S, 3, 3) how it shall be turned.
        occupancy: what walls and furniture take up of the floor.
        solids: what walls and furniture fill, for support heights.
    """

    model: mujoco.MjModel
    task: Task
    object_names: tuple[str, ...]
    half_extents_m: np.ndarray
    built: tuple[BuiltObject, ...]
    bps: np.ndarray
    grasps_o: np.ndarray
    grasp_ok: np.ndarray
    initial_qpos: np.ndarray
    subtask_object: np.ndarray
    goal_pos_w: np.ndarray
    goal_rot_w: np.ndarray
    occupancy: OccupancyGrid
    solids: tuple[Prism, ...]

    @property
    def num_objects(self) -> int:
        """K."""
        return len(self.object_names)

    @property
    def num_subtasks(self) -> int:
        """S."""
        return len(self.subtask_object)


def compile_scene(task: Task, *, physics_hz: int = 120) -> Scene:
    """Compiles a task. The same task gives the same model, bit for bit.

    Args:
        task: a valid task (`hv_sim.task.check_task`).
        physics_hz: physics steps per second, a multiple of the control rate.

    Raises:
        TaskError: the furniture has more parts than a scene can hold.
        ValueError: `physics_hz` is not valid.
    """
    built = [built_object(placement) for placement in task.objects]
    static = [*room_parts(task.room), *(part for f in task.furniture for part in furniture_parts(f))]
    colliding = sum(part.collides for part in static)
    for what, count, most in (
        ("parts that collide", colliding, STATIC_COLLIDERS - 1),
        ("parts to look at", len(static) - colliding, STATIC_GEOMS - STATIC_COLLIDERS),
    ):
        if count > most:
            raise TaskError(f"furniture: {count} {what}, with the room's; valid: at most {most}, take some away")

    spec = mujoco.MjSpec()
    spec.modelname = task.name
    _set_look(spec)
    floor_material = FLOORS[task.room.floor][0]
    add_materials(spec, {floor_material, *(p.material for p in static), *(p.material for b in built for p in b.parts)})
    add_humanoid(spec)
    _add_static(spec, task.room, static)
    for placement, thing in zip(task.objects, built, strict=True):
        _add_meshes(spec, placement.name, thing)
        _add_object(spec, placement.name, placement.position_m, thing)
    configure_physics(spec, physics_hz)
    model = spec.compile()

    names = tuple(o.name for o in task.objects)
    solids = tuple(prisms(static))
    qpos = [standing_qpos(task.robot.position_m, task.robot.yaw_rad)]
    qpos += [np.array([*o.position_m, np.cos(o.yaw_rad / 2), 0, 0, np.sin(o.yaw_rad / 2)]) for o in task.objects]
    return Scene(
        model=model,
        task=task,
        object_names=names,
        half_extents_m=np.stack([b.half_extents_m for b in built]),
        built=tuple(built),
        bps=np.stack([basis_point_set(b.parts) for b in built]),
        grasps_o=np.stack([b.grasps_o for b in built]),
        grasp_ok=np.stack([b.grasp_ok for b in built]),
        initial_qpos=np.concatenate(qpos),
        subtask_object=np.array([names.index(s.object) for s in task.subtasks]),
        goal_pos_w=np.array([s.goal_position_m for s in task.subtasks]),
        goal_rot_w=np.stack([rotation_about_z(s.goal_yaw_rad) for s in task.subtasks]),
        occupancy=occupancy_grid(solids, task.room.size_m),
        solids=solids,
    )


def rotation_about_z(yaw_rad: float) -> np.ndarray:
    """(3, 3) rotation matrix."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _set_look(spec: mujoco.MjSpec) -> None:
    """Plain light from two sides without shadows, and a pale nothing around the room."""
    spec.visual.headlight.ambient = [0.46, 0.46, 0.46]
    spec.visual.headlight.diffuse = [0.30, 0.30, 0.30]
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1280, 960
    # 285 pictures a second (128 px, OSMesa, one core); 90 with 4 samples a pixel, 52 with finer round shapes too
    quality = spec.visual.quality
    quality.offsamples, quality.numslices, quality.numstacks, quality.numquads = 0, 18, 9, 2
    spec.visual.map.znear, spec.visual.map.zfar = 0.04, 40.0
    spec.stat.extent, spec.stat.center = 1.0, [0.0, 0.0, 0.8]
    pale = [0.97, 0.97, 0.96]
    spec.add_texture(
        name="background",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=pale,
        rgb2=pale,
        width=8,
        height=48,
    )
    for direction, strength in (((0.35, -0.55, -0.8), 0.40), ((-0.5, 0.3, -0.6), 0.22)):
        light = spec.worldbody.add_light(pos=[0, 0, WALL_HEIGHT_M], dir=list(direction), castshadow=False)
        light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        light.diffuse, light.ambient, light.specular = [strength] * 3, [0.0] * 3, [0.25 * strength] * 3


def _add_static(spec: mujoco.MjSpec, room: Room, parts: list[Part]) -> None:
    world = spec.worldbody
    material, color = FLOORS[room.floor]
    floor = world.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[room.size_m[0] / 2, room.size_m[1] / 2, 1.0]
    )
    floor.material, floor.rgba = material, [*color, 1.0]
    floor.contype, floor.conaffinity, floor.friction = ENVIRONMENT_CONTYPE, ALL_CONAFFINITY, [1.0, 0.02, 0.001]
    _add_parts(world, parts, STATIC_GEOMS - 1, STATIC_COLLIDERS - 1, _PARKED_M)


def _add_meshes(spec: mujoco.MjSpec, name: str, built: BuiltObject) -> None:
    for i, part in enumerate(built.parts):
        if part.mesh is not None:
            mesh = spec.add_mesh(name=f"{name}_{i}")
            mesh.uservert, mesh.userface = part.mesh.vertices_m.ravel().tolist(), part.mesh.faces.ravel().tolist()
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # meshes from anywhere are rarely closed


def _add_object(spec: mujoco.MjSpec, name: str, position_m: tuple[float, float, float], built: BuiltObject) -> None:
    body = spec.worldbody.add_body(name=name, pos=list(position_m))
    body.add_freejoint(name=name)
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = built.mass_kg, list(built.com_m), list(built.inertia)
    _add_parts(body, built.parts, OBJECT_GEOMS, OBJECT_COLLIDERS, name=name)
    for geom in body.geoms:
        # what is round comes to rest when it rolls: .01 m of rolling friction, .65 m/s^2 for a bin on its side
        rolls = geom.type == mujoco.mjtGeom.mjGEOM_CYLINDER
        geom.condim, geom.friction = (6, [1.0, 0.02, 0.01]) if rolls else (4, [1.0, 0.02, 0.001])


def _add_parts(
    body: mujoco.MjsBody,
    parts: Sequence[Part],
    count: int,
    colliders: int,
    padding_pos_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    name: str = "",
) -> None:
    """Adds the parts as geoms, and padding up to `count` geoms of which `colliders` collide, or seem to.

    Meshes are called after `name` and the number of their part.
    """
    for i, part in enumerate(parts):
        geom = body.add_geom(
            type=_GEOM_TYPES[part.shape], size=list(part.size_m), pos=list(part.pos_m), quat=list(part.quat)
        )
        if part.mesh is not None:
            geom.meshname = f"{name}_{i}"
        geom.rgba = [*part.color, 1.0 if part.visible else 0.0]
        geom.material = part.material
        geom.group = 0 if part.visible else _PADDING_GROUP
        geom.mass = 0.0
        geom.contype = ENVIRONMENT_CONTYPE if part.collides else 0
        geom.conaffinity = ALL_CONAFFINITY if part.collides else 0
        geom.friction = [1.0, 0.02, 0.001]
    colliding = sum(part.collides for part in parts)
    looking = len(parts) - colliding
    if colliding > colliders or looking > count - colliders:
        raise ValueError(
            f"parts: {colliding} colliding and {looking} others do not fit into {colliders} and {count - colliders}"
        )
    for i in range(count - len(parts)):
        geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.001, 0, 0], pos=list(padding_pos_m))
        geom.rgba, geom.group, geom.mass = [0.5, 0.5, 0.5, 0.0], _PADDING_GROUP, 0.0
        geom.contype = _PADDING_CONTYPE if i < colliders - colliding else 0
        geom.conaffinity = 0
