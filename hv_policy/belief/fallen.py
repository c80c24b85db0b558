"""What has fallen over is as large as it was when it stood: three lengths, of which another one is upright now.

A picture of a thing on its side tells its outline to 5 cm; of a thing of a known kind that stands, to 2 cm. What was
measured before it was touched says which outlines there can be, and the picture says which of them it is.
"""

from __future__ import annotations

from itertools import permutations

import torch
from torch import Tensor

from hv_policy.belief.attitude import FACES, UPRIGHT
from hv_policy.belief.outline import compass_yaw_rad, half_sides_m, outline_along
from hv_policy.belief.regrip import BELOW_TOP_M
from hv_policy.belief.stands import LOW_M

WIDTH_SPREAD_M, HEIGHT_SPREAD_M, UPRIGHT_SPREAD = 0.03, 0.035, 0.5
"""Deviations of half an extent, of the height of the middle, and of how upright a thing is, of what is on its side."""
UNLIKELY = 9.0
"""What fits none of the ways to lie better than that (squared deviations) leans on something, or was measured wrongly
when it stood."""
_WAYS = torch.tensor(list(permutations(range(3))))
"""(6, 3) which of the lengths runs along the faces, across them, and upward."""


def measured_standing(outline: Tensor, faces: Tensor, height_m: Tensor, above_m: Tensor) -> Tensor:
    """(n, 3) half extents of things that stand, along their faces, across and upward.

    Args:
        outline: (n, 3) (`hv_policy.belief.outline`).
        faces: (n, 2) which way their faces run (`hv_policy.belief.attitude`): as the walls do, mostly.
        height_m: (n,) of their middles above the floor.
        above_m: (n,) how far above its middle such a thing is held: nearly at its top, which tells the height of what
            stands on a table.
    """
    high = torch.where(height_m < LOW_M, height_m, above_m + BELOW_TOP_M)
    return torch.cat([half_sides_m(outline, compass_yaw_rad(faces)), high[:, None]], 1)


def as_it_lies(half_m: Tensor, outline: Tensor, attitude: Tensor, height_m: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """(n, 3) outlines, (n, 3) attitudes and (n,) heights of the middles above the floor, of things on the floor with
    half extents (n, 3), as a picture shows them.

    Args:
        half_m: from `measured_standing`.
        outline, attitude: (n, 3) as they are seen now.
        height_m: (n,) likewise.
    """
    yaw = compass_yaw_rad(attitude[:, FACES])
    seen = half_sides_m(outline, yaw)
    ways = half_m[:, _WAYS]  # (n, 6, 3)
    upright = (_WAYS[:, 2] == 2).to(outline)
    wrong = ((ways[..., :2] - seen[:, None]) / WIDTH_SPREAD_M).square().sum(2)
    wrong = wrong + ((ways[..., 2] - height_m[:, None]) / HEIGHT_SPREAD_M).square()
    wrong = wrong + ((attitude[:, UPRIGHT, None].abs() - upright) / UPRIGHT_SPREAD).square()
    share = (-wrong / 2).softmax(1)[..., None]
    likely = (share * ways).sum(1)
    fits = wrong.amin(1) < UNLIKELY
    outline = torch.where(fits[:, None], outline_along(likely[:, :2], yaw), outline)
    stands = torch.where(fits, (share[..., 0] * upright).sum(1), attitude[:, UPRIGHT])
    return outline, torch.cat([attitude[:, FACES], stands[:, None]], 1), torch.where(fits, likely[:, 2], height_m)
