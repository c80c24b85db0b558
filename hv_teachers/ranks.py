"""The processes of one training (`torchrun`): each practises its share of the environments, all learn the same.

What is drawn is drawn by every process for all environments, from the same state of the generator, and each takes its
own rows: environments, samples and transitions are numbered as one process would number them. Gradients are summed,
each weighed with the share of the batch that it comes from. So more processes do what one would, up to the order in
which numbers are added.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta

import torch
from torch import Tensor, nn

PATIENCE = timedelta(hours=12)
"""How long a process waits for the others; the first one records the motion set alone."""


@dataclass(frozen=True)
class Ranks:
    """One process among those of a training; the default is the only one."""

    rank: int = 0
    count: int = 1

    @property
    def is_first(self) -> bool:
        """It writes what all have made."""
        return self.rank == 0

    def share(self, total: int, name: str = "env.num_envs") -> slice:
        """This process's part of `total` things in a row.

        Raises:
            ValueError: they cannot be shared out evenly; `name` is what is too many or too few.
        """
        if total % self.count:
            raise ValueError(f"{name}: {total} is not valid for {self.count} processes; valid: a multiple of it")
        each = total // self.count
        return slice(self.rank * each, (self.rank + 1) * each)

    def gather(self, values: Tensor, dim: int = 0) -> Tensor:
        """Every process's tensor of the same shape, joined along `dim` in their order."""
        if self.count == 1:
            return values
        sent = values.to(torch.uint8) if values.dtype == torch.bool else values
        sent = sent.contiguous()
        received = [torch.empty_like(sent) for _ in range(self.count)]
        torch.distributed.all_gather(received, sent)
        return torch.cat(received, dim).to(values.dtype)

    def numbers(self, chosen: Tensor) -> tuple[Tensor, int]:
        """(k,) int64 places of this process's chosen among everybody's, and how many there are.

        Args:
            chosen: (T, n) bool, a row for each step, a column for each environment of this process. Step by step,
                environment by environment, is the order in which `x[chosen]` comes.
        """
        everyone = self.gather(chosen, 1)
        place = everyone.flatten().cumsum(0).view_as(everyone) - 1
        mine = place[:, self.rank * chosen.shape[1] :][:, : chosen.shape[1]]
        return mine[chosen], int(everyone.sum())

    def rows(self, values: Tensor, numbers: Tensor, total: int, wanted: Tensor) -> Tensor:
        """(W, ...) rows number `wanted` (W,) of `total` that all processes hold together, the same for each of them.

        Args:
            values: (k, ...) what this process holds.
            numbers: (k,) its numbers.
            total: how many there are altogether.
            wanted: (W,) int64.
        """
        if self.count == 1:
            return values[wanted]
        row = places(numbers, total)[wanted]
        found = values.new_zeros(len(wanted), *values.shape[1:])
        found[row >= 0] = values[row[row >= 0]]
        torch.distributed.all_reduce(found)
        return found

    def moments(self, values: Tensor) -> tuple[Tensor, Tensor]:
        """Mean and standard deviation (D,) of everybody's rows (k, D) together."""
        if self.count == 1:
            return values.mean(0), values.std(0)
        exact = values.double()
        sums = torch.cat([exact.new_full((1,), len(values)), exact.sum(0)])
        torch.distributed.all_reduce(sums)
        number, mean = sums[0], sums[1:] / sums[0]
        squares = (exact - mean).square().sum(0)
        torch.distributed.all_reduce(squares)
        return mean.to(values.dtype), (squares / (number - 1)).sqrt().to(values.dtype)

    def sums(self, values: Mapping[str, float]) -> dict[str, float]:
        """Sums by name; a process need not have every name."""
        if self.count == 1:
            return dict(values)
        received: list[dict[str, float]] = [{}] * self.count
        torch.distributed.all_gather_object(received, dict(values))
        total: dict[str, float] = defaultdict(float)
        for one in received:
            for name, value in one.items():
                total[name] += value
        return dict(total)

    def means(self, values: Mapping[str, float]) -> dict[str, float]:
        """Means by name over the processes; a name that one does not have counts as 0 there."""
        return {name: value / self.count for name, value in self.sums(values).items()}

    def sum_gradients(self, parameters: Iterable[nn.Parameter]) -> None:
        """Every gradient becomes the sum over the processes; without one it counts as 0."""
        if self.count == 1:
            return
        learned = [p for p in parameters if p.requires_grad]
        if not learned:
            return
        flat = torch.cat([(torch.zeros_like(p) if p.grad is None else p.grad).flatten() for p in learned])
        torch.distributed.all_reduce(flat)
        for parameter, gradient in zip(learned, flat.split([p.numel() for p in learned]), strict=True):
            parameter.grad = gradient.view_as(parameter).clone()

    def copy_from_first(self, module: nn.Module) -> None:
        """Parameters and buffers become those of the first process."""
        if self.count > 1:
            for tensor in module.state_dict().values():
                torch.distributed.broadcast(tensor, src=0)

    def wait(self) -> None:
        """Goes on when every process has come here."""
        if self.count > 1:
            torch.distributed.barrier()


def places(numbers: Tensor, total: int) -> Tensor:
    """(total,) int64: where in `numbers` (k,) each number from 0 to total - 1 stands, -1 for those that do not."""
    at = torch.full((total,), -1, dtype=torch.int64)
    at[numbers] = torch.arange(len(numbers))
    return at


@contextmanager
def joined_ranks() -> Iterator[Ranks]:
    """The processes that `torchrun` started, or this one alone; each sees one GPU of its machine, if there are any.

    Networks live on the CPU (only the physics of `env.physics: warp` does not), so gloo carries what they exchange.
    """
    count = int(os.environ.get("WORLD_SIZE", "1"))
    if count == 1:
        yield Ranks()
        return
    gpu = own_gpu(int(os.environ["LOCAL_RANK"]), os.environ.get("CUDA_VISIBLE_DEVICES"), torch.cuda.device_count())
    if gpu is not None:
        os.environ["CUDA_VISIBLE_DEVICES"] = gpu  # before anything has begun to use one
    torch.distributed.init_process_group("gloo", timeout=PATIENCE)
    try:
        yield Ranks(torch.distributed.get_rank(), count)
    finally:
        torch.distributed.destroy_process_group()


def own_gpu(local_rank: int, visible: str | None, count: int) -> str | None:
    """The GPU of a process, as CUDA_VISIBLE_DEVICES wants it: they are dealt out in turn; None if there is none.

    Args:
        local_rank: number of the process on its machine.
        visible: CUDA_VISIBLE_DEVICES as it is.
        count: GPUs that can be seen.
    """
    if not count:
        return None
    names = visible.split(",") if visible else [str(i) for i in range(count)]
    return names[local_rank % len(names)]
