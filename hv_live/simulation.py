"""One robot in one room that does what it is told, step by step; no clock, no threads, no network.

with Simulation("living_room_1", policy="teacher") as live:
    live.instruct("Take the red toaster from the coffee table to the console table.")
    live.run(seconds=5)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from hv_live.actors import HEAD_SIZE_PX, Actor, Cast
from hv_live.live_world import LiveWorld
from hv_live.understanding import NotUnderstoodError, clean_sentence, understand
from hv_sim.humanoid import BODY_NAMES, CONTROL_HZ
from hv_sim.rendering import CameraRenderer
from hv_sim.task import Task, load_task
from hv_sim.world import pick_phrasing
from hv_teachers.episodes import HELD_M, LIFTED_M, NEAR_M, PLACED_M

if TYPE_CHECKING:
    from hv_live.recorder import LiveRecorder

MOST_SAID = 200
"""Instructions that are remembered."""
_HANDS = [BODY_NAMES.index("right_hand"), BODY_NAMES.index("left_hand")]


@dataclass
class Said:
    """An instruction that was given, and what became of it."""

    text: str
    by: str
    """`task` (the room's own first one), `you`, or `instructor`."""
    status: str = "now"
    """`now`, `done`, or `left` for another one."""
    begun_step: int = 0
    ended_step: int | None = None


class Simulation:
    """A room, a robot, who plays it, and the instruction in force.

    It begins with the task's first instruction. Further ones come from a person (`instruct`), at any step, or from
    Algorithm 3 (`set_instructor`), which gives the task's own when the last one is done.

    Args:
        task: a task, its name or its file.
        policy: see `hv_live.actors.Cast`; or a cast that is kept between simulations.
        seed: decides the start.

    Raises:
        hv_sim.task.TaskError: the task is unknown or invalid.
        ValueError: the policy is unknown or cannot be read.
    """

    def __init__(
        self, task: Task | str | Path = "living_room_1", policy: str | Cast = "student", seed: int = 0
    ) -> None:
        self.task = task if isinstance(task, Task) else load_task(task)
        self.cast = Cast(policy) if isinstance(policy, str) else policy
        self.world = LiveWorld(self.task)
        self.policy = self.cast.first
        self._actor: Actor = self.cast.get(self.policy)
        self._eyes = CameraRenderer(HEAD_SIZE_PX, HEAD_SIZE_PX, max_scenes=1)
        self.recorder: LiveRecorder | None = None
        self.instructor = False
        """Algorithm 3 plays the user."""
        self.seed = seed
        self.said: list[Said] = []
        self.last_told = ""
        """The words that the policy was given at the last control step."""
        self._start_height = np.zeros(0)
        self._accepted: set[int] = set()
        self.reset(seed)

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # what is so now

    @property
    def instruction(self) -> str:
        """The instruction in force."""
        return self.world.instructions()[0]

    @property
    def done(self) -> bool:
        """The instruction in force is done: its object rests near its goal and the robot has stepped back."""
        return self.said[-1].status == "done"

    @property
    def fallen(self) -> bool:
        """The robot has fallen since the last reset."""
        return bool(self.world.fallen[0])

    @property
    def time_s(self) -> float:
        """Seconds of the simulated clock since the last reset."""
        return int(self.world.episode_step[0]) / CONTROL_HZ

    @property
    def progress(self) -> float | None:
        """How much of its way the object has gone, in [0, 1]; None where the goal is not known."""
        if self.done:
            return 1.0
        return float(self.world.progress()[0] - self.world.num_finished[0]) if self.world.goal_known else None

    @property
    def distance_m(self) -> float | None:
        """Of the object from its goal; None where the goal is not known."""
        return float(self.world.object_goal_distances_m()[0, -1]) if self.world.goal_known else None

    @property
    def stage(self) -> str:
        """What the robot is about, judged from where robot, hands and object are."""
        world, state = self.world, self.world.state
        if self.done:
            return "done"
        if not world.goal_known:
            return "the policy alone knows what these words ask for"
        k = int(world.object_index[0])
        position = state.object_pos_w[0, k]
        near = float((position - state.link_pos_w[0, 0])[:2].norm()) < NEAR_M
        in_hands = float((position - state.link_pos_w[0, _HANDS].mean(0)).norm()) < HELD_M
        lifted = float(position[2]) - float(self._start_height[k]) > LIFTED_M
        if (self.distance_m or 0.0) < PLACED_M:
            return "putting it down" if near else "placed"
        if in_hands and (lifted or bool(world.navigator.picked_up[0])):
            return "carrying"
        return "taking hold" if near else "on its way"

    # what can be done

    def step(self) -> None:
        """One control step of 1/30 s: look, decide, move, judge."""
        world = self.world
        is_wanted = self.recorder is not None or self._actor.needs_picture(world)
        picture = self.head_picture() if is_wanted else None
        [self.last_told] = world.instructions()
        intent, targets = self._actor.act(world, picture)
        if not bool(targets.isfinite().all()):
            raise ValueError(f"policy {self.policy}: its joint targets are not finite")
        if self.recorder is not None and picture is not None and not self.recorder.is_full:
            self.recorder.add(world, picture, intent, targets, self._actor.knowledge)
        world.step(targets)
        if bool(world.finished[0]) and self.said[-1].status == "now":
            self._accept()
            if self.instructor and not self._give_next_of_task():
                self.instructor = False

    def run(self, seconds: float) -> None:
        """As many control steps as that takes on the simulated clock."""
        for _ in range(round(seconds * CONTROL_HZ)):
            self.step()

    def instruct(self, sentence: str) -> None:
        """Gives an instruction; it holds from the next control step on, in place of the one in force.

        Raises:
            NotUnderstoodError: it is not a sentence, or who plays needs a goal and the sentence names none.
        """
        text = clean_sentence(sentence)
        try:
            subtask = understand(text, self.world.whole_scene, self.world.layout())
        except NotUnderstoodError as error:
            if self._actor.needs_goal:
                raise NotUnderstoodError(f"the {self.policy} needs an object and a place: {error}") from None
            subtask = None
        self.instructor = False
        self._end_current("left")
        if subtask is None:
            self.world.give_words(text)
        else:
            self.world.give(subtask)
        self._begin(text, "you")

    def set_instructor(self, on: bool) -> None:
        """Lets Algorithm 3 give the task's own instructions, in turn, those that are not done yet.

        Raises:
            ValueError: all of them are done.
        """
        if on and (self.done or not self.world.goal_known) and not self._give_next_of_task():
            raise ValueError("every instruction of this room is done: reset it, or choose another one")
        self.instructor = on

    def set_policy(self, name: str) -> None:
        """Lets somebody else play on from here.

        Raises:
            ValueError: nobody is called so, or who is needs a goal and the words in force name none.
        """
        actor = self.cast.get(name)
        if actor.needs_goal and not self.world.goal_known:
            raise ValueError(f"the {name} needs an object and a place: give such an instruction first")
        self.policy, self._actor = name, actor
        actor.reset()

    def push(self, direction_rad: float, speed_m_s: float = 0.5) -> None:
        """Shoves the robot horizontally, in a direction of its own: 0 forward, pi/2 to its left."""
        yaw = self.world.robot_xy_yaw()[2] + direction_rad
        self.world.push(speed_m_s * np.array([np.cos(yaw), np.sin(yaw), 0.0]))

    def reset(self, seed: int | None = None) -> None:
        """Begins anew with the task's first instruction; by default with the next seed."""
        if self.recorder is not None:
            self.recorder.end_episode()
        self.seed = self.seed + 1 if seed is None else seed
        self.world.restart(self.seed)
        self._actor.reset()
        self.said = []
        self._accepted.clear()
        self._begin(self.instruction, "task")

    def start_recording(self, root: str | Path) -> None:
        """Records control steps into a new dataset until `stop_recording`.

        Raises:
            hv_teachers.dataset_format.RecordingError: the folder exists.
        """
        from hv_live.recorder import LiveRecorder  # with LeRobot's datasets, which take seconds to import

        if self.recorder is None:
            self.recorder = LiveRecorder(Path(root))

    def stop_recording(self) -> LiveRecorder | None:
        """Takes no more steps; what was recorded is kept once the recorder that is returned is finished."""
        recorder, self.recorder = self.recorder, None
        return recorder

    def head_picture(self) -> np.ndarray:
        """(128, 128, 3) uint8: what the robot sees."""
        physics = self.world.physics
        return self._eyes.render(physics.model(0), physics.data(0))

    def copy_data(self, data: mujoco.MjData) -> None:
        """Copies the state, kinematics computed, for somebody who draws it elsewhere."""
        self.world.physics.data(0, data)

    def task_instruction(self, index: int) -> str:
        """The task's own instruction of that number, in the words that the seed chooses."""
        return pick_phrasing(self.task.subtasks[index].phrasings, self.seed, index)

    def close(self) -> None:
        """Frees the OpenGL context; finishes a recording that still runs."""
        recorder = self.stop_recording()
        if recorder is not None and recorder.num_frames:
            recorder.finish()
        self._eyes.close()

    # inside

    def _begin(self, text: str, by: str) -> None:
        self.said.append(Said(text, by, begun_step=int(self.world.episode_step[0])))
        del self.said[:-MOST_SAID]
        self._start_height = self.world.state.object_pos_w[0, :, 2].numpy().copy()

    def _end_current(self, status: str) -> None:
        current = self.said[-1]
        if current.status == "now":
            current.status, current.ended_step = status, int(self.world.episode_step[0])

    def _give_next_of_task(self) -> bool:
        """Gives the first of the task's own instructions that was not done yet; False if there is none."""
        for i, subtask in enumerate(self.task.subtasks):
            if i in self._accepted:
                continue
            self._end_current("left")
            text = self.task_instruction(i)
            self.world.give(replace(subtask, instruction=text, paraphrases=()))
            self._begin(text, "instructor")
            return True
        return False

    def _accept(self) -> None:
        self._end_current("done")
        now = self.world.current
        for i, own in enumerate(self.task.subtasks):
            if (own.object, own.goal_position_m) == (now.object, now.goal_position_m):
                self._accepted.add(i)
