"""Practice for the motor prior: random intents on an empty floor, and the scripted planner carrying boxes.

Batched; half of the environments (by configuration) hold a box. An episode may begin anywhere: standing, bent over the
box, with the box in the hands, about to put it down (reference state initialisation).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import torch
from torch import Tensor

from hv_policy.batch_invariant import atan2
from hv_policy.decision.view import Phase, TaskView
from hv_policy.motor import embodiment as body
from hv_policy.motor.gait import PELVIS_PITCH_SHARE
from hv_policy.motor.intent import GAZE, HEIGHT, LEFT_HAND, PITCH, RIGHT_HAND, SQUEEZE, neutral_intent
from hv_policy.motor.kinematics import rotate_xy
from hv_policy.motor.prior import MotorPrior, MotorStep
from hv_policy.motor.reference import feet_ahead, standing_pose
from hv_sim.humanoid import ROBOT_NQ
from hv_sim.metrics import is_fallen
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import Heading, proprioception
from hv_sim.physics import PhysicsState
from hv_teachers.motor_critic import critic_sight
from hv_teachers.motor_rewards import RewardConfig, motor_reward
from hv_teachers.motor_scenes import (
    BEHIND_M,
    RETREAT_CLEARANCE_M,
    CarryTask,
    LoadRange,
    compile_ground,
    draw_carry_task,
    table_clearance_m,
    tables_of,
)
from hv_teachers.planner import PlannerConfig, ScriptedPlanner
from hv_teachers.postures import reach_posture
from hv_teachers.regrasp import Regrasp, grip_ahead, regrasp

PLACED_STEPS, PLACED_M = 45, 0.2
SHOVE_STEPS = 3
"""Control steps that a push lasts: .1 s."""
START_ATTEMPTS = 50
START_PHASES = (Phase.APPROACH, Phase.REACH, Phase.SQUEEZE, Phase.CARRY, Phase.ALIGN_PLACE, Phase.RELEASE)

@dataclass(frozen=True)
class MotorEnvConfig:
    """Shares of what is practised and how hard."""

    num_envs: int = 1024
    load_share: float = 0.5
    episode_s: float = 16.0
    push_interval_s: float = 5.0
    push_n_s: float = 38.0
    load: LoadRange = field(default_factory=LoadRange)
    start_shares: tuple[float, ...] = (0.25, 0.15, 0.15, 0.15, 0.15, 0.15)
    """How often an episode with a load begins in each of `START_PHASES`."""
    bent_share: float = 0.3
    """How often an episode without a load begins bent down."""
    auto_reset: bool = True
    planner: PlannerConfig = field(default_factory=PlannerConfig)
    reward: RewardConfig = field(default_factory=RewardConfig)
    randomize: bool = True
    late_share: float = 0.2
    """How many robots' servos hear of their targets one control step later."""
    physics_hz: int = 120
    num_threads: int = 0


class MotorEnv:
    """`step(residual)` -> rewards, failures, time-outs, terms; `features` is what is seen then. The base controller of
    `prior` stands between residual and physics."""

    def __init__(self, prior: MotorPrior, config: MotorEnvConfig, seed: int) -> None:
        self.config, self.prior = config, prior
        self.num_envs = config.num_envs
        self.rng = np.random.default_rng(seed)
        loads = round(config.num_envs * config.load_share)
        self.has_load = torch.arange(self.num_envs) < loads
        self.tasks: list[CarryTask | None] = [
            draw_carry_task(self.rng, config.load) if i < loads else None for i in range(self.num_envs)
        ]
        models = [
            compile_ground(
                self.rng, t, randomize=config.randomize, friction=config.load.friction, physics_hz=config.physics_hz
            )
            for t in self.tasks
        ]
        self.physics = MujocoPhysics(models, num_threads=config.num_threads)
        self.planner = ScriptedPlanner(loads, config.planner)
        self._stack_tasks()
        n = self.num_envs
        self.phase = torch.zeros(n, dtype=torch.long)
        """(N,) the planner's phase; it plans for the environments with a load, which are the first ones."""
        self.object_target = torch.zeros(n, 3)
        """(N, 3) see `ScriptedPlanner`."""
        self._lost = torch.zeros(n, dtype=torch.bool)
        self.max_steps = int(config.episode_s * 30)
        self.episode_step = torch.zeros(n, dtype=torch.long)
        self.command = neutral_intent(n)
        self.command_left = torch.zeros(n, dtype=torch.long)
        self.waypoint_index = torch.zeros(n, dtype=torch.long)
        self.push_in = torch.zeros(n, dtype=torch.long)
        # spread over those with and without a load
        late = config.late_share if config.randomize else 0.0
        self._late = ((torch.arange(n) * 0.618034) % 1.0 < late)[:, None]
        self._last_targets = torch.zeros(n, 28)
        self._shove, self._shove_left = np.zeros((n, 3)), np.zeros(n, dtype=np.int64)
        self.idle_steps = torch.zeros(n, dtype=torch.long)
        self.dropped = torch.zeros(n, dtype=torch.bool)
        self._reset(np.arange(n))
        self._look()

    def step(self, residual: Tensor) -> tuple[Tensor, Tensor, Tensor, dict[str, Tensor]]:
        """One control step. (N, 28) -> rewards (N,), failures (N,) bool, time-outs (N,) bool, terms {name: (N,)}."""
        previous = self.motor_step
        targets = self.prior.apply_residual(previous, residual)
        self._push()
        heard = torch.where(self._late & (self.episode_step > 0)[:, None], self._last_targets, targets)
        self._last_targets = targets
        self.physics.step(heard)
        self.episode_step += 1
        self._state = self._observe()
        heading = Heading.of(self._state)
        object_target = self.object_target
        terms = motor_reward(self._state, heading, previous, residual, self, object_target, self.config.reward)
        terms["placed"] = self.config.reward.placed * self.placed()
        reward = torch.stack(list(terms.values())).sum(0)
        failed = self._failed(previous, object_target)
        done = self.episode_step >= self.max_steps
        finished = self.has_load & (self.phase == Phase.IDLE) & (self.idle_steps > 60)
        timed_out = (done | finished) & ~failed
        ended = failed | timed_out
        if ended.any() and self.config.auto_reset:
            self._reset(ended.nonzero()[:, 0].numpy())
        self._look()
        return torch.nan_to_num(reward), failed, timed_out, terms

    def object_goal_distance(self) -> Tensor:
        """(N,) how far the load is from where it belongs, m."""
        return (self.object_pos() - self.goal_pos).norm(dim=-1)

    def placed(self) -> Tensor:
        """(N,) bool: since 1.5 s the work is done, and the load is where it belongs."""
        return self.has_load & (self.idle_steps == PLACED_STEPS) & (self.object_goal_distance() < PLACED_M)

    def holding(self) -> Tensor:
        """(N,) bool: the load should be in the hands."""
        return self.has_load & (self.phase >= Phase.LIFT) & (self.phase <= Phase.LOWER)

    def object_pos(self) -> Tensor:
        """(N, 3) where the load is, world frame, m."""
        return self._state.object_pos_w[:, 0]

    # inside

    def _stack_tasks(self) -> None:
        def stack(name: str, size: int) -> Tensor:
            rows = [np.zeros(size) if t is None else np.atleast_1d(getattr(t, name)) for t in self.tasks]
            return torch.tensor(np.stack(rows), dtype=torch.float32)

        self.half = stack("half_extents_m", 3)
        self.mass = stack("mass_kg", 1)[:, 0]
        self.grasp_height = stack("grasp_height_m", 1)[:, 0]
        self.goal_pos, self.start_pos = stack("goal_pos", 3), stack("start_pos", 3)
        self.pick_stand, self.place_stand = stack("pick_stand", 3), stack("place_stand", 3)
        n = self.num_envs
        self._way = Regrasp(torch.zeros(n, 2, 3), torch.zeros(n), torch.zeros(n, 3))
        self._waypoints = torch.zeros(n, 5, 2)
        self._planned_for = torch.zeros(n, 3)

    def _observe(self) -> PhysicsState:
        state = self.physics.state()
        if state.object_pos_w.shape[1]:
            return state
        # nobody carries anything: one absent object each
        n = self.num_envs
        return replace(
            state,
            object_pos_w=torch.zeros(n, 1, 3),
            object_rot_w=torch.zeros(n, 1, 3, 3),
            object_lin_vel_w=torch.zeros(n, 1, 3),
            object_ang_vel_w=torch.zeros(n, 1, 3),
        )

    def _view(self, heading: Heading) -> TaskView:
        state, loads = self._state, self.planner.num_envs
        self._plan_again(state.link_pos_w[:, 0, :2])
        root, rotation = state.link_pos_w[:loads, 0, :2], state.object_rot_w[:loads, 0]
        position = self.object_pos()[:loads]
        grasp = (rotation[:, None] @ self._way.local[:loads, ..., None])[..., 0] + position[:, None]
        carrying = self.planner.phase >= Phase.CARRY
        low = torch.where(carrying, 2, 0)
        high = torch.where(carrying, 4, 1)
        rows = torch.arange(loads)
        index = torch.maximum(torch.minimum(self.waypoint_index[:loads], high), low)
        near = (self._waypoints[rows, index] - root).norm(dim=-1) < 0.3
        index = torch.minimum(index + near.long(), high)
        self.waypoint_index[:loads] = index
        return TaskView(
            root_xy=root,
            root_yaw=atan2(heading.sin, heading.cos)[:loads],
            feet_xy=state.link_pos_w[:loads, body.FEET, :2].mean(1),
            hands=state.link_pos_w[:loads, body.HANDS],
            object_pos=position,
            grasp=grasp,
            depth_m=self._way.depth_m[:loads],
            goal_pos=self.goal_pos[:loads],
            pick_stand=self._way.stand[:loads],
            place_stand=self.place_stand[:loads],
            waypoint=self._waypoints[rows, index],
            waypoint_is_last=index == high,
            may_back=torch.ones(loads, dtype=torch.bool),
            clearance_m=torch.ones(loads),
            away=torch.zeros(loads, 2),
        )

    def _plan_again(self, root: Tensor) -> None:
        """A box that slipped away or was kicked is taken from where it now lies."""
        moved = (self.object_pos() - self._planned_for).norm(dim=-1) > 0.1
        again = self.has_load & (self.phase <= Phase.SQUEEZE) & (self._lost | moved)
        ids = again.nonzero()[:, 0]
        if not len(ids):
            return
        state = self._state
        way = regrasp(
            self.object_pos()[ids], state.object_rot_w[ids, 0], self.half[ids], self.grasp_height[ids], root[ids]
        )
        self._way.local[ids], self._way.depth_m[ids], self._way.stand[ids] = way.local, way.depth_m, way.stand
        self._waypoints[ids, 0], self._waypoints[ids, 1] = _behind(way.stand), way.stand[:, :2]
        self._waypoints[ids, 2] = self._waypoints[ids, 0]
        self._planned_for[ids] = self.object_pos()[ids]
        self.waypoint_index[ids] = 0

    def _plan_first(self, rows: Tensor) -> None:
        """The way that the task was drawn with."""
        half, grasp = self.half[rows], self.grasp_height[rows]
        left = torch.stack([grip_ahead(half[:, 0]), half[:, 1], grasp], -1)
        self._way.local[rows] = torch.stack([left * left.new_tensor([1.0, -1.0, 1.0]), left], 1)
        self._way.depth_m[rows], self._way.stand[rows] = 2 * half[:, 0], self.pick_stand[rows]
        self._planned_for[rows] = self.start_pos[rows]
        pick, place = self.pick_stand[rows], self.place_stand[rows]
        to_goal = [_behind(pick), _behind(place), place[:, :2]]
        self._waypoints[rows] = torch.stack([_behind(pick), pick[:, :2], *to_goal], 1)

    def _look(self) -> None:
        """Intents for the state as it now is, and the base controller's answer to them."""
        self._state = self._observe()
        heading = Heading.of(self._state)
        self._draw_commands()
        self.intent = self.command.clone()
        loads = self.planner.num_envs
        if loads:
            self.intent[:loads] = self.planner(self._view(heading))
            self.phase[:loads], self._lost[:loads] = self.planner.phase, self.planner.lost
            self.object_target[:loads] = self.planner.object_target
        self.idle_steps = torch.where(self.phase == Phase.IDLE, self.idle_steps + 1, 0)
        observed = proprioception(self._state, heading)
        self.motor_step: MotorStep = self.prior.advance(observed, self.intent)
        load = {
            "object": self.object_pos(),
            "velocity": self._state.object_lin_vel_w[:, 0],
            "target": self.object_target,
            "half": self.half,
            "mass": self.mass,
            "phase": self.phase,
            "present": self.has_load,
        }
        time = self.episode_step / self.max_steps
        self.features = self.motor_step.features
        self.critic_extra = critic_sight(self._state, heading, self.motor_step, load, time)

    def _failed(self, step: MotorStep, object_target: Tensor) -> Tensor:
        state = self._state
        height = state.link_pos_w[:, 0, 2]
        lean = state.link_rot_w[:, 0, 2, 2]
        sunk = height < step.reference.pelvis_pos[:, 2] - 0.25
        tipped = lean < step.reference.pelvis_rot[:, 2, 2] - 0.45
        self.dropped = self.has_load & (
            self._lost | (((self.object_pos() - object_target).norm(dim=-1) > 0.35) & self.holding())
        )
        broken = ~torch.isfinite(height)
        return sunk | tipped | is_fallen(state) | self.dropped | broken

    def shove(self, ids: np.ndarray, impulse_n_s: np.ndarray) -> None:
        """Pushes the torsos of environments `ids` (n,) with (n, 3) world impulses, spread over `SHOVE_STEPS` steps."""
        self._shove[ids] = impulse_n_s / SHOVE_STEPS
        self._shove_left[ids] = SHOVE_STEPS

    def _push(self) -> None:
        if self.config.push_n_s > 0:
            self.push_in -= 1
            due = (self.push_in <= 0).nonzero()[:, 0].numpy()
            angle = self.rng.uniform(-np.pi, np.pi, len(due))
            # a robot that holds something is pushed gently
            most = self.config.push_n_s * np.where(self.holding()[due].numpy(), 0.4, 1.0)
            impulse = self.rng.uniform(0.1, 1.0, len(due)) * most
            self.shove(due, impulse[:, None] * np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1))
            steps = self.rng.uniform(0.5, 1.5, len(due)) * self.config.push_interval_s * 30
            self.push_in[due] = torch.tensor(steps.astype(np.int64))
        shoved = np.nonzero(self._shove_left > 0)[0]
        if len(shoved):
            self.physics.apply_impulse(shoved, body.TORSO, self._shove[shoved])
            self._shove_left[shoved] -= 1

    def _draw_commands(self) -> None:
        self.command_left -= 1
        due = ((self.command_left <= 0) & ~self.has_load).nonzero()[:, 0]
        if not len(due):
            return
        self.command[due] = draw_intents(self.rng, len(due))
        self.command_left[due] = torch.tensor(self.rng.integers(30, 120, len(due)))

    def _reset(self, ids: np.ndarray) -> None:
        rows = torch.as_tensor(ids)
        loaded = self.has_load[rows]
        n = len(ids)
        kind = self.rng.choice(START_PHASES, n, p=self.config.start_shares)
        kind = torch.where(loaded, torch.tensor(kind), torch.tensor(int(Phase.APPROACH)))
        holding = (kind == Phase.CARRY) | (kind == Phase.ALIGN_PLACE)
        intent = neutral_intent(n)
        task_half, grasp = self.half[rows], self.grasp_height[rows]
        ahead, beyond = (0.2 + task_half[:, 0]).clamp(min=0.34), grip_ahead(task_half[:, 0])
        carry_z = (
            torch.maximum(self.start_pos[rows, 2], self.goal_pos[rows, 2]) + self.config.planner.clearance_m
        ).clamp(min=self.config.planner.carry_height_m)
        side = task_half[:, 1] + body.HAND_RADIUS_M - 0.012
        hands = torch.stack([torch.stack([ahead, s * side, carry_z + grasp], -1) for s in (-1, 1)], 1)
        neutral = torch.stack([intent[:, RIGHT_HAND], intent[:, LEFT_HAND]], 1)
        hands = torch.where(holding[:, None, None], hands, neutral)
        height = torch.full((n,), 0.84)
        pitch = torch.full((n,), 0.05)
        free = ~loaded
        bend = torch.tensor(self.rng.uniform(0, 0.9, n), dtype=torch.float32)
        squat, lean = reach_posture(bend)
        low = free & torch.tensor(self.rng.random(n) < self.config.bent_share)
        height, pitch = torch.where(low, squat, height), torch.where(low, lean, pitch)
        reach = torch.stack(
            [torch.stack([0.42 + 0 * bend, s * 0.22 + 0 * bend, bend.clamp(min=0.12)], -1) for s in (-1, 1)], 1
        )
        hands = torch.where(low[:, None, None], reach, hands)
        # bent over the box: about to squeeze it where it is, or just having put it down
        putting, taking = kind == Phase.RELEASE, kind == Phase.SQUEEZE
        bent = putting | taking
        rest = torch.where(putting[:, None], self.goal_pos[rows], self.start_pos[rows])
        stand = torch.where(putting[:, None], self.place_stand[rows], self.pick_stand[rows])
        low_height, low_pitch = reach_posture(rest[:, 2] + grasp)
        back = feet_ahead(low_height, low_pitch) - feet_ahead(height, pitch)
        away = (rest[:, :2] - stand[:, :2]).norm(dim=-1) + back
        gap = torch.where(putting, -0.012, 0.06)
        grip = torch.stack(
            [torch.stack([away + beyond, s * (side + 0.012 + gap), rest[:, 2] + grasp], -1) for s in (-1, 1)], 1
        )
        height, pitch = torch.where(bent, low_height, height), torch.where(bent, low_pitch, pitch)
        hands = torch.where(bent[:, None, None], grip, hands)
        joints, tilt = standing_pose(height, pitch, hands)
        joints = joints + torch.tensor(self.rng.normal(0, 0.02, joints.shape), dtype=torch.float32)

        place = self._start_place(kind, rows, n)
        behind = torch.stack([stand[:, 2].cos(), stand[:, 2].sin()], -1) * back[:, None]
        bent_place = torch.cat([stand[:, :2] - behind, stand[:, 2:]], -1)
        place = torch.where(bent[:, None], bent_place, place)
        qpos, qvel = [], []
        noise = self.rng.normal(0, 0.05, (n, ROBOT_NQ - 1))
        for i in range(n):
            env = int(ids[i])
            yaw, lean_i = float(place[i, 2]), float(tilt[i]) / 2
            cy, sy, cp, sp = np.cos(yaw / 2), np.sin(yaw / 2), np.cos(lean_i), np.sin(lean_i)
            root = [
                float(place[i, 0]),
                float(place[i, 1]),
                float(height[i]) + 0.004,
                cy * cp,
                -sy * sp,
                cy * sp,
                sy * cp,
            ]
            q = np.concatenate([root, joints[i].numpy()])
            v = noise[i] if not holding[i] else 0.2 * noise[i]
            task = self.tasks[env]
            if task is not None:
                if holding[i]:
                    centre = torch.stack([ahead[i] - beyond[i], torch.zeros(())])[None]
                    forward = rotate_xy(place[i : i + 1, 2], centre)[0]
                    box = [*(place[i, :2] + forward).tolist(), float(carry_z[i]), cy, 0, 0, sy]
                else:
                    turn = self.rng.uniform(-0.08, 0.08) if not bent[i] else 0.0
                    turn += float(task.place_stand[2]) if putting[i] else 0.0
                    box = [*rest[i].tolist(), np.cos(turn / 2), 0, 0, np.sin(turn / 2)]
                    box[2] += 0.001
                q = np.concatenate([q, box])
                v = np.concatenate([v, np.zeros(6)])
            qpos.append(q)
            qvel.append(v)
        self.physics.reset(ids, qpos, qvel)
        self.prior.reset(rows)
        self.planner.reset(rows[loaded], kind[loaded])
        self.phase[rows], self._lost[rows] = kind, False
        self._plan_first(rows)
        first = {Phase.REACH: 1, Phase.SQUEEZE: 1, Phase.CARRY: 2, Phase.ALIGN_PLACE: 4, Phase.RELEASE: 4}
        self.waypoint_index[rows] = torch.tensor([first.get(Phase(k), 0) for k in kind.tolist()])
        self._shove_left[ids] = 0
        self.episode_step[rows] = 0
        self.idle_steps[rows] = 0
        self.command_left[rows] = torch.where(low, 45, 0)
        crouched = neutral_intent(n)
        crouched[:, HEIGHT], crouched[:, PITCH] = height, pitch
        crouched[:, RIGHT_HAND], crouched[:, LEFT_HAND] = hands[:, 0], hands[:, 1]
        self.command[rows] = torch.where(low[:, None], crouched, self.command[rows])
        self.push_in[rows] = torch.tensor(
            (self.rng.uniform(0.3, 1.2, n) * self.config.push_interval_s * 30).astype(np.int64)
        )

    def _start_place(self, kind: Tensor, rows: Tensor, n: int) -> Tensor:
        """(n, 3) x, y, yaw where the robot begins."""
        draw = self.rng.uniform(-1, 1, (n, 3))
        for i, row in enumerate(rows.tolist()):
            task = self.tasks[row]
            for _ in range(START_ATTEMPTS if task is not None and kind[i] == Phase.APPROACH else 0):
                at = task.pick_stand[:2] + np.array([-0.6 - 0.7 * (draw[i, 0] + 1), 0.9 * draw[i, 1]])
                if table_clearance_m(at[None], tables_of(task)) > RETREAT_CLEARANCE_M:
                    break
                draw[i] = self.rng.uniform(-1, 1, 3)
        pick, place = self.pick_stand[rows], self.place_stand[rows]
        away = torch.tensor(
            np.stack([-0.6 - 0.7 * (draw[:, 0] + 1), 0.9 * draw[:, 1], 0.8 * draw[:, 2]], -1), dtype=torch.float32
        )
        close = torch.tensor(draw * np.array([0.03, 0.03, 0.06]), dtype=torch.float32)
        loose = torch.tensor(draw * np.array([0.15, 0.15, 0.3]), dtype=torch.float32)
        start = torch.where((kind == Phase.ALIGN_PLACE)[:, None], place + loose, pick + close)
        start = torch.where((kind == Phase.APPROACH)[:, None], pick + away, start)
        return start


def _behind(stand: Tensor) -> Tensor:
    return stand[:, :2] - BEHIND_M * torch.stack([stand[:, 2].cos(), stand[:, 2].sin()], -1)


def draw_intents(rng: np.random.Generator, n: int) -> Tensor:
    """(n, 14) random intents: walking any way, turning, standing, bending and reaching; hands anywhere within reach."""
    intent = neutral_intent(n).numpy()
    mode = rng.choice(6, n, p=[0.12, 0.2, 0.25, 0.1, 0.13, 0.2])
    u = rng.uniform(-1, 1, (n, 8))
    walk = mode == 1
    intent[walk, 0] = np.interp(u[walk, 0], [-1, 1], [-0.5, 1.2])
    mixed = mode == 2
    intent[mixed, 0] = np.interp(u[mixed, 0], [-1, 1], [-0.5, 1.2])
    intent[mixed, 1] = 0.4 * u[mixed, 1]
    intent[mixed, 2] = 1.5 * u[mixed, 2]
    side = mode == 3
    intent[side, 1] = 0.4 * u[side, 1]
    turn = mode == 4
    intent[turn, 2] = 1.5 * u[turn, 2]
    bend = mode == 5
    height = np.interp(u[:, 3], [-1, 1], [0.42, 0.86])
    # deep in the knees, or from the hips
    pitch = np.clip((0.86 - height) / 0.44 * 1.4 + np.where(u[:, 7] > 0.3, 0.8, 0.3) * u[:, 4], 0.0, 1.4)
    # upright or bent: slow while bent
    intent[:, HEIGHT] = np.where(bend, height, np.interp(u[:, 3], [-1, 1], [0.78, 0.86]))
    intent[:, PITCH] = np.where(bend, pitch, 0.1 + 0.1 * u[:, 4])
    intent[bend, 0] = 0.15 * u[bend, 0] * (rng.random(bend.sum()) < 0.3)
    reaching = rng.random(n) < 0.6
    # hands in a shell around the shoulders, which move forward and down with the pitch
    pelvis = PELVIS_PITCH_SHARE * intent[:, PITCH]
    shoulder_x = 0.236 * np.sin(pelvis) + 0.2435 * np.sin(intent[:, PITCH])
    shoulder_z = intent[:, HEIGHT] + 0.236 * np.cos(pelvis) + 0.2435 * np.cos(intent[:, PITCH])
    for hand, sign in ((LEFT_HAND, 1.0), (RIGHT_HAND, -1.0)):
        radius = rng.uniform(0.28, 0.48, n)
        elevation = rng.uniform(-1.5, 0.5, n)
        azimuth = rng.uniform(-0.5, 0.7, n)
        point = np.stack(
            [
                shoulder_x + radius * np.cos(elevation) * np.cos(azimuth),
                sign * (0.18 + radius * np.cos(elevation) * np.sin(azimuth)),
                np.maximum(shoulder_z + radius * np.sin(elevation), 0.06),
            ],
            -1,
        )
        point[:, 1] = sign * np.maximum(sign * point[:, 1], 0.08)
        intent[:, hand] = np.where(reaching[:, None], point, intent[:, hand])
    intent[:, SQUEEZE] = 0.0
    intent[:, GAZE] = np.stack([0.7 * u[:, 5], 0.3 + 0.4 * u[:, 6]], -1)
    return torch.tensor(intent, dtype=torch.float32)
