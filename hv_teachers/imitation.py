"""Learning from the planner: what it was shown and said, in a ring on disk and in memory, and the loss."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import torch
from safetensors.torch import load_file, save_file
from torch import Tensor, nn

from hv_policy.decision.network import DecisionNetwork
from hv_teachers.ranks import places
from hv_teachers.teacher import Sight
from hv_teachers.teacher_env import Label

HUBER = 0.1
"""In the network's units: beyond it an error counts linearly."""


@dataclass
class Samples:
    """What the networks were shown and what the planner said; one row each. Halves where that is exact enough."""

    sights: Tensor  # (B, SIGHT_DIM) float16
    anchors: Tensor  # (B, 42) float16
    shape: Tensor  # (B,) int32, row of `ImitationBuffer.geometry`
    memory_before: Tensor  # (B, 18)
    memory: Tensor  # (B, M)
    phase: Tensor  # (B,) int64
    action: Tensor  # (B, A)

    @staticmethod
    def of(seen: Sight, label: Label, shape: Tensor, chosen: Tensor) -> Samples:
        """One step's samples of the environments where `chosen` (N,) is true; `shape` (N,) int32."""
        return Samples(
            seen.sights[chosen].half(),
            label.anchors[chosen].half(),
            shape[chosen],
            label.memory_before[chosen],
            label.memory[chosen],
            label.phase[chosen],
            label.action[chosen],
        )

    def tensors(self) -> dict[str, Tensor]:
        return dict(vars(self))

    @staticmethod
    def join(parts: list[Samples]) -> Samples:
        return Samples(*(torch.cat([getattr(p, name) for p in parts]) for name in vars(parts[0])))

    def __len__(self) -> int:
        return len(self.phase)

    def at(self, rows: Tensor) -> Samples:
        return Samples(*(getattr(self, name)[rows] for name in vars(self)))


@dataclass
class SharedSamples:
    """Samples that the processes of a training hold together, numbered as one process would number them."""

    here: Samples
    """Those of this process, (k,) rows."""
    numbers: Tensor
    """(k,) int64."""
    total: int
    """How many there are, here and elsewhere."""

    def __post_init__(self) -> None:
        self._row = places(self.numbers, self.total)

    @staticmethod
    def alone(samples: Samples) -> SharedSamples:
        """There is no other process."""
        return SharedSamples(samples, torch.arange(len(samples)), len(samples))

    def __len__(self) -> int:
        return self.total

    def at(self, numbers: Tensor) -> Samples:
        """Those of `numbers` (B,) that are here, in their order: at most B rows."""
        rows = self._row[numbers]
        return self.here.at(rows[rows >= 0])

    @staticmethod
    def join(parts: list[SharedSamples]) -> SharedSamples:
        numbers, total = [], 0
        for part in parts:
            numbers.append(part.numbers + total)
            total += part.total
        return SharedSamples(Samples.join([part.here for part in parts]), torch.cat(numbers), total)


class ImitationBuffer:
    """The newest samples; each round is a file, so that a killed training finds them again.

    Args:
        folder: of the files; every process of a training has its own.
        capacity: samples kept, those of other processes counted; whole rounds are dropped.
    """

    def __init__(self, folder: Path, capacity: int) -> None:
        self.folder, self.capacity = Path(folder), capacity
        self.rounds: dict[int, SharedSamples] = {}
        self.geometry = torch.zeros(0, 600)
        """(G, 600) the shapes seen so far."""
        self._row_of: dict[bytes, int] = {}

    def shape_rows(self, geometry: Tensor) -> Tensor:
        """(N,) int32 rows in the table of shapes of basis point sets (N, 600); unknown ones are added."""
        rows, new = [], []
        for one in geometry:
            key = one.numpy().tobytes()
            if key not in self._row_of:
                self._row_of[key] = len(self._row_of)
                new.append(one)
            rows.append(self._row_of[key])
        if new:
            self.geometry = torch.cat([self.geometry, torch.stack(new)])
        return torch.tensor(rows, dtype=torch.int32)

    def add(self, number: int, samples: SharedSamples) -> None:
        """Adds a round's samples and writes them."""
        self.rounds[number] = samples
        self.folder.mkdir(parents=True, exist_ok=True)
        tensors = samples.here.tensors()
        if len(samples.here) < samples.total:  # a lone process numbers its own in their order
            tensors |= {"number": samples.numbers, "total": torch.tensor([samples.total])}
        _write(self.folder / f"round_{number:05d}.safetensors", tensors)
        while len(self) > self.capacity and len(self.rounds) > 1:
            oldest = min(self.rounds)
            del self.rounds[oldest]

    def __len__(self) -> int:
        return sum(len(s) for s in self.rounds.values())

    def all(self) -> SharedSamples:
        """Everything in it."""
        return SharedSamples.join([self.rounds[k] for k in sorted(self.rounds)])

    def state(self) -> dict[str, object]:
        """What a checkpoint needs beside the files."""
        return {"rounds": sorted(self.rounds), "geometry": self.geometry.clone()}

    def restore(self, saved: dict) -> None:
        """Reads the rounds of a checkpoint again.

        Raises:
            FileNotFoundError: one of them is gone.
        """
        self.rounds = {}
        for number in saved["rounds"]:
            tensors = load_file(str(self.folder / f"round_{number:05d}.safetensors"))
            numbers, total = tensors.pop("number", None), tensors.pop("total", None)
            samples = Samples(**tensors)
            self.rounds[int(number)] = (
                SharedSamples.alone(samples)
                if numbers is None or total is None
                else SharedSamples(samples, numbers, int(total))
            )
        self.geometry = saved["geometry"].clone()
        self._row_of = {row.numpy().tobytes(): i for i, row in enumerate(self.geometry)}

    def forget_files(self) -> None:
        """Deletes the files of rounds that are no longer kept (once no checkpoint needs them)."""
        for path in self.folder.glob("round_*.safetensors"):
            if int(path.stem.split("_")[1]) not in self.rounds:
                path.unlink()


def imitation_loss(
    network: DecisionNetwork, samples: Samples, geometry: Tensor, transition_weight: float, actions: bool = True
) -> tuple[Tensor, dict[str, float]]:
    """Huber loss of the actions plus cross-entropy of the next phase.

    Args:
        network: the learner.
        samples: (B,) rows.
        geometry: (B, 600).
        transition_weight: of samples in which the phase changes.
        actions: False leaves the actions out of the loss.

    Returns:
        The loss, and what to log: `action_loss`, `phase_loss`, `phase_wrong` (share).
    """
    sights, anchors = samples.sights.float(), samples.anchors.float()
    said = network(sights, anchors, geometry, samples.memory)
    error = nn.functional.smooth_l1_loss(said, samples.action, beta=HUBER, reduction="none").sum(-1)
    shown = {"action_loss": float(error.detach().mean())}
    loss = error.mean() if actions else torch.zeros(())
    if network.config.memory == "phase":
        logits = network.phase_logits(sights, geometry, samples.memory_before)
        changes = samples.phase != samples.memory_before[:, 0].long()
        weight = 1.0 + (transition_weight - 1.0) * changes
        phase = (nn.functional.cross_entropy(logits, samples.phase, reduction="none") * weight).mean()
        wrong = logits.detach().argmax(-1) != samples.phase
        shown |= {"phase_loss": float(phase.detach()), "phase_wrong": float(wrong.float().mean())}
        loss = loss + phase
    return loss, shown


def _write(path: Path, tensors: dict[str, Tensor]) -> None:
    temporary = path.with_suffix(".tmp")
    save_file({k: v.contiguous() for k, v in tensors.items()}, temporary)
    temporary.replace(path)
