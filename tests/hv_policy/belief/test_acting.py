"""The form `belief` as LeRobot sees it: trained from batches, acting step by step, saved and loaded."""

import json
import math
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import torch
from policy_samples import HEAD, STATE, TASKS, make_config

from hv_policy.belief import student
from hv_policy.belief.belief import BeliefConfig
from hv_policy.belief.boxes import first_box_hit
from hv_policy.belief.camera import project
from hv_policy.belief.closer_look import Found
from hv_policy.belief.floor_map import cells_of
from hv_policy.belief.floor_patch import patch_points, write_patch
from hv_policy.belief.labels import LABELS
from hv_policy.belief.landmark_head import GAP_M, Piece
from hv_policy.belief.outline import half_extent_m, outline_along
from hv_policy.belief.perception import GOAL_QUERY, OBJECT_QUERY, measurement_loss
from hv_policy.belief.perception_loss import perception_loss
from hv_policy.belief.places import GOAL, OBJECT, PICK, PLACE, SPAN, to_frame
from hv_policy.belief.stands import Stand
from hv_policy.belief.student import LIFTED_S, BeliefNetwork
from hv_policy.decision.view import Phase
from hv_policy.half_precision import is_fast_in_half
from hv_policy.modeling_hv import HVPolicy
from hv_policy.motor.embodiment import HANDS
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld


def make_believer(**changes) -> HVPolicy:
    torch.manual_seed(0)
    meta = SimpleNamespace(tasks=pd.DataFrame({"task_index": [0, 1]}, index=TASKS))
    return HVPolicy(make_config(form="belief", **changes), dataset_meta=meta)


@pytest.fixture(scope="module")
def states() -> list[torch.Tensor]:
    """(2, 223) proprioception of two humanoids that begin to sway, for 8 steps."""
    world = RearrangeWorld(load_suite("seen")[:2], num_threads=1)
    seen = []
    for step in range(8):
        seen.append(proprioception(world.state).clone())
        world.step(torch.full((2, 28), 0.02 * step))
    return seen


def frames_of(states: list[torch.Tensor], seed: int = 0) -> list[dict]:
    generator = torch.Generator().manual_seed(seed)
    return [{HEAD: torch.rand(len(s), 3, 64, 64, generator=generator), STATE: s} for s in states]


def roll(policy: HVPolicy, frames: list[dict], tasks: list[list[str]]) -> list[torch.Tensor]:
    policy.reset()
    return [policy.select_action({**frame, "task": task}) for frame, task in zip(frames, tasks, strict=True)]


def labelled(count: int, generator: torch.Generator, state: torch.Tensor) -> dict:
    """Pictures with a bright spot; the object is to the left of the robot if the spot is on the left."""
    left = torch.randint(2, (count,), generator=generator)
    pictures = 0.2 * torch.rand(count, 3, 64, 64, generator=generator)
    pictures[left == 1, :, 24:40, 4:20] += 0.7
    pictures[left == 0, :, 24:40, 44:60] += 0.7
    places = torch.zeros(count, 21)
    places[:, 0], places[:, 1] = 1.0, left * 2.0 - 1
    assert {"places": 21, "object": 15, "half_extents": 3} == LABELS
    batch = {HEAD: pictures, STATE: state.expand(count, -1), "task": TASKS[:1] * count}
    upright = torch.tensor([0.0] * 3 + [1.0, 0, 0, 0, 1.0, 0] + [0.0] * 6)
    known = {"places": places, "object": upright.expand(count, -1), "half_extents": torch.full((count, 3), 0.15)}
    return batch | {f"privileged.{name}": values for name, values in known.items()}


def taught(policy: HVPolicy, batch: Callable[[], dict], steps: int, lr: float) -> dict[str, float]:
    """Trains on `steps` batches; returns the last one's figures."""
    optimizer = torch.optim.AdamW(policy.get_optim_params(), lr=lr)
    for _ in range(steps):
        loss, figures = policy(batch())
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(policy.parameters(), 5.0)
        optimizer.step()
    return figures


def test_learns_where_an_object_is_and_how_sure_that_is(states):
    policy = make_believer()
    policy.train()
    generator = torch.Generator().manual_seed(1)
    figures = taught(policy, lambda: labelled(32, generator, states[0][:1]), 160, 6e-4)
    policy.eval()
    assert isinstance(policy.network, BeliefNetwork)
    batch = labelled(64, generator, states[0][:1])
    words, is_word = policy.student.reader.read(batch["task"])
    with torch.no_grad():
        seen = policy.network.perception(batch[HEAD], batch[STATE], words, is_word)
    wrong = (seen.places[:, 1].sign() != batch["privileged.places"][:, 1].sign()).float().mean()
    assert wrong < 0.05
    assert seen.log_spread[:, 1].exp().mean() < 0.6
    assert figures["object_error_m"] < 0.5


@pytest.mark.skipif(not is_fast_in_half("cpu"), reason="this processor has no instructions for bfloat16")
def test_training_takes_half_precision_and_learns_the_same(states, monkeypatch):
    policy = make_believer(mirror_share=0.0, recolour=False, word_dropout=0.0)
    batch = labelled(32, torch.Generator().manual_seed(1), states[0][:1])
    inside, gradients = [], []

    def watched(*args):
        inside.append(torch.is_autocast_enabled("cpu"))
        return perception_loss(*args)

    monkeypatch.setattr(student, "perception_loss", watched)
    for trains in (False, True):
        policy.train(trains)
        policy.zero_grad()
        policy(batch)[0].backward()
        gradients.append(torch.cat([p.grad.flatten() for p in policy.parameters() if p.grad is not None]))
    assert inside == [False, True]
    assert torch.nn.functional.cosine_similarity(*gradients, dim=0) > 0.98


def test_who_got_up_begins_anew_and_does_not_know_its_whereabouts(states):
    policy = make_believer()
    policy.eval()
    frames = frames_of(states)
    roll(policy, frames[:4], [TASKS] * 4)
    following = policy.student.following
    lies = torch.tensor([True, False])
    following.prior.getting_up.active = lies.clone()
    policy.select_action({**frames[4], "task": TASKS})
    assert following.lay.tolist() == [True, False]
    following.blind_steps[:] = 100
    assert following.looks.tolist() == [1]
    following.belief.compass_looks[:] = 5.0
    following.wayfinder.floor.evidence[:] = 1.0
    following.slips[:] = 2
    following.prior.getting_up.active = torch.zeros(2, dtype=torch.bool)
    following.blind_steps[:] = 0  # nobody looks in this step
    policy.select_action({**frames[5], "task": TASKS})
    assert following.slips.tolist() == [0, 2]
    assert following.belief.compass_looks[1] >= 5.0
    assert following.belief.compass_looks[0] < 5.0
    assert (following.wayfinder.floor.evidence[1] == 1.0).float().mean() > 0.9
    assert (following.wayfinder.floor.evidence[0] == 1.0).float().mean() < 0.1
    assert not following.lay.any()


def test_who_has_something_between_the_hands_goes_on_lifting_but_not_for_ever(states):
    policy = make_believer()
    policy.eval()
    roll(policy, frames_of(states)[:2], [TASKS] * 2)
    following, body = policy.student.following, read_proprioception(states[2])
    following.memory.phase = torch.full((2,), int(Phase.LIFT))
    following.memory.from_hands = body.pos[:, HANDS].clone()
    following.memory.clock_s = torch.tensor([1.0, LIFTED_S + 0.1])
    given_up = torch.full((2,), int(Phase.APPROACH))
    assert following._felt(body, given_up)[0].tolist() == [Phase.LIFT, Phase.APPROACH]
    following.memory.from_hands = 1.5 * following.memory.from_hands  # they have come together since
    assert following._felt(body, given_up)[0].tolist() == [Phase.APPROACH] * 2


def test_loss_is_least_where_the_spread_is_the_error():
    seen = SimpleNamespace(places=torch.full((1, 21), 0.3), log_spread=torch.zeros(1, 21))
    losses = {}
    for spread in (0.05, 0.3, 2.0):
        seen.log_spread = torch.full((1, 21), spread).log()
        likely = measurement_loss(seen, torch.zeros(1, 21)) / spread  # without the weight
        losses[spread] = float(likely)
    assert min(losses, key=losses.__getitem__) == 0.3


def test_only_the_perception_is_trained():
    policy = make_believer()
    trained = {name.split(".")[1] for name, p in policy.named_parameters() if p.requires_grad}
    assert trained == {"perception"}


def test_environments_do_not_see_each_other(states):
    policy, frames = make_believer().eval(), frames_of(states)
    tasks = [[TASKS[0], TASKS[step >= 4]] for step in range(8)]
    together = roll(policy, frames, tasks)
    for env in range(2):
        mine = [{k: v[env : env + 1] for k, v in frame.items()} for frame in frames]
        alone = roll(policy, mine, [[t[env]] for t in tasks])
        for step in range(8):
            torch.testing.assert_close(together[step][env], alone[step][0], atol=1e-4, rtol=1e-4)


def test_a_new_instruction_is_a_new_task_there_alone(states):
    policy, frames = make_believer().eval(), frames_of(states)
    roll(policy, frames[:4], [[TASKS[0]] * 2] * 4)
    following = policy.student.following
    following.slips[:] = 2
    following.searched_rad[:] = 3.0
    policy.select_action({**frames[4], "task": [TASKS[0], TASKS[1]]})
    assert following.searched_rad[0] >= 3.0
    assert following.searched_rad[1] < 0.1
    assert following.slips.tolist() == [2, 0]
    assert following.blind_steps.tolist()[1] == 1  # it looked at once


def test_nothing_leaks_over_a_reset_or_from_a_glance(states):
    policy, frames = make_believer().eval(), frames_of(states)
    tasks = [TASKS] * 8
    first = roll(policy, frames, tasks)
    roll(policy, frames_of(states, seed=3), tasks)
    policy.reset()
    for frame, task, before in zip(frames, tasks, first, strict=True):
        glance = policy.predict_action_chunk({**frame, "task": task})[:, 0]
        torch.testing.assert_close(glance, before, atol=0, rtol=0)
        torch.testing.assert_close(policy.select_action({**frame, "task": task}), before, atol=0, rtol=0)


def test_saved_and_loaded_policy_acts_the_same(states, tmp_path):
    policy, frames = make_believer().eval(), frames_of(states)
    policy.save_pretrained(tmp_path / "policy")
    loaded = HVPolicy.from_pretrained(tmp_path / "policy").eval()
    for a, b in zip(roll(policy, frames, [TASKS] * 8), roll(loaded, frames, [TASKS] * 8), strict=True):
        torch.testing.assert_close(a, b, atol=0, rtol=0)


def test_another_body_is_refused_in_one_line():
    from lerobot.configs import FeatureType, PolicyFeature

    features = {HEAD: PolicyFeature(FeatureType.VISUAL, (3, 64, 64)), STATE: PolicyFeature(FeatureType.STATE, (14,))}
    with pytest.raises(ValueError, match="form: belief is for one camera, a state of 223") as error:
        make_believer(input_features=features)
    assert "\n" not in str(error.value)


def test_training_without_labels_is_refused_in_one_line(states):
    policy = make_believer()
    policy.student._meta = None
    with pytest.raises(ValueError, match="trained on a dataset of hv-record"):
        policy({HEAD: torch.rand(2, 3, 64, 64), STATE: states[0], "task": TASKS})


def test_who_does_not_know_where_a_thing_is_looks_round_but_not_for_ever(states):
    policy, frame = make_believer().eval(), frames_of(states)[0]
    with torch.no_grad():
        policy.network.perception.measure.weight.zero_()
        policy.network.perception.measure.bias[21:] = 1.5  # says that it cannot tell
    policy.reset()
    policy.select_action({**frame, "task": TASKS})
    following = policy.student.following
    assert following.rising.intent[:, 2].tolist() == [1.0, 1.0]
    assert following.memory.clock_s.tolist() == [0.0, 0.0]
    following.searched_rad[0] = 10.0
    policy.select_action({**frame, "task": TASKS})
    assert following.rising.intent[1, 2] == 1.0
    assert following.exploring_s[0] > 0
    assert following.searched_rad[0] == 10.0
    with torch.no_grad():
        policy.network.perception.measure.bias[21:] = -3.0  # is sure
    policy.reset()
    for _ in range(3):
        policy.select_action({**frame, "task": TASKS})
    assert float(policy.student.following.searched_rad.max()) == 0.0


def sure_believer(states, spread: float = -3.0) -> tuple[HVPolicy, dict]:
    """A student that says of every place how uncertain it is (logarithm), after its first step."""
    policy, frame = make_believer().eval(), frames_of(states)[0]
    with torch.no_grad():
        policy.network.perception.measure.weight.zero_()
        policy.network.perception.measure.bias[21:] = spread
    policy.reset()
    policy.select_action({**frame, "task": TASKS})
    return policy, frame


def test_having_turned_all_round_it_looks_from_elsewhere_and_gives_up_in_the_end(states):
    policy, frame = sure_believer(states, 1.5)
    following = policy.student.following
    for round_ in range(1, 4):
        following.searched_rad[:] = torch.tensor([10.0, 0.0])
        policy.select_action({**frame, "task": TASKS})
        assert following.rounds.tolist() == [round_, 0]
        if round_ == 3:
            break
        assert following.exploring_s[0] > 0
        there = (following.vantage[0] - following.belief.pose[0, :2]).norm()
        assert 1.0 < float(there) < 1.6
        assert following.rising.intent[1, 2] == 1.0  # the other one is still turning
        following.vantage[0] = following.belief.pose[0, :2]  # arrived
        policy.select_action({**frame, "task": TASKS})
        assert following.searched_rad[0] < 0.1
        assert following.exploring_s[0] == 0
    for _ in range(3):
        policy.select_action({**frame, "task": TASKS})
        assert following.exploring_s[0] == 0
        assert following.searched_rad[0] == 10.0


def test_from_before_its_goal_a_picture_past_the_thing_in_the_hands_tells_next_to_nothing_of_it():
    phase, to_goal_m = torch.tensor([Phase.CARRY, Phase.CARRY, Phase.APPROACH]), torch.tensor([0.5, 3.0, 0.5])
    factor = student._hidden(phase, to_goal_m)
    assert (factor[:, GOAL] == torch.tensor([[student.BEFORE_GOAL], [student.BEHIND], [1.0]])).all()


def test_who_turns_goes_on_turning_and_who_walks_goes_on_walking(states):
    policy, _ = sure_believer(states)
    following, c = policy.student.following, BeliefConfig()

    def uncertain_by(share: float) -> torch.Tensor:
        """Places 2 m away, to the left of one robot and straight ahead of the other, that uncertain."""
        places = torch.zeros(2, 21)
        places[0, 1] = places[1, 0] = 2.0
        following.belief.variance[:, 0] = (share * math.hypot(2.0, 0.5)) ** 2
        return places

    between = (c.found + c.searching) / 2
    following.searching[:] = torch.tensor([True, False])
    for _ in range(3):
        assert following._searches(uncertain_by(between)).tolist() == [True, False]
    assert following._searches(uncertain_by(c.found - 0.01)).tolist() == [False, False]
    assert following._searches(uncertain_by(between)).tolist() == [False, False]
    assert following._searches(uncertain_by(c.searching + 0.01)).tolist() == [True, True]
    following.hear(["Put it back.", following.instructions[1]])
    assert following.searching.tolist() == [False, True]


def test_how_high_a_thing_is_stays_while_the_arms_reach_round_it(states):
    policy, frame = sure_believer(states)
    following = policy.student.following
    before = following.belief.places[:, 2].clone()
    with torch.no_grad():
        policy.network.perception.measure.bias[2] += 1.0  # it seems to be higher
    network, height = policy.network.decision, []
    for phases in ([Phase.REACH, Phase.SQUEEZE], [Phase.ALIGN, Phase.APPROACH]):
        following.memory.phase[:] = torch.tensor([int(phase) for phase in phases])
        following.blind_steps[:] = 99
        network.phase_logits = lambda sights, geometry, memory: torch.eye(11)[memory[:, 0].long()]
        try:
            policy.select_action({**frame, "task": TASKS})
        finally:
            del network.phase_logits
        height.append((following.belief.places[:, 2] - before).abs())
    assert float(height[0].max()) < 0.2 * float(height[1].min())


def test_who_is_not_believed_takes_another_thing_or_another_place(states):
    policy, _ = sure_believer(states)
    following = policy.student.following
    belief, envs = following.belief, torch.tensor([True, True])
    belief.places[:, :2] = belief.places[:, 3:5] = torch.tensor([1.0, 0.5])
    following.refusals.seen[:] = torch.tensor([[1.0, 0.5], [1.0, 1.0]])  # the first one hardly saw its goal
    following.slips[:] = following.searched_rad[:] = 3
    following._think_again(envs)
    assert (belief.variance[:, [0, 2]] > 100).tolist() == [[False, True], [False, True]], "it looks at the goal again"
    belief.variance[:] = 0.01
    following._think_again(envs)
    assert (belief.variance[:, [0, 2]] > 100).tolist() == [[False, True], [True, False]]
    assert following.slips.tolist() == following.searched_rad.tolist() == [0, 0]
    assert following.copy().refusals is not following.refusals


def test_what_was_just_put_down_is_not_looked_for_all_round(states, monkeypatch):
    policy, batch = sure_believer(states)
    policy.select_action(batch)
    following, c = policy.student.following, BeliefConfig()
    following.belief.places[:, 3] += 3.0  # not where it should be
    following.memory.phase[:] = torch.tensor([int(Phase.IDLE), int(Phase.RETREAT)])
    monkeypatch.setattr(type(following.memory), "advance", lambda self, phase, view: torch.tensor([True, True]))
    policy.select_action(batch)
    assert following.belief.variance[:, 0].sqrt().tolist() == pytest.approx([c.doubt_put_down, c.doubt], abs=0.02)


def test_nothing_is_reached_for_that_may_be_elsewhere_and_nothing_for_ever(states):
    policy, _ = sure_believer(states)
    following, phases = policy.student.following, torch.tensor([int(Phase.REACH), int(Phase.REACH)])
    following.memory.phase[:] = phases
    following.belief.variance[:, 0] = torch.tensor([0.5**2, 0.05**2])
    near = torch.zeros(2, 21)
    assert following._sure_of(phases, near).tolist() == [int(Phase.APPROACH), int(Phase.REACH)]
    assert following.belief.variance[1, 0] < 0.1
    following.memory.clock_s[1] = 9.0
    assert following._sure_of(phases, near).tolist() == [int(Phase.APPROACH), int(Phase.APPROACH)]
    assert following.belief.variance[1, 0] > 0.4  # it may be elsewhere
    lifting = torch.tensor([int(Phase.LIFT)] * 2)
    following.memory.phase[:] = lifting
    assert following._sure_of(lifting, near).tolist() == lifting.tolist()


def test_who_cannot_reach_from_one_side_twice_goes_to_another(states):
    policy, batch = sure_believer(states)
    policy.select_action(batch)
    following, stand = policy.student.following, Stand(np.array([1.0, 0.0, 0.0]), 0, 0.0)
    following.wayfinder._picks = [stand, stand]
    following.memory.clock_s[:] = 1.0
    goes_back = torch.tensor([int(Phase.ALIGN), int(Phase.SQUEEZE)])
    following.memory.phase[:] = int(Phase.REACH)
    assert following._elsewhere(goes_back.clone()).tolist() == goes_back.tolist()
    assert following._elsewhere(goes_back.clone()).tolist() == [int(Phase.APPROACH), int(Phase.SQUEEZE)]
    following.memory.phase[:] = int(Phase.ALIGN)
    walks = torch.full((2,), int(Phase.APPROACH))
    following._elsewhere(walks)
    assert following.wayfinder.fail(1) == 1  # had not been patient yet
    following.memory.clock_s[:] = 9.0
    following._elsewhere(walks)
    assert following.wayfinder.fail(1) == 3


def test_what_slipped_out_of_the_hands_is_held_otherwise_until_there_is_something_else_to_do(states, monkeypatch):
    policy, batch = sure_believer(states)
    policy.select_action(batch)
    following = policy.student.following
    monkeypatch.setattr(type(following.memory), "advance", lambda self, phase, view: torch.tensor([True, False]))
    for phase, slips in ((Phase.LIFT, 1), (Phase.CARRY, 2)):
        following.memory.phase[:] = int(phase)
        policy.select_action(batch)
        assert following.slips.tolist() == [slips, 0]
        assert following.copy().slips.tolist() == [slips, 0]
    following.hear(["Put it back.", following.instructions[1]])
    assert following.slips.tolist() == [0, 0]


def test_what_has_been_in_the_hands_is_looked_at_closer_and_told_in_metres(states, monkeypatch):
    policy, frame = sure_believer(states)
    following, asked = policy.student.following, []

    def look_closer(head, pictures, body, at_h, wanted):
        asked.append(wanted.tolist())
        rows = wanted.nonzero()[:, 0]
        shape = torch.tensor([0.3, 0.1, 0.5]), torch.tensor([1.0, 0.0, 0.1])
        there = at_h[rows] + torch.tensor([0.1, 0.0, 0.05]), torch.full((len(rows), 3), 0.002)
        return Found(rows, *there, *(one.expand(len(rows), -1) for one in shape))

    monkeypatch.setattr(student, "look_closer", look_closer)
    before = following.belief.now()[:, OBJECT].clone()
    following.touched[:] = torch.tensor([True, False])
    following.belief.variance[:, :2] = 0.01
    for _ in range(3):
        following.blind_steps[:], following.memory.phase[:] = 99, int(Phase.APPROACH)
        policy.select_action({**frame, "task": TASKS})
    assert asked == [[True, False]] * 3
    moved = (following.belief.now()[:, OBJECT] - before).norm(dim=1)
    assert moved[0] > 0.08 > 0.04 > moved[1]
    assert following.belief.attitude[0, 2] < 0.6 < following._attitude[1, 2]


def test_how_large_a_thing_was_is_remembered_from_before_it_was_touched(states):
    policy, _ = sure_believer(states)
    following = policy.student.following
    belief, none = following.belief, torch.tensor([False, False])
    half_m = torch.tensor([0.1, 0.15])
    belief.compass[:], belief.outline[:] = torch.tensor([1.0, 0.0]), outline_along(half_m[None], torch.zeros(1))
    belief.places[:, 2] = 0.25
    following._take_hold(~none)
    torch.testing.assert_close(following.stood_m, torch.tensor([[0.1, 0.15, 0.25]]).expand(2, -1), atol=1e-4, rtol=0)
    belief.outline[:] = outline_along(torch.tensor([[0.12, 0.22]]), torch.zeros(1))  # it lies
    belief.attitude[:], belief.shape_weight[:] = torch.tensor([1.0, 0.0, 0.3]), 1.0
    belief.places[:, 2] = 0.17
    following._take_hold(~none)
    torch.testing.assert_close(following.stood_m[:, 2], torch.tensor([0.25, 0.25]), atol=1e-4, rtol=0)
    following.slips[:], following.memory.phase[:] = torch.tensor([1, 0]), int(Phase.APPROACH)
    following._lie_as_before(torch.tensor([0, 1]))
    wide = half_extent_m(belief.outline, torch.full((2,), torch.pi / 2))
    assert wide[0] == pytest.approx(0.25, abs=0.01)
    assert belief.places[0, 2] == pytest.approx(0.15, abs=0.01)
    assert wide[1] == pytest.approx(0.22, abs=1e-3)
    assert belief.places[1, 2] == pytest.approx(0.17)
    following.hear(["Put it back.", following.instructions[1]])
    assert following.touched.tolist() == [False, True]


def test_who_hesitates_for_long_steps_back_and_looks_anew(states):
    policy, _ = sure_believer(states)
    following, aligns = policy.student.following, torch.tensor([int(Phase.ALIGN)] * 2)
    reaches, near = torch.tensor([int(Phase.REACH)] * 2), torch.zeros(2, 21)
    following.memory.phase[:] = aligns
    following.belief.variance[:, 0] = torch.tensor([0.3**2, 0.05**2])
    following.rounds[:], following.searched_rad[:] = 3, 7.5
    for step in range(200):  # to and fro between aligning and approaching; only the first one is not sure
        following._sure_of((reaches if step % 2 else aligns).clone(), near)
        if following.rounds[0] == 0:
            break
    assert 4.0 < step / 30 < 6.0
    assert following.wayfinder.steps_back.tolist() == [True, False]
    assert following.belief.variance[:, 0].sqrt().tolist() == pytest.approx([0.7, 0.05])
    assert following.searched_rad.tolist() == [0.0, 7.5]
    assert following.hesitates_s.tolist() == [0.0, 0.0]
    following.belief.variance[0, 0] = 0.05**2
    following._sure_of(reaches.clone(), near)
    assert following.hesitates_s[0] == 0


def test_who_cannot_step_back_from_what_it_put_down_walks_away(states):
    policy, frame = sure_believer(states)
    following = policy.student.following
    following.memory.phase[:] = int(Phase.RETREAT)
    following.memory.clock_s[:] = torch.tensor([9.0, 1.0])
    network = policy.network.decision
    network.phase_logits = lambda sights, geometry, memory: torch.eye(11)[[int(Phase.RETREAT)] * 2]
    try:
        policy.select_action({**frame, "task": TASKS})
    finally:
        del network.phase_logits
    assert following.memory.phase.tolist() == [int(Phase.APPROACH), int(Phase.RETREAT)]
    place = following.wayfinder._away_to[0]
    assert float((place - following.belief.pose[0, :2]).norm()) == pytest.approx(1.5, abs=0.05)
    assert following.belief.variance[0, 0] < 0.1, "nothing was lost"


def test_a_stand_that_is_far_is_walked_to(states):
    policy, _ = sure_believer(states)
    following, near = policy.student.following, torch.zeros(2, 21)
    far = near.clone()
    far[0, PICK] = far[0, PLACE] = torch.tensor([0.6, 0.9])
    for walks, aligns in ((Phase.APPROACH, Phase.ALIGN), (Phase.CARRY, Phase.ALIGN_PLACE)):
        following.memory.phase[:] = int(walks)
        wanted = torch.tensor([int(aligns)] * 2)
        assert following._sure_of(wanted, near).tolist() == [int(aligns)] * 2
        assert following._sure_of(wanted, far).tolist() == [int(walks), int(aligns)]


def test_floor_that_is_taken_is_learned_and_walked_round(states):
    """Dark floor is taken, bright floor is free; what was learned ends up in the map."""
    policy = make_believer(word_dropout=0.0)
    policy.train()
    state = states[0][:1]
    body, points = read_proprioception(state), patch_points()
    level = torch.cat([points, torch.zeros(len(points), 1)], -1)
    at, _ = project(body, level[None])
    generator = torch.Generator().manual_seed(4)

    def batch(count: int) -> dict:
        made = labelled(count, generator, state)
        edge = 0.6 * (2 * torch.rand(count, generator=generator) - 1)
        across = torch.linspace(-1, 1, 64)
        pictures = (across[None] > edge[:, None]).float()[:, None, None].expand(-1, 3, 64, -1) * 0.8 + 0.1
        taken = at[:, :, 0] < edge[:, None]
        return made | {HEAD: pictures, "privileged.floor": [write_patch(row.numpy()) for row in taken]}

    figures = taught(policy, lambda: batch(16), 80, 1e-3)
    assert figures["floor_wrong"] < 0.1
    policy.eval()
    policy.reset()
    left_is_taken = torch.full((1, 3, 64, 64), 0.9)
    left_is_taken[..., :32] = 0.1
    for _ in range(9):
        policy.select_action({HEAD: left_is_taken, STATE: state, "task": TASKS[:1]})
    evidence = policy.student.following.wayfinder.floor.evidence[0]
    ahead = cells_of(torch.tensor([[1.6, 0.6], [1.6, -0.6]]))
    assert evidence[tuple(ahead[0])] > 0.3
    assert evidence[tuple(ahead[1])] < -0.3


def test_what_should_be_in_view_and_is_not_is_believed_less(states):
    policy, frame = sure_believer(states)
    following = policy.student.following
    state = frame[STATE]
    ids = torch.arange(2)
    pose = following.belief.pose
    following.belief.places[:, OBJECT] = to_frame(torch.tensor([[1.2, 0.0, 0.8] + [0.0] * 18] * 2), pose)[:, OBJECT]
    seen = policy.network.perception(frame[HEAD], state, *policy.student.reader.recall(TASKS))
    seen.pointing[0, OBJECT_QUERY, 0] = -0.01  # not there
    seen.pointing[1, OBJECT_QUERY, 0] = -3.0
    before = following.belief.variance.clone()
    following._miss(ids, seen, read_proprioception(state), following.belief.now())
    assert following.belief.variance[0, 0] > before[0, 0] + 0.04**2
    assert following.belief.variance[1, 0] == before[1, 0]
    assert torch.equal(following.belief.variance[:, 2], before[:, 2])  # the goal's
    near = to_frame(torch.tensor([[0.45, 0.0, 0.8] + [0.0] * 18] * 2), pose)[:, OBJECT]
    following.belief.places[:, OBJECT], hidden = near, following.belief.variance.clone()
    following._miss(ids, seen, read_proprioception(state), following.belief.now())  # the arms may be before it
    assert torch.equal(following.belief.variance, hidden)
    following.belief.places[1, :2] = pose[1, :2] + 0.1  # inside the robot
    following._miss(ids, seen, read_proprioception(state), following.belief.now())
    assert following.belief.variance[1, 0] > before[1, 0] + 0.04**2


def test_what_is_out_of_the_picture_is_told_less_firmly(states):
    policy, frame = sure_believer(states)
    following = policy.student.following
    seen = policy.network.perception(frame[HEAD], frame[STATE], *policy.student.reader.recall(TASKS))
    seen.pointing[:, OBJECT_QUERY, 0] = torch.tensor([0.0, -30.0])
    seen.pointing[:, GOAL_QUERY, 0] = torch.tensor([-30.0, 0.0])
    doubtful, more = following._doubtful(seen), 1 + BeliefConfig().unseen
    torch.testing.assert_close(doubtful[:, OBJECT], torch.tensor([[more] * 3, [1.0] * 3]))
    torch.testing.assert_close(doubtful[:, GOAL], torch.tensor([[1.0] * 3, [more] * 3]))
    assert (doubtful[:, 6:] == 1).all()



def test_parts_of_pictures_learn_the_names_of_what_they_show(states):
    """A red and a blue patch stand where two boxes are; which is which has to be learned from their names."""
    policy = make_believer(word_dropout=0.0)
    policy.train()
    state = states[0][:1]
    body = read_proprioception(state)
    generator = torch.Generator().manual_seed(2)
    rays = policy.network.perception.rays

    def batch(count: int) -> dict:
        made = labelled(count, generator, state)
        pictures, texts = 0.3 * torch.rand(count, 3, 64, 64, generator=generator), []
        for i in range(count):
            boxes = torch.zeros(2, 7)
            boxes[:, 0] = 1.5
            boxes[:, 1] = torch.tensor([0.6, -0.6])[torch.randperm(2, generator=generator)]
            boxes[:, 2], boxes[:, 3:6] = 0.8, 0.25
            shown = first_box_hit(body, rays, boxes[None], torch.ones(1, 2, dtype=torch.bool))[0].view(8, 8)
            for k, channel in enumerate((0, 2)):
                pictures[i, channel] += 0.7 * (shown == k).float().repeat_interleave(8, 0).repeat_interleave(8, 1)
            names = ("the red box", "the blue box")
            texts.append(json.dumps([[name, *box.tolist()] for name, box in zip(names, boxes, strict=True)]))
        return made | {HEAD: pictures, "privileged.landmarks": texts}

    figures = taught(policy, lambda: batch(16), 60, 1e-3)
    # 0.3 of a log-likelihood that begins at about one, and 0.2 of one that begins at log(65) = 4.2 and cannot go below
    # the entropy of the blurred middle that it is to point at, 1.8
    assert figures["naming_loss"] < 0.3 * 0.1 + 0.2 * 1.9


def test_between_two_looks_no_picture_is_needed(states):
    """What is shown then changes nothing, and a new instruction makes it look at once."""
    policy = make_believer().eval()
    frames = [{HEAD: torch.rand(1, 3, 64, 64), STATE: states[0][:1], "task": TASKS[:1]} for _ in range(2)]
    assert policy.needs_picture(TASKS[:1])
    needed = []
    for _ in range(2 * BeliefConfig().look_every):
        needed.append(policy.needs_picture(TASKS[:1]))
        chunks = [policy.predict_action_chunk(frame) for frame in frames]
        assert torch.equal(*chunks) or needed[-1]
        policy.select_action(frames[0])
    assert sum(needed) == 2
    policy.select_action(frames[0])
    assert not policy.needs_picture(TASKS[:1])
    assert policy.needs_picture(TASKS[1:2])


def test_the_middle_of_the_room_is_taken_from_the_map(states):
    policy = make_believer()
    into_the_middle = "Put the lamp exactly in the middle of the room."
    tasks = [into_the_middle, "Put the lamp on the middle of the desk."]
    roll(policy, frames_of(states[:2]), [tasks] * 2)
    following, reworder = policy.student.following, policy.student.network.reworder
    belief, both = following.belief, torch.arange(2)
    belief.compass[:] = torch.tensor([1.0, 0.0])
    known = belief.places.clone()
    following.wayfinder.floor.evidence[:] = 0.0
    following._find_middle(reworder, both)
    assert torch.equal(belief.places, known)  # nothing has been seen of the walls
    low, high = cells_of(torch.tensor([[-2.0, -1.0], [3.0, 4.0]])).tolist()
    following.wayfinder.floor.evidence[:, low[0] - 3 : high[0] + 3, low[1] - 3 : high[1] + 3] = 2.0
    following.wayfinder.floor.evidence[:, low[0] : high[0], low[1] : high[1]] = -2.0
    following._find_middle(reworder, both)
    torch.testing.assert_close(belief.places[0, GOAL][:2], torch.tensor([0.5, 1.5]), atol=0.1, rtol=0)
    assert torch.equal(belief.places[1], known[1])


def test_a_goal_beside_a_piece_of_furniture_follows_from_the_piece(states, monkeypatch):
    policy = make_believer()
    network, asked = policy.student.network, []

    def find_pieces(sight, named):
        asked.append(named.shape)
        n = len(named)
        one = torch.ones(n, 1)
        front = torch.tensor([0.0, -1.0]).expand(n, 1, 2)  # looks to the robot's right
        half = torch.tensor([0.3, 0.6, 0.4]).expand(n, 1, 3)
        return Piece(torch.tensor([2.0, 1.0]).expand(n, 1, 2), half, front, -5.0 * one, 5.0 * one)

    monkeypatch.setattr(network.perception, "find_pieces", find_pieces)
    tasks = ["Put the lamp just to the left of the sofa.", "Put the lamp on the floor."]
    frames = frames_of(states[:1])
    roll(policy, frames, [tasks])
    goal = policy.student.following.belief.now()[0, GOAL]
    beside = GAP_M + float(policy.student.following.belief.places[0, SPAN].norm().clamp(0.1, 0.22))
    # who looks at its front has its own right hand, -x here, at the left
    torch.testing.assert_close(goal[:2], torch.tensor([2.0 - 0.6 - beside, 1.0]), atol=0.1, rtol=0)
    assert asked == [(1, 1, network.perception.queries.shape[1])]
