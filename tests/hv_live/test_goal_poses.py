import numpy as np

from hv_live.goal_poses import goal_pose
from hv_sim.navigation import sides_with_room
from hv_sim.places import Place, layout_at
from hv_sim.scene import compile_scene
from hv_sim.suites import load_suite
from hv_sim.task import load_task


def test_a_pose_is_clear_of_what_stands_there_and_within_reach():
    """In twelve rooms: wherever a top has room, the thing stands on it, apart from the others, with room before it."""
    found = 0
    for task in load_suite("unseen")[::6]:
        scene, layout = compile_scene(task), layout_at(task, 0)
        name = task.objects[0].name
        half = scene.half_extents_m[0]
        for surface in list(layout.surfaces)[:2]:
            place = Place("on", surface)
            pose = goal_pose(scene, layout, name, place)
            if pose is None or pose[0] in [s.goal_position_m for s in task.subtasks]:
                continue
            found += 1
            assert layout.contains(place, name, pose[0])
            for other, (at, _) in layout.poses.items():
                if other != name and abs(at[2] - pose[0][2]) < 0.3:
                    assert np.hypot(at[0] - pose[0][0], at[1] - pose[0][1]) > max(half[:2])
            assert sides_with_room(scene.occupancy, *pose, half, scene.grasp_ok[0])
    assert found > 5


def test_a_place_that_holds_nothing_has_no_pose():
    task = load_task("living_room_1")
    scene, layout = compile_scene(task), layout_at(task, 0)
    assert goal_pose(scene, layout, "box", Place("on", "sofa")) is None
    assert goal_pose(scene, layout, "toaster", Place("left_of", "toaster")) is None


def test_every_goal_of_the_benchmark_is_taken_where_it_fits_its_place():
    for task in load_suite("unseen")[::22]:
        scene, layout = compile_scene(task), layout_at(task, 0)
        subtask = task.subtasks[0]
        [place, *_] = layout.places(subtask.object, subtask.goal_position_m)
        assert goal_pose(scene, layout, subtask.object, place) == (subtask.goal_position_m, subtask.goal_yaw_rad)
