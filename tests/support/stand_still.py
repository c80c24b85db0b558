"""An expert for tests: keeps every joint at zero, the pose that the humanoid stands in."""

import torch
from torch import Tensor

from hv_sim.world import RearrangeWorld


class StandStill:
    knowledge = None
    executed = None

    def see_through(self, camera) -> None:
        pass

    def __init__(self, num_envs: int):
        self.num_envs = num_envs

    def reset(self, ids: Tensor | None = None) -> None:
        pass

    def __call__(self, world: RearrangeWorld) -> tuple[Tensor, Tensor]:
        sway = 0.05 * torch.sin(world.episode_step.float() / 5)
        return torch.zeros(self.num_envs, 14), sway[:, None].expand(-1, 28).clone()
