import json

import numpy as np
from live_cast import SpyCast

from hv_live.floor_map import room_message, state_message
from hv_live.simulation import Simulation


def test_the_room_and_what_is_so_in_it():
    with Simulation("living_room_1", SpyCast()) as live:
        task = live.task
        room = json.loads(json.dumps(room_message(live), allow_nan=False))
        assert room["size"] == list(task.room.size_m)
        assert [piece["x"] for piece in room["furniture"]] == [f.position_m[0] for f in task.furniture]
        assert [thing["label"] for thing in room["objects"]] == ["the cardboard box", "the toaster"]
        assert room["objects"][1]["color"].startswith("rgb(")
        assert room["suggestions"] == [s.instruction for s in task.subtasks]

        live.run(0.2)
        state = json.loads(json.dumps(state_message(live), allow_nan=False))
        assert state["step"] == 6
        assert np.allclose(state["objects"][0][:2], task.objects[0].position_m[:2], atol=0.02)
        assert np.allclose(state["robot"][:2], task.robot.position_m, atol=0.1)
        assert state["goal"]["object"] == 0
        assert np.allclose([state["goal"]["x"], state["goal"]["y"]], task.subtasks[0].goal_position_m[:2], atol=1e-3)
        assert state["told"] == state["instruction"] == task.subtasks[0].instruction

        live.instruct("please wave at me")
        state = json.loads(json.dumps(state_message(live), allow_nan=False))
        assert (state["goal"], state["progress"], state["distance_m"]) == (None, None, None)
        assert [said["status"] for said in state["said"]] == ["left", "now"]
