"""A small residual network from camera pictures to a grid of tokens, trained from scratch.

Group normalisation, not batch normalisation: a picture's features must not depend on the company that it comes in.
"""

import torch
import torch.nn.functional as F
from torch import Tensor, nn


class ImageEncoder(nn.Module):
    """Pictures (B, 3, H, W), values 0..1 -> tokens (B, (S/16)^2, dim), where S is the picture's side in the network.

    Args:
        image_size: S in pixels; pictures of another size are resized to it.
        channels: channels at S/4, S/8, S/16.
        blocks: residual blocks at S/8 and at S/16.
        dim: width of a token.
    """

    def __init__(self, image_size: int, channels: tuple[int, int, int], blocks: int, dim: int):
        super().__init__()
        self.image_size = image_size
        fine, middle, coarse = channels
        self.stem = nn.Sequential(nn.Conv2d(3, fine, 8, stride=4, padding=2), _norm(fine), nn.ReLU(inplace=True))
        self.middle = nn.Sequential(_Downsample(fine, middle), *[_ResidualBlock(middle) for _ in range(blocks)])
        self.coarse = nn.Sequential(_Downsample(middle, coarse), *[_ResidualBlock(coarse) for _ in range(blocks)])
        self.project = nn.Linear(coarse, dim)
        grid = image_size // 16
        self.position = nn.Parameter(torch.randn(grid * grid, dim) * 0.1)

    def forward(self, pictures: Tensor) -> Tensor:
        if pictures.shape[-2:] != (self.image_size, self.image_size):
            size = (self.image_size, self.image_size)
            pictures = F.interpolate(pictures, size=size, mode="bilinear", antialias=True, align_corners=False)
        pictures = (pictures * 4 - 2).contiguous(memory_format=torch.channels_last)  # about zero mean, unit variance
        features = self.coarse(self.middle(self.stem(pictures)))
        return self.project(features.flatten(2).transpose(1, 2)) + self.position


def _norm(channels: int) -> nn.GroupNorm:
    return nn.GroupNorm(channels // 16, channels)


class _Downsample(nn.Sequential):
    """Halves the size: 3x3 convolution of stride 2."""

    def __init__(self, channels_in: int, channels_out: int):
        convolution = nn.Conv2d(channels_in, channels_out, 3, stride=2, padding=1, bias=False)
        super().__init__(convolution, _norm(channels_out), nn.ReLU(inplace=True))


class _ResidualBlock(nn.Module):
    def __init__(self, channels: int):
        super().__init__()
        self.first = nn.Conv2d(channels, channels, 3, padding=1, bias=False)
        self.first_norm = _norm(channels)
        self.second = nn.Conv2d(channels, channels, 3, padding=1, bias=False)
        self.second_norm = _norm(channels)

    def forward(self, x: Tensor) -> Tensor:
        hidden = F.relu(self.first_norm(self.first(x)), inplace=True)
        return F.relu(x + self.second_norm(self.second(hidden)))


class FineImageEncoder(nn.Module):
    """Pictures (B, 3, H, W), values 0..1 -> tokens (B, (S/8)^2, dim): what is fine, and what surrounds it; and finer
    features (B, channels[0], S/4, S/4).

    Args:
        image_size: S in pixels; pictures of another size are resized to it.
        channels: channels at S/4, S/8, S/16.
        dim: width of a token.
    """

    def __init__(self, image_size: int, channels: tuple[int, int, int], dim: int):
        super().__init__()
        self.image_size = image_size
        fine, middle, coarse = channels
        self.stem = nn.Sequential(nn.Conv2d(3, fine, 8, stride=4, padding=2), _norm(fine), nn.ReLU(inplace=True))
        self.middle = nn.Sequential(_Downsample(fine, middle), _ResidualBlock(middle))
        self.coarse = nn.Sequential(_Downsample(middle, coarse), _ResidualBlock(coarse), _ResidualBlock(coarse))
        self.from_middle = nn.Linear(middle, dim)
        self.from_coarse = nn.Linear(coarse, dim, bias=False)

    @property
    def grid(self) -> int:
        """Tokens along a side."""
        return self.image_size // 8

    def forward(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        size = (self.image_size, self.image_size)
        if pictures.shape[-2:] != size:
            pictures = F.interpolate(pictures, size=size, mode="bilinear", antialias=True, align_corners=False)
        pictures = (pictures * 4 - 2).contiguous(memory_format=torch.channels_last)
        fine = self.stem(pictures)
        middle = self.middle(fine)
        around = self.from_coarse(self.coarse(middle).permute(0, 2, 3, 1))
        around = around.repeat_interleave(2, 1).repeat_interleave(2, 2)
        return (self.from_middle(middle.permute(0, 2, 3, 1)) + around).flatten(1, 2), fine
