"""The dual teacher: who decides when, alone and in company, and its folder."""

import pytest
import torch

from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.decision.view import Phase
from hv_sim.task import load_task
from hv_sim.world import RearrangeWorld
from hv_teachers import teacher as module
from hv_teachers.expert import PlannerExpert
from hv_teachers.teacher import Teacher, load_shipped_teacher

SMALL = {"hidden": (16,), "phase_hidden": (8,), "geometry": 4}


def network(seed, **options):
    torch.manual_seed(seed)
    made = DecisionNetwork(DecisionConfig(**(SMALL | options))).eval()
    torch.nn.init.normal_(made.head.bias, std=0.2)
    return made


def walker(forward):
    """A network that always approaches and always walks at one speed."""
    made = network(0)
    with torch.no_grad():
        made.head.weight.zero_()
        made.head.bias.zero_()
        made.head.bias.view(11, -1)[:, 0] = forward / 0.5
        made.phase_head.weight.zero_()
        made.phase_head.bias.view(11, 11)[:] = torch.nn.functional.one_hot(torch.tensor(0), 11) * 9.0
    return made


def test_teacher_2_plays_every_sub_task_but_the_first():
    task = load_task("living_room_1")
    world = RearrangeWorld([task, task], num_threads=1)
    world.instructor.num_finished[1] = 1
    teacher = Teacher([walker(0.2), walker(0.6)])
    intents, targets = teacher.decide(world)
    assert intents[:, 0].tolist() == pytest.approx([0.2, 0.6])
    assert targets.shape == (2, 28)
    assert teacher.phase is not None
    assert teacher.phase.tolist() == [Phase.APPROACH, Phase.APPROACH]
    world.instructor.num_finished[1] = 5  # of a longer chain
    assert teacher.decide(world)[0][1, 0].item() == pytest.approx(0.6)
    alone = Teacher([walker(0.3)]).decide(world)[0]
    assert alone[:, 0].tolist() == pytest.approx([0.3, 0.3])


@pytest.mark.parametrize("options", [{}, {"memory": "intent"}, {"memory": "none", "action": "joints"}])
def test_an_environment_alone_is_the_one_among_others(options):
    tasks = [load_task("living_room_3"), load_task("living_room_8")]
    trails = []
    for chosen, seeds in (([1], [7]), ([0, 1], [1, 7])):
        world = RearrangeWorld([tasks[i] for i in chosen], num_threads=1)
        world.reset(seeds=seeds)
        teacher = Teacher([network(1, **options), network(2, **options)])
        for _ in range(25):
            world.step(teacher(world))
        trails.append(world.state.link_pos_w[-1])
    torch.testing.assert_close(trails[0], trails[1], atol=1e-3, rtol=0)


@pytest.mark.parametrize("make", [lambda _: load_shipped_teacher().decide, PlannerExpert], ids=["teacher", "planner"])
def test_no_bit_depends_on_how_many_there_are(make):
    # PyTorch computes some functions another way where there are 32 numbers or more
    tasks = [load_task("living_room_3"), load_task("living_room_8")]
    states = []
    for copies in (1, 33):
        world = RearrangeWorld(tasks * copies, num_threads=1)
        decide = make(world.num_envs)
        for _ in range(12):
            world.step(decide(world)[1])
        states.append(world.state.link_pos_w[:2])
    assert torch.equal(*states)


def test_a_new_episode_is_noticed():
    world = RearrangeWorld([load_task("living_room_8")], num_threads=1)
    teacher = Teacher([network(1), network(2)])
    world.reset(seeds=[3])
    first = [teacher(world).clone()]
    world.step(first[0])
    first.append(teacher(world).clone())
    for _ in range(5):
        world.step(teacher(world))
    world.reset(seeds=[3])
    again = [teacher(world).clone()]
    world.step(again[0])
    again.append(teacher(world).clone())
    torch.testing.assert_close(again, first)


def test_folder(tmp_path):
    Teacher([network(1), network(2)]).save(tmp_path)
    assert len(Teacher.load(tmp_path).networks) == 2
    (tmp_path / "teacher_2.safetensors").unlink()
    assert len(Teacher.load(tmp_path).networks) == 1
    with pytest.raises(ValueError, match=r"teacher_1\.safetensors: there is no such file; valid: a folder with"):
        Teacher.load(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="valid: all of one kind"):
        Teacher([network(1), network(2, memory="none")])


def test_a_package_without_teachers_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "WEIGHTS", tmp_path)
    with pytest.raises(
        ValueError, match=r"teacher: teacher_1\.safetensors, teacher_2\.safetensors not in .*hv-train-teacher"
    ):
        load_shipped_teacher()
    Teacher([network(1), network(2)]).save(tmp_path)
    assert len(load_shipped_teacher().networks) == 2
