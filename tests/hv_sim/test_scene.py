"""Scenes: the promised layout, the same bytes from the same task, and things that stay where they are put."""

import dataclasses
import json
import time

import mujoco
import mujoco.batch
import numpy as np
import pytest

from hv_sim.humanoid import BODY_NAMES
from hv_sim.objects import OBJECT_KINDS, build_object
from hv_sim.scene import OBJECT_GEOMS, STATIC_GEOMS, compile_scene
from hv_sim.suites import load_suite
from hv_sim.task import (
    FurniturePlacement,
    ObjectPlacement,
    RobotStart,
    Room,
    SubTask,
    Task,
    TaskError,
    available_tasks,
    load_task,
)


def _bytes(model):
    buffer = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def _task(kinds):
    """Objects of the given kinds in a row on the floor."""
    objects = []
    for i, kind in enumerate(kinds):
        z = OBJECT_KINDS[kind].size_m[2] / 2
        objects.append(ObjectPlacement(f"{kind}_{i}", kind, (-2.4 + 0.9 * (i % 6), -1.0 + i // 6, z), 0.3 * i))
    goal = SubTask(objects[0].name, (2.0, 2.0, OBJECT_KINDS[kinds[0]].size_m[2] / 2), 0.0, "Move it.")
    return Task("row", Room(), RobotStart((0.0, -2.0)), (), tuple(objects), (goal,))


@pytest.fixture(scope="module")
def scenes():
    return [compile_scene(load_task(name)) for name in available_tasks()]


def test_layout_of_bodies_and_coordinates(scenes):
    for scene in scenes:
        model, k = scene.model, scene.num_objects
        assert tuple(model.body(i + 1).name for i in range(15)) == BODY_NAMES
        assert tuple(model.body(16 + i).name for i in range(k)) == scene.object_names
        assert (model.nbody, model.nq, model.nv, model.nu) == (16 + k, 35 + 7 * k, 34 + 6 * k, 28)
        assert scene.initial_qpos.shape == (model.nq,)
        for i in range(k):
            joint = model.joint(scene.object_names[i])
            assert (joint.qposadr[0], joint.dofadr[0], joint.bodyid[0]) == (35 + 7 * i, 34 + 6 * i, 16 + i)
            assert model.body_geomnum[16 + i] == OBJECT_GEOMS
        assert model.body_geomnum[0] == STATIC_GEOMS


def test_arrays_follow_the_task(scenes):
    for scene in scenes:
        task, k, s = scene.task, scene.num_objects, scene.num_subtasks
        assert scene.half_extents_m.shape == (k, 3)
        assert scene.bps.shape == (k, 200, 3)
        assert scene.grasps_o.shape == (k, 4, 2, 3)
        assert [scene.object_names[i] for i in scene.subtask_object] == [sub.object for sub in task.subtasks]
        assert scene.goal_pos_w.shape == (s, 3)
        data = mujoco.MjData(scene.model)
        data.qpos[:] = scene.initial_qpos
        mujoco.mj_forward(scene.model, data)
        for i, placed in enumerate(task.objects):
            np.testing.assert_allclose(data.xpos[16 + i], placed.position_m, atol=1e-12)
            x_axis = data.xmat[16 + i].reshape(3, 3)[:, 0]
            np.testing.assert_allclose(x_axis, [np.cos(placed.yaw_rad), np.sin(placed.yaw_rad), 0], atol=1e-12)
        for i, sub in enumerate(task.subtasks):
            rotation = np.zeros(9)
            half = sub.goal_yaw_rad / 2
            mujoco.mju_quat2Mat(rotation, np.array([np.cos(half), 0, 0, np.sin(half)]))
            np.testing.assert_allclose(scene.goal_rot_w[i], rotation.reshape(3, 3), atol=1e-12)


def test_masses_are_the_objects(scenes):
    for scene in scenes:
        for i, placed in enumerate(scene.task.objects):
            built = build_object(placed.kind, placed.size_m, placed.mass_kg, placed.color)
            assert scene.model.body_mass[16 + i] == built.mass_kg
            np.testing.assert_allclose(scene.model.body_ipos[16 + i], built.com_m)


def test_same_task_gives_the_same_bytes(scenes, tmp_path):
    for scene in scenes[:3]:
        document = json.loads(json.dumps(scene.task.to_dict()))
        again = compile_scene(Task.from_dict(document))
        assert _bytes(again.model) == _bytes(scene.model)
        for field in ("half_extents_m", "bps", "grasps_o", "initial_qpos", "goal_pos_w", "goal_rot_w"):
            np.testing.assert_array_equal(getattr(again, field), getattr(scene, field))
    assert _bytes(scenes[0].model) != _bytes(scenes[1].model)


def test_scenes_with_as_many_objects_share_a_batch(scenes):
    pairs = [s for s in scenes if s.num_objects == 2]
    mixed = [
        _task(pair) for pair in (("box", "stool"), ("plant", "lamp"), ("vase", "microwave"), ("basket", "suitcase"))
    ]
    models = [s.model for s in pairs] + [compile_scene(t).model for t in mixed]
    batch = mujoco.batch.Batch(models[0], len(models), nthread=1, persistent=True)
    batch.set_models(models)
    batch.reset()  # a persistent batch keeps what it knows of the first model until then
    qpos = np.stack([s.initial_qpos for s in pairs] + [compile_scene(t).initial_qpos for t in mixed])
    batch.bind("qpos")[:] = qpos
    batch.bind("ctrl")[:] = qpos[:, 7:35]
    batch.forward()
    batch.step(nstep=30)
    for i, model in enumerate(models):  # the batch against plain MuJoCo
        data = mujoco.MjData(model)
        data.qpos[:] = qpos[i]
        data.ctrl[:] = qpos[i, 7:35]
        mujoco.mj_forward(model, data)
        mujoco.mj_step(model, data, 30)
        np.testing.assert_array_equal(batch.bind("qpos")[i], data.qpos)


def _drift(scene, seconds=2.0):
    """(K,) how far each object moves in some time, and (K,) how far its z axis tilts, in radians."""
    data = mujoco.MjData(scene.model)
    data.qpos[:] = scene.initial_qpos
    data.ctrl[:] = scene.initial_qpos[7:35]
    mujoco.mj_forward(scene.model, data)
    start = data.xpos[16:].copy()
    mujoco.mj_step(scene.model, data, int(seconds / scene.model.opt.timestep))
    tilt = np.arccos(np.clip(data.xmat[16:, 8], -1, 1))
    return np.linalg.norm(data.xpos[16:] - start, axis=-1), tilt


def test_packaged_scenes_are_at_rest(scenes):
    for scene in scenes:
        moved, tilt = _drift(scene)
        assert moved.max() < 0.01, scene.task.name
        assert tilt.max() < 0.02, scene.task.name


def test_goals_are_at_rest(scenes):
    """Objects put exactly at their goals stay there."""
    for scene in scenes:
        objects = list(scene.task.objects)
        for i, sub in zip(scene.subtask_object, scene.task.subtasks, strict=True):
            objects[i] = dataclasses.replace(objects[i], position_m=sub.goal_position_m, yaw_rad=sub.goal_yaw_rad)
        moved, _ = _drift(compile_scene(dataclasses.replace(scene.task, objects=tuple(objects))))
        assert moved.max() < 0.01, scene.task.name


def test_every_kind_stands_by_itself():
    kinds = sorted(OBJECT_KINDS)
    for some in (kinds[i : i + 12] for i in range(0, len(kinds), 12)):
        moved, tilt = _drift(compile_scene(_task(some)))
        assert moved.max() < 0.01, some
        assert tilt.max() < 0.02, some


@pytest.mark.parametrize("kind", sorted(OBJECT_KINDS))
def test_two_pressing_spheres_lift_every_kind(kind):
    """Two hand-sized spheres on force-limited sliders squeeze each grasp and rise: the object comes along, upright."""
    built = build_object(kind)
    half = built.half_extents_m
    for i in np.flatnonzero(built.grasp_ok):
        left, right = built.grasps_o[i]
        push = (right - left) / np.linalg.norm(right - left)
        spec = mujoco.MjSpec()
        spec.option.timestep, spec.option.noslip_iterations = 1 / 120, 3
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        floor = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[2, 2, 1])
        floor.contype, floor.conaffinity = 2, 3
        for side, (point, sign) in enumerate(((left, 1), (right, -1))):
            hand = spec.worldbody.add_body(name=f"hand_{side}", pos=np.add(point, (0, 0, half[2])) - sign * 0.05 * push)
            for axis, name, kp, force in ((push, "squeeze", 4000, 190.0), ([0, 0, 1], "lift", 20000, 300.0)):
                hand.add_joint(name=f"{name}_{side}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis, armature=0.5)
                servo = spec.add_actuator(name=f"{name}_{side}", target=f"{name}_{side}")
                servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
                servo.set_to_position(kp=kp, kv=2 * (kp * 0.5) ** 0.5)
                servo.forcelimited, servo.forcerange = mujoco.mjtLimited.mjLIMITED_TRUE, [-force, force]
            geom = hand.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.04, 0, 0], mass=0.5)
            geom.condim, geom.contype, geom.conaffinity, geom.friction = 4, 1, 2, [1.0, 0.05, 0.005]
        body = spec.worldbody.add_body(name="object", pos=[0, 0, half[2]])
        body.add_freejoint()
        body.explicitinertial = True
        body.mass, body.ipos, body.inertia = built.mass_kg, built.com_m, built.inertia
        for part in (p for p in built.parts if p.collides):
            shape = mujoco.mjtGeom.mjGEOM_BOX if part.shape == "box" else mujoco.mjtGeom.mjGEOM_CYLINDER
            geom = body.add_geom(type=shape, size=list(part.size_m), pos=list(part.pos_m), quat=list(part.quat))
            geom.condim, geom.contype, geom.conaffinity, geom.friction = 4, 2, 3, [1.0, 0.02, 0.001]
        for geom in spec.geoms:
            geom.solref = [2 / 120, 1]
        model = spec.compile()
        data = mujoco.MjData(model)
        for step in range(360):
            squeeze, lift = min(1.0, step / 60) * 0.12, np.clip((step - 120) / 120, 0, 1) * 0.3
            data.ctrl[:] = [squeeze, lift, -squeeze, lift]
            mujoco.mj_step(model, data)
        height = data.body("object").xpos[2] - half[2]
        assert height > 0.2, f"{kind}, grasp {i}: lifted {height:.2f} m"
        assert data.body("object").xmat[8] > 0.9, f"{kind}, grasp {i}: tilted"


def test_compiling_is_quick():
    tasks = load_suite("seen")[:8]  # two of each kind of room
    compile_scene(tasks[0])
    took = []
    for task in tasks:
        start = time.process_time()
        compile_scene(task)
        took.append(time.process_time() - start)
    # 0.05 s on an idle core; others may be at work on it
    assert np.median(took) < 0.2
    assert max(took) < 0.6


def test_too_much_furniture_is_refused():
    task = _task(["box"])
    many = tuple(FurniturePlacement(f"sofa_{i}", "sofa", (0.0, 0.0)) for i in range(20))
    with pytest.raises(TaskError, match=r"furniture: .* at most"):
        compile_scene(dataclasses.replace(task, furniture=many))


def test_physics_rate_is_checked():
    with pytest.raises(ValueError, match="physics_hz"):
        compile_scene(_task(["box"]), physics_hz=100)
    assert compile_scene(_task(["box"]), physics_hz=240).model.opt.timestep == 1 / 240
