"""The practice world: labels, rewards, ends, who learns, and that a state put back goes on as it was."""

from copy import deepcopy
from dataclasses import replace

import pytest
import torch

from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.decision.view import Phase
from hv_policy.motor.prior import load_shipped_motor_prior
from hv_sim.single_object import single_object_tasks
from hv_sim.task import load_task
from hv_teachers.teacher_env import TeacherEnv, TeacherEnvConfig
from hv_teachers.world_snapshot import restore_env, save_env

SMALL = {"hidden": (16,), "phase_hidden": (8,), "geometry": 4}
TEACHER = DecisionConfig(**SMALL)
CONFIG = TeacherEnvConfig(num_envs=2, num_threads=1)


def make(config=CONFIG, teacher=TEACHER, tasks=("living_room_1", "living_room_8"), first=None):
    return TeacherEnv([load_task(t) for t in tasks], config, teacher, load_shipped_motor_prior(), 5, first)


def network(**options):
    torch.manual_seed(0)
    return DecisionNetwork(DecisionConfig(**(SMALL | options))).eval()


@torch.no_grad()
def play(env, net, steps, expert=(True, False)):
    """The planner plays where `expert` is true, the network elsewhere; trail of roots, rewards and windows."""
    trail = []
    for _ in range(steps):
        seen = env.look()
        label = env.label(seen)
        decision = env.decide(net, seen)
        outcome = env.act(seen, env.follow(label, torch.tensor(expert), decision))
        trail.append((env.world.state.link_pos_w.clone(), outcome))
    return trail


@pytest.mark.parametrize("options", [{}, {"memory": "intent"}, {"memory": "none", "action": "joints"}])
def test_what_is_put_back_goes_on_the_same(options):
    env, net = make(teacher=DecisionConfig(**(SMALL | options))), network(**options)
    play(env, net, 40)
    saved = save_env(env)
    frozen = deepcopy(saved)
    restore_env(env, saved)
    here = play(env, net, 25)
    other = make(teacher=DecisionConfig(**(SMALL | options)))
    play(other, net, 3)
    restore_env(other, frozen)
    for (a, x), (b, y) in zip(here, play(other, net, 25), strict=True):
        assert torch.equal(a, b)
        assert torch.equal(x.style_windows, y.style_windows)
        assert all(torch.equal(x.terms[k], y.terms[k]) for k in x.terms)


def test_labels_follow_the_network_memory():
    env, net = make(), network()
    play(env, net, 5)
    # the network believes that it carries; the planner, asked as from there, finds that there is nothing in its hands
    env.senses.memory.phase[:] = int(Phase.CARRY)
    env.senses.memory.clock_s[:] = 2.0
    env.senses.memory.offset[:] = 0.0
    label = env.label(env.look())
    assert label.phase.tolist() == [Phase.APPROACH, Phase.APPROACH]
    assert label.lost.all()
    assert env.senses.memory.phase.tolist() == [Phase.CARRY, Phase.CARRY]  # asking changes nothing
    assert label.action.shape == (2, 14)


def test_rewards_of_both_kinds():
    net = network()
    _, outcome = play(make(), net, 2)[-1]
    assert len(outcome.terms) == 8
    assert outcome.style_windows.shape == (2, 1310)
    _, outcome = play(make(replace(CONFIG, reward="retreat")), net, 2)[-1]
    assert set(outcome.terms) == {"retreat_robot2object", "retreat_hand2object"}
    assert all(float(v.sum()) == 0 for v in outcome.terms.values())  # nothing is placed yet


def test_time_runs_out_and_the_next_episode_begins():
    env = make(replace(CONFIG, steps_per_subtask=4), tasks=("living_room_1",) * 2)
    trail = play(env, network(), 8)
    assert [bool(o.timed_out.all()) for _, o in trail] == [False] * 7 + [True]
    assert env.ended["episodes"] == 2
    assert env.ended["subtasks"] == 4
    assert env.world.episode_step.tolist() == [0, 0]
    assert env.episodes.tolist() == [2, 2]
    assert env.look() is env.look()


def test_a_fall_ends_an_episode_unless_told_otherwise():
    for ends in (True, False):
        env = make(
            replace(CONFIG, end_when_fallen=ends), teacher=DecisionConfig(action="joints", memory="none", **SMALL)
        )
        limp = network(action="joints", memory="none")
        with torch.no_grad():
            limp.head.weight.zero_()
            limp.head.bias[:] = torch.linspace(-2, 2, 28)
        trail = play(env, limp, 60, expert=(False, False))
        assert any(bool(o.failed.any()) for _, o in trail) is ends


def test_only_the_second_half_is_learned_behind_a_first_teacher():
    first, net = network(), network()
    env = make(first=first)
    assert env.learning.tolist() == [False, False]
    env.world.instructor.num_finished[1] = 1
    assert env.learning.tolist() == [False, True]
    with torch.no_grad():
        net.head.bias.add_(0.3)
        seen = env.look()
        mixed = env.decide(net, seen).action
        alone = DecisionNetwork.forward(first, seen.sights, *_inputs(env, seen))
    torch.testing.assert_close(mixed[0], alone[0])
    assert not torch.allclose(mixed[1], alone[1])


def _inputs(env, seen):
    anchors, memory = env.senses.inputs(seen)
    return anchors, seen.geometry, memory


def test_without_release_an_episode_ends_when_the_planner_would_let_go():
    env, net = make(replace(CONFIG, end_when_placed=True)), network()
    with torch.no_grad():
        net.phase_head.weight.zero_()
        net.phase_head.bias.view(11, 11)[:] = torch.eye(11) * 9  # stays in its phase
        for asked in (False, True):
            env.look()
            env.senses.memory.phase[:] = torch.tensor([int(Phase.RELEASE), int(Phase.APPROACH)])
            seen = env.look()
            if asked:
                assert env.label(seen).phase[0] == Phase.RELEASE
            outcome = env.act(seen, env.decide(net, seen).action)
            assert outcome.timed_out.tolist() == [asked, False]


def test_second_halves_begin_where_first_ones_end():
    task = load_task("living_room_1")
    singles = single_object_tasks(task)
    assert [s.name for s in singles] == ["living_room_1.1", "living_room_1.2"]
    moved = {o.name: o for o in singles[1].objects}[task.subtasks[0].object]
    assert moved.position_m == task.subtasks[0].goal_position_m
    assert singles[0].robot == task.robot
    assert singles[1].robot != task.robot


def test_bad_fields():
    with pytest.raises(ValueError, match=r"env\.reward: 'fun' is not valid; valid: rearrange, retreat"):
        TeacherEnvConfig(reward="fun")
    with pytest.raises(ValueError, match=r"env\.num_envs: 0 is not valid"):
        TeacherEnvConfig(num_envs=0)
