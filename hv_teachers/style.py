"""What the style discriminator sees (Table 12 of the paper): 131 numbers a frame, ten frames in a row.

The motion set that it takes for good style is recorded from the planner's expert on its motor prior: sub-tasks that it
finished without a fall. Kinematic references would have been smoother, but they carry nothing, and a discriminator
tells at a glance a body that bears its load from one that need not. Mocap clips may be added (`hv_teachers.mocap`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor
from tqdm import tqdm

from hv_policy.motor import embodiment as body
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.prior import MotorPrior
from hv_sim.observations import Heading
from hv_sim.physics import PhysicsState
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld
from hv_teachers.expert import PlannerExpert

FRAME_DIM = 1 + 3 + 3 + 6 + 12 * 6 + 28 + 5 * 3 + 3
WINDOW_FRAMES = 10

# the twelve links that joints turn (the hands are fixed to the forearms), and what each is turned against
JOINT_LINKS = [1, 2, 3, 4, 6, 7, 9, 10, 11, 12, 13, 14]
JOINT_PARENTS = [0, 1, 1, 3, 1, 6, 0, 9, 10, 0, 12, 13]
END_EFFECTORS = [*body.HANDS, *body.FEET, body.HEAD]
_LINKS, _PARENTS, _ENDS = np.array(JOINT_LINKS), np.array(JOINT_PARENTS), np.array(END_EFFECTORS)


def style_frame(state: PhysicsState, object_pos_w: Tensor, heading: Heading | None = None) -> Tensor:
    """(N, 131) one frame of Table 12, in the heading frame; positions relative to the root.

    Root height 1, linear and angular velocity 3 + 3, rotation 6; rotations of the 12 joints against their parent link
    72; joint velocities 28; hands, feet and head 15; position of the current object 3.

    Args:
        state: of the robots.
        object_pos_w: (N, 3) the current object's centre, world frame.
        heading: of the robots, if at hand.
    """
    heading = Heading.of(state) if heading is None else heading
    frame = torch.empty(len(object_pos_w), FRAME_DIM)
    links = state.link_pos_w, state.link_rot_w, state.link_lin_vel_w[:, 0], state.link_ang_vel_w[:, 0]
    arrays = as_arrays(*links, state.joint_vel, object_pos_w, heading.cos, heading.sin)
    _fill_frames(frame.numpy(), *arrays, _LINKS, _PARENTS, _ENDS)
    return frame


@numba.njit(cache=True)
def _fill_frames(
    out: Array,
    pos: Array,
    rot: Array,
    lin_vel: Array,
    ang_vel: Array,
    joint_vel: Array,
    obj: Array,
    cos: Array,
    sin: Array,
    links: Array,
    parents: Array,
    ends: Array,
) -> None:
    """`style_frame` of links (N, 15, 3), (N, 15, 3, 3) and the root's velocities (N, 3), robot by robot."""
    for i in range(len(out)):
        row, c, s = out[i], cos[i], sin[i]
        row[0] = pos[i, 0, 2]
        at = 1
        for velocity in (lin_vel, ang_vel):
            x, y = velocity[i, 0], velocity[i, 1]
            row[at], row[at + 1], row[at + 2] = c * x + s * y, c * y - s * x, velocity[i, 2]
            at += 3
        for column in range(2):
            x, y = rot[i, 0, 0, column], rot[i, 0, 1, column]
            row[at], row[at + 1], row[at + 2] = c * x + s * y, c * y - s * x, rot[i, 0, 2, column]
            at += 3
        for joint in range(len(links)):
            parent, link = rot[i, parents[joint]], rot[i, links[joint]]
            for column in range(2):
                for d in range(3):
                    row[at] = parent[0, d] * link[0, column] + parent[1, d] * link[1, column]
                    row[at] += parent[2, d] * link[2, column]
                    at += 1
        for joint in range(joint_vel.shape[1]):
            row[at] = joint_vel[i, joint]
            at += 1
        for k in range(len(ends) + 1):
            point = pos[i, ends[k]] if k < len(ends) else obj[i]
            x, y = point[0] - pos[i, 0, 0], point[1] - pos[i, 0, 1]
            row[at], row[at + 1], row[at + 2] = c * x + s * y, c * y - s * x, point[2] - pos[i, 0, 2]
            at += 3


class StyleHistory:
    """The last ten frames of every environment; an episode's first frame stands for those before it."""

    def __init__(self, num_envs: int) -> None:
        self.frames = torch.zeros(num_envs, WINDOW_FRAMES, FRAME_DIM)
        """(N, 10, 131) oldest first."""
        self.fresh = torch.ones(num_envs, dtype=torch.bool)
        """(N,) no frame of the present episode has been added yet."""

    def reset(self, ids: Tensor) -> None:
        """New episodes begin in environments `ids`."""
        self.fresh[ids] = True

    def add(self, frame: Tensor) -> Tensor:
        """Adds (N, 131) and returns the windows (N, 10 * 131)."""
        moved = torch.cat([self.frames[:, 1:], frame[:, None]], 1)
        if self.fresh.any():
            moved = torch.where(self.fresh[:, None, None], frame[:, None].expand_as(moved), moved)
            self.fresh = torch.zeros_like(self.fresh)
        self.frames = moved
        return self.frames.flatten(1)


@dataclass
class MotionSet:
    """Clips of good style.

    Attributes:
        frames: (F, 131) of all clips, one after the other.
        starts: (W,) int64, every frame at which a window of ten frames of one clip begins.
    """

    frames: Tensor
    starts: Tensor

    @staticmethod
    def of(clips: Sequence[Tensor]) -> MotionSet:
        """From clips (T, 131); those shorter than a window are left out.

        Raises:
            ValueError: no clip is long enough, or one has another width.
        """
        for clip in clips:
            if clip.ndim != 2 or clip.shape[1] != FRAME_DIM:
                raise ValueError(f"clips: shape {tuple(clip.shape)} is not valid; valid: (frames, {FRAME_DIM})")
        kept = [clip for clip in clips if len(clip) >= WINDOW_FRAMES]
        if not kept:
            raise ValueError(f"clips: none of {len(clips)} has {WINDOW_FRAMES} frames")
        starts, at = [], 0
        for clip in kept:
            starts.append(torch.arange(at, at + len(clip) - WINDOW_FRAMES + 1))
            at += len(clip)
        return MotionSet(torch.cat(kept), torch.cat(starts))

    def sample(self, num: int, generator: torch.Generator | None = None) -> Tensor:
        """(num, 10 * 131) windows drawn with replacement."""
        chosen = self.starts[torch.randint(len(self.starts), (num,), generator=generator)]
        return self.frames[chosen[:, None] + torch.arange(WINDOW_FRAMES)].flatten(1)

    def joined(self, other: MotionSet) -> MotionSet:
        """Both sets' clips."""
        return MotionSet(
            torch.cat([self.frames, other.frames]), torch.cat([self.starts, other.starts + len(self.frames)])
        )

    def save(self, path: Path) -> None:
        """Writes a safetensors file, whole or not at all."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_suffix(".tmp")
        tensors = {"frames": self.frames.contiguous(), "starts": self.starts.contiguous()}
        save_file(tensors, temporary, metadata={"format": "hv_motion_set/1"})
        temporary.replace(path)

    @staticmethod
    def load(path: Path) -> MotionSet:
        """Reads what `save` wrote.

        Raises:
            ValueError: the file is not a motion set.
        """
        try:
            with safe_open(str(path), framework="pt") as file:
                if (file.metadata() or {}).get("format") != "hv_motion_set/1":
                    raise ValueError(f"{path}: not a motion set; valid: what hv-train-teacher wrote")
                return MotionSet(file.get_tensor("frames"), file.get_tensor("starts"))
        except (OSError, SafetensorError) as error:
            raise ValueError(f"{path}: cannot be read: {' '.join(str(error).split())}") from error


def record_motion_set(
    tasks: Sequence[Task],
    *,
    seed: int,
    prior: MotorPrior | None = None,
    max_steps: int | None = None,
    num_threads: int = 0,
    progress: bool = False,
) -> MotionSet:
    """The planner's expert plays one episode of each task; sub-tasks finished without a fall become clips.

    Args:
        tasks: one environment each.
        seed: of the episodes.
        prior: the controller (default: the shipped one).
        max_steps: where to stop (default: at the episodes' ends).
        num_threads: of the physics.
        progress: show a bar.

    Raises:
        ValueError: no sub-task was finished.
    """
    world = RearrangeWorld(tasks, num_threads=num_threads, max_episode_steps=max_steps)
    world.reset(seeds=[seed + i for i in range(world.num_envs)])
    expert = PlannerExpert(world.num_envs, prior)
    rows = torch.arange(world.num_envs)
    running: list[list[Tensor]] = [[] for _ in tasks]
    clips: list[Tensor] = []
    for _ in tqdm(range(world.max_episode_steps), desc="motion set", disable=not progress, mininterval=5):
        if bool(world.done.all()):
            break
        done_before, finished_before = world.done, world.num_finished.clone()
        object_before = world.object_index
        world.step(expert(world)[1])
        frames = style_frame(world.state, world.state.object_pos_w[rows, object_before])
        for i in (~done_before).nonzero()[:, 0].tolist():
            running[i].append(frames[i])
            if world.num_finished[i] > finished_before[i]:
                if not world.fallen[i]:
                    clips.append(torch.stack(running[i]))
                running[i] = []
    if not clips:
        raise ValueError(f"tasks: the planner finished none of {len(tasks)} within {world.max_episode_steps} steps")
    return MotionSet.of(clips)
