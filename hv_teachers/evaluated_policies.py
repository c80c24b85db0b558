"""The policies that `hv-eval` knows: the planner, the teachers, and any LeRobot checkpoint."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hv_policy.motor.prior import SHIPPED_MOTOR_PRIOR
from hv_policy.network_file import SHIPPED_STUDENT
from hv_sim.humanoid import NUM_JOINTS
from hv_sim.world import RearrangeWorld
from hv_teachers.episodes import EvaluatedPolicy, files_fingerprint
from hv_teachers.expert import PlannerExpert
from hv_teachers.impairments import NOTHING_TAKEN, Impairments
from hv_teachers.planner import PlannerConfig
from hv_teachers.teacher import TEACHER_FILES, WEIGHTS, Teacher, load_shipped_teacher

_WEIGHTS = ("*.safetensors", "*.json", "*.pt", "*.bin")


def load_evaluated_policy(name: str, impairments: Impairments = NOTHING_TAKEN) -> EvaluatedPolicy:
    """`planner`, `teacher`, `student`, a folder with teachers, or a folder with a LeRobot policy (`pretrained_model`).

    Args:
        name: which.
        impairments: what is taken from it, if it sees.

    Raises:
        ValueError: it is none of these, cannot be read, or does not see anything that could be taken from it.
    """
    policy = _load(name)
    if isinstance(policy, _LeRobotPolicy):
        policy.impairments = impairments
    elif impairments:
        raise ValueError(f"without, wrong_instruction: {name} neither sees nor listens; valid: a policy with a camera")
    return policy


def _load(name: str) -> EvaluatedPolicy:
    if name == "planner":
        return _Planner()
    if name == "teacher":
        return _Teacher(load_shipped_teacher(), WEIGHTS)
    folder = SHIPPED_STUDENT if name == "student" else Path(name)
    if (folder / TEACHER_FILES[0]).is_file():
        return _Teacher(Teacher.load(folder), folder)
    for candidate in (folder, folder / "pretrained_model", folder / "checkpoints" / "last" / "pretrained_model"):
        if (candidate / "config.json").is_file():
            return _LeRobotPolicy(candidate)
    raise ValueError(
        f"policy: {name!r} is not known; valid: planner, teacher, student, a folder of teachers or a LeRobot checkpoint"
    )


_DEFAULT_PX = (128, 128)


class _Planner:
    sees, picture_px = False, _DEFAULT_PX

    def __init__(self) -> None:
        self.expert = PlannerExpert(1)

    def reset(self, num_envs: int) -> None:
        self.expert = PlannerExpert(num_envs, self.expert.prior)
        self.expert.reset()

    def needs_picture(self, world: RearrangeWorld) -> bool:
        return False

    def __call__(self, world: RearrangeWorld, observation: dict[str, Any] | None) -> Tensor:
        return self.expert(world)[1]

    def fingerprint(self) -> str:
        settings = hashlib.sha256(json.dumps(asdict(PlannerConfig())).encode()).hexdigest()[:8]
        return f"planner-{files_fingerprint(SHIPPED_MOTOR_PRIOR)}-{settings}"


class _Teacher:
    sees, picture_px = False, _DEFAULT_PX

    def __init__(self, teacher: Teacher, folder: Path) -> None:
        self.teacher, self.folder = teacher, folder

    def reset(self, num_envs: int) -> None:
        self.teacher.reset()

    def needs_picture(self, world: RearrangeWorld) -> bool:
        return False

    def __call__(self, world: RearrangeWorld, observation: dict[str, Any] | None) -> Tensor:
        return self.teacher(world)

    def fingerprint(self) -> str:
        files = [self.folder / n for n in TEACHER_FILES if (self.folder / n).is_file()]
        return f"teacher-{files_fingerprint(*files, SHIPPED_MOTOR_PRIOR)}"


class _LeRobotPolicy:
    """A checkpoint, with its own processors, one environment at a time as `lerobot-eval --eval.batch_size=1` does."""

    sees = True

    def __init__(self, folder: Path) -> None:
        from lerobot.configs.policies import PreTrainedConfig
        from lerobot.policies import make_pre_post_processors
        from lerobot.policies.factory import get_policy_class
        from lerobot.utils.import_utils import register_third_party_plugins

        register_third_party_plugins()  # makes --policy.type=hv known, and other people's
        self.folder, self.impairments = folder, NOTHING_TAKEN
        try:
            config = PreTrainedConfig.from_pretrained(folder)
            config.pretrained_path = folder
            if not torch.cuda.is_available():
                config.device = "cpu"
            self.policy = get_policy_class(config.type).from_pretrained(folder, config=config)
            self.policy.eval()
            self.before, self.after = make_pre_post_processors(
                policy_cfg=config,
                pretrained_path=str(folder),
                preprocessor_overrides={"device_processor": {"device": str(config.device)}},
            )
        except (OSError, KeyError, TypeError, RuntimeError) as error:
            reason = " ".join(str(error).split())[:200]
            raise ValueError(f"policy: {folder} cannot be read as a LeRobot policy ({reason})") from error
        action = config.action_feature
        if action is not None and tuple(action.shape) != (NUM_JOINTS,):
            raise ValueError(f"policy: {folder} says {tuple(action.shape)} numbers; valid: {NUM_JOINTS} joint targets")

    @property
    def picture_px(self) -> tuple[int, int]:
        shapes = [feature.shape for feature in self.policy.config.image_features.values()]
        return (shapes[0][-2], shapes[0][-1]) if shapes else _DEFAULT_PX

    def reset(self, num_envs: int) -> None:
        self.policy.reset()

    def needs_picture(self, world: RearrangeWorld) -> bool:
        """Whether it will look at the next picture; most policies always do."""
        asked = getattr(self.policy, "needs_picture", None)
        return True if asked is None else bool(asked(self.impairments.told(world)))

    def __call__(self, world: RearrangeWorld, observation: dict[str, Any] | None) -> Tensor:
        from lerobot.envs.utils import preprocess_observation

        assert observation is not None
        observation = self.impairments.seen(observation)
        batch = {
            "pixels": {k: v[None] for k, v in observation["pixels"].items()},
            "agent_pos": observation["agent_pos"][None],
        }
        inputs = preprocess_observation(batch)
        inputs["task"] = self.impairments.told(world)
        with torch.inference_mode():
            action = self.after(self.policy.select_action(self.before(inputs)))
        return torch.from_numpy(np.asarray(action.to("cpu").numpy(), dtype=np.float32))

    def fingerprint(self) -> str:
        return checkpoint_fingerprint(self.folder, self.policy.config.type)


def checkpoint_fingerprint(folder: Path, kind: str) -> str:
    """A hash of the files of a LeRobot policy, after its `type`."""
    files = sorted(p for pattern in _WEIGHTS for p in folder.glob(pattern))
    return f"{kind}-{files_fingerprint(*files)}"
