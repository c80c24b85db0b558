from dataclasses import replace

from hv_live.rooms_on_offer import catalogue, rooms_on_offer
from hv_sim.task import load_task


def test_the_first_one_the_packaged_ones_and_the_suites():
    mine = replace(load_task("living_room_2"), name="my_room")
    tasks = rooms_on_offer(mine)
    assert next(iter(tasks)) == "my_room"
    assert {"living_room_8", "unseen_065", "chain5_000", "seen_349"} <= set(tasks)
    shown = catalogue(tasks)
    assert len(shown) == len(tasks)
    assert {entry["room"] for entry in shown} == {"living_room", "bedroom", "kitchen", "warehouse"}
