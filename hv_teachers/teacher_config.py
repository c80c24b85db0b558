"""What a training of a teacher is: one dataclass with defaults, YAML files that hold what differs, key=value on top."""

from __future__ import annotations

import typing
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from types import UnionType
from typing import Any

import yaml

from hv_policy.decision.network import DecisionConfig
from hv_teachers.amp import StyleConfig
from hv_teachers.curriculum import PARTS
from hv_teachers.teacher_env import TeacherEnvConfig

CONFIG_FOLDER = Path(__file__).resolve().parents[1] / "configs"


@dataclass(frozen=True)
class DaggerConfig:
    """Behaviour cloning and DAgger from the planner. `samples` are control steps over all environments."""

    samples: int = 0
    round_steps: int = 300
    """Control steps of a round; after each the networks are trained on everything in the buffer."""
    buffer: int = 800_000
    """Newest samples kept, .9 kB each."""
    replays: float = 5.0
    """How often a sample of the last round is used, on average."""
    batch_size: int = 2048
    learning_rate: float = 1e-3
    final_learning_rate: float = 1e-4
    beta_decay: float = 0.6
    """In round k the planner acts in a share beta_decay ** k of the environments; the first round is its alone."""
    expert_steps: int = 90
    """For how long who acts is drawn."""
    transition_weight: float = 5.0
    """Of a sample in which the phase changes, beside one in which it stays."""


@dataclass(frozen=True)
class PpoConfig:
    """PPO from where imitation left off. `samples` are control steps of the learner over all environments."""

    samples: int = 0
    steps_per_iteration: int = 24
    epochs: int = 3
    mini_batches: int = 4
    learning_rate: float = 2e-5
    """Of the actor, fixed. By KL divergence it fell to 1e-5 within twenty iterations, and took the critic's with it:
    with a spread of .05 over 14 numbers every step is a long one."""
    critic_learning_rate: float = 5e-4
    gamma: float = 0.99
    lam: float = 0.95
    clip: float = 0.2
    noise: float = 0.05
    """Fixed spread of an action, in the network's units."""
    critic_hidden: tuple[int, ...] = (512, 256)
    critic_warmup: int = 20
    """Iterations in which only the critic learns."""
    imitation_batches: int = 2
    """Mini-batches of imitation after each iteration, so that the phases stay what they are; 0 leaves them alone."""
    imitate_actions: bool = False
    """Imitate the planner's actions too; they then stay what they are as well."""
    imitation_learning_rate: float = 1e-4
    reward_scale: float = 0.05
    fall_penalty: float = 10.0
    """Taken off the reward (before scaling) when the robot falls."""


@dataclass(frozen=True)
class TeacherTrainingConfig:
    """One stage of a teacher's training.

    Raises:
        ValueError: a field is not valid.
    """

    name: str = "teacher"
    tasks: str = "single"
    """Suites, tasks or files, separated by commas."""
    part: str = "whole"
    """See `hv_teachers.curriculum.practice_tasks`."""
    init: str = ""
    """Weights to begin from (a teacher's .safetensors); empty: new ones."""
    first_teacher: str = ""
    """The teacher that plays the first sub-task of an episode; empty: the learner plays everything."""
    prior: str = ""
    """Weights of the motor prior; empty: the shipped ones."""
    seed: int = 0
    new_tasks_every: int = 8
    """Rounds (or 12 iterations each) after which other tasks take their turn, if there are more than environments."""
    checkpoint_every: int = 1
    """Rounds, or 12 iterations each, between checkpoints."""
    mocap_wheel: str = ""
    """An isaaclab wheel whose clips join the motion set; empty: none."""
    motion_tasks: int = 64
    """Episodes that the planner plays for the motion set."""
    env: TeacherEnvConfig = field(default_factory=TeacherEnvConfig)
    teacher: DecisionConfig = field(default_factory=DecisionConfig)
    dagger: DaggerConfig = field(default_factory=DaggerConfig)
    ppo: PpoConfig = field(default_factory=PpoConfig)
    style: StyleConfig = field(default_factory=StyleConfig)

    def __post_init__(self) -> None:
        if self.part not in PARTS:
            raise ValueError(f"part: {self.part!r} is not valid; valid: {', '.join(PARTS)}")
        if self.dagger.samples + self.ppo.samples < 1:
            raise ValueError("dagger.samples, ppo.samples: both 0; valid: at least one above 0")
        counts = {name: getattr(self, name) for name in ("new_tasks_every", "checkpoint_every", "motion_tasks")}
        for part, of in (("dagger", self.dagger), ("ppo", self.ppo)):
            names = ("round_steps", "batch_size", "buffer", "steps_per_iteration", "epochs", "mini_batches")
            counts |= {f"{part}.{name}": getattr(of, name) for name in names if hasattr(of, name)}
        for name, count in counts.items():
            if count < 1:
                raise ValueError(f"{name}: {count} is not valid; valid: an integer >= 1")

    @property
    def samples(self) -> int:
        """Control steps of the whole stage."""
        return self.dagger.samples + self.ppo.samples


def read_yaml(name_or_path: str) -> dict[str, Any]:
    """A YAML file by path, or one of `configs/` by name.

    Raises:
        ValueError: there is no such file, or it is not a mapping.
    """
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        path = CONFIG_FOLDER / f"{name_or_path}.yaml"
    if not path.is_file():
        known = sorted(p.stem for p in CONFIG_FOLDER.glob("*.yaml"))
        raise ValueError(f"config: {name_or_path!r} is neither a file nor one of {', '.join(known)}")
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: not readable YAML: {' '.join(str(error).split())}") from None
    if not isinstance(data, dict):
        raise ValueError(f"{path}: holds no mapping")
    return data


def training_config(*layers: dict[str, Any]) -> TeacherTrainingConfig:
    """Defaults with nested mappings laid over them; a key may also be dotted (`env.num_envs`).

    Raises:
        ValueError: a key is unknown, or a value is not valid.
    """
    merged: dict[str, Any] = {}
    for layer in layers:
        for key, value in layer.items():
            _set(merged, key.split("."), value)
    return _build(TeacherTrainingConfig, merged, "")


def plain(config: Any) -> Any:
    """A configuration as mappings, lists and scalars, for YAML and for comparison."""
    if is_dataclass(config):
        return {f.name: plain(getattr(config, f.name)) for f in fields(config)}
    return list(config) if isinstance(config, tuple) else config


def differences(a: dict[str, Any], b: dict[str, Any], where: str = "") -> list[str]:
    """Dotted names of what differs between two configurations as `plain` gives them."""
    found = []
    for key in sorted(a.keys() | b.keys()):
        x, y = a.get(key), b.get(key)
        if isinstance(x, dict) and isinstance(y, dict):
            found += differences(x, y, f"{where}{key}.")
        elif x != y:
            found.append(f"{where}{key}")
    return found


def _set(target: dict[str, Any], path: list[str], value: Any) -> None:
    if len(path) > 1:
        inner = target.setdefault(path[0], {})
        if not isinstance(inner, dict):
            raise ValueError(f"{path[0]}: {inner!r} has no field {path[1]!r}")
        _set(inner, path[1:], value)
    elif isinstance(value, dict):
        inner = target.setdefault(path[0], {})
        for key, item in value.items():
            _set(inner, str(key).split("."), item)
    else:
        target[path[0]] = value


def _build(kind: Any, values: dict[str, Any], where: str) -> Any:
    hints = typing.get_type_hints(kind)
    default = kind() if kind is not TeacherTrainingConfig else None
    unknown = [key for key in values if key not in hints]
    if unknown:
        raise ValueError(f"{where}{unknown[0]}: unknown; valid: {', '.join(f.name for f in fields(kind))}")
    given = {}
    for key, value in values.items():
        hint = hints[key]
        if is_dataclass(hint):
            if not isinstance(value, dict):
                raise ValueError(f"{where}{key}: {value!r} is not valid; valid: a mapping")
            given[key] = _build(hint, value, f"{where}{key}.")
        else:
            given[key] = _scalar(hint, value, f"{where}{key}")
    try:
        return kind(**given) if default is None else replace(default, **given)
    except TypeError as error:
        raise ValueError(f"{where or 'config'}: {error}") from None


def _scalar(hint: Any, value: Any, where: str) -> Any:
    kinds = typing.get_args(hint) if isinstance(hint, UnionType) else (hint,)
    if value is None and type(None) in kinds:
        return None
    for kind in kinds:
        if kind is bool and isinstance(value, bool):
            return value
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if kind is int and is_number and float(value).is_integer():
            return int(value)
        if kind is float and is_number:
            return float(value)
        if kind is str and isinstance(value, str):
            return value
        if kind is float and isinstance(value, str):  # YAML 1.1 reads 1e6 as a string
            try:
                return float(value)
            except ValueError:
                continue
        if kind is int and isinstance(value, str):
            try:
                if float(value).is_integer():
                    return int(float(value))
            except ValueError:
                continue
        if typing.get_origin(kind) is tuple and isinstance(value, (list, tuple)):
            return tuple(_scalar(typing.get_args(kind)[0], v, where) for v in value)
    names = ", ".join(getattr(k, "__name__", str(k)) for k in kinds)
    raise ValueError(f"{where}: {value!r} is not valid; valid: {names}")
