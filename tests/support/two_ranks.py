"""One of two processes of a test: checks what `hv_teachers.ranks` promises against what one process would find."""

import sys

import torch
from torch import nn

from hv_teachers.ranks import Ranks, joined_ranks

STEPS, ENVS, WIDTH = 5, 6, 3


def check(ranks: Ranks) -> None:
    alone = Ranks()
    generator = torch.Generator().manual_seed(0)
    values = torch.randn(STEPS, ENVS, WIDTH, generator=generator)
    chosen = torch.rand(STEPS, ENVS, generator=generator) < 0.5
    chosen[:, ENVS // 2 :] &= torch.arange(STEPS)[:, None] > 2  # unequal shares
    mine = ranks.share(ENVS)
    assert torch.equal(ranks.gather(values[:, mine], 1), values)
    assert torch.equal(ranks.gather(chosen[:, mine], 1), chosen)

    numbers, total = ranks.numbers(chosen[:, mine])
    here, everyone = values[:, mine][chosen[:, mine]], values[chosen]
    assert total == len(everyone)
    assert torch.equal(everyone[numbers], here)
    wanted = torch.tensor([0, total - 1, 3, 3])
    assert torch.equal(ranks.rows(here, numbers, total, wanted), everyone[wanted])
    for found, right in zip(ranks.moments(here), alone.moments(everyone), strict=True):
        torch.testing.assert_close(found, right)

    assert ranks.sums({"both": 1.0, f"of {ranks.rank}": 2.0}) == {"both": 2.0, "of 0": 2.0, "of 1": 2.0}
    assert ranks.means({"both": ranks.rank + 1.0}) == {"both": 1.5}

    torch.manual_seed(ranks.rank)
    model = nn.Linear(WIDTH, 1)
    ranks.copy_from_first(model)
    model.bias.requires_grad_(False)
    if ranks.is_first:  # the other one has nothing of this batch
        model(here).sum().backward()
    ranks.sum_gradients(model.parameters())
    right = values[:, : ENVS // 2][chosen[:, : ENVS // 2]].sum(0)
    torch.testing.assert_close(model.weight.grad[0], right)
    assert model.bias.grad is None
    ranks.wait()


if __name__ == "__main__":
    with joined_ranks() as ranks:
        assert ranks.count == 2
        check(ranks)
        print(f"rank {ranks.rank} is right", file=sys.stderr)
