"""What is taken from a policy, and nothing else."""

import numpy as np
import pytest

from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.evaluated_policies import load_evaluated_policy
from hv_teachers.evaluation import EvaluationConfig, evaluate
from hv_teachers.impairments import Impairments, read_impairments

OBSERVATION = {"pixels": {"head": np.full((4, 4, 3), 9, np.uint8)}, "agent_pos": np.ones(3, np.float32)}


@pytest.fixture(scope="module")
def world() -> RearrangeWorld:
    made = RearrangeWorld(load_suite("seen")[:2], num_threads=1)
    made.reset(seeds=[3, 4])
    return made


def test_each_modality_is_blanked_alone(world: RearrangeWorld):
    for name in ("vision", "language", "proprioception"):
        taken = Impairments((name,))
        seen = taken.seen(OBSERVATION)
        assert bool(seen["pixels"]["head"].any()) == (name != "vision")
        assert bool(seen["agent_pos"].any()) == (name != "proprioception")
        assert seen["pixels"]["head"].shape == (4, 4, 3)
        assert taken.told(world) == (["", ""] if name == "language" else world.instructions())
    assert OBSERVATION["pixels"]["head"].all()
    assert OBSERVATION["agent_pos"].all()


def test_the_wrong_instruction_is_the_other_sub_tasks(world: RearrangeWorld):
    told = Impairments(wrong_instruction=True).told(world)
    for task, right, wrong in zip(world.tasks, world.instructions(), told, strict=True):
        assert right in task.subtasks[0].phrasings
        assert wrong in task.subtasks[1].phrasings
    world.instructor.num_finished[:] = 1
    for task, wrong in zip(world.tasks, Impairments(wrong_instruction=True).told(world), strict=True):
        assert wrong in task.subtasks[0].phrasings
    world.instructor.num_finished[:] = 0


def test_names_are_checked():
    assert read_impairments(["vision", "language"], False) == read_impairments(["language", "vision"], False)
    assert not Impairments()
    assert Impairments(wrong_instruction=True)
    for names in (["sight"], ["vision", "vision"]):
        with pytest.raises(ValueError, match=r"without: '\w+' is not valid; valid: each of vision, language"):
            read_impairments(names, False)


def test_the_planner_has_nothing_that_could_be_taken(tmp_path):
    with pytest.raises(ValueError, match="planner neither sees nor listens"):
        load_evaluated_policy("planner", Impairments(("vision",)))
    config = EvaluationConfig("planner", "unseen", impairments=Impairments(wrong_instruction=True))
    with pytest.raises(ValueError, match="planner neither sees"):
        evaluate(config, load_suite("unseen")[:1], tmp_path / "e")
    assert not (tmp_path / "e").exists()
